//! Progress of consumers, for producers of recorded data.

use crate::layout::sample;

sample! {
    /// Progress of one consumer on one topic. Producers of recorded data wait for it, so that no reader falls
    /// behind and no sample is lost.
    Progress, size 56 {
        /// Monotonic start time of the consumer, nanoseconds: a restart shows as a new value.
        consumer_incarnation: u64,
        /// Monotonic start time of the publisher whose samples are counted.
        publisher_incarnation: u64,
        /// Samples of that source worked off: all with a sequence number below this.
        done_sequence: u64,
        /// Slices of that publisher taken since the consumer joined.
        done_batches: u64,
        /// How far the consumer has got in the time of the data, UTC, nanoseconds; i64::MIN if unknown.
        progress_ns: i64 = i64::MIN,
        /// Number of the source, or of the wide-area sensor; 0 for the system tracks.
        number: u16,
        /// Kind of topic: a `Stream` code.
        stream: u8,
        /// Kind of the consumer: a `ProcessKind` code.
        consumer: u8,
        /// Reserved, 0.
        reserved: u32,
        /// Monotonic time of this statement, nanoseconds.
        said_ns: i64,
    }
}
