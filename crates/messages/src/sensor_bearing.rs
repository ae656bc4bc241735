//! Bearings of transmitters, with the position of the sensor, before location.

use crate::StageTimes;
use crate::codes::bits;
use crate::layout::sample;

bits! {
    /// Bits of [`SensorBearing::valid`].
    sensor_bearing_bits: u16 {
        /// `emitter_id` is known: the sensor distinguishes transmitters.
        EMITTER = 1;
        /// `heading_rad` is known.
        HEADING = 1 << 1;
        /// `frequency_hz` was measured.
        FREQUENCY = 1 << 2;
        /// `pulse_interval_s` was measured.
        PULSE_INTERVAL = 1 << 3;
    }
}

sample! {
    /// One bearing of a transmitter, with the position of the measurement (FM-7).
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
