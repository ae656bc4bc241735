//! Places of targets on the ellipsoid, and vectors of the system frame in a target's own horizon.
//!
//! The system frame is a plane that touches the earth at the origin. 400 km from there the vertical leans by 3.6° and,
//! at middle latitudes, true north is turned by about 4°. The documents ask for velocity and course "related to
//! geographical north at the target", for rates of climb, and for heights above the ellipsoid, so vectors are turned
//! into the east, north and up of the target's own place: at 250 m/s the difference is 17 m/s.
//!
//! If a source observes no height, the vertical component of a velocity is meaningless. The target is then assumed to
//! fly level above the ellipsoid, not level above the system's plane.

use frames::{Geodetic, SensorFrame, SystemFrame};
use messages::Covariance;

/// Largest distance from the system's origin along an axis, metres: beyond the range of every item.
const DISTANCE_MAX_M: f64 = 4.2e6;
/// Farthest from the ellipsoid, metres.
const HEIGHT_MAX_M: f64 = 100_000.0;

/// A direction in the system frame: east, north, up.
pub(super) type Axis = [f64; 3];

/// A target's place.
#[derive(Clone, Copy, Debug)]
pub(super) struct TargetPlace {
    /// Latitude, longitude and height above the ellipsoid.
    pub(super) geodetic: Geodetic,
    /// East, north and up at the target.
    axes: [Axis; 3],
}

impl TargetPlace {
    /// The place of a system position, metres; `None` for one that no target has.
    pub(super) fn new(system: &SystemFrame, position_m: [f64; 3]) -> Option<Self> {
        // Written so that NaN fails.
        if !position_m.iter().all(|axis| axis.abs() <= DISTANCE_MAX_M) {
            return None;
        }
        let geodetic = system.to_geodetic(position_m);
        if !(-HEIGHT_MAX_M..=HEIGHT_MAX_M).contains(&geodetic.height_m()) {
            return None;
        }
        Some(Self {
            geodetic,
            axes: axes(&SensorFrame::new(system, geodetic, 0.0), position_m),
        })
    }

    /// Up at the target.
    pub(super) fn up(&self) -> Axis {
        self.axes[2]
    }

    /// Returns the directions of the east and north components at the target for a velocity in the system frame. With
    /// an unknown vertical component, the directions are those of level flight.
    pub(super) fn horizontal(&self, vertical_known: bool) -> [Axis; 2] {
        let [east, north, up] = self.axes;
        if vertical_known {
            return [east, north];
        }
        // Level: up · v = 0 gives the vertical component that the horizontal ones stand for.
        [east, north].map(|axis| {
            let share = axis[2] / up[2];
            [axis[0] - share * up[0], axis[1] - share * up[1], 0.0]
        })
    }
}

/// The axes of a sensor's own frame (x, y, up), at a point, in the system frame.
pub(super) fn axes(frame: &SensorFrame, position_m: [f64; 3]) -> [Axis; 3] {
    let origin = frame.to_cartesian(position_m);
    let column = |axis: usize| {
        let mut tip = position_m;
        tip[axis] += 1.0;
        let tip = frame.to_cartesian(tip);
        [0, 1, 2].map(|i| tip[i] - origin[i])
    };
    let [east, north, up] = [column(0), column(1), column(2)];
    [0, 1, 2].map(|i| [east[i], north[i], up[i]])
}

/// Component of a vector along an axis; components that the axis does not have may be anything.
pub(super) fn along(axis: Axis, vector: [f64; 3]) -> f64 {
    let parts = axis.iter().zip(vector).filter(|(share, _)| **share != 0.0);
    parts.map(|(share, component)| share * component).sum()
}

/// Covariance of the components of position along two axes, m².
pub(super) fn position_covariance(covariance: &Covariance, a: Axis, b: Axis) -> f64 {
    bilinear(covariance, 0, a, b)
}

/// Covariance of the components of velocity along two axes, m²/s².
pub(super) fn velocity_covariance(covariance: &Covariance, a: Axis, b: Axis) -> f64 {
    bilinear(covariance, 3, a, b)
}

fn bilinear(covariance: &Covariance, first: usize, a: Axis, b: Axis) -> f64 {
    let row = |i: usize| along(b, [0, 1, 2].map(|j| covariance.get(first + i, first + j)));
    along(a, [0, 1, 2].map(row))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn system() -> SystemFrame {
        SystemFrame::at(Geodetic::from_degrees(52.0, 13.0, 0.0).unwrap())
    }

    #[test]
    fn places_that_no_target_has_are_none() {
        for position in [
            [f64::NAN, 0.0, 0.0],
            [5e6, 0.0, 0.0],
            [0.0, f64::INFINITY, 0.0],
            [0.0, 0.0, 2e5],
        ] {
            assert!(TargetPlace::new(&system(), position).is_none(), "{position:?}");
        }
    }

    #[test]
    fn far_from_the_origin_the_vertical_leans() {
        let place = TargetPlace::new(&system(), [400e3, 0.0, 0.0]).unwrap();
        let lean = place.up()[0].asin().to_degrees();
        assert!((lean - 3.6).abs() < 0.05, "{lean}");
        // A level flight towards the east sinks below the system's plane, and so is a little faster than in the plane.
        let [east, north] = place.horizontal(false).map(|axis| along(axis, [250.0, 0.0, f64::NAN]));
        assert!(
            (east.hypot(north) - 250.0 / lean.to_radians().cos()).abs() < 0.01,
            "{east} {north}"
        );
    }

    proptest! {
        /// A second of motion, moved to the target's own frame point by point, is its velocity.
        #[test]
        fn axes_are_those_of_the_targets_own_frame(
            position in [-400e3..400e3f64, -400e3..400e3f64, -20e3..20e3f64],
            velocity in prop::array::uniform3(-300.0..300.0f64),
        ) {
            let place = TargetPlace::new(&system(), position).unwrap();
            let local = SystemFrame::at(place.geodetic);
            let later = [0, 1, 2].map(|axis| position[axis] + velocity[axis]);
            let moved = local.to_local(system().to_geodetic(later));
            let [east, north] = place.horizontal(true).map(|axis| along(axis, velocity));
            prop_assert!((moved[0] - east).abs() < 1e-3 && (moved[1] - north).abs() < 1e-3, "{moved:?}");
            prop_assert!((moved[2] - along(place.up(), velocity)).abs() < 1e-3);
            // Without the vertical component: the same as with the one that makes the flight level.
            let up = place.up();
            let level = [velocity[0], velocity[1], -(up[0] * velocity[0] + up[1] * velocity[1]) / up[2]];
            for (known, unknown) in place.horizontal(true).into_iter().zip(place.horizontal(false)) {
                prop_assert!((along(known, level) - along(unknown, velocity)).abs() < 1e-6);
            }
        }
    }
}
