//! Initial state, or snapshot of the state, of a fusion process.
//!
//! A fusion that starts after another continues from the predecessor's checkpoint. In the first moments after the
//! start, fusion publishes this initial state, in parts, before any dependent output. A recording with all parts of
//! an epoch can be replayed from there, because an engine's start is a function of these parts alone. A recorder
//! absent at the start requests a snapshot of the whole engine, which is published in the same form.

use crate::layout::sample;

/// Number of words in a part.
pub const RESTORED_WORDS: usize = 120;

sample! {
    /// Part of the initial state of a fusion, or of a snapshot of its state.
    Restored, size 1000 {
        /// Start-up number of the fusion.
        epoch: u64,
        /// UTC at the start, or at which the image was made, nanoseconds since 1970.
        time_ns: i64,
        /// Place of this part among all, from 0.
        part: u32,
        /// Number of parts.
        parts: u32,
        /// How many of `words` hold something.
        count: u32,
        /// 1 if the tracks were too old to continue, and each is reported as terminated; 2 for a snapshot.
        ends: u32,
        /// Sequence number at its publisher.
        sequence: u64,
        /// Words of a `fusion::checkpoint::Snapshot`, after those of the parts before; of an image the number of the
        /// next system-track state, then the bytes of `fusion::Engine::image`, filled up with zeros.
        words: [u64; 120] = [0; RESTORED_WORDS],
    }
}

impl Restored {
    /// [`Restored::ends`]: the part belongs to a snapshot.
    pub const IMAGE: u32 = 2;
}
