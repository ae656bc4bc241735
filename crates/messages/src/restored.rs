//! State that a fusion starts from.
//!
//! A fusion that starts after another one goes on from its checkpoint. It says so in the first moments after its start:
//! what it starts from, in parts, then whatever comes of it. A recording that has the parts of an epoch, each one, can
//! be replayed from there; an engine's start is a function of them alone.

use crate::layout::sample;

/// Words of a part.
pub const RESTORED_WORDS: usize = 120;

sample! {
    /// Part of what a fusion starts from.
    Restored, size 1000 {
        /// Start-up number of the fusion that starts.
        epoch: u64,
        /// UTC at the start, nanoseconds since 1970.
        time_ns: i64,
        /// Place of this part among all, from 0.
        part: u32,
        /// Number of parts.
        parts: u32,
        /// How many of `words` hold something.
        count: u32,
        /// 1 if the tracks in it were too old to go on: each is told ended.
        ends: u32,
        /// Sequence number at its publisher.
        sequence: u64,
        /// Words of a `fusion::checkpoint::Snapshot`, after those of the parts before.
        words: [u64; 120] = [0; RESTORED_WORDS],
    }
}
