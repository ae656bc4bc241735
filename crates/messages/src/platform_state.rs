//! Position and attitude of a moving sensor.

use crate::StageTimes;
use crate::codes::bits;
use crate::layout::sample;

bits! {
    /// Bits of [`PlatformState::valid`].
    platform_state_bits: u16 {
        /// `velocity_mps` is known.
        VELOCITY = 1;
        /// `heading_rad` is known.
        HEADING = 1 << 1;
        /// `pitch_rad` and `roll_rad` are known.
        ATTITUDE = 1 << 2;
        /// `position_sigma_m` is known.
        POSITION_SIGMA = 1 << 3;
        /// `heading_sigma_rad` is known.
        HEADING_SIGMA = 1 << 4;
        /// `velocity_sigma_mps` is known.
        VELOCITY_SIGMA = 1 << 5;
        /// `pitch_sigma_rad` and `roll_sigma_rad` are known.
        ATTITUDE_SIGMA = 1 << 6;
        /// `position_m` is not known: a state of attitude or velocity alone.
        NO_POSITION = 1 << 7;
    }
}

sample! {
    /// Position and attitude of the platform that carries a sensor, at one time (EL-11).
    PlatformState, size 168 {
        /// Time at which the platform was there, UTC, nanoseconds since 1970.
        time_ns: i64,
        /// The state's sequence number at its publisher.
        sequence: u64,
        /// Stages passed so far.
        stages: StageTimes,
        /// Position east, north, up in the system frame, metres; 0 with the bit `NO_POSITION`.
        position_m: [f64; 3],
        /// Velocity east, north, up, metres per second.
        velocity_mps: [f64; 3],
        /// Where its nose points, radians clockwise from the system frame's north.
        heading_rad: f64,
        /// Nose above the horizon, radians.
        pitch_rad: f64,
        /// Right wing below the horizon, radians.
        roll_rad: f64,
        /// Standard deviation of each coordinate of the position, metres.
        position_sigma_m: f64,
        /// Standard deviation of the heading, radians.
        heading_sigma_rad: f64,
        /// Standard deviation of each component of the velocity, metres per second.
        velocity_sigma_mps: f64,
        /// Standard deviation of the pitch, radians.
        pitch_sigma_rad: f64,
        /// Standard deviation of the roll, radians.
        roll_sigma_rad: f64,
        /// Source of the sensor on the platform: its number in the configuration (TI-2).
        source: u16,
        /// Which fields hold something: see `platform_state_bits`.
        valid: u16,
        /// Reserved, 0.
        reserved: u32,
    }
}
