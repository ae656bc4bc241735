//! System tracks by state, and their history in numbers.

use messages::{Counter, Counters};
use serde::Serialize;

/// The system tracks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct TrackCounts {
    /// Confirmed now, coasted ones apart.
    pub confirmed: u64,
    /// Coasted now.
    pub coasted: u64,
    /// Tentative now.
    pub tentative: u64,
    /// Suspended now: not shown, while their numbers rest.
    pub suspended: u64,
    /// Maximum number that were confirmed or coasted at a time.
    pub live_max: u64,
    /// Started so far.
    pub started: u64,
    /// Confirmed so far.
    pub ever_confirmed: u64,
    /// Ended so far.
    pub ended: u64,
    /// Resumed by their targets after a silence, so far.
    pub resumed: u64,
    /// Found to be the same target as another, so far.
    pub merged: u64,
    /// Sensor tracks removed from a system track that they no longer fitted, so far.
    pub split: u64,
    /// Changes of the selected source, so far.
    pub hand_overs: u64,
}

impl TrackCounts {
    /// Returns the counts by fusion's counters; `live_max` is the maximum number confirmed or coasted so far.
    pub fn new(fusion: &Counters, live_max: u64) -> Self {
        let (live, coasted) = (fusion[Counter::LiveTracks], fusion[Counter::CoastedTracks]);
        Self {
            confirmed: live.saturating_sub(coasted),
            coasted,
            tentative: fusion[Counter::TentativeTracks],
            suspended: fusion[Counter::SuspendedTracks],
            live_max,
            started: fusion[Counter::TracksStarted],
            ever_confirmed: fusion[Counter::TracksConfirmed],
            ended: fusion[Counter::TracksTerminated],
            resumed: fusion[Counter::NumbersResumed],
            merged: fusion[Counter::TracksMerged],
            split: fusion[Counter::ContributionsSplit],
            hand_overs: fusion[Counter::HandOvers],
        }
    }
}
