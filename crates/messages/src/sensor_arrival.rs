//! Arrival times of transmissions at receivers, before location.

use crate::StageTimes;
use crate::codes::bits;
use crate::layout::sample;

bits! {
    /// Bits of [`SensorArrival::valid`].
    sensor_arrival_bits: u16 {
        /// `time_s` is a difference: arrival at the receiver minus arrival at the second one.
        DIFFERENCE = 1;
        /// `reference_m` is known: the transmission is of a reference emitter.
        REFERENCE = 1 << 1;
    }
}

sample! {
    /// Arrival of a transmission at one receiver, or the difference between two (FM-7).
    SensorArrival, size 176 {
        /// Time of the transmission, UTC, nanoseconds since 1970.
        time_of_measurement_ns: i64,
        /// The arrival's sequence number at its publisher.
        sequence: u64,
        /// Stages passed so far.
        stages: StageTimes,
        /// Arrival by the receiver's clock, seconds since midnight (UTC), or a difference of two arrivals, seconds.
        time_s: f64,
        /// Standard deviation of that, seconds.
        sigma_s: f64,
        /// Where the receiver is, metres east, north and up.
        receiver_m: [f64; 3],
        /// Where the second receiver of a difference is.
        receiver_2_m: [f64; 3],
        /// Where the reference emitter is.
        reference_m: [f64; 3],
        /// Name of the receiver in ASCII, unused bytes 0.
        receiver: [u8; 16],
        /// Name of the second receiver of a difference.
        receiver_2: [u8; 16],
        /// Number of the transmitter at its source.
        emitter_id: u32,
        /// Source: its number in the configuration (TI-2).
        source: u16,
        /// Which fields hold something: see `sensor_arrival_bits`.
        valid: u16,
    }
}
