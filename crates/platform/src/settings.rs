//! Assumptions on a platform where its states give no value.

use settings::{Degrees, Seconds};

settings::settings! {
    /// Assumptions on a platform's states.
    #[derive(Copy)]
    pub struct Assumed {
        /// Longest time between two states for the platform's state to be interpolated between them.
        max_gap_s: Seconds = Seconds::of(2.0), in [1e-3, 600];
        /// Standard deviation of each coordinate of positions that state none.
        position_sigma_m: f64 = 5.0, in [1e-3, 1e5];
        /// Standard deviation of each component of velocities that state none.
        velocity_sigma_mps: f64 = 0.5, in [1e-3, 1e3];
        /// Standard deviation of headings that state none.
        heading_sigma_deg: Degrees = Degrees::of(1.0), in [1e-3, 90];
        /// Standard deviation of pitch and roll that state none.
        attitude_sigma_deg: Degrees = Degrees::of(0.5), in [1e-3, 45];
        /// Time in which the errors of heading, pitch and roll change; 0: they are new at each look of a sensor.
        attitude_correlation_s: Seconds = Seconds::of(0.0), in [0, 600];
        /// Standard deviation of pitch and roll of a platform without sensors of attitude, which is assumed level.
        level_sigma_deg: Degrees = Degrees::of(3.0), in [1e-3, 45];
        /// Acceleration between two states that the interpolation does not follow.
        acceleration_mps2: f64 = 0.5, in [0, 100];
        /// Angular acceleration between two states that the interpolation does not follow.
        angular_acceleration_degps2: Degrees = Degrees::of(3.0), in [0, 360];
    }
}
