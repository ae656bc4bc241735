//! From where a sensor hears a transmitter, before anybody has located it.

use crate::StageTimes;
use crate::layout::sample;

/// Bits of [`SensorBearing::valid`].
pub mod sensor_bearing_bits {
    /// `emitter_id` is known: the sensor tells transmitters apart.
    pub const EMITTER: u16 = 1;
    /// `heading_rad` is known.
    pub const HEADING: u16 = 1 << 1;
    /// `frequency_hz` was measured.
    pub const FREQUENCY: u16 = 1 << 2;
    /// `pulse_interval_s` was measured.
    pub const PULSE_INTERVAL: u16 = 1 << 3;

    pub(crate) const NAMES: &[(&str, u64)] = &[
        ("EMITTER", EMITTER as u64),
        ("HEADING", HEADING as u64),
        ("FREQUENCY", FREQUENCY as u64),
        ("PULSE_INTERVAL", PULSE_INTERVAL as u64),
    ];
}

sample! {
    /// One bearing of a transmitter, with the place from which it was measured (FM-7).
    #[derive(Default)]
    SensorBearing, size 120 {
        /// Time of measurement, UTC, nanoseconds since 1970.
        time_of_measurement_ns: i64,
        /// The bearing's sequence number at its publisher.
        sequence: u64,
        /// Stages passed so far.
        stages: StageTimes,
        /// Direction, radians clockwise from north.
        bearing_rad: f64,
        /// Standard deviation of that, radians.
        sigma_rad: f64,
        /// Where the platform was, metres east, north and up.
        platform_m: [f64; 3],
        /// Where its nose pointed, radians clockwise from north.
        heading_rad: f64,
        /// Frequency of the emission, hertz.
        frequency_hz: f64,
        /// Time between its pulses, seconds.
        pulse_interval_s: f64,
        /// Number of the transmitter at its source.
        emitter_id: u32,
        /// Source: its number in the configuration (TI-2).
        source: u16,
        /// Which fields hold something: see `sensor_bearing_bits`.
        valid: u16,
    }
}
