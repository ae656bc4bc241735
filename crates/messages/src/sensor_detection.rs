//! What a sensor saw, before anybody made a track of it.

use crate::StageTimes;
use crate::layout::sample;

/// Bits of [`SensorDetection::valid`].
pub mod sensor_detection_bits {
    /// `range_rate_mps` was measured.
    pub const RANGE_RATE: u8 = 1;
    /// `sigmas` hold standard deviations.
    pub const SIGMAS: u8 = 1 << 1;

    pub(crate) const NAMES: &[(&str, u64)] = &[("RANGE_RATE", RANGE_RATE as u64), ("SIGMAS", SIGMAS as u64)];
}

sample! {
    /// One detection of one sensor (FM-6): a measurement that belongs to no track yet.
    #[derive(Default)]
    SensorDetection, size 152 {
        /// Time of measurement, UTC, nanoseconds since 1970.
        time_of_measurement_ns: i64,
        /// The detection's sequence number at its publisher.
        sequence: u64,
        /// Stages passed so far.
        stages: StageTimes,
        /// The sensor's scan, turn or frame; it rises with time.
        scan: u32,
        /// Number of the detection, unique within its scan.
        detection_id: u32,
        /// Measured values in the order of the kind: metres, radians; 0 beyond.
        values: [f64; 3],
        /// Speed away from the sensor, metres per second.
        range_rate_mps: f64,
        /// Standard deviations of the values and, last, of the range rate.
        sigmas: [f64; 4],
        /// Where the sensor was, metres east, north and up.
        platform_m: [f64; 3],
        /// Source: its number in the configuration (TI-2).
        source: u16,
        /// Which quantities were measured: 0 position2, 1 position3, 2 range_bearing, 3 range_bearing_elevation, 4 bearing, 5 bearing_elevation.
        kind: u8,
        /// Which fields hold something: see `sensor_detection_bits`.
        valid: u8,
        /// Reserved, 0.
        reserved: u32,
    }
}
