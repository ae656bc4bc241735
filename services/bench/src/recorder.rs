//! Records the answers: latencies from the intended times, and the number of answers to each report.

use hdrhistogram::Histogram;
use messages::{NO_SOURCE, SystemTrack};
use telemetry::Stage;

use crate::pace::Pace;

/// Longest distinguishable latency, nanoseconds.
const LONGEST_NS: u64 = 100_000_000_000;

/// Recorded stages: all stages with stamps of a single clock.
pub(crate) const STAGES: [Stage; 5] = [
    Stage::IngestToPublish,
    Stage::PublishToTaken,
    Stage::TakenToFused,
    Stage::FusedToReceived,
    Stage::EndToEnd,
];
const END_TO_END: usize = 4;

/// Creates a histogram that never allocates again.
pub(crate) fn histogram() -> Histogram<u64> {
    Histogram::new_with_bounds(1, LONGEST_NS, 3).expect("bounds and digits are possible")
}

/// Counts and latencies of the answers to one load.
#[derive(Debug)]
pub(crate) struct Recorder {
    pace: Pace,
    batch: u16,
    /// Flooding source; its reports are counted separately.
    flooding: u16,
    /// Number of sources taking turns.
    sources: u64,
    stages: [Histogram<u64>; 5],
    flooded: Histogram<u64>,
    /// Number of received states of each batch.
    answers: Vec<u16>,
    counts: StateCounts,
    detailed: bool,
}

/// Counts of received states.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct StateCounts {
    /// States caused by reports of this load.
    pub(crate) answers: u64,
    /// States without a triggering report: coasting, ending.
    pub(crate) untriggered: u64,
    /// States caused by earlier loads or by a flood.
    pub(crate) others: u64,
    /// States that are not confirmed.
    pub(crate) unconfirmed: u64,
    /// States lost before the receiver, since its creation.
    pub(crate) missed: u64,
}

impl Recorder {
    /// Creates a recorder for `batches` of `batch` reports at `pace`; `detailed` records all stages, not only the
    /// total.
    pub(crate) fn new(pace: Pace, batches: u64, batch: usize, detailed: bool) -> Self {
        Self {
            pace,
            batch: batch as u16,
            flooding: NO_SOURCE,
            sources: 1,
            stages: std::array::from_fn(|_| histogram()),
            flooded: histogram(),
            answers: vec![0; batches as usize],
            counts: StateCounts::default(),
            detailed,
        }
    }

    /// Sets a pace known only after the memory was allocated.
    pub(crate) fn set_pace(&mut self, pace: Pace) {
        self.pace = pace;
    }

    /// Returns this recorder with separate counts for `source`, one of `sources` taking turns.
    pub(crate) fn with_flooding(mut self, source: u16, sources: u64) -> Self {
        (self.flooding, self.sources) = (source, sources);
        self
    }

    /// Records a received state.
    pub(crate) fn record(&mut self, track: &SystemTrack, received_ns: i64) {
        if track.trigger_source == NO_SOURCE {
            self.counts.untriggered += 1;
            return;
        }
        let stamps = &track.stages;
        let batch = self.pace.batch_at(stamps.ingested_ns);
        let Some(answers) = batch.and_then(|batch| self.answers.get_mut(batch as usize)) else {
            self.counts.others += 1;
            return;
        };
        *answers = answers.saturating_add(1);
        self.counts.answers += 1;
        self.counts.unconfirmed += u64::from(track.state != messages::TrackState::Confirmed as u8);
        let took = |from: i64, until: i64| (until - from).max(1) as u64;
        let whole_ns = took(stamps.ingested_ns, received_ns);
        if track.trigger_source == self.flooding {
            self.flooded.saturating_record(whole_ns);
            return;
        }
        self.stages[END_TO_END].saturating_record(whole_ns);
        if self.detailed && stamps.fused_ns != 0 {
            self.stages[0].saturating_record(took(stamps.ingested_ns, stamps.published_ns));
            self.stages[1].saturating_record(took(stamps.published_ns, stamps.taken_ns));
            self.stages[2].saturating_record(took(stamps.taken_ns, stamps.fused_ns));
            self.stages[3].saturating_record(took(stamps.fused_ns, received_ns));
        }
    }

    /// Sets the number of states missed by the receiver since its creation.
    pub(crate) fn missed_by_reader(&mut self, missed: u64) {
        self.counts.missed = missed;
    }

    pub(crate) fn counts(&self) -> StateCounts {
        self.counts
    }

    /// Returns the number of reports in `batches` batches.
    pub(crate) fn reports(&self, batches: u64) -> u64 {
        batches * u64::from(self.batch)
    }

    /// Returns the unanswered reports of the first `sent` batches, without those of a flooding source.
    pub(crate) fn unanswered(&self, sent: u64) -> u64 {
        self.missing(sent, |source| source != u64::from(self.flooding))
    }

    /// Returns the unanswered reports of the flooding source's own share.
    pub(crate) fn flood_unanswered(&self, sent: u64) -> u64 {
        self.missing(sent, |source| source == u64::from(self.flooding))
    }

    fn missing(&self, sent: u64, counts: impl Fn(u64) -> bool) -> u64 {
        let missing = |answers: &u16| u64::from(self.batch.saturating_sub(*answers));
        let of_source = |(batch, _): &(u64, &u16)| counts(batch % self.sources);
        let answers = (0..sent).zip(&self.answers).filter(of_source);
        answers.map(|(_, answers)| missing(answers)).sum()
    }

    /// Returns the number of states beyond one per report.
    pub(crate) fn beyond_one(&self) -> u64 {
        let beyond = |answers: &u16| u64::from(answers.saturating_sub(self.batch));
        self.answers.iter().map(beyond).sum()
    }

    /// Whether all of the first `sent` batches are answered.
    pub(crate) fn has_all(&self, sent: u64) -> bool {
        self.counts.answers >= sent * u64::from(self.batch)
    }

    /// Returns latencies from the intended time to reception.
    pub(crate) fn end_to_end(&self) -> &Histogram<u64> {
        &self.stages[END_TO_END]
    }

    /// Returns latencies of the flooding source's own reports, from the intended time to reception.
    pub(crate) fn flooded(&self) -> &Histogram<u64> {
        &self.flooded
    }

    /// Returns all stages, in the order of [`STAGES`].
    pub(crate) fn stages(&self) -> &[Histogram<u64>; 5] {
        &self.stages
    }
}
