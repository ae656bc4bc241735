//! Latencies per stage and source.
//!
//! A latency is recorded in the histograms of its source only. At the close of an interval, histograms are added over
//! the sources and to the totals. Recording therefore costs six increments, whatever is shown later.
//!
//! A missing stamp, a stamp before its predecessor, or more than ten minutes after it, gives no latency: it is
//! counted per stage. (The age of recorded data is years, for example.) A latency beyond the stage's deadline is
//! recorded and counted as a miss; for a report that waited for its scan by design, the deadline counts from the end of
//! that wait.
//!
//! Recording allocates nothing once every source has reported and each histogram covers the occurring latencies: a
//! histogram grows with the first value beyond its end.

use hdrhistogram::Histogram;
use messages::{NO_SOURCE, SystemTrack};

use crate::deadlines::Deadlines;
use crate::stage::{JourneyEnd, Stage};
use crate::summary::Summary;

/// Longest recorded latency, nanoseconds: ten minutes.
pub const VALUE_MAX_NS: u64 = 600_000_000_000;
/// Maximum number of sources with own histograms.
pub const SOURCES_MAX: usize = 128;
/// Source number under which sources beyond the maximum are recorded together.
pub const OTHER_SOURCES: u16 = NO_SOURCE;

/// Time span of a figure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Span {
    /// Latest closed interval.
    Interval,
    /// All closed intervals.
    Total,
}

/// Stamps of one stage that were counted instead of recorded.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Irregularities {
    /// One of the two stamps is missing (0 or negative).
    pub missing: u64,
    /// The stage ended before it began.
    pub negative: u64,
    /// The stage took more than ten minutes.
    pub too_long: u64,
}

/// Extent of a measurement.
#[derive(Clone, Copy, Debug)]
pub struct Journey {
    /// Number of sources with own histograms, in the order of their first reports.
    pub sources_max: usize,
    /// End of the journey.
    pub end: JourneyEnd,
    /// Deadlines of the stages.
    pub deadlines: Deadlines,
}

impl Default for Journey {
    fn default() -> Self {
        Self {
            sources_max: SOURCES_MAX,
            end: JourneyEnd::Received,
            deadlines: Deadlines::default(),
        }
    }
}

/// Latencies per stage and source.
#[derive(Clone, Debug)]
pub struct Stages {
    journey: Journey,
    /// Sources in the order of their numbers.
    sources: Vec<SourceStages>,
    all: [Closed; 6],
    irregularities: [Irregularities; 6],
    recorded: u64,
    untriggered: u64,
    /// Source number below which the present interval is closed; 0 while no interval is being closed.
    next_to_close: u32,
}

#[derive(Clone, Debug)]
struct SourceStages {
    number: u16,
    /// Open interval.
    current: [Histogram<u64>; 6],
    /// Missed deadlines in the open interval.
    current_misses: [u64; 6],
    closed: [Closed; 6],
}

impl SourceStages {
    /// Closes the interval and adds it to the interval of `all` sources.
    fn close_interval(&mut self, all: &mut [Closed; 6]) {
        for (index, closed) in self.closed.iter_mut().enumerate() {
            std::mem::swap(&mut closed.interval, &mut self.current[index]);
            self.current[index].reset();
            closed.interval_misses = std::mem::take(&mut self.current_misses[index]);
            closed.add_up();
            add(&mut all[index].interval, &closed.interval);
            all[index].interval_misses += closed.interval_misses;
        }
    }
}

#[derive(Clone, Debug)]
struct Closed {
    interval: Histogram<u64>,
    total: Histogram<u64>,
    interval_misses: u64,
    total_misses: u64,
}

impl Closed {
    fn new() -> Self {
        Self {
            interval: empty(),
            total: empty(),
            interval_misses: 0,
            total_misses: 0,
        }
    }

    /// Adds the interval to the total.
    fn add_up(&mut self) {
        add(&mut self.total, &self.interval);
        self.total_misses += self.interval_misses;
    }
}

/// Creates a histogram that grows with its values, so that a quiet source costs little.
fn empty() -> Histogram<u64> {
    Histogram::new(3).expect("three significant digits are possible")
}

fn add(to: &mut Histogram<u64>, from: &Histogram<u64>) {
    to.add(from).expect("the histogram grows as needed");
}

impl Default for Stages {
    fn default() -> Self {
        Self::new(Journey::default())
    }
}

impl Stages {
    /// Creates an empty measurement.
    pub fn new(journey: Journey) -> Self {
        Self {
            journey,
            sources: Vec::with_capacity(journey.sources_max + 1),
            all: std::array::from_fn(|_| Closed::new()),
            irregularities: Default::default(),
            recorded: 0,
            untriggered: 0,
            next_to_close: 0,
        }
    }

    /// Records the stages of a system track received at `received_ns` on the stages' monotonic clock,
    /// `received_utc_ns` in UTC.
    ///
    /// A state without a report (coasting, termination) has no stages and is counted only.
    pub fn record(&mut self, track: &SystemTrack, received_ns: i64, received_utc_ns: i64) {
        if track.trigger_source == NO_SOURCE {
            self.untriggered += 1;
            return;
        }
        self.recorded += 1;
        let place = self.place_for(track.trigger_source);
        let source = &mut self.sources[place];
        let ended = self.journey.end.of(track, received_ns, received_utc_ns);
        for (index, stage) in Stage::ALL.into_iter().enumerate() {
            if !stage.is_measured(self.journey.end) {
                continue;
            }
            let (begun_ns, ended_ns) = stage.stamps(track, ended);
            let irregularities = &mut self.irregularities[index];
            if begun_ns <= 0 || ended_ns <= 0 {
                irregularities.missing += 1;
            } else if ended_ns < begun_ns {
                irregularities.negative += 1;
            } else if (ended_ns - begun_ns) as u64 > VALUE_MAX_NS {
                irregularities.too_long += 1;
            } else {
                let took_ns = (ended_ns - begun_ns) as u64;
                source.current[index]
                    .record(took_ns)
                    .expect("the histogram grows as needed");
                let deadline_ns = self.journey.deadlines.get(stage);
                let answered_ns = took_ns.saturating_sub(stage.held_ns(track));
                source.current_misses[index] +=
                    u64::from(deadline_ns.is_some_and(|deadline_ns| answered_ns > deadline_ns));
            }
        }
    }

    /// Closes the interval and opens the next: latencies since the last call become [`Span::Interval`] and are added
    /// to [`Span::Total`].
    pub fn close_interval(&mut self) {
        while self.close_next_source() {}
    }

    /// Does a part of [`Stages::close_interval`]: closes the interval of one source, in some tenths of a millisecond,
    /// so that recording can continue in between. Later latencies of the source belong to its next interval. Returns
    /// `false` at the end; only then are the figures of all sources together complete.
    pub fn close_next_source(&mut self) -> bool {
        if self.next_to_close == 0 {
            for all in &mut self.all {
                all.interval.reset();
                all.interval_misses = 0;
            }
        }
        // By number, not by place: a new source may have appeared.
        let end = self.sources.last().map_or(0, |source| u32::from(source.number) + 1);
        let waiting = |source: &&mut SourceStages| u32::from(source.number) >= self.next_to_close;
        if let Some(source) = self.sources.iter_mut().find(waiting) {
            self.next_to_close = u32::from(source.number) + 1;
            source.close_interval(&mut self.all);
        }
        if self.next_to_close < end {
            return true;
        }
        self.next_to_close = 0;
        self.all.iter_mut().for_each(Closed::add_up);
        false
    }

    /// Returns the numbers of the sources with histograms, rising.
    pub fn sources(&self) -> impl ExactSizeIterator<Item = u16> + '_ {
        self.sources.iter().map(|source| source.number)
    }

    /// Returns the extent of the measurement.
    pub fn journey(&self) -> &Journey {
        &self.journey
    }

    /// Returns the latencies of one stage in nanoseconds, of one source or of all (`None`). `None` if the source has
    /// not reported, or the stage is not measured.
    pub fn histogram(&self, stage: Stage, source: Option<u16>, span: Span) -> Option<&Histogram<u64>> {
        let closed = self.closed(stage, source)?;
        Some(match span {
            Span::Interval => &closed.interval,
            Span::Total => &closed.total,
        })
    }

    /// Returns the number of missed deadlines of one stage, with reports of one source or of all (`None`).
    pub fn deadline_misses(&self, stage: Stage, source: Option<u16>, span: Span) -> u64 {
        self.closed(stage, source).map_or(0, |closed| match span {
            Span::Interval => closed.interval_misses,
            Span::Total => closed.total_misses,
        })
    }

    fn closed(&self, stage: Stage, source: Option<u16>) -> Option<&Closed> {
        let closed = match source {
            None => &self.all,
            Some(number) => {
                let place = self.sources.binary_search_by_key(&number, |source| source.number);
                &self.sources[place.ok()?].closed
            }
        };
        stage.is_measured(self.journey.end).then_some(&closed[stage as usize])
    }

    /// Returns the figures of one stage, of one source or of all (`None`); all 0 without latencies.
    pub fn summary(&self, stage: Stage, source: Option<u16>, span: Span) -> Summary {
        self.histogram(stage, source, span)
            .map_or_else(Summary::default, Summary::from)
    }

    /// Returns the counts of latencies that were not recorded in one stage, since the start.
    pub fn irregularities(&self, stage: Stage) -> Irregularities {
        self.irregularities[stage as usize]
    }

    /// Returns the number of recorded system tracks since the start.
    pub fn recorded(&self) -> u64 {
        self.recorded
    }

    /// Returns the number of system tracks without a report since the start.
    pub fn untriggered(&self) -> u64 {
        self.untriggered
    }

    fn place_for(&mut self, number: u16) -> usize {
        let find =
            |sources: &[SourceStages], number: u16| sources.binary_search_by_key(&number, |source| source.number);
        match find(&self.sources, number) {
            Ok(place) => place,
            Err(place) if self.sources.len() < self.journey.sources_max => self.insert(place, number),
            Err(_) => match find(&self.sources, OTHER_SOURCES) {
                Ok(place) => place,
                Err(place) => self.insert(place, OTHER_SOURCES),
            },
        }
    }

    fn insert(&mut self, place: usize, number: u16) -> usize {
        let source = SourceStages {
            number,
            current: std::array::from_fn(|_| empty()),
            current_misses: [0; 6],
            closed: std::array::from_fn(|_| Closed::new()),
        };
        self.sources.insert(place, source);
        place
    }
}

#[cfg(test)]
mod tests {
    use messages::StageTimes;

    use super::*;

    const RECEIVED_NS: i64 = 1_000_000_000;
    const UTC_NS: i64 = 1_700_000_000_000_000_000;

    /// Stages of 1, 2, 3 and 4 units; measured 100 units before reception.
    fn track(source: u16, unit_ns: i64) -> SystemTrack {
        let fused_ns = RECEIVED_NS - 4 * unit_ns;
        SystemTrack {
            trigger_source: source,
            time_of_measurement_ns: UTC_NS - 100 * unit_ns,
            stages: StageTimes {
                ingested_ns: fused_ns - 6 * unit_ns,
                published_ns: fused_ns - 5 * unit_ns,
                taken_ns: fused_ns - 3 * unit_ns,
                fused_ns,
            },
            ..SystemTrack::default()
        }
    }

    #[test]
    fn figures_known_by_construction() {
        let mut stages = Stages::default();
        for unit_ns in 1..=1000 {
            stages.record(&track(2, unit_ns), RECEIVED_NS, UTC_NS);
        }
        assert_eq!(
            stages.summary(Stage::EndToEnd, None, Span::Total).count,
            0,
            "not closed yet"
        );
        stages.close_interval();
        for (stage, factor) in Stage::ALL.into_iter().zip([1, 2, 3, 4, 10, 100]) {
            let summary = stages.summary(stage, None, Span::Total);
            assert_eq!(summary.count, 1000);
            let near = |value: u64, expected: u64| {
                assert!(
                    value.abs_diff(expected) as f64 <= 1e-3 * expected as f64,
                    "{stage:?} {value}"
                );
            };
            near(summary.p50_ns, 500 * factor);
            near(summary.p90_ns, 900 * factor);
            near(summary.p99_ns, 990 * factor);
            near(summary.p999_ns, 999 * factor);
            near(summary.max_ns, 1000 * factor);
            assert!((summary.mean_ns / (500.5 * factor as f64) - 1.0).abs() < 1e-3);
            assert_eq!(summary, stages.summary(stage, Some(2), Span::Interval));
            assert_eq!(stages.irregularities(stage), Irregularities::default());
        }
    }

    #[test]
    fn intervals_add_up_over_sources_and_time() {
        let mut stages = Stages::default();
        let count = |stages: &Stages, source, span| stages.summary(Stage::TakenToFused, source, span).count;
        stages.record(&track(5, 10), RECEIVED_NS, UTC_NS);
        stages.record(&track(1, 20), RECEIVED_NS, UTC_NS);
        stages.close_interval();
        stages.record(&track(5, 30), RECEIVED_NS, UTC_NS);
        stages.close_interval();
        assert_eq!(stages.sources().collect::<Vec<_>>(), [1, 5]);
        assert_eq!(count(&stages, None, Span::Interval), 1);
        assert_eq!(count(&stages, Some(1), Span::Interval), 0);
        assert_eq!(count(&stages, Some(5), Span::Interval), 1);
        assert_eq!(count(&stages, None, Span::Total), 3);
        assert_eq!(count(&stages, Some(5), Span::Total), 2);
        assert_eq!(stages.summary(Stage::TakenToFused, None, Span::Total).max_ns, 90);
        assert_eq!(
            stages.summary(Stage::TakenToFused, Some(7), Span::Total),
            Summary::default()
        );
        stages.close_interval();
        assert_eq!(count(&stages, None, Span::Interval), 0);
        assert_eq!(count(&stages, None, Span::Total), 3);
    }

    #[test]
    fn recording_goes_on_while_an_interval_is_closed_source_by_source() {
        let mut stages = Stages::default();
        let count = |stages: &Stages, source, span| stages.summary(Stage::EndToEnd, source, span).count;
        for source in [2, 5, 9] {
            stages.record(&track(source, 10), RECEIVED_NS, UTC_NS);
        }
        let mut parts = 1;
        while stages.close_next_source() {
            parts += 1;
            // Of a closed source, an open source, and an unknown source.
            for source in [2, 9, 7] {
                stages.record(&track(source, 10), RECEIVED_NS, UTC_NS);
            }
        }
        assert_eq!(parts, 4, "the new one too");
        let intervals = [2, 5, 7, 9].map(|source| count(&stages, Some(source), Span::Interval));
        assert_eq!(intervals, [1, 1, 2, 4]);
        assert_eq!(count(&stages, None, Span::Interval), 8);
        stages.close_interval();
        assert_eq!(
            count(&stages, None, Span::Total),
            12,
            "nothing is lost or counted twice"
        );
        assert_eq!(stages.recorded(), 12);
        let mut nothing = Stages::default();
        assert!(!nothing.close_next_source());
    }

    #[test]
    fn impossible_stamps_are_counted() {
        let mut stages = Stages::default();
        let mut missing = track(1, 10);
        missing.stages.published_ns = 0;
        stages.record(&missing, RECEIVED_NS, UTC_NS);
        // Received before fused: another machine's clock.
        stages.record(&track(1, 10), RECEIVED_NS - 100, UTC_NS);
        // Recorded data: as old as the recording.
        stages.record(&track(1, 10), RECEIVED_NS, 2 * UTC_NS);
        stages.close_interval();
        let counts = |stage| {
            let Irregularities {
                missing,
                negative,
                too_long,
            } = stages.irregularities(stage);
            let count = stages.summary(stage, None, Span::Total).count;
            (count, missing, negative, too_long)
        };
        assert_eq!(counts(Stage::IngestToPublish), (2, 1, 0, 0));
        assert_eq!(counts(Stage::PublishToTaken), (2, 1, 0, 0));
        assert_eq!(counts(Stage::TakenToFused), (3, 0, 0, 0));
        assert_eq!(counts(Stage::FusedToReceived), (2, 0, 1, 0));
        assert_eq!(counts(Stage::EndToEnd), (3, 0, 0, 0));
        assert_eq!(counts(Stage::Age), (2, 0, 0, 1));
        assert_eq!((stages.recorded(), stages.untriggered()), (3, 0));
    }

    #[test]
    fn a_subscriber_that_looks_now_and_then_does_not_measure_its_own_pause() {
        let mut stages = Stages::new(Journey {
            end: JourneyEnd::Published,
            ..Journey::default()
        });
        // Fused 40 ns before reception, had the subscriber not paused for 5 ms.
        stages.record(&track(1, 10), RECEIVED_NS + 5_000_000, UTC_NS + 5_000_000);
        let mut unfused = track(1, 10);
        unfused.stages.fused_ns = 0;
        stages.record(&unfused, RECEIVED_NS, UTC_NS);
        stages.close_interval();
        let max = |stage| stages.summary(stage, Some(1), Span::Total).max_ns;
        assert_eq!((max(Stage::TakenToFused), max(Stage::EndToEnd)), (30, 60));
        assert_eq!(max(Stage::Age), 1000 - 40);
        assert!(stages.histogram(Stage::FusedToReceived, None, Span::Total).is_none());
        assert_eq!(
            stages.irregularities(Stage::FusedToReceived),
            Irregularities::default(),
            "not even counted"
        );
        assert_eq!(stages.irregularities(Stage::EndToEnd).missing, 1);
        assert_eq!(stages.irregularities(Stage::Age).missing, 1);
    }

    #[test]
    fn what_takes_longer_than_its_deadline_is_counted_by_stage_source_and_span() {
        let deadlines = Deadlines::default()
            .with(Stage::TakenToFused, Some(30))
            .with(Stage::EndToEnd, Some(150));
        let mut stages = Stages::new(Journey {
            deadlines,
            ..Journey::default()
        });
        // Fusion: 30 (just in time), 33, 60 and 300; end to end: 100, 110, 200 and 1000.
        for (source, unit_ns) in [(1, 10), (2, 11), (2, 20)] {
            stages.record(&track(source, unit_ns), RECEIVED_NS, UTC_NS);
        }
        stages.close_interval();
        stages.record(&track(1, 100), RECEIVED_NS, UTC_NS);
        stages.close_interval();
        let misses = |stage, source, span| stages.deadline_misses(stage, source, span);
        assert_eq!(misses(Stage::TakenToFused, None, Span::Total), 3);
        assert_eq!(misses(Stage::TakenToFused, None, Span::Interval), 1);
        assert_eq!(misses(Stage::TakenToFused, Some(1), Span::Total), 1);
        assert_eq!(misses(Stage::TakenToFused, Some(2), Span::Total), 2);
        assert_eq!(misses(Stage::TakenToFused, Some(2), Span::Interval), 0);
        assert_eq!(misses(Stage::EndToEnd, None, Span::Total), 2);
        assert_eq!(
            misses(Stage::PublishToTaken, None, Span::Total),
            0,
            "nobody set a deadline"
        );
        assert_eq!(misses(Stage::EndToEnd, Some(9), Span::Total), 0, "no such source");
    }

    #[test]
    fn deadlines_count_from_when_a_report_could_be_answered() {
        let us = 1_000;
        let deadlines = Deadlines::default()
            .with(Stage::PublishToTaken, Some(10 * us as u64))
            .with(Stage::TakenToFused, Some(30 * us as u64))
            .with(Stage::EndToEnd, Some(150 * us as u64));
        let mut stages = Stages::new(Journey {
            deadlines,
            ..Journey::default()
        });
        // Fusion takes 60 µs, all 200 µs, of which the scan took 20, 30 and 50.
        for held_us in [20, 30, 50] {
            let state = SystemTrack {
                held_us,
                ..track(1, 20 * us)
            };
            stages.record(&state, RECEIVED_NS, UTC_NS);
        }
        stages.close_interval();
        let misses = |stage| stages.deadline_misses(stage, None, Span::Total);
        assert_eq!((misses(Stage::TakenToFused), misses(Stage::EndToEnd)), (1, 2));
        assert_eq!(misses(Stage::PublishToTaken), 3, "no scan is waited for there");
        let fusion = stages.summary(Stage::TakenToFused, None, Span::Total);
        assert!(fusion.max_ns >= 60 * us as u64, "what subscribers wait is shown whole");
    }

    #[test]
    fn states_without_a_report_are_counted() {
        let mut stages = Stages::default();
        stages.record(&track(NO_SOURCE, 10), RECEIVED_NS, UTC_NS);
        stages.close_interval();
        assert_eq!((stages.recorded(), stages.untriggered()), (0, 1));
        assert_eq!(stages.summary(Stage::EndToEnd, None, Span::Total).count, 0);
    }

    #[test]
    fn sources_beyond_the_maximum_are_recorded_together() {
        let mut stages = Stages::new(Journey {
            sources_max: 2,
            ..Journey::default()
        });
        for source in [3, 1, 4, 1, 5, 9, 2, 6] {
            stages.record(&track(source, 10), RECEIVED_NS, UTC_NS);
        }
        stages.close_interval();
        assert_eq!(stages.sources().collect::<Vec<_>>(), [1, 3, OTHER_SOURCES]);
        let count = |source| stages.summary(Stage::EndToEnd, source, Span::Total).count;
        assert_eq!((count(Some(1)), count(Some(3)), count(Some(OTHER_SOURCES))), (2, 1, 5));
        assert_eq!(count(None), 8);
    }

    #[test]
    fn range_is_one_nanosecond_to_ten_minutes() {
        let mut stages = Stages::default();
        let longest = VALUE_MAX_NS as i64;
        for taken in [1, longest, longest + 1] {
            let mut track = track(1, 10);
            track.stages.fused_ns = track.stages.taken_ns + taken;
            stages.record(&track, i64::MAX, UTC_NS);
        }
        stages.close_interval();
        let summary = stages.summary(Stage::TakenToFused, None, Span::Total);
        assert_eq!((summary.count, summary.p50_ns), (2, 1));
        assert!(summary.max_ns.abs_diff(VALUE_MAX_NS) <= VALUE_MAX_NS / 1000);
        assert_eq!(stages.irregularities(Stage::TakenToFused).too_long, 1);
    }
}
