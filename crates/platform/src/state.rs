//! A platform's state as given by a single message, with the values of that message.

use messages::{PlatformState, StageTimes, platform_state_bits as bits};
use observations::Detection;

/// State of a platform at a time. Each part may be missing: a compass gives a heading alone.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct State {
    /// Time, UTC, nanoseconds since 1970.
    pub time_ns: i64,
    /// Position east, north, up in the system frame, metres.
    pub position_m: Option<[f64; 3]>,
    /// Velocity east, north, up, metres per second.
    pub velocity_mps: Option<[f64; 3]>,
    /// Direction of the nose, radians clockwise from the system frame's north.
    pub heading_rad: Option<f64>,
    /// Pitch (nose up) and roll (right side down), radians.
    pub tilt_rad: Option<[f64; 2]>,
    /// Standard deviation of each coordinate of the position, metres.
    pub position_sigma_m: Option<f64>,
    /// Standard deviation of each component of the velocity, metres per second.
    pub velocity_sigma_mps: Option<f64>,
    /// Standard deviation of the heading, radians.
    pub heading_sigma_rad: Option<f64>,
    /// Standard deviations of pitch and roll, radians.
    pub tilt_sigmas_rad: Option<[f64; 2]>,
}

impl State {
    /// Takes a state from shared memory; values that are not finite, and standard deviations that are not positive,
    /// are left out.
    pub fn of_sample(sample: &PlatformState) -> Self {
        let stated = |bit: u16| sample.valid & bit != 0;
        Self {
            time_ns: sample.time_ns,
            position_m: (!stated(bits::NO_POSITION)).then_some(sample.position_m),
            velocity_mps: stated(bits::VELOCITY).then_some(sample.velocity_mps),
            heading_rad: stated(bits::HEADING).then_some(sample.heading_rad),
            tilt_rad: stated(bits::ATTITUDE).then_some([sample.pitch_rad, sample.roll_rad]),
            position_sigma_m: stated(bits::POSITION_SIGMA).then_some(sample.position_sigma_m),
            velocity_sigma_mps: stated(bits::VELOCITY_SIGMA).then_some(sample.velocity_sigma_mps),
            heading_sigma_rad: stated(bits::HEADING_SIGMA).then_some(sample.heading_sigma_rad),
            tilt_sigmas_rad: stated(bits::ATTITUDE_SIGMA).then_some([sample.pitch_sigma_rad, sample.roll_sigma_rad]),
        }
        .finite()
    }

    /// Takes the state of the platform from a detection.
    pub fn of_detection(detection: &Detection) -> Self {
        let platform = &detection.platform;
        let [heading, pitch, roll] = platform.attitude_rad.unwrap_or_default().map(f64::from);
        let [heading_sigma, pitch_sigma, roll_sigma] = platform.attitude_sigmas_rad.map(f64::from);
        let is_known = platform.attitude_rad.is_some();
        Self {
            time_ns: detection.time_of_measurement_ns,
            position_m: Some(detection.platform_m),
            velocity_mps: platform.velocity_mps.map(|velocity| velocity.map(f64::from)),
            heading_rad: is_known.then_some(heading),
            tilt_rad: is_known.then_some([pitch, roll]),
            position_sigma_m: platform.sigma_m.map(f64::from),
            velocity_sigma_mps: None,
            heading_sigma_rad: Some(heading_sigma),
            tilt_sigmas_rad: Some([pitch_sigma, roll_sigma]),
        }
        .finite()
    }

    /// The state as a sample of source number `source`.
    pub fn sample(&self, source: u16, stages: StageTimes) -> PlatformState {
        let flag = |is_set: bool, bit: u16| if is_set { bit } else { 0 };
        let [pitch_rad, roll_rad] = self.tilt_rad.unwrap_or_default();
        let [pitch_sigma_rad, roll_sigma_rad] = self.tilt_sigmas_rad.unwrap_or_default();
        PlatformState {
            time_ns: self.time_ns,
            stages,
            position_m: self.position_m.unwrap_or_default(),
            velocity_mps: self.velocity_mps.unwrap_or_default(),
            heading_rad: self.heading_rad.unwrap_or_default(),
            pitch_rad,
            roll_rad,
            position_sigma_m: self.position_sigma_m.unwrap_or_default(),
            heading_sigma_rad: self.heading_sigma_rad.unwrap_or_default(),
            velocity_sigma_mps: self.velocity_sigma_mps.unwrap_or_default(),
            pitch_sigma_rad,
            roll_sigma_rad,
            source,
            valid: flag(self.position_m.is_none(), bits::NO_POSITION)
                | flag(self.velocity_mps.is_some(), bits::VELOCITY)
                | flag(self.heading_rad.is_some(), bits::HEADING)
                | flag(self.tilt_rad.is_some(), bits::ATTITUDE)
                | flag(self.position_sigma_m.is_some(), bits::POSITION_SIGMA)
                | flag(self.velocity_sigma_mps.is_some(), bits::VELOCITY_SIGMA)
                | flag(self.heading_sigma_rad.is_some(), bits::HEADING_SIGMA)
                | flag(self.tilt_sigmas_rad.is_some(), bits::ATTITUDE_SIGMA),
            ..PlatformState::default()
        }
    }

    /// The state without values that are not finite and without standard deviations that are not positive.
    fn finite(self) -> Self {
        let number = |value: &f64| value.is_finite();
        let sigma = |value: &f64| value.is_finite() && *value > 0.0;
        Self {
            time_ns: self.time_ns,
            position_m: self.position_m.filter(|values| values.iter().all(number)),
            velocity_mps: self.velocity_mps.filter(|values| values.iter().all(number)),
            heading_rad: self.heading_rad.filter(number),
            tilt_rad: self.tilt_rad.filter(|values| values.iter().all(number)),
            position_sigma_m: self.position_sigma_m.filter(sigma),
            velocity_sigma_mps: self.velocity_sigma_mps.filter(sigma),
            heading_sigma_rad: self.heading_sigma_rad.filter(sigma),
            tilt_sigmas_rad: self.tilt_sigmas_rad.filter(|values| values.iter().all(sigma)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sample_holds_a_state_to_the_last_bit() {
        let whole = State {
            time_ns: 5,
            position_m: Some([1.0, 2.0, 1.0 / 3.0]),
            velocity_mps: Some([0.1, 0.2, 0.3]),
            heading_rad: Some(6.2),
            tilt_rad: Some([-0.1, 0.2]),
            position_sigma_m: Some(2.0),
            velocity_sigma_mps: Some(0.1),
            heading_sigma_rad: Some(0.005),
            tilt_sigmas_rad: Some([0.004, 0.006]),
        };
        let compass = State {
            time_ns: 5,
            heading_rad: Some(1.0),
            ..State::default()
        };
        for state in [whole, compass, State::default()] {
            assert_eq!(State::of_sample(&state.sample(3, StageTimes::default())), state);
        }
    }

    #[test]
    fn numbers_that_are_none_are_left_out() {
        let broken = State {
            position_m: Some([f64::NAN, 0.0, 0.0]),
            heading_rad: Some(f64::INFINITY),
            heading_sigma_rad: Some(0.0),
            ..State::default()
        };
        assert_eq!(
            State::of_sample(&broken.sample(0, StageTimes::default())),
            State::default()
        );
    }
}
