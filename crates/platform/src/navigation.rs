//! States as given by navigation receivers, relative to the Earth, and the conversion to the system frame.
//!
//! A compass counts from the north at the ship, and an inertial sensor's horizon is the ship's. A hundred kilometres
//! from the origin of the system frame, the frame's north and horizontal differ from these by a degree. Attitudes and
//! velocities are therefore turned by the rotation between the two places.

use frames::{FrameChange, Geodetic, SystemFrame};

use crate::rotation::{Attitude, IDENTITY, Matrix, times};
use crate::state::State;

/// State of a platform relative to the Earth; each part may be missing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Navigation {
    /// Time, UTC, nanoseconds since 1970.
    pub time_ns: i64,
    /// Place.
    pub place: Option<Geodetic>,
    /// Velocity towards the east and north at the place, metres per second.
    pub velocity_mps: Option<[f64; 2]>,
    /// Direction of the nose, radians clockwise from true north.
    pub heading_rad: Option<f64>,
    /// Pitch (nose up) and roll (right side down), radians.
    pub tilt_rad: Option<[f64; 2]>,
    /// Standard deviation of the heading, radians.
    pub heading_sigma_rad: Option<f64>,
    /// Standard deviations of pitch and roll, radians.
    pub tilt_sigmas_rad: Option<[f64; 2]>,
}

impl Navigation {
    /// Instrument readings at the ship for a state in the system frame, for simulations.
    pub fn of(state: &State, frame: &SystemFrame) -> Self {
        let place = state.position_m.map(|position| frame.to_geodetic(position));
        let here = place.map_or(*frame, SystemFrame::at);
        let axes = *FrameChange::between(frame, &here).rotation();
        let [pitch, roll] = state.tilt_rad.unwrap_or_default();
        let seen = Attitude::of([state.heading_rad.unwrap_or_default(), pitch, roll]).seen_from(&axes);
        Self {
            time_ns: state.time_ns,
            place,
            velocity_mps: state.velocity_mps.map(|velocity| {
                let [east, north, _] = times(&axes, velocity);
                [east, north]
            }),
            heading_rad: state.heading_rad.map(|_| seen.heading_rad),
            tilt_rad: state.tilt_rad.map(|_| [seen.pitch_rad, seen.roll_rad]),
            heading_sigma_rad: state.heading_sigma_rad,
            tilt_sigmas_rad: state.tilt_sigmas_rad,
        }
    }
}

/// Converts states relative to the Earth to the system frame.
#[derive(Clone, Copy, Debug)]
pub struct Navigator {
    frame: SystemFrame,
    /// Axes at the latest place, in the system frame.
    axes: Option<Matrix>,
}

impl Navigator {
    /// Converts to this frame.
    pub fn new(frame: SystemFrame) -> Self {
        Self { frame, axes: None }
    }

    /// Converts a state; before the first place, directions are taken as at the origin.
    pub fn state(&mut self, navigation: &Navigation) -> State {
        if let Some(place) = navigation.place {
            let here = SystemFrame::at(place);
            self.axes = Some(*FrameChange::between(&here, &self.frame).rotation());
        }
        let axes = self.axes.unwrap_or(IDENTITY);
        let [pitch, roll] = navigation.tilt_rad.unwrap_or_default();
        let seen = Attitude::of([navigation.heading_rad.unwrap_or_default(), pitch, roll]).seen_from(&axes);
        let is_whole = navigation.heading_rad.is_some();
        State {
            time_ns: navigation.time_ns,
            position_m: navigation.place.map(|place| self.frame.to_local(place)),
            velocity_mps: navigation
                .velocity_mps
                .map(|[east, north]| times(&axes, [east, north, 0.0])),
            heading_rad: is_whole.then_some(seen.heading_rad),
            // Without a heading, the direction in which the two horizons differ is unknown.
            tilt_rad: navigation.tilt_rad.map(|tilt| match is_whole {
                true => [seen.pitch_rad, seen.roll_rad],
                false => tilt,
            }),
            position_sigma_m: None,
            velocity_sigma_mps: None,
            heading_sigma_rad: navigation.heading_sigma_rad,
            tilt_sigmas_rad: navigation.tilt_sigmas_rad,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_heading_is_turned_by_the_convergence_of_the_meridians() {
        let origin = Geodetic::from_degrees(60.0, 5.0, 0.0).unwrap();
        let frame = SystemFrame::at(origin);
        let [here, ahead] = [60.5, 60.6].map(|latitude| Geodetic::from_degrees(latitude, 8.0, 0.0).unwrap());
        let mut navigator = Navigator::new(frame);
        let north = Navigation {
            place: Some(here),
            velocity_mps: Some([0.0, 10.0]),
            heading_rad: Some(0.0),
            tilt_rad: Some([0.0, 0.0]),
            ..Navigation::default()
        };
        let state = navigator.state(&north);
        let (a, b) = (frame.to_local(here), frame.to_local(ahead));
        let expected = (b[0] - a[0]).atan2(b[1] - a[1]);
        let heading = state.heading_rad.unwrap();
        assert!(
            (heading - expected).abs() < 1e-3 && heading.abs() > 0.03,
            "{heading} {expected}"
        );
        let [vx, vy, _] = state.velocity_mps.unwrap();
        assert!((vx.atan2(vy) - heading).abs() < 1e-9);
        // The horizon at the ship is not the origin's: two degrees away, the eastern side is lower.
        let [_, roll] = state.tilt_rad.unwrap();
        assert!(roll > 0.02, "{roll}");
        // A compass gives no place: the latest one serves.
        let compass = Navigation {
            heading_rad: Some(0.0),
            ..Navigation::default()
        };
        assert!((navigator.state(&compass).heading_rad.unwrap() - heading).abs() < 1e-3);
        assert_eq!(Navigator::new(frame).state(&compass).heading_rad, Some(0.0));
        // The conversion of the instruments' readings of a state gives the state again.
        let again = navigator.state(&Navigation::of(&state, &frame));
        let (position, expected) = (again.position_m.unwrap(), state.position_m.unwrap());
        assert!((0..3).all(|axis| (position[axis] - expected[axis]).abs() < 1e-3));
        let turned = (again.heading_rad.unwrap() - heading + 1.0).rem_euclid(std::f64::consts::TAU) - 1.0;
        assert!(turned.abs() < 1e-9);
        let [_, again_roll] = again.tilt_rad.unwrap();
        assert!((again_roll - roll).abs() < 1e-9);
    }
}
