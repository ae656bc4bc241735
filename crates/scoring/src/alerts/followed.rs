//! The targets that tracks follow, over time.

use std::collections::BTreeMap;

use crate::continuity::Continuity;
use crate::picture::{Timeline, TimelinePass};

/// Time from an alert to the nearest second in which its track followed a target, seconds: a track that coasts through
/// the time of its alert is still that of its target.
const AWAY_MAX_S: f64 = 30.0;

/// Which target each track follows.
#[derive(Debug, Default)]
pub(super) struct Followed {
    /// By track, in the order of time.
    runs: BTreeMap<i64, Vec<Run>>,
    /// First second in which a target has a track.
    since_s: BTreeMap<i64, i64>,
}

/// Seconds in a row in which a track follows a target.
#[derive(Clone, Copy, Debug)]
struct Run {
    target: i64,
    first_s: i64,
    last_s: i64,
}

impl Followed {
    pub(super) fn of(truth: &Timeline, tracks: &Timeline, (first_s, last_s): (i64, i64), gate_m: f64) -> Self {
        let mut followed = Self::default();
        let (mut targets, mut shown) = (TimelinePass::new(truth), TimelinePass::new(tracks));
        let mut continuity = Continuity::new(gate_m, 0.0);
        for second in first_s..=last_s {
            let (targets, shown) = (targets.at(second), shown.at(second));
            if !truth.knows(&targets) {
                continuity.pause();
                continue;
            }
            continuity.add(&targets, &shown);
            for target in targets.iter().map(|target| target.id) {
                if let Some(track) = continuity.track_of(target) {
                    followed.add(track, target, second);
                }
            }
        }
        followed
    }

    fn add(&mut self, track: i64, target: i64, second: i64) {
        self.since_s.entry(target).or_insert(second);
        let runs = self.runs.entry(track).or_default();
        match runs.last_mut() {
            Some(run) if run.target == target && run.last_s + 1 >= second => run.last_s = second,
            _ => runs.push(Run {
                target,
                first_s: second,
                last_s: second,
            }),
        }
    }

    /// Number of tracks that followed a target.
    pub(super) fn tracks(&self) -> u64 {
        self.runs.len() as u64
    }

    /// The target that a track follows at a time, or next to it; `None` if it follows none.
    pub(super) fn target_of(&self, track: i64, time_s: f64) -> Option<i64> {
        let away_s = |run: &Run| (run.first_s as f64 - time_s).max(time_s - run.last_s as f64).max(0.0);
        let nearest = self
            .runs
            .get(&track)?
            .iter()
            .min_by(|one, other| away_s(one).total_cmp(&away_s(other)));
        nearest.filter(|run| away_s(run) <= AWAY_MAX_S).map(|run| run.target)
    }

    /// First second in which a target has a track; `None` if it never has one.
    pub(super) fn since_s(&self, target: i64) -> Option<i64> {
        self.since_s.get(&target).copied()
    }
}
