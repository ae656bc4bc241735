//! Publishing what a wide-area sensor's recording holds, paced by the times of arrival.
//!
//! As with a recorded source: the clock starts when the recorder is there, nothing is published that it could not take, and a
//! replay that was killed resumes with the first report that it lacks.

use std::time::Duration;

use bus::{Mark, Publisher, SharedMemory, WaitMode, Waiter};
use configuration::{Process, WideAreaSensor};
use messages::{Counter, Counters, ProcessKind, StageTimes, Stream, StreamId, WideArea};
use observations::Sampled;
use runtime::clock::mono_ns;
use runtime::flow::Flow;
use runtime::{Agent, HealthEntry, Now, Speed, Turn};
use tracking::wide_area::WideAreaReport;

use super::recorded::{self, Recorded};

/// How long to wait for the recorder before looking again.
const PATIENCE: Duration = Duration::from_millis(20);
/// Time between two repetitions of the end, nanoseconds.
const END_REPEAT_NS: i64 = 250_000_000;

/// The agent of a recorded wide-area sensor.
#[derive(Debug)]
pub(super) struct Replay {
    sensor: u16,
    reports: Vec<WideAreaReport>,
    counters: Counters,
    next: usize,
    publisher: Publisher<SharedMemory, WideArea>,
    flow: Flow<SharedMemory>,
    waiter: Waiter<SharedMemory>,
    speed: Speed,
    /// Monotonic time and time of the data at which the recording's clock started.
    clock: Option<(i64, i64)>,
    ended: bool,
    end_said_ns: i64,
    waited: u64,
}

impl Replay {
    pub(super) fn new(process: &Process, sensor: &WideAreaSensor) -> anyhow::Result<Self> {
        let Recorded { reports, counters } = recorded::read(sensor, &process.options.data, process.first_day_ns())?;
        let topic = messages::wide_area(&sensor.name);
        let consumers: &[ProcessKind] = match process.config.recorder {
            true => &[ProcessKind::Recorder],
            false => &[],
        };
        let stream = StreamId {
            stream: Stream::WideArea,
            number: sensor.number,
        };
        let mut waiter = process.bus.waiter(WaitMode::Event);
        waiter.watch(&process.bus, &messages::progress())?;
        Ok(Self {
            sensor: sensor.number,
            reports,
            counters,
            next: 0,
            publisher: process.bus.publisher(&topic, process.incarnation)?,
            flow: Flow::new(
                &process.bus,
                process.incarnation,
                stream,
                topic.capacity.depth,
                consumers,
            )?,
            waiter,
            speed: process.options.speed,
            clock: None,
            ended: false,
            end_said_ns: 0,
            waited: 0,
        })
    }

    /// Publishes the next `count` reports.
    fn publish(&mut self, count: usize, now: Now) -> anyhow::Result<()> {
        let rest = &self.reports[self.next..];
        let mark = Mark {
            progress_ns: rest.get(count).map_or(i64::MAX, |report| report.arrival_ns),
            sent_ns: mono_ns(),
            end: rest.len() == count,
        };
        let (sensor, first) = (self.sensor, self.next as u64);
        let stages = StageTimes {
            ingested_ns: now.mono_ns,
            published_ns: mark.sent_ns,
            ..StageTimes::default()
        };
        self.publisher.send(mark, count, |index, _| WideArea {
            // Its place in the recording, so that one that is published again is recognised.
            sequence: first + index as u64,
            ..rest[index].sample(sensor, stages)
        })?;
        self.next += count;
        (self.ended, self.end_said_ns) = (mark.end, mark.sent_ns);
        Ok(())
    }

    /// How many reports, at most a slice, are due, and how long until the next one is.
    fn due(&self, (begun_ns, data_ns): (i64, i64), now: Now) -> (usize, Duration) {
        let rest = &self.reports[self.next..];
        let Speed::Factor(factor) = self.speed else {
            return (rest.len().min(self.publisher.slice_len()), PATIENCE);
        };
        let until_ns = data_ns + ((now.mono_ns - begun_ns) as f64 * factor) as i64;
        let due = rest.partition_point(|report| report.arrival_ns <= until_ns);
        let next_ns = rest.get(due).map_or(0, |report| report.arrival_ns - until_ns);
        let wait = Duration::from_nanos((next_ns as f64 / factor).max(0.0) as u64);
        (due.min(self.publisher.slice_len()), wait.min(PATIENCE))
    }
}

impl Agent for Replay {
    fn turn(&mut self, now: Now) -> anyhow::Result<Turn> {
        let sent = self.publisher.counts().slices;
        self.flow.update(sent)?;
        if self.ended {
            // A recorder that was restarted has not heard it.
            if now.mono_ns >= self.end_said_ns + END_REPEAT_NS && self.flow.may_send(sent) {
                self.publish(0, now)?;
            }
            return Ok(Turn::Idle(PATIENCE));
        }
        if !self.flow.all_present() {
            return Ok(Turn::Idle(PATIENCE));
        }
        let Some(clock) = self.clock else {
            self.next = (self.flow.first_needed() as usize).min(self.reports.len());
            let data_ns = self.reports.get(self.next).map_or(0, |report| report.arrival_ns);
            self.clock = Some((now.mono_ns, data_ns));
            return Ok(Turn::Worked);
        };
        let (count, wait) = self.due(clock, now);
        if count == 0 && self.next < self.reports.len() {
            return Ok(Turn::Idle(wait));
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
        let next = self.reports.get(self.next);
        let mut entry = HealthEntry {
            progress_ns: next.map_or(i64::MIN, |report| report.arrival_ns),
            counters: self.counters,
            ..HealthEntry::default()
        };
        entry.set(Counter::Published, self.publisher.counts().samples);
        entry.set(Counter::WaitedForConsumers, self.waited);
        if self.ended {
            entry.note = "end of the recording".to_owned();
        }
        entries.push(entry);
    }
}
