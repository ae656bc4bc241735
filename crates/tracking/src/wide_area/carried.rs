//! State of wide-area support that a population carries from scan to scan.

use super::identification::Identities;

/// State after a scan.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SupportState {
    /// Reports that arrived up to this time, nanoseconds, have been used.
    pub(crate) reports_ns: i64,
    /// Emissions that were received up to this time, nanoseconds, have been used.
    pub(crate) emissions_ns: i64,
    /// Types and origins of the confirmed tracks.
    pub(crate) identities: Identities,
}

impl SupportState {
    /// Before the first scan, with room for `tracks_max` tracks and `types` types of targets.
    pub(crate) fn new(tracks_max: usize, types: usize) -> Self {
        Self {
            reports_ns: i64::MIN,
            emissions_ns: i64::MIN,
            identities: Identities::new(tracks_max, types),
        }
    }

    /// Takes over the time up to which reports are used. Tracks are identified after the update.
    pub(crate) fn follow(&mut self, before: &Self) {
        self.reports_ns = before.reports_ns;
    }
}
