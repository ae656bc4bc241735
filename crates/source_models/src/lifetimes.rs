//! Life times of reports and tracks, in multiples of their sources' periods.
//!
//! A track must live until the next report of its slowest source. With a radar turn of twelve seconds, tracks with a
//! life time of six would restart at every turn. Life times without a configured value follow from the sources'
//! periods, and an unknown period is learned: the median time between two reports of a sensor track. Before the second
//! report of a source, the source may be slow, and tracks get sufficient time. A track also survives the occasional
//! gaps of its sources (module `gaps`). For a target with fewer reports than other targets of the same sources, the
//! target's own intervals count instead (module `rhythm`), unless `fresh_s` or `life.terminate_s` is stated.
//!
//! Reports may be late (order `arrival`): a measurement some seconds old may be the latest available. The usual
//! lateness of a source's reports is learned, and added to the validity time of the reports.

use messages::NS_PER_S;
use serde::{Deserialize, Serialize};

use crate::gaps::Gaps;
use crate::median::Median;
use crate::restarts::Restarts;
use crate::rhythm::Rhythm;
use crate::settings::{FRESH_PERIODS, LifeSettings, SourceSet, SourceSettings};

/// Time allowed for a source's second report of a track, nanoseconds: slower sources are rare.
const PATIENCE_NS: i64 = 60_000_000_000;

/// Binary logarithms of the step sizes of the lateness estimate: for a report later than expected, and for other
/// reports. About one report in ten exceeds the estimate.
const LATER: u32 = 2;
const EARLIER: u32 = 5;

/// How long reports and tracks live.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct Lifetimes {
    learned: Vec<LearnedPeriod>,
    /// Validity time of a report, per source, nanoseconds: the periods of the source plus the usual lateness.
    fresh_ns: Vec<i64>,
    /// How late most reports are, per source, nanoseconds; `None` before the first.
    late_ns: Vec<Option<i64>>,
    /// The gaps of each source; empty with a configured life time.
    gaps: Vec<Gaps>,
    /// Sources with a configured validity time of reports, as bits.
    states_fresh: SourceSet,
    /// Time without a report after which a tentative track ends, nanoseconds.
    pub(crate) tentative_ns: i64,
    /// Least time without a report after which a confirmed track ends, nanoseconds.
    pub(crate) terminate_ns: i64,
    /// The latest restarts of the sources.
    pub(crate) restarts: Restarts,
}

/// Period of a source without a configured period.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct LearnedPeriod {
    /// The shortest accepted period, nanoseconds; `None` if the source's period is stated.
    least_ns: Option<i64>,
    interval_s: Median,
    /// Time of the source's first report, nanoseconds.
    first_ns: Option<i64>,
}

impl LearnedPeriod {
    /// Whether a second report of the source may still be expected at `now_ns`.
    fn is_awaited(&self, now_ns: i64) -> bool {
        let has_begun = |first_ns: i64| now_ns.saturating_sub(first_ns) <= PATIENCE_NS;
        self.least_ns.is_some() && self.interval_s.is_unknown() && self.first_ns.is_some_and(has_begun)
    }
}

impl Lifetimes {
    pub(crate) fn new(settings: &LifeSettings, sources: &[SourceSettings]) -> Self {
        let learned = sources.iter().map(|source| LearnedPeriod {
            least_ns: source.learns_period.then_some(source.period_ns),
            interval_s: Median::default(),
            first_ns: None,
        });
        let mut new = Self {
            learned: learned.collect(),
            fresh_ns: sources.iter().map(|source| source.fresh_ns).collect(),
            late_ns: vec![None; sources.len()],
            gaps: match settings.terminate_s {
                Some(_) => Vec::new(),
                None => vec![Gaps::default(); sources.len()],
            },
            states_fresh: (0..)
                .zip(sources)
                .filter(|(_, source)| source.states_fresh)
                .map(|(number, _)| number)
                .collect(),
            tentative_ns: 0,
            terminate_ns: 0,
            restarts: Restarts::new(sources.len()),
        };
        new.derive(settings, i64::MIN);
        new
    }

    /// Validity time of a report of `source`, nanoseconds.
    #[inline]
    pub(crate) fn fresh_ns(&self, source: u16) -> i64 {
        self.fresh_ns[usize::from(source)]
    }

    /// Updates the rhythm of a target, with or without address or MMSI, from a report of `source`, `interval_ns` after
    /// the previous report.
    #[inline]
    pub(crate) fn learn_rhythm(&self, rhythm: &mut Rhythm, (source, is_named): (u16, bool), interval_ns: i64) {
        if !self.states_fresh.contains(source) {
            rhythm.learn(interval_ns, self.fresh_ns(source), is_named);
        }
    }

    /// How late most reports of `source` are, nanoseconds.
    #[inline]
    pub(crate) fn late_ns(&self, source: u16) -> i64 {
        self.late_ns[usize::from(source)].unwrap_or_default()
    }

    /// Learns from the lateness of a report of `source`, nanoseconds.
    #[inline]
    pub(crate) fn learn_lateness(&mut self, source: u16, late_ns: i64) {
        let known = &mut self.late_ns[usize::from(source)];
        let change_ns = match *known {
            None => late_ns,
            Some(before_ns) if late_ns > before_ns => (late_ns - before_ns) >> LATER,
            Some(before_ns) => (late_ns - before_ns) >> EARLIER,
        };
        *known = Some(known.unwrap_or_default() + change_ns);
        self.fresh_ns[usize::from(source)] += change_ns;
    }

    /// Learns from an interval between two reports of one sensor track of `source`.
    #[inline]
    pub(crate) fn learn_gap(&mut self, source: u16, interval_ns: i64) {
        if let Some(gaps) = self.gaps.get_mut(usize::from(source)) {
            gaps.learn(interval_ns);
        }
    }

    /// Time without a report after which a track of `source` ends, nanoseconds.
    #[inline]
    pub(crate) fn silence_ns(&self, source: u16) -> i64 {
        let gaps = self.gaps.get(usize::from(source));
        gaps.map_or(0, Gaps::silence_ns).max(self.terminate_ns)
    }

    /// The same for a target with this rhythm; `usual_ns` is the life time otherwise.
    #[inline]
    pub(crate) fn silence_at(&self, rhythm: Rhythm, usual_ns: i64) -> i64 {
        match self.gaps.is_empty() {
            true => usual_ns,
            false => usual_ns.max(rhythm.silence_ns()),
        }
    }

    /// Time without a report after which a confirmed track of these sources ends, nanoseconds.
    pub(crate) fn silence_of(&self, sources: SourceSet) -> i64 {
        sources
            .iter()
            .filter(|source| usize::from(*source) < self.fresh_ns.len())
            .map(|source| self.silence_ns(source))
            .max()
            .unwrap_or(self.terminate_ns)
    }

    /// Learns from a report of `source`, `since_ns` after the previous report of its sensor track, if any.
    #[inline]
    pub(crate) fn learn(&mut self, source: u16, time_ns: i64, since_ns: Option<i64>) {
        let learned = &mut self.learned[usize::from(source)];
        if learned.least_ns.is_none() {
            return;
        }
        if learned.first_ns.is_none() {
            learned.first_ns = Some(time_ns);
        }
        if let Some(since_ns) = since_ns.filter(|since_ns| *since_ns > 0) {
            learned.interval_s.add(since_ns as f64 / NS_PER_S);
        }
    }

    /// Sets the sources' periods to the learned values, and derives all life times; returns whether a period has
    /// changed.
    pub(crate) fn follow(&mut self, settings: &LifeSettings, sources: &mut [SourceSettings], now_ns: i64) -> bool {
        let mut has_changed = false;
        let known = self.learned.iter().zip(&mut self.fresh_ns).zip(&self.late_ns);
        for (((learned, fresh_ns), late_ns), source) in known.zip(sources) {
            let Some(least_ns) = learned.least_ns.filter(|_| !learned.interval_s.is_unknown()) else {
                continue;
            };
            let period_ns = least_ns.max((learned.interval_s.value() * NS_PER_S) as i64);
            has_changed |= period_ns != source.period_ns;
            source.period_ns = period_ns;
            source.fresh_ns = (FRESH_PERIODS * period_ns as f64) as i64;
            *fresh_ns = source.fresh_ns + late_ns.unwrap_or_default();
        }
        self.derive(settings, now_ns);
        has_changed
    }

    fn derive(&mut self, settings: &LifeSettings, now_ns: i64) {
        let longest_ns = self.fresh_ns.iter().copied().max().unwrap_or_default();
        let awaited = self.learned.iter().any(|learned| learned.is_awaited(now_ns));
        let least_ns = longest_ns.max(if awaited { PATIENCE_NS } else { 0 });
        self.tentative_ns = settings.tentative_ns(least_ns);
        self.terminate_ns = settings.terminate_ns(least_ns);
    }
}

#[cfg(test)]
mod tests {
    use settings::Seconds;

    use super::*;
    use crate::testing::test_settings;
    use test_support::S;

    #[test]
    fn unstated_times_follow_from_the_slowest_source() {
        let mut settings = test_settings(2);
        let lifetimes = Lifetimes::new(&settings.life, &settings.sources);
        assert_eq!((lifetimes.tentative_ns, lifetimes.terminate_ns), (6 * S, 20 * S));
        (settings.sources[1].period_ns, settings.sources[1].fresh_ns) = (12 * S, 30 * S);
        let lifetimes = Lifetimes::new(&settings.life, &settings.sources);
        assert_eq!((lifetimes.tentative_ns, lifetimes.terminate_ns), (30 * S, 30 * S + 1));
        settings.life.tentative_s = Some(Seconds::of_ns(40 * S));
        settings.life.terminate_s = Some(Seconds::of_ns(5 * S));
        let lifetimes = Lifetimes::new(&settings.life, &settings.sources);
        assert_eq!((lifetimes.tentative_ns, lifetimes.terminate_ns), (40 * S, 5 * S));
    }

    #[test]
    fn stated_times_that_cannot_work_are_told() {
        let keys = |tentative_s: Option<i64>, terminate_s: Option<i64>| {
            let mut settings = test_settings(2);
            (settings.sources[1].period_ns, settings.sources[1].fresh_ns) = (12 * S, 30 * S);
            settings.life.tentative_s = tentative_s.map(|seconds| Seconds::of_ns(seconds * S));
            settings.life.terminate_s = terminate_s.map(|seconds| Seconds::of_ns(seconds * S));
            let doubts = settings.doubtful_lifetimes();
            doubts.iter().map(|doubt| doubt.to_string()).collect::<Vec<_>>()
        };
        assert_eq!(keys(None, None), Vec::<String>::new());
        assert_eq!(keys(Some(30), Some(60)), Vec::<String>::new());
        let told = keys(Some(6), Some(20));
        assert_eq!(told.len(), 2);
        assert!(
            told[0].contains("tentative_s") && told[0].contains("source1, every 12 s"),
            "{told:?}"
        );
        assert!(
            told[1].contains("terminate_s") && told[1].contains("still counts, 30 s"),
            "{told:?}"
        );
        assert!(keys(Some(50), Some(40))[0].contains("outlives"));
    }

    #[test]
    fn what_comes_late_counts_as_much_longer() {
        let settings = test_settings(2);
        let mut lifetimes = Lifetimes::new(&settings.life, &settings.sources);
        let fresh_ns = lifetimes.fresh_ns(1);
        for _ in 0..5 {
            lifetimes.learn_lateness(1, 3 * S);
        }
        assert_eq!(
            [0, 1].map(|source| lifetimes.fresh_ns(source)),
            [fresh_ns, fresh_ns + 3 * S]
        );
        // Few of the delays 0, 1, …, 9 s exceed the expected delay.
        for report in 0..1000 {
            lifetimes.learn_lateness(1, report * 7 % 10 * S);
        }
        assert!(
            (6 * S..9 * S).contains(&lifetimes.late_ns(1)),
            "{}",
            lifetimes.late_ns(1)
        );
        for _ in 0..1000 {
            lifetimes.learn_lateness(1, 0);
        }
        assert!(lifetimes.late_ns(1) < S / 1000, "delays end");
    }

    #[test]
    fn a_track_lives_through_the_gaps_of_its_own_sources() {
        let mut settings = test_settings(2);
        let mut lifetimes = Lifetimes::new(&settings.life, &settings.sources);
        (0..10).for_each(|_| lifetimes.learn_gap(1, 30 * S));
        let both = SourceSet::of(0) | SourceSet::of(1);
        let sets = [SourceSet::of(0), SourceSet::of(1), both, SourceSet::ALL];
        let [one, other, both, all] = sets.map(|sources| lifetimes.silence_of(sources));
        assert_eq!((one, both, all), (20 * S, other, other));
        assert!((30 * S..45 * S).contains(&other), "{other}");
        settings.life.terminate_s = Some(Seconds::of_ns(5 * S));
        let mut stated = Lifetimes::new(&settings.life, &settings.sources);
        stated.learn_gap(1, 30 * S);
        assert_eq!(
            (stated.silence_ns(1), stated.silence_of(SourceSet::of(1))),
            (5 * S, 5 * S)
        );
    }

    #[test]
    fn an_unstated_period_is_learned_and_awaited_for_a_while() {
        let mut settings = test_settings(2);
        settings.sources[1].learns_period = true;
        let mut lifetimes = Lifetimes::new(&settings.life, &settings.sources);
        assert_eq!(lifetimes.tentative_ns, 6 * S);
        lifetimes.learn(1, 100 * S, None);
        assert!(!lifetimes.follow(&settings.life, &mut settings.sources, 100 * S));
        assert_eq!(lifetimes.tentative_ns, PATIENCE_NS);
        // A source without a second report no longer delays the others.
        assert!(!lifetimes.follow(&settings.life, &mut settings.sources, 161 * S));
        assert_eq!(lifetimes.tentative_ns, 6 * S);
        for report in 1..20 {
            // A miss now and then does not matter.
            let periods = if report % 5 == 0 { 2 } else { 1 };
            lifetimes.learn(1, (100 + 12 * report) * S, Some(12 * periods * S));
            lifetimes.learn(0, (100 + 12 * report) * S, Some(3 * S));
        }
        assert!(lifetimes.follow(&settings.life, &mut settings.sources, 340 * S));
        let (period_ns, fresh_ns) = (settings.sources[1].period_ns, lifetimes.fresh_ns(1));
        assert!((period_ns - 12 * S).abs() < S / 2, "{period_ns}");
        assert_eq!(fresh_ns, (2.5 * period_ns as f64) as i64);
        assert_eq!(lifetimes.tentative_ns, fresh_ns);
        assert_eq!(settings.sources[0].period_ns, S, "a stated period stays");
    }
}
