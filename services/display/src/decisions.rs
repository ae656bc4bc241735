//! Latest decisions of fusion on each system track.
//!
//! One queue for all tracks would lose the decisions on a quiet track to those on busy ones. Each system track
//! therefore has its own decisions.

use std::collections::VecDeque;

use messages::Decision;
use rustc_hash::FxHashMap;

/// Maximum number of decisions on one system track.
const DECISIONS_MAX: usize = 20;
/// Maximum number of system tracks; with their decisions 13 MB.
const TRACKS_MAX: usize = 10_000;

/// Decisions by system track, see the module's documentation.
#[derive(Debug, Default)]
pub(crate) struct Decisions {
    tracks: FxHashMap<u32, VecDeque<Decision>>,
}

impl Decisions {
    /// Stores a decision for each system track of it.
    pub(crate) fn keep(&mut self, decision: &Decision) {
        let tracks = [decision.system_track, decision.other_system_track];
        for track in tracks.into_iter().filter(|track| *track != 0) {
            if self.tracks.len() >= TRACKS_MAX && !self.tracks.contains_key(&track) {
                continue;
            }
            let known = self.tracks.entry(track).or_default();
            if known.len() == DECISIONS_MAX {
                known.pop_front();
            }
            known.push_back(*decision);
        }
    }

    /// Returns the decisions on a system track, the latest first.
    pub(crate) fn of(&self, track: u32) -> impl Iterator<Item = &Decision> {
        self.tracks.get(&track).into_iter().flatten().rev()
    }

    /// Drops the tracks without a decision since `oldest_ns` for which `is_live` is false.
    pub(crate) fn forget_before(&mut self, oldest_ns: i64, is_live: impl Fn(u32) -> bool) {
        let is_recent = |known: &VecDeque<Decision>| known.back().is_some_and(|last| last.time_ns >= oldest_ns);
        self.tracks.retain(|track, known| is_live(*track) || is_recent(known));
    }
}

#[cfg(test)]
mod tests {
    use messages::DecisionKind;

    use super::*;

    fn decision(system_track: u32, time_ns: i64) -> Decision {
        Decision {
            system_track,
            time_ns,
            kind: DecisionKind::Joined as u8,
            ..Decision::default()
        }
    }

    #[test]
    fn a_busy_track_takes_no_decision_from_a_quiet_one() {
        let mut decisions = Decisions::default();
        decisions.keep(&decision(1, 5));
        (0..1_000).for_each(|time| decisions.keep(&decision(2, time)));
        assert_eq!(decisions.of(1).count(), 1);
        let times: Vec<i64> = decisions.of(2).map(|decision| decision.time_ns).collect();
        assert_eq!(times, (980..1_000).rev().collect::<Vec<i64>>());
        (10..2 * TRACKS_MAX as u32).for_each(|track| decisions.keep(&decision(track, 5)));
        assert_eq!(decisions.tracks.len(), TRACKS_MAX);
        decisions.forget_before(6, |track| track == 1);
        assert_eq!(decisions.tracks.len(), 2);
    }
}
