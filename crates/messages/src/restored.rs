//! State that a fusion starts from, or has.
//!
//! A fusion that starts after another one goes on from its checkpoint. It says so in the first moments after its start:
//! what it starts from, in parts, then whatever comes of it. A recording that has the parts of an epoch, each one, can
//! be replayed from there; an engine's start is a function of them alone. A recorder that was not there at the start
//! asks for an image of the whole engine, which is said in the same way.

use crate::layout::sample;

/// Words of a part.
pub const RESTORED_WORDS: usize = 120;

sample! {
    /// Part of what a fusion starts from, or of an image of what it has.
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
        /// 1 if the tracks in it were too old to go on: each is told ended; 2 if it is of an image.
        ends: u32,
        /// Sequence number at its publisher.
        sequence: u64,
        /// Words of a `fusion::checkpoint::Snapshot`, after those of the parts before; of an image the number of the
        /// next system-track state, then the octets of `fusion::Engine::image`, filled up with zeros.
        words: [u64; 120] = [0; RESTORED_WORDS],
    }
}

impl Restored {
    /// [`Restored::ends`]: the part is one of an image.
    pub const IMAGE: u32 = 2;
}
