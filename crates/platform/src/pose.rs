//! State of a platform at the time of a detection.

use crate::rotation::{Attitude, sum, times};
use crate::state::State;

/// Why a platform's state at a time is not known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoState {
    /// No state has come.
    None,
    /// The states have not reached the time.
    NotYet,
    /// The time is before the oldest kept state.
    TooOld,
    /// The states around the time are too far apart.
    Gap,
}

/// An angle at a time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AngleAt {
    /// Value, radians.
    pub angle_rad: f64,
    /// Rate, radians per second.
    pub rate_radps: f64,
    /// Standard deviation, radians.
    pub sigma_rad: f64,
}

/// State of a platform at the time of a detection, with standard deviations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Time, UTC, nanoseconds since 1970.
    pub time_ns: i64,
    /// Position east, north, up in the system frame, metres.
    pub position_m: [f64; 3],
    /// Standard deviation of each coordinate, metres.
    pub position_sigma_m: f64,
    /// Velocity east, north, up, metres per second, if known.
    pub velocity_mps: Option<[f64; 3]>,
    /// Standard deviation of each component, metres per second.
    pub velocity_sigma_mps: f64,
    /// Heading, clockwise from the system frame's north, or the reason for its absence.
    pub heading: Result<AngleAt, NoState>,
    /// Pitch and roll, or the reason for their absence. A platform without sensors of attitude is assumed level.
    pub tilt: Result<[AngleAt; 2], NoState>,
}

impl Pose {
    /// The pose that a single state gives, with assumed standard deviations where the state has none; `None` without a
    /// position. For detections that carry the state of the platform.
    pub fn of(state: &State, assumed: &crate::Assumed) -> Option<Self> {
        let angle = |angle_rad, sigma_rad| AngleAt {
            angle_rad,
            rate_radps: 0.0,
            sigma_rad,
        };
        let tilt_sigmas = state.tilt_sigmas_rad.unwrap_or([assumed.attitude_sigma_deg.rad(); 2]);
        let tilt = match state.tilt_rad {
            Some([pitch, roll]) => [angle(pitch, tilt_sigmas[0]), angle(roll, tilt_sigmas[1])],
            None => level(assumed),
        };
        Some(Self {
            time_ns: state.time_ns,
            position_m: state.position_m?,
            position_sigma_m: state.position_sigma_m.unwrap_or(assumed.position_sigma_m),
            velocity_mps: state.velocity_mps,
            velocity_sigma_mps: state.velocity_sigma_mps.unwrap_or(assumed.velocity_sigma_mps),
            heading: state.heading_rad.ok_or(NoState::None).map(|heading_rad| {
                let sigma_rad = state.heading_sigma_rad.unwrap_or(assumed.heading_sigma_deg.rad());
                angle(heading_rad, sigma_rad)
            }),
            tilt: Ok(tilt),
        })
    }

    /// The pose with the standard deviations of the angles multiplied.
    pub(crate) fn with_angle_sigmas(self, factor: f64) -> Self {
        let scaled = |angle: AngleAt| AngleAt {
            sigma_rad: angle.sigma_rad * factor,
            ..angle
        };
        Self {
            heading: self.heading.map(scaled),
            tilt: self.tilt.map(|angles| angles.map(scaled)),
            ..self
        }
    }

    /// Attitude of the platform.
    ///
    /// # Errors
    /// The reason, if the attitude is unknown.
    pub fn attitude(&self) -> Result<Attitude, NoState> {
        let angles = self.angles()?;
        Ok(Attitude::of(angles.map(|angle| angle.angle_rad)))
    }

    /// Heading, pitch, roll.
    pub(crate) fn angles(&self) -> Result<[AngleAt; 3], NoState> {
        let [pitch, roll] = self.tilt?;
        Ok([self.heading?, pitch, roll])
    }

    /// Velocity of a point of the platform at `arm` (right, forward, up, metres), east, north, up, metres per second.
    pub(crate) fn velocity_at(&self, arm: [f64; 3]) -> Option<[f64; 3]> {
        let velocity = self.velocity_mps?;
        let Ok(angles) = self.angles() else {
            return Some(velocity);
        };
        let derivatives = Attitude::of(angles.map(|angle| angle.angle_rad)).derivatives();
        let turning = angles.iter().zip(&derivatives).map(|(angle, derivative)| {
            let per_radian = times(derivative, arm);
            per_radian.map(|speed| speed * angle.rate_radps)
        });
        Some(turning.fold(velocity, sum))
    }
}

/// Pitch and roll of a platform that is assumed level.
pub(crate) fn level(assumed: &crate::Assumed) -> [AngleAt; 2] {
    [AngleAt {
        sigma_rad: assumed.level_sigma_deg.rad(),
        ..AngleAt::default()
    }; 2]
}
