//! The sources' topics, as read by fusion.

use std::collections::VecDeque;

use bus::{Bus, Look, ReceiveOutcome, Slice, Subscriber, Transport, WaitMode, Waiter};
use deployment::Deployment;
use fusion::ReportNumber;
use fusion::checkpoint::SourcePosition;
use messages::{BatchHeader, Counter, Counters, SensorTrack};
use runtime::{Now, Speed};

use crate::clocks::ClockReading;
use crate::forecast::Forecast;
use crate::source_time::{CommonOffsets, SourceTime};

/// Silence after which a source has no vote on the right clock, nanoseconds.
const HEARD_NS: i64 = 60_000_000_000;
/// Maximum number of empty or foreign slices (of another layout) passed over in a row before other sources have a turn.
const PASSED_OVER_MAX: usize = 16;

/// Topic of a source.
#[derive(Debug)]
pub(crate) struct SourceInput<S: Transport> {
    pub(crate) source: u16,
    subscriber: Subscriber<S, SensorTrack>,
    /// Maximum number of samples in a slice of the topic.
    pub(crate) slice_len: usize,
    /// Latest progress mark, UTC, nanoseconds.
    pub(crate) progress_ns: i64,
    /// Order `arrival`: the slice that is being worked off.
    in_hand: Option<InHand<S>>,
    /// Order `arrival`: judge of the source's clock.
    pub(crate) time: SourceTime,
    /// Monotonic time of the latest slice, nanoseconds.
    heard_ns: i64,
    /// In mode `hybrid`: forecast of the next slice.
    forecast: Option<Forecast>,
    /// Whether the source has announced the end.
    pub(crate) has_ended: bool,
    /// Order `arrival`, recordings: processed slices and the following number, until published.
    pub(crate) passed: Vec<(BatchHeader, u64)>,
    next_number: u64,
    /// Order `arrival`: progress of the previous fusion process.
    done: Option<SourcePosition>,
    /// The previous process had also processed all reports sent by other publishers before this time (monotonic,
    /// nanoseconds).
    done_ns: i64,
    /// Order `time`: publishers of reports that were taken, and the number of the first report of each.
    publishers: VecDeque<(u64, u64)>,
    /// Order `time`: publisher of the last taken slice.
    publisher: Option<u64>,
}

/// Slice that stays in shared memory while its reports are processed singly, in turn with other sources' reports.
#[derive(Debug)]
struct InHand<S: Transport> {
    slice: Slice<S, SensorTrack>,
    /// Header of the slice.
    header: BatchHeader,
    /// Place of the report that is next.
    next: usize,
    taken_ns: i64,
}

/// Number of the next report of the slice in hand.
#[derive(Clone, Copy, Debug)]
pub(crate) struct InputReport {
    pub(crate) number: ReportNumber,
    /// Whether the report was the last of the slice.
    pub(crate) last: bool,
}

impl<S: Transport> SourceInput<S> {
    /// Opens the topics of all sources, in the order of the numbers, watched by `waiter`. Recordings are replayed at
    /// `speed`.
    pub(crate) fn open_all(
        config: &Deployment,
        speed: Speed,
        bus: &Bus<S>,
        incarnation: u64,
        waiter: &mut Waiter<S>,
    ) -> anyhow::Result<Vec<Self>> {
        let mut inputs = Vec::new();
        for source in &config.sources {
            let topic = messages::sensor_tracks(&source.name);
            waiter.watch(bus, &topic)?;
            let subscriber = bus.subscriber(&topic, || incarnation)?;
            inputs.push(Self {
                source: source.number,
                subscriber,
                slice_len: topic.capacity.slice_len,
                progress_ns: i64::MIN,
                in_hand: None,
                time: SourceTime::of(source, speed),
                heard_ns: i64::MIN,
                forecast: matches!(waiter.mode(), WaitMode::Hybrid { .. }).then(Forecast::default),
                has_ended: false,
                passed: Vec::new(),
                next_number: 0,
                done: None,
                done_ns: i64::MIN,
                publishers: VecDeque::with_capacity(topic.capacity.publishers),
                publisher: None,
            });
        }
        Ok(inputs)
    }

    /// Takes the next slice in hand if none is, in a full look or after a publisher's hint. After a full look with a
    /// find, looks stay full until the queue is empty. `false` without a slice. `true` with a slice in hand, or after
    /// so many unusable slices that other sources must have a turn first.
    #[inline]
    pub(crate) fn reach(&mut self, clock: fn() -> i64, look: Look) -> anyhow::Result<bool> {
        if self.in_hand.is_some() {
            return Ok(true);
        }
        if look == Look::Glance && !self.may_have_slices() {
            return Ok(false);
        }
        let found = self.look_into_queue(clock)?;
        if look == Look::Full && found {
            self.subscriber.disregard_hints();
        }
        Ok(found)
    }

    /// Whether a glance would look into the queue: a few instructions, since most glances find nothing.
    #[inline]
    pub(crate) fn may_have_slices(&self) -> bool {
        self.subscriber.may_have_slices()
    }

    #[inline(never)]
    fn look_into_queue(&mut self, clock: fn() -> i64) -> anyhow::Result<bool> {
        for _ in 0..PASSED_OVER_MAX {
            match self.subscriber.receive()? {
                ReceiveOutcome::Nothing => return Ok(false),
                ReceiveOutcome::Rejected | ReceiveOutcome::OfOlderEpoch => {}
                ReceiveOutcome::Slice(slice) => {
                    let (header, reports) = (*slice.header(), slice.samples().len());
                    if reports == 0 {
                        self.pass(&header);
                        continue;
                    }
                    self.heard_ns = header.sent_ns;
                    if let Some(forecast) = &mut self.forecast {
                        forecast.learn(header.sent_ns);
                    }
                    self.time.state(header.clock_offset_ms);
                    let next = self.count_done(&header, reports);
                    if next == reports {
                        self.pass(&header);
                        continue;
                    }
                    // Read here, not before: a slice not yet in hand may still be unpublished.
                    let taken_ns = clock();
                    self.in_hand = Some(InHand {
                        slice,
                        header,
                        next,
                        taken_ns,
                    });
                    return Ok(true);
                }
            }
        }
        Ok(true)
    }

    /// Number of the slice's reports that the previous fusion had worked off.
    fn count_done(&self, header: &BatchHeader, reports: usize) -> usize {
        match self.done {
            Some(done) if header.incarnation == done.incarnation => {
                let past = done.next_sequence.saturating_sub(header.first_sequence);
                past.min(reports as u64) as usize
            }
            _ if header.sent_ns < self.done_ns => reports,
            _ => 0,
        }
    }

    /// Another fusion process has progressed to `done`, and for other publishers of the source to reports sent before
    /// `done_ns`: processed reports are skipped, the others are kept.
    pub(crate) fn follow(
        &mut self,
        done: Option<SourcePosition>,
        done_ns: i64,
        clock: fn() -> i64,
    ) -> anyhow::Result<()> {
        (self.done, self.done_ns) = (done.or(self.done), done_ns);
        if let Some(hand) = self.in_hand.take() {
            let next = self.count_done(&hand.header, hand.slice.samples().len());
            if next == hand.slice.samples().len() {
                self.pass(&hand.header);
            } else {
                self.in_hand = Some(InHand { next, ..hand });
            }
        }
        self.reach(clock, Look::Full).map(|_| ())
    }

    /// Everything up to a slice's mark has been worked off.
    fn pass(&mut self, header: &BatchHeader) {
        if header.progress_ns != i64::MIN {
            self.time.begin(header.progress_ns, header.sent_ns);
        }
        self.progress_ns = self.progress_ns.max(header.progress_ns);
        self.has_ended |= header.flags & BatchHeader::END != 0;
        if self.time.is_of_recording() {
            self.passed.push((*header, self.next_number));
        }
    }

    /// Whether a slice is in hand.
    #[inline]
    pub(crate) fn has_reports(&self) -> bool {
        self.in_hand.is_some()
    }

    /// When the slice in hand was sent, monotonic, nanoseconds.
    #[inline]
    pub(crate) fn sent_ns(&self) -> Option<i64> {
        self.in_hand.as_ref().map(|hand| hand.header.sent_ns)
    }

    /// When the next slice is expected, monotonic, nanoseconds.
    pub(crate) fn expected_ns(&self) -> Option<i64> {
        self.forecast.as_ref().and_then(Forecast::next_ns)
    }

    /// Returns the clock of a source with recent reports; the engine's time is `ahead_s` ahead of the machine's UTC.
    pub(crate) fn known_clock(&self, now: Now, ahead_s: f64) -> Option<ClockReading> {
        let is_heard = now.mono_ns.saturating_sub(self.heard_ns) <= HEARD_NS;
        self.time.known(ahead_s).filter(|_| is_heard)
    }

    /// Writes the next report of the slice in hand into `report`, stamped with source and time; `now` has the engine's
    /// time. The last report releases the slice; then the slice's watermark holds.
    #[inline]
    pub(crate) fn next_report(
        &mut self,
        report: &mut SensorTrack,
        now: Now,
        clocks: CommonOffsets,
    ) -> Option<InputReport> {
        let hand = self.in_hand.as_mut()?;
        let reports = hand.slice.samples();
        let (sent_ns, publisher) = (hand.header.sent_ns, hand.header.incarnation);
        let sequence = hand.header.first_sequence.wrapping_add(hand.next as u64);
        *report = *reports.get(hand.next)?;
        stamp(report, self.source, hand.taken_ns);
        self.next_number = report.sequence.wrapping_add(1);
        hand.next += 1;
        let last = hand.next == reports.len();
        self.time.begin(report.time_of_measurement_ns, sent_ns);
        let is_wild = !self.time.believes(report.time_of_measurement_ns, sent_ns, now, clocks);
        if last {
            let header = hand.header;
            self.in_hand = None;
            self.pass(&header);
        }
        let number = ReportNumber {
            publisher,
            sequence,
            is_wild,
        };
        Some(InputReport { number, last })
    }

    /// Order `time`: a slice of `publisher` was taken; the reports are new from number `first` on.
    pub(crate) fn came_from(&mut self, publisher: u64, first: u64) {
        if self.publisher != Some(publisher) {
            self.publisher = Some(publisher);
            self.publishers.push_back((first, publisher));
        }
    }

    /// Order `time`: number of the next report to process.
    pub(crate) fn number_of(&mut self, report: &SensorTrack) -> ReportNumber {
        while self.publishers.get(1).is_some_and(|next| next.0 <= report.sequence) {
            self.publishers.pop_front();
        }
        ReportNumber {
            publisher: self.publishers.front().map_or(0, |(_, publisher)| *publisher),
            sequence: report.sequence,
            is_wild: false,
        }
    }

    /// Takes a slice, if available. Each report is stamped with the time by `clock` and the source, and passed to
    /// `visit` before the header.
    pub(crate) fn take_slice(
        &mut self,
        clock: fn() -> i64,
        mut visit: impl FnMut(&SensorTrack),
        mut header: impl FnMut(&BatchHeader, &[SensorTrack]),
    ) -> anyhow::Result<bool> {
        let (source, progress_ns) = (self.source, &mut self.progress_ns);
        let taken = self.subscriber.take(1, |batch, reports| {
            // Read here, not before the take: between the two the slice may have been published.
            let taken_ns = clock();
            for report in reports {
                let mut report = *report;
                stamp(&mut report, source, taken_ns);
                visit(&report);
            }
            *progress_ns = (*progress_ns).max(batch.progress_ns);
            header(batch, reports);
        })?;
        Ok(taken > 0)
    }

    pub(crate) fn has_slices(&self) -> bool {
        self.subscriber.has_slices()
    }

    /// Slices received so far.
    pub(crate) fn slices(&self) -> u64 {
        self.subscriber.counts().slices
    }

    /// Adds the counts of the topic's reader.
    pub(crate) fn count(&self, counters: &mut Counters) {
        let counts = self.subscriber.counts();
        counters[Counter::Taken] += counts.taken;
        counters[Counter::Lost] += counts.lost;
        counters[Counter::RejectedSchema] += counts.schema_mismatch;
    }
}

#[inline]
fn stamp(report: &mut SensorTrack, source: u16, taken_ns: i64) {
    report.stages.taken_ns = taken_ns;
    // The topic determines the source: the report's own source is not believed.
    report.source = source;
}
