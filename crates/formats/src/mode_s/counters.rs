//! Counts of a reader.

use super::refusal::ModeSRefusal;

/// Counts of frames. Each frame is in exactly one of `accepted`, `other` and `refused`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ModeSCounters {
    /// Frames that were used.
    pub accepted: u64,
    /// Right frames of kinds that are not used, replies of Modes A and C, and messages without a frame.
    pub other: u64,
    /// Frames and lines that were refused, by [`ModeSRefusal`].
    pub refused: [u64; ModeSRefusal::ALL.len()],
    /// Frames with a time or with ticks of their own.
    pub timed: u64,
    /// Accepted frames with a position that waits for its pair.
    pub unpaired: u64,
    /// Accepted frames of ground stations about aircraft (TIS-B).
    pub tis_b: u64,
    /// Accepted frames of ground stations that repeat another data link (ADS-R).
    pub rebroadcast: u64,
    /// Accepted frames with an address that is not the aircraft's own.
    pub anonymous: u64,
    /// Observations given.
    pub observations: u64,
    /// Statements given.
    pub statements: u64,
    /// Octets between messages of Beast, which belong to none.
    pub damaged_octets: u64,
    /// Times at which the receiver's ticks began anew, in a stream dated by ticks.
    pub tick_restarts: u64,
}

impl ModeSCounters {
    /// Refused frames by reason.
    pub fn refusals(&self) -> impl Iterator<Item = (ModeSRefusal, u64)> {
        ModeSRefusal::ALL.into_iter().zip(self.refused)
    }

    /// Frames refused for one reason.
    pub fn refused(&self, reason: ModeSRefusal) -> u64 {
        self.refused[reason as usize]
    }

    /// Frames and lines refused for any reason.
    pub fn refused_sum(&self) -> u64 {
        self.refused.iter().sum()
    }
}
