//! Replaying a recording, paced by its own times of measurement.
//!
//! The recording's clock starts when every consumer is there. At a finite speed a report is published when that clock
//! reaches its time; at the greatest, as soon as the consumers have room. Either way nothing is published that they
//! could not take. A replay that was killed resumes with the first report that some consumer still lacks: reports are
//! numbered by their place in the recording, so the consumers recognise any that come twice.

use std::time::Duration;

use anyhow::Context as _;
use bus::{Mark, Publisher, SharedMemory, WaitMode, Waiter};
use configuration::{Process, Recorded, Source};
use messages::{Counter, ProcessKind, SensorDetection, SensorTrack, Stream, StreamId};
use runtime::clock::mono_ns;
use runtime::flow::Flow;
use runtime::{Agent, HealthEntry, Now, Speed, Turn};
use tracking::wide_area::arrivals::Arrivals;

use crate::recording::{AHEAD, Recording};
use crate::wide_area::recorded;

/// How long to wait for consumers before looking again.
const PATIENCE: Duration = Duration::from_millis(20);

/// Time between two repetitions of the end, nanoseconds.
const END_REPEAT_NS: i64 = 250_000_000;

/// The agent of a recorded source.
#[derive(Debug)]
pub(crate) struct Replay {
    recording: Recording,
    publisher: Publisher<SharedMemory, SensorTrack>,
    flow: Flow<SharedMemory>,
    waiter: Waiter<SharedMemory>,
    speed: Speed,
    /// The recording's clock, once it runs.
    clock: Option<Clock>,
    ended: bool,
    end_said_ns: i64,
    waited: u64,
    detections: Option<Detections>,
}

/// The way out of the detections of which the tracks were made; only the recorder reads them all.
#[derive(Debug)]
struct Detections {
    publisher: Publisher<SharedMemory, SensorDetection>,
    flow: Flow<SharedMemory>,
}

/// What the wide-area sensors that the source's tracker listens to have counted: read here, and not taken from their
/// topics, so that the tracks do not depend on who is faster.
fn counts(process: &Process, source: &Source) -> anyhow::Result<Arrivals> {
    let mut reports = Vec::new();
    for number in source.tracker.iter().flat_map(|tracker| &tracker.wide_area_sensors) {
        let sensor = &process.config.wide_area_sensors[usize::from(*number)];
        reports.extend(recorded::read(sensor, &process.options.data, process.first_day_ns())?.reports);
    }
    Ok(Arrivals::of(reports))
}

/// Maps the machine's monotonic clock to the recording's time.
#[derive(Clone, Copy, Debug)]
struct Clock {
    mono_ns: i64,
    data_ns: i64,
}

impl Replay {
    pub(crate) fn new(process: &Process, source: &Source, recorded: &Recorded) -> anyhow::Result<Self> {
        let path = process.options.data.join(&recorded.file);
        let bytes = std::fs::read(&path).with_context(|| format!("reading {}", path.display()))?;
        let first_day_ns = process.first_day_ns();
        let topic = messages::sensor_tracks(&source.name);
        assert!(topic.capacity.slice_len < AHEAD, "the next report's time must be known");
        let mut consumers = vec![ProcessKind::Fusion];
        if process.config.recorder {
            consumers.push(ProcessKind::Recorder);
        }
        let detections = match &source.tracker {
            Some(_) => Some(Detections::open(process, source)?),
            None => None,
        };
        let mut waiter = process.bus.waiter(WaitMode::Event);
        waiter.watch(&process.bus, &messages::progress())?;
        Ok(Self {
            recording: Recording::supported(bytes, recorded, source, first_day_ns, counts(process, source)?)
                .with_context(|| path.display().to_string())?,
            publisher: process
                .bus
                .publisher(&topic, process.incarnation)?
                .of_sensor(source.uid),
            flow: Flow::new(
                &process.bus,
                process.incarnation,
                StreamId {
                    stream: Stream::SensorTracks,
                    number: source.number,
                },
                topic.capacity.depth,
                &consumers,
            )?,
            waiter,
            speed: process.options.speed,
            clock: None,
            ended: false,
            end_said_ns: 0,
            waited: 0,
            detections,
        })
    }

    /// Starts the recording's clock at the first report that is still needed.
    fn start(&mut self, now: Now) {
        let first_needed = self.flow.first_needed();
        while self
            .recording
            .peek()
            .is_some_and(|report| report.sequence < first_needed)
        {
            self.recording.next();
        }
        let data_ns = self.recording.peek().map_or(0, |report| report.time_of_measurement_ns);
        self.clock = Some(Clock {
            mono_ns: now.mono_ns,
            data_ns,
        });
    }

    /// Publishes a slice of the detections that are due before the next reports; whether there were any, or they must
    /// wait for the recorder. A recorder that still lacks some is given them again after a restart.
    fn publish_detections(&mut self, until_ns: i64, now: Now) -> anyhow::Result<Option<Turn>> {
        let Some(Detections { publisher, flow }) = &mut self.detections else {
            return Ok(None);
        };
        let sent = publisher.counts().slices;
        flow.update(sent)?;
        let (recording, first_needed) = (&mut self.recording, flow.first_needed());
        while recording
            .peek_detection()
            .is_some_and(|next| next.sequence < first_needed)
        {
            recording.next_detection();
        }
        let is_due = |next: &SensorDetection| next.time_of_measurement_ns <= until_ns;
        if !recording.peek_detection().is_some_and(is_due) {
            return Ok(None);
        }
        if !flow.may_send(sent) {
            self.waited += 1;
            return Ok(Some(Turn::Idle(PATIENCE)));
        }
        let mut slice = Vec::with_capacity(publisher.slice_len());
        while slice.len() < publisher.slice_len()
            && let Some(next) = recording.peek_detection().filter(|next| is_due(next))
        {
            slice.push(*next);
            recording.next_detection();
        }
        let mark = Mark {
            progress_ns: slice.last().map_or(i64::MIN, |last| last.time_of_measurement_ns),
            sent_ns: mono_ns(),
            end: false,
        };
        publisher.send(mark, slice.len(), |index, _| {
            let mut detection = slice[index];
            detection.stages.ingested_ns = now.mono_ns;
            detection.stages.published_ns = mark.sent_ns;
            detection
        })?;
        Ok(Some(Turn::Worked))
    }

    /// Up to what time of the data everything is due.
    fn until_ns(&self, clock: Clock, now: Now) -> i64 {
        match self.speed {
            Speed::Max => i64::MAX,
            Speed::Factor(factor) => clock.data_ns + ((now.mono_ns - clock.mono_ns) as f64 * factor) as i64,
        }
    }

    /// How many reports, at most a slice, are due at `now`.
    fn due(&self, clock: Clock, now: Now) -> usize {
        let until_ns = self.until_ns(clock, now);
        let due = |ahead: &usize| {
            self.recording
                .peek_nth(*ahead)
                .is_some_and(|report| report.time_of_measurement_ns <= until_ns)
        };
        (0..self.publisher.slice_len()).take_while(due).count()
    }

    /// Publishes the next `count` reports, and how far the source has got with them.
    fn publish(&mut self, count: usize, now: Now) -> anyhow::Result<()> {
        // The read-ahead is longer than a slice, so only the end of the recording has no next report.
        let next_ns = self
            .recording
            .peek_nth(count)
            .map(|report| report.time_of_measurement_ns);
        let mark = Mark {
            progress_ns: next_ns.unwrap_or(i64::MAX),
            sent_ns: mono_ns(),
            end: next_ns.is_none(),
        };
        let recording = &mut self.recording;
        self.publisher.send(mark, count, |_, _| {
            let mut report = recording.next().unwrap_or_default();
            // A recorded report comes in when it is due, at the beginning of this turn.
            report.stages.ingested_ns = now.mono_ns;
            report.stages.published_ns = mark.sent_ns;
            report
        })?;
        self.ended = mark.end;
        self.end_said_ns = mark.sent_ns;
        if let Some(detections) = self.detections.as_mut().filter(|_| mark.end) {
            detections.publisher.send(mark, 0, |_, _| SensorDetection::default())?;
        }
        Ok(())
    }

    fn until_due(&self, clock: Clock, now: Now) -> Duration {
        let (Speed::Factor(factor), Some(next)) = (self.speed, self.recording.peek()) else {
            return PATIENCE;
        };
        let data_ns = (next.time_of_measurement_ns - clock.data_ns) as f64 / factor;
        let wait_ns = clock.mono_ns as f64 + data_ns - now.mono_ns as f64;
        Duration::from_nanos(wait_ns.max(0.0) as u64).min(PATIENCE)
    }
}

impl Detections {
    fn open(process: &Process, source: &Source) -> anyhow::Result<Self> {
        let topic = messages::sensor_detections(&source.name);
        let consumers: &[ProcessKind] = match process.config.recorder {
            true => &[ProcessKind::Recorder],
            false => &[],
        };
        Ok(Self {
            publisher: process
                .bus
                .publisher(&topic, process.incarnation)?
                .of_sensor(source.uid),
            flow: Flow::new(
                &process.bus,
                process.incarnation,
                StreamId {
                    stream: Stream::Detections,
                    number: source.number,
                },
                topic.capacity.depth,
                consumers,
            )?,
        })
    }
}

impl Agent for Replay {
    fn turn(&mut self, now: Now) -> anyhow::Result<Turn> {
        let sent = self.publisher.counts().slices;
        self.flow.update(sent)?;
        if self.ended {
            // A consumer that was restarted has not heard it: said again now and then, until the launcher stops us.
            if now.mono_ns >= self.end_said_ns + END_REPEAT_NS && self.flow.may_send(sent) {
                self.publish(0, now)?;
            }
            return Ok(Turn::Idle(PATIENCE));
        }
        if !self.flow.all_present() {
            return Ok(Turn::Idle(PATIENCE));
        }
        let Some(clock) = self.clock else {
            self.start(now);
            if self.recording.peek().is_some() {
                // Says where the source begins, so that the others need not wait for its first report.
                self.publish(0, now)?;
            }
            return Ok(Turn::Worked);
        };
        let count = self.due(clock, now);
        // Detections first: those up to the last of these reports, and all that are left before the end is said.
        let is_last = self.recording.peek_nth(count).is_none();
        let last_ns = count.checked_sub(1).and_then(|last| self.recording.peek_nth(last));
        let last_ns = last_ns.map_or(i64::MIN, |last| last.time_of_measurement_ns);
        if let Some(turn) = self.publish_detections(if is_last { i64::MAX } else { last_ns }, now)? {
            return Ok(turn);
        }
        if count == 0 && self.recording.peek().is_some() {
            return Ok(Turn::Idle(self.until_due(clock, now)));
        }
        if !self.flow.may_send(sent) {
            self.waited += 1;
            return Ok(Turn::Idle(PATIENCE));
        }
        self.publish(count, now)?;
        Ok(Turn::Worked)
    }

    fn wait(&mut self, at_most: Duration) -> anyhow::Result<()> {
        let flow = &self.flow;
        self.waiter.wait(at_most, || flow.has_news())?;
        Ok(())
    }

    fn health(&self, entries: &mut Vec<HealthEntry>) {
        let progress_ns = self
            .recording
            .peek()
            .map_or(i64::MIN, |report| report.time_of_measurement_ns);
        let mut entry = HealthEntry {
            progress_ns,
            counters: self.recording.counters(),
            ..HealthEntry::default()
        };
        entry.set(Counter::Published, self.publisher.counts().samples);
        entry.set(Counter::WaitedForConsumers, self.waited);
        if self.ended {
            entry.note = "end of the recording".to_owned();
        } else if self.clock.is_none() {
            entry.note = "waiting for fusion and recorder".to_owned();
        }
        entries.push(entry);
    }
}
