//! Reports that teach, of a source with many reports.
//!
//! The accuracy of a source, its detection points, steps of its errors and the motion of targets follow from
//! innovations. Some tens of innovations a second suffice, however many the source sends: the estimates average over a
//! minute. So the innovations of a part of the targets teach. The targets are chosen by their numbers, for half a
//! minute each, because successive innovations of one target belong together, and because all sources should be
//! compared on the same targets. A choice by count alone would take the first reports of each scan, on one side of the
//! sky.
//!
//! Differences of states, for the systematic errors, have a sampling of their own by the number already known: a source
//! that is new needs all of them.

use serde::{Deserialize, Serialize};

/// Number of reports of a source that teach, per second.
const REPORTS_PER_S: f64 = 64.0;
/// Ticks for which a target teaches.
const TURN_TICKS: u32 = 32;
/// Weight of a tick in the mean number of reports: a slow source may send all its reports within one tick of several.
const TICK_WEIGHT: f64 = 1.0 / 8.0;

/// Sampling of the reports of all sources.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Sampling {
    sources: Vec<SampledSource>,
    ticks: u32,
    /// Changes the choice of targets.
    salt: u32,
}

/// Sampling of the reports of a source.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct SampledSource {
    /// Reports since the latest tick, and the mean number per tick.
    reports: u32,
    mean: f64,
    /// Largest mixed number of a target that teaches: the share of the targets, of the whole range.
    limit: u32,
}

impl Sampling {
    pub(crate) fn new(sources: usize) -> Self {
        let all = SampledSource {
            reports: 0,
            mean: 0.0,
            limit: u32::MAX,
        };
        Self {
            sources: vec![all; sources],
            ticks: 0,
            salt: 0,
        }
    }

    /// Counts a report of a source.
    #[inline]
    pub(crate) fn count(&mut self, source: u16) {
        let sampled = &mut self.sources[usize::from(source)];
        sampled.reports = sampled.reports.saturating_add(1);
    }

    /// Returns whether the reports of `source` on a target with this number teach now.
    #[inline]
    pub(crate) fn includes(&self, source: u16, target: u32) -> bool {
        let limit = self.sources[usize::from(source)].limit;
        limit == u32::MAX || mixed(target ^ self.salt) <= limit
    }

    /// Takes a tick of `tick_s` seconds.
    pub(crate) fn tick(&mut self, tick_s: f64) {
        for sampled in &mut self.sources {
            sampled.mean += TICK_WEIGHT * (f64::from(sampled.reports) - sampled.mean);
            sampled.reports = 0;
            let share = REPORTS_PER_S * tick_s / sampled.mean.max(REPORTS_PER_S * tick_s);
            sampled.limit = (share * f64::from(u32::MAX)) as u32;
        }
        self.ticks = self.ticks.wrapping_add(1);
        if self.ticks.is_multiple_of(TURN_TICKS) {
            self.salt = mixed(self.salt.wrapping_add(1));
        }
    }
}

/// Returns a number in which each bit depends on all bits of `number`: small successive numbers are spread evenly.
#[inline]
fn mixed(number: u32) -> u32 {
    let spread = number.wrapping_mul(0x9e37_79b1);
    (spread ^ (spread >> 15)).wrapping_mul(0x85eb_ca77)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A sampling of two sources after `ticks`: the first sends `reports` each tick, the second all in each fourth.
    fn after(ticks: u32, reports: u32) -> Sampling {
        let mut sampling = Sampling::new(2);
        for tick in 0..ticks {
            for _ in 0..reports {
                sampling.count(0);
                if tick % 4 == 0 {
                    (0..4).for_each(|_| sampling.count(1));
                }
            }
            sampling.tick(1.0);
        }
        sampling
    }

    fn chosen(sampling: &Sampling, source: u16) -> Vec<u32> {
        (1..=10_000)
            .filter(|target| sampling.includes(source, *target))
            .collect()
    }

    #[test]
    fn all_reports_of_a_source_with_few_teach() {
        let sampling = after(100, 60);
        assert_eq!(chosen(&sampling, 0).len(), 10_000);
    }

    #[test]
    fn of_many_reports_as_many_teach_as_of_few_however_they_come() {
        let sampling = after(100, 640);
        let share = |source: u16| chosen(&sampling, source).len() as f64 / 10_000.0;
        assert!((share(0) - 0.1).abs() < 0.02, "{}", share(0));
        assert!((0.05..0.2).contains(&share(1)), "{}", share(1));
    }

    #[test]
    fn sources_teach_on_the_same_targets_and_each_target_has_its_turn() {
        let sampling = after(100, 640);
        let (own, other) = (chosen(&sampling, 0), chosen(&sampling, 1));
        let (few, many) = if own.len() < other.len() {
            (&own, &other)
        } else {
            (&other, &own)
        };
        assert!(few.iter().all(|target| many.contains(target)));
        let (mut later, mut seen) = (sampling, std::collections::BTreeSet::new());
        for tick in 0..100 * TURN_TICKS {
            if tick % TURN_TICKS == 0 {
                seen.extend(chosen(&later, 0));
            }
            (0..640).for_each(|_| later.count(0));
            let before = chosen(&later, 0);
            later.tick(1.0);
            let goes_on = !later.ticks.is_multiple_of(TURN_TICKS);
            assert!(!goes_on || before.len().abs_diff(chosen(&later, 0).len()) < 3);
        }
        assert!(seen.len() > 9_900, "{}", seen.len());
    }
}
