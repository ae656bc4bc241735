//! The header of every slice.

use crate::layout::sample;

sample! {
    /// Precedes every slice on every topic.
    ///
    /// A slice may be empty: then it only says how far its source has got.
    BatchHeader, size 64 {
        /// Fingerprint of the layout the publisher was built with; others are rejected.
        schema: u64,
        /// Monotonic start time of the publisher, nanoseconds: a restart shows as a new value.
        incarnation: u64,
        /// Samples sent by this incarnation before this slice: the sequence number of its first sample.
        first_sequence: u64,
        /// Progress mark: no later sample will have a time of measurement before this (UTC, ns); i64::MIN if unknown.
        progress_ns: i64,
        /// Monotonic time of the send, nanoseconds.
        sent_ns: i64,
        /// Start-up number of fusion, rising with each start; tracks of smaller ones are not kept up. 0: not fusion.
        epoch: u64,
        /// Bit 0: the source has ended, nothing follows. Bit 1: fusion goes on with the tracks of the one before it.
        flags: u32,
        /// Identity of the sensor, the same in every deployment that hears it; 0: unknown, or no sensor.
        sensor_uid: u32,
        /// Deployment that the samples come from, where not the one at hand; 0: the one at hand.
        origin: u32,
        /// Offset of the source's clock against the publisher's UTC, by the times at which its data are received,
        /// milliseconds; positive if the clock is ahead, 0 if it is not known.
        clock_offset_ms: i32,
    }
}

impl BatchHeader {
    /// Bit of [`BatchHeader::flags`]: the source has ended.
    pub const END: u32 = 1;
    /// Bit of [`BatchHeader::flags`]: this fusion goes on with the tracks of the one before it, under their numbers, or
    /// tells them ended. Without it, nobody knows of older epochs' tracks any more.
    pub const GOES_ON: u32 = 2;
}
