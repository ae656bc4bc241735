//! Replay of a recording, paced by the recorded times.
//!
//! The recording's clock starts when every consumer has joined. At a finite speed a sample is published when that clock
//! reaches the sample's time; at maximum speed, as soon as the consumers have room. In both cases nothing is published
//! beyond the consumers' room. A killed replay resumes with the first sample that a consumer lacks: samples are
//! numbered by the place in the recording, so that consumers recognise repeated samples.

use std::fmt::Debug;
use std::time::Duration;

use bus::{Mark, SharedMemory, WaitMode, Waiter};
use messages::{Counter, Counters, Outgoing, ProcessKind, SensorDetection, StreamId, TargetStatement, Topic};
use runtime::Process;
use runtime::clock::mono_ns;
use runtime::{Agent, HealthEntry, Now, Speed, Turn};

use crate::beside::{Beside, BesideOutlet};
use crate::outlet::PacedOutlet;

/// Time between two looks for consumers.
const PATIENCE: Duration = Duration::from_millis(20);
/// Time between two repetitions of the end, nanoseconds.
const END_REPEAT_NS: i64 = 250_000_000;

/// Samples of a recording in the order of the due times, numbered by place.
pub(crate) trait Replayed: Debug {
    /// Sample.
    type Sample: Outgoing;
    /// Consumers that must join before the recording's clock starts, in words.
    const WAITS_FOR: &'static str;

    /// Number of the next sample, and UTC at which the sample `ahead` places later is due, nanoseconds; `None` if there
    /// is no such sample. At least a slice ahead is known.
    fn due_ns(&self, ahead: usize) -> Option<i64>;

    /// Number of samples that are made and not taken.
    fn ahead(&self) -> usize;

    /// Takes the next sample, with the sample's number.
    fn next(&mut self) -> Option<(u64, Self::Sample)>;

    /// Leaves out the samples numbered below `first_needed`.
    fn skip_to(&mut self, first_needed: u64);

    /// The detections of which the samples were made, if tracks are made here.
    fn detections(&mut self) -> Option<&mut Beside<SensorDetection>> {
        None
    }

    /// What targets have stated, if the recording gives statements.
    fn statements(&mut self) -> Option<&mut Beside<TargetStatement>> {
        None
    }

    /// Counts so far.
    fn counters(&self) -> Counters;
}

/// The agent of a recording.
#[derive(Debug)]
pub(crate) struct ReplayAgent<R: Replayed> {
    recording: R,
    outlet: PacedOutlet<R::Sample>,
    detections: Option<BesideOutlet<SensorDetection>>,
    statements: Option<BesideOutlet<TargetStatement>>,
    waiter: Waiter<SharedMemory>,
    speed: Speed,
    /// The recording's clock, once running.
    clock: Option<ReplayClock>,
    ended: bool,
    end_said_ns: i64,
    waited: u64,
}

/// Maps the machine's monotonic clock to the recording's time.
#[derive(Clone, Copy, Debug)]
struct ReplayClock {
    mono_ns: i64,
    data_ns: i64,
}

/// Topic as which a recording is published.
pub(crate) struct Published<'a, T> {
    pub(crate) topic: &'a Topic<T>,
    pub(crate) stream: StreamId,
    /// Identity of the sensor, if any.
    pub(crate) sensor_uid: Option<u32>,
}

impl<T: Outgoing> Published<'_, T> {
    /// Opens the topic, which `consumers` must be able to follow, and, if present, the recorder.
    pub(crate) fn open(&self, process: &Process, consumers: &[ProcessKind]) -> anyhow::Result<PacedOutlet<T>> {
        let recorder = process.config.services.recorder.then_some(ProcessKind::Recorder);
        let consumers: Vec<ProcessKind> = consumers.iter().copied().chain(recorder).collect();
        PacedOutlet::open(process, self.topic, self.stream, self.sensor_uid, &consumers)
    }
}

impl<R: Replayed> ReplayAgent<R> {
    pub(crate) fn new(
        process: &Process,
        recording: R,
        outlet: PacedOutlet<R::Sample>,
        detections: Option<PacedOutlet<SensorDetection>>,
        statements: Option<PacedOutlet<TargetStatement>>,
    ) -> anyhow::Result<Self> {
        let mut waiter = process.bus.waiter(WaitMode::Event);
        waiter.watch(&process.bus, &messages::progress())?;
        Ok(Self {
            recording,
            outlet,
            detections: detections.map(BesideOutlet),
            statements: statements.map(BesideOutlet),
            waiter,
            speed: process.options.speed,
            clock: None,
            ended: false,
            end_said_ns: 0,
            waited: 0,
        })
    }

    /// Starts the recording's clock at the first sample that is still needed.
    fn start(&mut self, now: Now) {
        self.recording.skip_to(self.outlet.flow().first_needed());
        self.clock = Some(ReplayClock {
            mono_ns: now.mono_ns,
            data_ns: self.recording.due_ns(0).unwrap_or(0),
        });
    }

    /// Publishes a slice of the detections, else of the statements, that are due before the next samples; `None` if
    /// there are none, else whether they wait for the recorder.
    fn publish_beside(&mut self, until_ns: i64, now: Now) -> anyhow::Result<Option<Turn>> {
        let mut sent = None;
        if let (Some(outlet), Some(detections)) = (&mut self.detections, self.recording.detections()) {
            sent = outlet.publish(detections, until_ns, now)?;
        }
        if sent.is_none()
            && let (Some(outlet), Some(statements)) = (&mut self.statements, self.recording.statements())
        {
            sent = outlet.publish(statements, until_ns, now)?;
        }
        self.waited += u64::from(sent == Some(false));
        Ok(sent.map(|is_sent| match is_sent {
            true => Turn::Worked,
            false => Turn::Idle(PATIENCE),
        }))
    }

    /// Time of the data until which everything is due.
    fn until_ns(&self, clock: ReplayClock, now: Now) -> i64 {
        match self.speed {
            Speed::Max => i64::MAX,
            Speed::Factor(factor) => clock.data_ns + ((now.mono_ns - clock.mono_ns) as f64 * factor) as i64,
        }
    }

    /// Number of samples, at most a slice, that are due at `now`.
    fn due(&self, clock: ReplayClock, now: Now) -> usize {
        let until_ns = self.until_ns(clock, now);
        let is_due = |ahead: &usize| self.recording.due_ns(*ahead).is_some_and(|due_ns| due_ns <= until_ns);
        (0..self.outlet.slice_len()).take_while(is_due).count()
    }

    /// Publishes the next `count` samples, and the recording's progress.
    fn publish(&mut self, count: usize, now: Now) -> anyhow::Result<()> {
        let next_ns = self.recording.due_ns(count);
        let mark = Mark {
            progress_ns: next_ns.unwrap_or(i64::MAX),
            sent_ns: mono_ns(),
            end: next_ns.is_none(),
        };
        let recording = &mut self.recording;
        let sent = self
            .outlet
            .send(mark, count, now.mono_ns, || recording.next().unwrap_or_default());
        sent?;
        self.ended = mark.end;
        self.end_said_ns = mark.sent_ns;
        if mark.end {
            self.detections
                .as_mut()
                .map_or(Ok(()), |outlet| outlet.end(mark, now))?;
            self.statements
                .as_mut()
                .map_or(Ok(()), |outlet| outlet.end(mark, now))?;
        }
        Ok(())
    }

    fn until_due(&self, clock: ReplayClock, now: Now) -> Duration {
        let (Speed::Factor(factor), Some(next_ns)) = (self.speed, self.recording.due_ns(0)) else {
            return PATIENCE;
        };
        let data_ns = (next_ns - clock.data_ns) as f64 / factor;
        let wait_ns = clock.mono_ns as f64 + data_ns - now.mono_ns as f64;
        Duration::from_nanos(wait_ns.max(0.0) as u64).min(PATIENCE)
    }
}

impl<R: Replayed> Agent for ReplayAgent<R> {
    fn turn(&mut self, now: Now) -> anyhow::Result<Turn> {
        self.outlet.update()?;
        if self.ended {
            // A restarted consumer has missed the end: the end is repeated until the launcher stops this process.
            if now.mono_ns >= self.end_said_ns + END_REPEAT_NS && self.outlet.may_send() {
                self.publish(0, now)?;
            }
            return Ok(Turn::Idle(PATIENCE));
        }
        if !self.outlet.flow().all_present() {
            return Ok(Turn::Idle(PATIENCE));
        }
        let Some(clock) = self.clock else {
            self.start(now);
            if self.recording.due_ns(0).is_some() {
                // Publishes the start of the source, so that readers need not wait for the first sample.
                self.publish(0, now)?;
            }
            return Ok(Turn::Worked);
        };
        let count = self.due(clock, now);
        // Detections and statements first: up to the last of these samples, and all that remain before the end.
        let last_ns = count.checked_sub(1).and_then(|last| self.recording.due_ns(last));
        let until_ns = match self.recording.due_ns(count) {
            Some(_) => last_ns.unwrap_or(i64::MIN),
            None => i64::MAX,
        };
        if let Some(turn) = self.publish_beside(until_ns, now)? {
            return Ok(turn);
        }
        if count == 0 && self.recording.due_ns(0).is_some() {
            return Ok(Turn::Idle(self.until_due(clock, now)));
        }
        if !self.outlet.may_send() {
            self.waited += 1;
            return Ok(Turn::Idle(PATIENCE));
        }
        self.publish(count, now)?;
        Ok(Turn::Worked)
    }

    fn wait(&mut self, at_most: Duration) -> anyhow::Result<()> {
        let flow = self.outlet.flow();
        self.waiter.wait(at_most, || flow.has_news())?;
        Ok(())
    }

    fn health(&self, entries: &mut Vec<HealthEntry>) {
        let mut entry = HealthEntry {
            progress_ns: self.recording.due_ns(0).unwrap_or(i64::MIN),
            counters: self.recording.counters(),
            ..HealthEntry::default()
        };
        entry.set(Counter::Published, self.outlet.sent());
        entry.set(Counter::WaitedForConsumers, self.waited);
        entry.set(Counter::ReportsAhead, self.recording.ahead() as u64);
        if self.ended {
            entry.note = "end of the recording".to_owned();
        } else if self.clock.is_none() {
            entry.note = format!("waiting for {}", R::WAITS_FOR);
        }
        entries.push(entry);
    }
}
