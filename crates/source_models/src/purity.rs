//! Purity of each source: share of targets among its new tracks (BF-2).
//!
//! A source with many false tracks deserves less belief without support. A new track is a target if a second source
//! agrees, or if the track outlives the usual length of false tracks; a track with an earlier end is false.

use serde::{Deserialize, Serialize};

use crate::detection_map::HitCount;

/// Reports after which a track of a single source is a target: false tracks seldom get as many.
pub const LASTING_REPORTS: u32 = 12;
/// New tracks of a source beyond this number are forgotten.
const MEMORY: f64 = 64.0;
/// Targets and false tracks assumed before learning.
const PRIOR: f64 = 2.0;

/// Counts of new tracks per source.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Purity {
    tallies: Vec<HitCount>,
}

impl Purity {
    pub(crate) fn new(sources: usize) -> Self {
        Self {
            tallies: vec![HitCount::default(); sources],
        }
    }

    /// Counts a new track of a source as a target, or as false.
    pub(crate) fn learn(&mut self, source: u16, is_target: bool) {
        self.tallies[usize::from(source)].add(is_target, 1.0, MEMORY);
    }

    /// Logarithm of the odds that a new track of the source is a target; at most 0, so that reputation alone is never
    /// sufficient.
    pub(crate) fn log_odds(&self, source: u16) -> f64 {
        self.tallies[usize::from(source)].log_odds(PRIOR).min(0.0)
    }

    /// Share of false tracks among the new tracks of the source; 0 before any, 1 at most.
    pub(crate) fn false_share(&self, source: u16) -> f64 {
        let tally = &self.tallies[usize::from(source)];
        tally.tries() * (1.0 - tally.mean()) / (tally.tries() + 2.0 * PRIOR)
    }

    /// Counts of a source.
    pub(crate) fn tally(&self, source: u16) -> &HitCount {
        &self.tallies[usize::from(source)]
    }

    /// Counts of a source, for checkpoints.
    pub(crate) fn tally_mut(&mut self, source: usize) -> &mut HitCount {
        &mut self.tallies[source]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn false_tracks_count_against_their_source_alone() {
        let mut purity = Purity::new(2);
        for _ in 0..30 {
            purity.learn(0, true);
            purity.learn(1, false);
        }
        assert_eq!(purity.log_odds(0), 0.0);
        assert!(purity.log_odds(1) < -2.5, "{}", purity.log_odds(1));
    }

    #[test]
    fn a_source_that_became_pure_is_believed_again() {
        let mut purity = Purity::new(1);
        for is_target in [false, true] {
            for _ in 0..200 {
                purity.learn(0, is_target);
            }
        }
        assert_eq!(purity.log_odds(0), 0.0);
    }
}
