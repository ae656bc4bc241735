//! Ready-made fixes of transmitters, before selection and smoothing.

use crate::StageTimes;
use crate::layout::sample;

sample! {
    /// Position of a transmitter, found by others (EL-12).
    SensorFix, size 104 {
        /// Time of the fix, UTC, nanoseconds since 1970.
        time_of_measurement_ns: i64,
        /// The fix's sequence number at its publisher.
        sequence: u64,
        /// Stages passed so far.
        stages: StageTimes,
        /// Position, metres east, north and up.
        position_m: [f64; 3],
        /// Covariance in the plane: east, east with north, north, m².
        covariance_m2: [f64; 3],
        /// Number of the transmitter at its source.
        emitter_id: u32,
        /// Source: its number in the configuration (TI-2).
        source: u16,
        /// Reserved, 0.
        reserved: u16,
    }
}
