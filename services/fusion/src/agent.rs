//! Duty cycle of fusion.

use std::sync::Arc;
use std::time::Duration;

use bus::{Bus, Transport, WaitMode, Waiter};
use deployment::{Deployment, Fusion, ReportOrder, Source, WaitWord};
use fusion::{Driver, Engine, Merger, PushOutcome, Settings, Sink as _};
use messages::{
    BatchHeader, Counter, NO_SOURCE, Order, OrderKind, OrderState, OrderStatus, ProcessKind, Refusal, Restored,
    SensorTrack, Stream, StreamId, TrackState,
};
use runtime::clock::mono_ns;
use runtime::flow::ConsumerProgress;
use runtime::housekeeping::{Queues, SnapshotParts};
use runtime::{Agent, HealthEntry, Now, Speed, Turn};

use crate::clocks::Clocks;
use crate::continuity::{FusionStart, Keeping, TakeOver};
use crate::health;
use crate::inputs::SourceInput;
use crate::log::Log;
use crate::output::TrackOutput;
use crate::smoothing::SmoothingQueue;
use crate::source_time::CommonOffsets;

mod arrival;

/// Maximum number of reports in a turn: a flood does not delay other work.
const REPORTS_PER_TURN: usize = 256;
/// Order `arrival`: longest time between two full looks at all sources, nanoseconds: if the loop spins, and if it
/// sleeps. A full look finds the slices of publishers that give no hint.
const FULL_LOOK_SPINNING_NS: i64 = 1_000_000;
const FULL_LOOK_SLEEPING_NS: i64 = 200_000_000;
/// Longest time without work until the next turn; and without tracks, if no standby waits for signs of life.
const IDLE: Duration = Duration::from_millis(20);
const IDLE_EMPTY: Duration = Duration::from_millis(100);
/// Order `time`: slices taken from a source before the turn of the next source.
const SLICES_PER_SOURCE: usize = 4;
/// Age beyond which an order is refused, nanoseconds: the sender has given up.
const ORDER_AGE_MAX_NS: i64 = 30_000_000_000;
/// Change of a source's clock offset that is passed to the engine, milliseconds.
const CLOCK_CHANGES_MS: u32 = 100;

/// Fusion as an agent, generic over the transport: tests run it in process.
#[derive(Debug)]
pub struct FusionAgent<S: Transport> {
    driver: Driver<Log>,
    inputs: Vec<SourceInput<S>>,
    output: TrackOutput<S>,
    queues: Arc<Queues>,
    waiter: Waiter<S>,
    /// Order `arrival`: the report in work.
    report: SensorTrack,
    /// Order `arrival`: sources of the present round.
    round: Vec<usize>,
    /// First source to look at in the next round.
    look_at: usize,
    /// When the next full look is due, monotonic, nanoseconds, and the time between two.
    full_look_ns: i64,
    full_look_every_ns: i64,
    idle_empty: Duration,
    /// Order `time`: reports that wait for the turn.
    merger: Option<Merger>,
    /// Recordings: publishes fusion's progress, so that no sample is lost.
    reached: Option<ConsumerProgress<S>>,
    end_sent: bool,
    progress_ns: i64,
    /// Writer of the checkpoint.
    keeping: Option<Keeping>,
    take_over: TakeOver,
    /// Order `arrival`: estimates of the sources' clocks.
    clocks: Clocks,
    common: CommonOffsets,
    /// Greatest number of system tracks that were confirmed or coasted after a turn.
    live_max: u64,
    /// Clock offset of each source as passed to the engine, milliseconds.
    told_ms: Vec<Option<i32>>,
}

/// Fusion that is ready to begin, and publishes nothing yet.
#[derive(Debug)]
pub(crate) struct Ready<S: Transport> {
    pub(crate) engine: Engine,
    pub(crate) inputs: Vec<SourceInput<S>>,
    waiter: Waiter<S>,
}

impl<S: Transport> Ready<S> {
    /// Allocates all tables of fusion of `config`, with a separate `core` for the thread if given, and opens the input
    /// topics.
    ///
    /// # Errors
    /// If a setting is invalid or a topic cannot be opened.
    pub(crate) fn new(
        config: &Deployment,
        settings: &Settings,
        (speed, core): (Speed, Option<usize>),
        bus: &Bus<S>,
        incarnation: u64,
    ) -> anyhow::Result<Self> {
        let mut waiter = bus.waiter(wait_mode(&config.fusion));
        if core.is_some() {
            waiter = waiter.without_yielding();
        }
        let inputs = SourceInput::open_all(config, speed, bus, incarnation, &mut waiter)?;
        if config.is_recorded() {
            waiter.watch(bus, &messages::progress())?;
        }
        Ok(Self {
            engine: Engine::new(settings.clone())?,
            inputs,
            waiter,
        })
    }
}

impl<S: Transport> FusionAgent<S> {
    /// Creates fusion of `config` with the engine of `settings` on `bus`, with recordings replayed at `speed`;
    /// `incarnation` is the process's monotonic start time. Orders come from `queues`, and decisions go there.
    ///
    /// # Errors
    /// If a setting is invalid or a topic cannot be opened.
    pub fn new(
        config: &Deployment,
        settings: &Settings,
        speed: Speed,
        bus: &Bus<S>,
        incarnation: u64,
        queues: Arc<Queues>,
    ) -> anyhow::Result<Self> {
        let ready = Ready::new(config, settings, (speed, config.fusion.core), bus, incarnation)?;
        Self::begin(ready, config, bus, (incarnation, incarnation), queues)
    }

    /// As [`Self::new`], but with the tracks of the checkpoint of the previous fusion, if any, and with a checkpoint
    /// for a successor, unless `config` has none.
    ///
    /// # Errors
    /// If a setting is invalid, a topic cannot be opened, or the machine has no memory for the checkpoint.
    pub fn resumed(
        config: &Deployment,
        settings: &Settings,
        speed: Speed,
        bus: &Bus<S>,
        incarnation: u64,
        queues: Arc<Queues>,
        now: Now,
    ) -> anyhow::Result<Self> {
        let Some(max_age_ns) = config.checkpoint.max_age_ns() else {
            return Self::new(config, settings, speed, bus, incarnation, queues);
        };
        let ready = Ready::new(config, settings, (speed, config.fusion.core), bus, incarnation)?;
        let start = FusionStart::look(bus.root(), max_age_ns, None, &ready.engine, now);
        let mut agent = Self::begin(ready, config, bus, (incarnation, start.epoch), queues)?;
        agent.resume(start, TakeOver::default(), now)?;
        Ok(agent)
    }

    /// Begins to fuse, as `epoch`.
    ///
    /// # Errors
    /// If a topic cannot be opened.
    pub(crate) fn begin(
        ready: Ready<S>,
        config: &Deployment,
        bus: &Bus<S>,
        (incarnation, epoch): (u64, u64),
        queues: Arc<Queues>,
    ) -> anyhow::Result<Self> {
        let Ready { engine, inputs, waiter } = ready;
        let recorded = config.is_recorded();
        let stream = |source: &Source| {
            let id = StreamId {
                stream: Stream::SensorTracks,
                number: source.number,
            };
            (id, 0)
        };
        let streams: Vec<_> = config.sources.iter().map(stream).collect();
        let reached = || ConsumerProgress::new(bus, incarnation, ProcessKind::Fusion, &streams);
        Ok(Self {
            driver: Driver::begin(engine, Log::open(bus)?, epoch),
            output: TrackOutput::new(config, bus, (incarnation, epoch), Arc::clone(&queues))?,
            keeping: None,
            take_over: TakeOver::default(),
            clocks: Clocks::default(),
            common: CommonOffsets::default(),
            live_max: 0,
            told_ms: vec![None; inputs.len()],
            full_look_ns: i64::MIN,
            full_look_every_ns: match waiter.mode() {
                WaitMode::Event => FULL_LOOK_SLEEPING_NS,
                WaitMode::Spin | WaitMode::Hybrid { .. } => FULL_LOOK_SPINNING_NS,
            },
            idle_empty: if config.has_standby() { IDLE } else { IDLE_EMPTY },
            queues,
            waiter,
            report: SensorTrack::default(),
            round: Vec::with_capacity(inputs.len()),
            look_at: 0,
            merger: (config.order == ReportOrder::Time).then(|| Merger::new(streams.len(), config.system_tracks.queue)),
            reached: recorded.then(reached).transpose()?,
            inputs,
            end_sent: false,
            progress_ns: i64::MIN,
        })
    }

    /// Passes the engine's output on to `queue`, too, for smoothed states. To be called before anything is processed.
    #[must_use]
    pub fn with_smoothing(mut self, queue: Option<Arc<SmoothingQueue>>) -> Self {
        if let Some(queue) = queue {
            self.output.smooth_into(queue);
        }
        self
    }

    /// Continues from the checkpoint of the previous fusion, if any, and writes a checkpoint for a successor.
    /// Terminated tracks are published.
    ///
    /// # Errors
    /// If a state cannot be published.
    pub(crate) fn resume(&mut self, start: FusionStart, take_over: TakeOver, now: Now) -> anyhow::Result<()> {
        self.take_over = take_over;
        let (ahead_ns, host_offset_ns) = start.clocks();
        self.clocks.resume(now, ahead_ns, host_offset_ns);
        if start.goes_on() {
            self.output.go_on();
        }
        self.keeping = Some(start.resume(&mut self.driver, &mut self.inputs, &mut self.output, now)?);
        self.output.send(self.progress_ns, false)
    }

    /// Longest time without work until the next turn: short while tracks may change without a report.
    fn idle(&self) -> Duration {
        let engine = self.driver.engine();
        let states = [
            TrackState::Tentative,
            TrackState::Confirmed,
            TrackState::Coasted,
            TrackState::Suspended,
        ];
        let has_tracks = states.iter().any(|state| engine.count_in_state(*state) > 0);
        if has_tracks || self.reached.is_some() {
            IDLE
        } else {
            self.idle_empty
        }
    }

    #[cold]
    fn obey(&mut self, now: Now) {
        while let Some(order) = self.queues.orders.pop() {
            if let Some(state) = self.driver.engine().order_of_token(order.token) {
                // A repetition: the sender has missed the answer.
                self.output.order(&state);
                continue;
            }
            let counter = match self.obey_one(&order, now) {
                Ok(()) => Counter::OrdersObeyed,
                Err(refusal) => {
                    self.output
                        .order(&OrderState::refused(&order, refusal, self.driver.engine().now_ns()));
                    Counter::OrdersRejected
                }
            };
            self.driver.engine_mut().counts_mut().add(NO_SOURCE, counter);
        }
    }

    /// Obeys an order.
    #[cold]
    fn obey_one(&mut self, order: &Order, now: Now) -> Result<(), Refusal> {
        let is_late = now.utc_ns.saturating_sub(order.sent_ns) > ORDER_AGE_MAX_NS;
        if is_late || order.ends_ns <= now.utc_ns {
            return Err(Refusal::Expired);
        }
        if order.kind() == Some(OrderKind::Snapshot) {
            let state = OrderState {
                order: *order,
                changed_ns: now.utc_ns,
                status: OrderStatus::Done.code(),
                ..OrderState::default()
            };
            return match self.say_image(now) {
                true => {
                    self.output.order(&state);
                    Ok(())
                }
                false => Err(Refusal::Busy),
            };
        }
        let passed_ns = self.driver.engine().now_ns();
        let mut order = *order;
        if order.ends_ns != i64::MAX && passed_ns != i64::MIN {
            order.ends_ns = passed_ns.saturating_add(order.ends_ns - now.utc_ns);
        }
        self.driver.order(&order, passed_ns, &mut self.output)
    }

    /// Publishes a snapshot of the engine, for a recorder that has not run from the beginning. The only work of the
    /// loop that takes long and allocates.
    fn say_image(&mut self, now: Now) -> bool {
        // All states so far are sent, and the result of an earlier order has been taken.
        if self.output.waiting() > 0 || self.queues.restored.is_full() {
            return false;
        }
        let (epoch, next) = self.output.next();
        let mut octets = next.to_le_bytes().to_vec();
        let time_ns = now.utc_ns;
        octets.append(&mut self.driver.snapshot(time_ns));
        let ends = Restored::IMAGE;
        let whole = SnapshotParts {
            epoch,
            time_ns,
            ends,
            octets,
        };
        self.queues.restored.push(whole).is_ok()
    }

    /// Order `arrival`: estimates the clocks, and passes changes to the engine.
    #[cold]
    fn look_at_clocks(&mut self, now: Now) {
        let ahead_ns = self.clocks.ahead_ns(now);
        let ahead_s = ahead_ns as f64 / messages::NS_PER_S;
        let known = self.inputs.iter().map(|input| input.known_clock(now, ahead_s));
        if let Some(host_offset_ns) = self.clocks.look(known.clone().flatten(), now) {
            self.driver.set_host_offset(host_offset_ns);
        }
        let host_offset_s = self.clocks.host_offset_s();
        self.common = CommonOffsets { host_offset_s, ahead_s };
        for ((input, known), told_ms) in self.inputs.iter().zip(known).zip(&mut self.told_ms) {
            let offset_ms = known.map(|known| (1e3 * (known.offset_s - host_offset_s)) as i32);
            let is_same = match (offset_ms, *told_ms) {
                (Some(offset_ms), Some(told_ms)) => offset_ms.abs_diff(told_ms) < CLOCK_CHANGES_MS,
                (offset_ms, told_ms) => offset_ms == told_ms,
            };
            if !is_same {
                *told_ms = offset_ms;
                self.driver.set_source_clock(input.source, offset_ms);
            }
        }
    }

    /// Order `time`: reports wait for the turn.
    fn work_by_time(&mut self, merger: &mut Merger) -> anyhow::Result<bool> {
        let mut worked = false;
        for index in 0..self.inputs.len() {
            worked |= self.queue_reports(index, merger)?;
        }
        for _ in 0..REPORTS_PER_TURN {
            if self.output.is_full() {
                self.output.send(self.progress_ns, false)?;
            }
            if !self.output.has_room()? {
                break;
            }
            let Some(mut report) = merger.pop() else {
                self.driver.advance(merger.safe_ns(), &mut self.output);
                break;
            };
            worked = true;
            self.progress_ns = report.time_of_measurement_ns;
            let number = self.inputs[usize::from(report.source)].number_of(&report);
            self.output.begin_report(report.stages.taken_ns);
            self.driver.report_in_order(&mut report, number, &mut self.output);
        }
        self.output.send(self.progress_ns, false)?;
        if merger.finished() && !self.end_sent && self.output.has_room()? {
            self.driver.advance(i64::MAX, &mut self.output);
            self.output.send(i64::MAX, true)?;
            self.end_sent = true;
        }
        Ok(worked)
    }

    /// Takes slices of a source while the queue has room for a whole slice; further slices stay in shared memory, and
    /// the producer waits.
    fn queue_reports(&mut self, index: usize, merger: &mut Merger) -> anyhow::Result<bool> {
        let input = &mut self.inputs[index];
        let mut worked = false;
        for _ in 0..SLICES_PER_SOURCE {
            if self.reached.is_some() && merger.room(index) < input.slice_len {
                break;
            }
            let (counts, source, first) = (
                self.driver.engine_mut().counts_mut(),
                input.source,
                merger.next_sequence(index),
            );
            let mut taken_header = None;
            let took = input.take_slice(
                mono_ns,
                |report| match merger.push(index, report) {
                    PushOutcome::Waiting | PushOutcome::Repeated => {}
                    PushOutcome::DroppedOldest => counts.add(source, Counter::DroppedQueue),
                    PushOutcome::OutOfOrder => counts.add(source, Counter::RejectedOutOfOrder),
                },
                |header, _| taken_header = Some(*header),
            )?;
            if !took {
                break;
            }
            worked = true;
            if let Some(header) = taken_header {
                input.came_from(header.incarnation, first);
                merger.set_watermark(index, header.progress_ns);
                if header.flags & BatchHeader::END != 0 {
                    merger.end(index);
                }
                if let Some(reached) = &mut self.reached {
                    reached.done(index, &header, merger.next_sequence(index));
                }
            }
        }
        Ok(worked)
    }
}

impl<S: Transport> FusionAgent<S> {
    /// Number of system tracks that are confirmed or coasted.
    fn live(&self) -> u64 {
        let states = [TrackState::Confirmed, TrackState::Coasted];
        states
            .map(|state| self.driver.engine().count_in_state(state) as u64)
            .iter()
            .sum()
    }
}

impl<S: Transport> Agent for FusionAgent<S> {
    fn turn(&mut self, now: Now) -> anyhow::Result<Turn> {
        if !self.queues.orders.is_empty() {
            self.obey(now);
        }
        if let Some(keeping) = &mut self.keeping {
            keeping.tend(self.driver.engine_mut(), now, self.clocks.ahead_ns(now));
        }
        let worked = match self.merger.take() {
            Some(mut merger) => {
                let worked = self.work_by_time(&mut merger);
                self.merger = Some(merger);
                worked?
            }
            None => self.work_on_arrival(now)?,
        };
        self.live_max = self.live_max.max(self.live());
        if let Some(reached) = &mut self.reached {
            for (index, input) in self.inputs.iter_mut().enumerate() {
                for (header, next_sequence) in input.passed.drain(..) {
                    reached.done(index, &header, next_sequence);
                }
            }
            // A source that waits for this progress leaves the loop without work.
            reached.say_at_times(now, !worked || self.end_sent)?;
        }
        if self.end_sent && self.output.all_received()? {
            // The process ends without a sleep.
            self.output.settle();
            return Ok(Turn::Finished);
        }
        Ok(if worked { Turn::Worked } else { Turn::Idle(self.idle()) })
    }

    fn close(&mut self, now: Now) -> anyhow::Result<()> {
        if let Some(keeping) = &mut self.keeping {
            keeping.close(self.driver.engine_mut(), now);
        }
        Ok(())
    }

    fn wait(&mut self, at_most: Duration) -> anyhow::Result<()> {
        self.output.settle();
        let now_ns = mono_ns();
        let expected = self.inputs.iter().filter_map(SourceInput::expected_ns);
        let expected = expected.filter(|time_ns| *time_ns >= now_ns).min();
        let expected = expected.map(|time_ns| Duration::from_nanos(time_ns.abs_diff(now_ns)));
        let (inputs, by_time) = (&mut self.inputs, self.merger.is_some());
        // The slice counts as taken at once; a fault recurs in the next turn, which reports it.
        let has_some = |input: &mut SourceInput<S>, look| match by_time {
            true => input.has_slices(),
            false => input.reach(mono_ns, look).unwrap_or(true),
        };
        self.waiter.wait_at_a_glance((at_most, expected), |look| {
            inputs.iter_mut().any(|input| has_some(input, look))
        })?;
        Ok(())
    }

    fn health(&self, entries: &mut Vec<HealthEntry>) {
        let counts = self.driver.engine().counts();
        let mut whole = HealthEntry {
            progress_ns: self.progress_ns,
            counters: *counts.total(),
            ..HealthEntry::default()
        };
        let level = |state| self.driver.engine().count_in_state(state) as u64;
        whole.set(Counter::LiveTracks, self.live());
        whole.set(Counter::LiveTracksMax, self.live_max);
        whole.set(Counter::TentativeTracks, level(TrackState::Tentative));
        whole.set(Counter::CoastedTracks, level(TrackState::Coasted));
        whole.set(Counter::SuspendedTracks, level(TrackState::Suspended));
        whole.set(Counter::TakeOvers, u64::from(self.take_over.from_another));
        whole.set(Counter::TakeOversFromStill, u64::from(self.take_over.stood_still));
        if self.merger.is_none() && self.reached.is_none() {
            // Without a source: the offset of sound clocks against the machine's.
            let host_offset_s = self.common.host_offset_s + self.common.ahead_s;
            whole.registration.set_clock_offset(Some((host_offset_s, 0.0)));
        }
        whole.counters.add(Counter::OrdersRejected, self.queues.refused());
        self.output.count(&mut whole.counters);
        for input in &self.inputs {
            input.count(&mut whole.counters);
        }
        entries.push(whole);
        let of_source = |input: &SourceInput<S>| health::of_source(self.driver.engine(), input, self.common);
        entries.extend(self.inputs.iter().map(of_source));
        debug_assert!(entries.iter().skip(1).all(|entry| entry.source != NO_SOURCE));
    }
}

/// How fusion waits for work.
fn wait_mode(fusion: &Fusion) -> WaitMode {
    match fusion.wait {
        WaitWord::Event => WaitMode::Event,
        WaitWord::Spin => WaitMode::Spin,
        WaitWord::Hybrid => WaitMode::Hybrid {
            spin_ns: (fusion.hybrid_spin_us * 1e3) as u64,
        },
    }
}
