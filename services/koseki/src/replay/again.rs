//! Repeats fusion's work, step by step in recorded order.
//!
//! A step names the processed report by the publisher's number. The reports are on the sources' topics of the same
//! recording, some before and some after the step. A fusion that started within the recording starts again here. If a
//! report or a step is missing, the further states of the engine are unknown. The work is then left out until the next
//! start of fusion, or until the next snapshot of the engine in the recording.

use std::collections::{BTreeMap, VecDeque};

use deployment::ReportOrder;
use fusion::checkpoint::Snapshot;
use fusion::event_log::{Event, EventReader};
use fusion::{Driver, Engine, FilterInput, ReportNumber, Settings, Sink};
use messages::{NO_SOURCE, Order, OrderKind, Restored, SensorTrack, SystemTrack, WorkStep};

/// A report that is not in the recording so long after the step is missing, nanoseconds.
const PATIENCE_NS: u64 = 10_000_000_000;

/// Result of the work.
#[derive(Debug)]
pub(crate) enum RunOutcome<'a> {
    /// Fusion begins, with this start-up number, or is known again from the state with this number on.
    Began(u64, u64),
    /// A state of a system track.
    State(&'a SystemTrack),
    /// The filter of a system track has received something.
    Input(&'a FilterInput),
    /// An event has been worked off.
    Worked(&'a Engine),
    /// Data of the fusion with this start-up number are missing: nothing follows until a fusion begins, or its state is
    /// known again.
    Broke(u64),
}

/// How work is done again.
#[derive(Clone, Debug)]
pub(crate) struct Plan {
    /// Settings of the engine.
    pub(crate) settings: Settings,
    /// Order in which fusion had worked.
    pub(crate) order: ReportOrder,
    /// Number of the deployment.
    pub(crate) origin: u32,
    /// Number in `settings` of each recorded source; `None` for a source with omitted reports.
    pub(crate) sources: Vec<Option<u16>>,
    /// Names of the conditions, by the numbers in the recording.
    pub(crate) conditions: Vec<String>,
    /// Whether work goes on although something is missing.
    pub(crate) tolerates: bool,
    /// Whether a fusion continues from the recorded state, not from the state of the preceding fusion here.
    pub(crate) restores: bool,
}

/// Time that the recorded work spans, nanoseconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Spans {
    pub(crate) done_ns: i64,
    pub(crate) left_out_ns: i64,
    last_ns: Option<i64>,
}

/// Work of a recording.
#[derive(Debug)]
pub(crate) struct Again {
    plan: Plan,
    /// By source and incarnation of the publisher, reports with their numbers.
    reports: BTreeMap<(u16, u64), VecDeque<(u32, SensorTrack)>>,
    work: VecDeque<Work>,
    /// The log of the latest step, and the number of the next step.
    next_step: Option<(u64, u64)>,
    log: EventReader,
    run: Option<FusionRun>,
    /// The fusion before `run`.
    before: Option<FusionRun>,
    /// Parts of each fusion's restored state, by the start-up number.
    restored: BTreeMap<u64, Vec<Restored>>,
    /// Parts of images, by the time of the image.
    images: BTreeMap<i64, Vec<Restored>>,
    /// Time of the latest image that is not needed any more.
    passed_image_ns: i64,
    pub(crate) spans: Spans,
    /// Reports worked off.
    pub(crate) worked: u64,
    pub(crate) missing: u64,
}

#[derive(Debug)]
enum Work {
    /// An event, and the time at which the recorder took the event.
    Event(Event, u64),
    /// Steps are missing, or cannot be read.
    Gap,
}

/// A fusion since its start.
#[derive(Debug)]
struct FusionRun {
    driver: Box<Driver<()>>,
    epoch: u64,
    /// Number of the next state.
    sequence: u64,
}

impl Again {
    pub(crate) fn new(plan: Plan) -> Self {
        Self {
            plan,
            reports: BTreeMap::new(),
            work: VecDeque::new(),
            log: EventReader::default(),
            next_step: None,
            run: None,
            before: None,
            restored: BTreeMap::new(),
            images: BTreeMap::new(),
            passed_image_ns: i64::MIN,
            spans: Spans::default(),
            worked: 0,
            missing: 0,
        }
    }

    /// The engine of the present or last fusion.
    pub(crate) fn engine(&self) -> Option<&Engine> {
        let run = self.run.as_ref().or(self.before.as_ref());
        run.map(|run| run.driver.engine())
    }

    /// Takes a report of `source`: the sample with this number of the publisher of this incarnation.
    pub(crate) fn report(&mut self, source: u16, publisher: u64, number: u64, report: &SensorTrack) {
        let number = match self.plan.order {
            ReportOrder::Arrival => number,
            ReportOrder::Time => report.sequence,
        };
        let waiting = self.reports.entry((source, publisher)).or_default();
        waiting.push_back((number as u32, *report));
    }

    /// Takes a part of a fusion's restored state, or of an image.
    pub(crate) fn restored(&mut self, part: &Restored) {
        let parts = match part.ends {
            Restored::IMAGE if part.time_ns <= self.passed_image_ns => return,
            Restored::IMAGE => self.images.entry(part.time_ns).or_default(),
            _ => self.restored.entry(part.epoch).or_default(),
        };
        parts.push(*part);
    }

    /// Takes a step: the sample with this number of the log of this incarnation, taken by the recorder at `taken_ns`.
    pub(crate) fn step(&mut self, log: u64, number: u64, step: WorkStep, taken_ns: u64) {
        let expected = self.next_step.filter(|(of, _)| *of == log).map_or(0, |(_, next)| next);
        if number != expected {
            self.work.push_back(Work::Gap);
        }
        self.next_step = Some((log, number + 1));
        match self.log.read(&step) {
            Ok(Some(event)) => self.work.push_back(Work::Event(event, taken_ns)),
            Ok(None) => {}
            Err(_) => self.work.push_back(Work::Gap),
        }
    }

    /// Performs all possible work; the recording has been read up to the recorder's time `read_ns`.
    ///
    /// # Errors
    /// If the settings cannot work.
    pub(crate) fn work(&mut self, read_ns: u64, out: &mut impl FnMut(RunOutcome<'_>)) -> anyhow::Result<()> {
        while let Some(work) = self.work.front() {
            let Work::Event(event, taken_ns) = *work else {
                self.break_off(out);
                self.work.pop_front();
                continue;
            };
            let is_early = read_ns < taken_ns.saturating_add(PATIENCE_NS);
            if !self.apply(&event, is_early, out)? {
                return Ok(());
            }
            if let Some(passed_ns) = event.passed_ns() {
                self.spans.pass(passed_ns, self.run.is_some());
            }
            self.work.pop_front();
        }
        Ok(())
    }

    /// Applies an event. `false` if the event `is_early`, and waits for samples that may follow in the recording.
    fn apply(&mut self, event: &Event, is_early: bool, out: &mut impl FnMut(RunOutcome<'_>)) -> anyhow::Result<bool> {
        let can_wait = self.run.is_some() && is_early;
        match *event {
            Event::Begin { epoch } => {
                self.spans.last_ns = None;
                self.before = self.run.take();
                self.run = Some(FusionRun::begin(&self.plan, epoch)?);
                out(RunOutcome::Began(epoch, 0));
            }
            Event::Report {
                source,
                publisher,
                sequence,
                is_wild,
                passed_ns,
            } => match self.find(source, publisher, sequence) {
                ReportSearch::NotYet if can_wait => return Ok(false),
                ReportSearch::Report(report) => {
                    let report = SensorTrack { source, ..*report };
                    let number = ReportNumber {
                        publisher,
                        sequence: sequence.into(),
                        is_wild,
                    };
                    self.take(report, number, passed_ns, out);
                }
                ReportSearch::NotYet | ReportSearch::Missing => {
                    self.missing += 1;
                    if !self.plan.tolerates {
                        self.break_off(out);
                    }
                }
            },
            // The report has no effect, apart from the place in the publisher's order.
            Event::Quarantine {
                source,
                publisher,
                sequence,
                ..
            } => {
                let found = self.find(source, publisher, sequence);
                return Ok(!(matches!(found, ReportSearch::NotYet) && can_wait));
            }
            Event::Time { passed_ns } => self.drive(out, |driver, sink| driver.advance(passed_ns, sink)),
            Event::Condition { condition, passed_ns } => {
                let name = self.plan.conditions.get(condition as usize);
                let order = Order {
                    token: 1,
                    ..Order::new(OrderKind::Condition)
                };
                match name.and_then(|name| order.with_name(name)) {
                    Some(order) => self.obey(&order, passed_ns, out),
                    None => self.drive(out, |driver, sink| driver.advance(passed_ns, sink)),
                }
            }
            Event::Order { order, passed_ns } => self.obey(&order, passed_ns, out),
            Event::Restored => match self.restore(out) {
                false if can_wait => return Ok(false),
                false => self.break_off(out),
                true => {}
            },
            Event::Numbers { first } => self.drive(out, |driver, _| driver.start_numbers_at(first)),
            Event::HostOffset { offset_ns } => self.drive(out, |driver, _| driver.set_host_offset(offset_ns)),
            Event::SourceClock { source, offset_ms, .. } => {
                if let Some(source) = self.plan.source(source) {
                    self.drive(out, |driver, _| driver.set_source_clock(source, offset_ms));
                }
            }
            Event::Snapshot { time_ns } => {
                if self.run.is_none() && !self.resume_image(time_ns, out)? && is_early {
                    return Ok(false);
                }
                self.passed_image_ns = time_ns;
                self.images = self.images.split_off(&time_ns.saturating_add(1));
            }
        }
        Ok(true)
    }

    /// Lets the present fusion continue from the restored state. `false` if this state is not in the recording.
    fn restore(&mut self, out: &mut impl FnMut(RunOutcome<'_>)) -> bool {
        let (plan, Some(run)) = (&self.plan, &mut self.run) else {
            return true;
        };
        let layout = run.driver.engine().checkpoint_layout();
        let mut parts = self.restored.remove(&run.epoch).unwrap_or_default();
        parts.sort_by_key(|part| part.part);
        let is_whole = is_whole(&parts);
        let snapshot = || Snapshot::of_words(words(&parts).collect(), &layout).ok();
        let found = (is_whole && plan.restores).then(snapshot).flatten();
        match (found, &mut self.before) {
            (Some(snapshot), _) => {
                let ends = parts[0].ends != 0;
                run.drive(plan.origin, out, |driver, sink| driver.resume(&snapshot, ends, sink));
                true
            }
            (None, Some(before)) if plan.tolerates && (is_whole || !plan.restores) => {
                std::mem::swap(&mut run.driver, &mut before.driver);
                true
            }
            (None, _) => {
                self.restored.insert(run.epoch, parts);
                false
            }
        }
    }

    /// Goes on from the image with this time. `false` if that is not in the recording, or is of another build.
    fn resume_image(&mut self, time_ns: i64, out: &mut impl FnMut(RunOutcome<'_>)) -> anyhow::Result<bool> {
        let Some(parts) = self.images.get_mut(&time_ns).filter(|parts| is_whole(parts)) else {
            return Ok(false);
        };
        parts.sort_by_key(|part| part.part);
        let octets: Vec<u8> = words(parts).flat_map(u64::to_le_bytes).collect();
        let Some((next, image)) = octets.split_first_chunk() else {
            return Ok(false);
        };
        let mut run = FusionRun {
            sequence: u64::from_le_bytes(*next),
            ..FusionRun::begin(&self.plan, parts[0].epoch)?
        };
        if self.plan.restores && run.driver.resume_snapshot(image).is_err() {
            return Ok(false);
        }
        out(RunOutcome::Began(run.epoch, run.sequence));
        self.run = Some(run);
        self.spans.last_ns = None;
        Ok(true)
    }

    fn break_off(&mut self, out: &mut impl FnMut(RunOutcome<'_>)) {
        if let Some(run) = self.run.take() {
            out(RunOutcome::Broke(run.epoch));
        }
    }

    /// Finds the report of `source` with this number of the publisher. Fusion never took the reports before.
    fn find(&mut self, source: u16, publisher: u64, number: u32) -> ReportSearch {
        let Some(waiting) = self.reports.get_mut(&(source, publisher)) else {
            return ReportSearch::NotYet;
        };
        while let Some((next, report)) = waiting.front() {
            let ahead = next.wrapping_sub(number).cast_signed();
            let report = *report;
            if ahead > 0 {
                return ReportSearch::Missing;
            }
            waiting.pop_front();
            if ahead == 0 {
                return ReportSearch::Report(Box::new(report));
            }
        }
        ReportSearch::NotYet
    }

    fn take(
        &mut self,
        mut report: SensorTrack,
        number: ReportNumber,
        passed_ns: i64,
        out: &mut impl FnMut(RunOutcome<'_>),
    ) {
        let Some(source) = self.plan.source(report.source).filter(|_| self.run.is_some()) else {
            return;
        };
        self.worked += 1;
        report.source = source;
        self.drive(out, |driver, sink| driver.report(&mut report, number, passed_ns, sink));
    }

    /// Obeys an order, if the order's sources take part.
    fn obey(&mut self, order: &Order, passed_ns: i64, out: &mut impl FnMut(RunOutcome<'_>)) {
        let number = |source: u16| match source {
            NO_SOURCE => Some(NO_SOURCE),
            source => self.plan.source(source),
        };
        let (source, other_source) = (number(order.source), number(order.other_source));
        self.drive(out, |driver, sink| match (source, other_source) {
            (Some(source), Some(other_source)) => {
                let order = Order {
                    source,
                    other_source,
                    ..*order
                };
                // Under other settings, an order may be refused.
                let _ = driver.order(&order, passed_ns, sink);
            }
            _ => driver.advance(passed_ns, sink),
        });
    }

    /// Lets the present fusion act, if any.
    fn drive<O: FnMut(RunOutcome<'_>)>(&mut self, out: &mut O, act: impl FnOnce(&mut Driver<()>, &mut RunSink<'_, O>)) {
        if let Some(run) = &mut self.run {
            run.drive(self.plan.origin, out, act);
        }
    }
}

impl Plan {
    /// Returns the number in the settings of a source of the recording; `None` if the source is left out.
    fn source(&self, recorded: u16) -> Option<u16> {
        self.sources.get(usize::from(recorded)).copied().flatten()
    }
}

fn is_whole(parts: &[Restored]) -> bool {
    parts.first().is_some_and(|first| first.parts as usize == parts.len())
}

fn words(parts: &[Restored]) -> impl Iterator<Item = u64> {
    parts
        .iter()
        .flat_map(|part| part.words.iter().take(part.count as usize).copied())
}

enum ReportSearch {
    Report(Box<SensorTrack>),
    NotYet,
    Missing,
}

impl FusionRun {
    /// Begins with a new engine.
    fn begin(plan: &Plan, epoch: u64) -> anyhow::Result<Self> {
        let engine = Engine::new(plan.settings.clone())?;
        Ok(Self {
            driver: Box::new(Driver::begin(engine, (), epoch)),
            epoch,
            sequence: 0,
        })
    }

    /// Lets the driver act; each state gets the same numbers as from fusion's output.
    fn drive<O: FnMut(RunOutcome<'_>)>(
        &mut self,
        origin: u32,
        out: &mut O,
        act: impl FnOnce(&mut Driver<()>, &mut RunSink<'_, O>),
    ) {
        let Self {
            driver,
            epoch,
            sequence,
        } = self;
        act(
            driver,
            &mut RunSink {
                epoch: *epoch,
                sequence,
                origin,
                out: &mut *out,
            },
        );
        out(RunOutcome::Worked(driver.engine()));
    }
}

/// Output of a run of fusion, as outcomes.
struct RunSink<'a, O> {
    epoch: u64,
    sequence: &'a mut u64,
    origin: u32,
    out: &'a mut O,
}

impl<O: FnMut(RunOutcome<'_>)> Sink for RunSink<'_, O> {
    fn track(&mut self, track: &SystemTrack) {
        let state = SystemTrack {
            sequence: *self.sequence,
            epoch: self.epoch,
            origin: self.origin,
            ..*track
        };
        *self.sequence += 1;
        (self.out)(RunOutcome::State(&state));
    }

    fn follows_inputs(&self) -> bool {
        true
    }

    fn input(&mut self, input: &FilterInput) {
        (self.out)(RunOutcome::Input(input));
    }
}

impl Spans {
    fn pass(&mut self, time_ns: i64, done: bool) {
        if matches!(time_ns, i64::MIN | i64::MAX) {
            return;
        }
        let passed_ns = self.last_ns.map_or(0, |last_ns| time_ns.saturating_sub(last_ns).max(0));
        self.last_ns = Some(self.last_ns.map_or(time_ns, |last_ns| last_ns.max(time_ns)));
        match done {
            true => self.done_ns += passed_ns,
            false => self.left_out_ns += passed_ns,
        }
    }
}
