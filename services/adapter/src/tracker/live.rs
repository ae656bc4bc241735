//! Live tracker process: takes the detections of its sensors from their topics.
//!
//! The events of a turn are taken in the order of their receipt, whichever topic they come from: after a pause of the
//! machine, one sensor's backlog must not make the others late. Detections of an external publisher have passed no
//! adapter, so their times and places are checked here.

use std::time::Duration;

use bus::{SharedMemory, Subscriber, WaitMode, Waiter};
use deployment::{Input, Process, Source};
use messages::{Counter, Counters, SensorDetection};
use observations::{Sampled, SensorEvent};
use runtime::clock::SteadyClock;
use runtime::{Agent, HealthEntry, Now, Turn};
use sources::{Pipeline, Processing, Samples};
use tracking::wide_area::arrivals::Arrivals;

use crate::Processed;
use crate::channel::SourceChannel;

/// Longest wait for detections in one turn, bounded by health messages and stop requests.
const PATIENCE: Duration = Duration::from_millis(50);
/// Slices taken at a time from the topic of a sensor.
const SLICES_PER_TURN: usize = 64;

/// Agent of a live tracker process.
#[derive(Debug)]
pub(super) struct TrackerAgent {
    channel: SourceChannel,
    sensors: Vec<TrackedSensor>,
    waiter: Waiter<SharedMemory>,
    steady: SteadyClock,
    /// Events of a turn: monotonic time of receipt (nanoseconds), place of the sensor, event.
    taken: Vec<(i64, usize, SensorEvent)>,
}

/// Sensor of the tracker.
#[derive(Debug)]
struct TrackedSensor {
    number: u16,
    name: String,
    events: Subscriber<SharedMemory, SensorDetection>,
    /// Checks of an external sensor.
    checks: Option<Box<Pipeline>>,
    /// Samples with codes of another schema.
    unknown: u64,
}

impl TrackerAgent {
    /// Opens the topics of the sensors, and the tracker.
    pub(super) fn open(process: &Process, tracker: Processed<'_>) -> anyhow::Result<Self> {
        let mut waiter = process.bus.waiter(WaitMode::Event);
        let mut sensors = Vec::new();
        for sensor in process.config.sensors_of(tracker.0) {
            let topic = messages::sensor_detections(&sensor.name);
            waiter.watch(&process.bus, &topic)?;
            sensors.push(TrackedSensor {
                number: sensor.number,
                name: sensor.name.clone(),
                events: process.bus.subscriber(&topic, || process.incarnation)?,
                checks: checks(process, sensor)?,
                unknown: 0,
            });
        }
        Ok(Self {
            channel: SourceChannel::open(process, tracker)?,
            sensors,
            waiter,
            steady: SteadyClock::of(Now::read()),
            taken: Vec::new(),
        })
    }

    /// Takes what has been published, in the order of receipt.
    fn take(&mut self, now: Now) -> anyhow::Result<()> {
        self.taken.clear();
        for (place, sensor) in self.sensors.iter_mut().enumerate() {
            let TrackedSensor {
                events,
                checks,
                unknown,
                ..
            } = sensor;
            let (taken, steady) = (&mut self.taken, self.steady);
            let mut checked = Samples::default();
            events.take(SLICES_PER_TURN, |_, samples| {
                for sample in samples {
                    let Some(event) = SensorEvent::of_sample(sample) else {
                        *unknown += 1;
                        continue;
                    };
                    let came_ns = match sample.stages.ingested_ns {
                        0 => now.mono_ns,
                        came_ns => came_ns.min(now.mono_ns),
                    };
                    let Some(checks) = checks else {
                        taken.push((came_ns, place, event));
                        continue;
                    };
                    let received_ns = steady.utc_ns(came_ns);
                    checks.received(received_ns, received_ns);
                    checks.row(&event, came_ns, &mut checked);
                    let passed = checked.detections.drain(..);
                    taken.extend(passed.filter_map(|sample| Some((came_ns, place, SensorEvent::of_sample(&sample)?))));
                }
            })?;
        }
        self.taken.sort_by_key(|(came_ns, place, _)| (*came_ns, *place));
        Ok(())
    }
}

/// Checks of a sensor whose detections pass no adapter.
fn checks(process: &Process, sensor: &Source) -> anyhow::Result<Option<Box<Pipeline>>> {
    let is_external = matches!(sensor.input, Input::External);
    let pipeline = || {
        Pipeline::new(
            sensor.model,
            &Processing::Plots,
            process.first_day_ns(),
            Arrivals::new(),
        )
    };
    Ok(is_external.then(pipeline).transpose()?.map(Box::new))
}

impl Agent for TrackerAgent {
    fn turn(&mut self, now: Now) -> anyhow::Result<Turn> {
        self.take(now)?;
        self.channel.listen()?;
        for (came_ns, place, event) in &self.taken {
            self.channel.event(*place, event, *came_ns)?;
        }
        if self.taken.is_empty() {
            self.channel.clock(now)?;
        }
        self.channel.publish()?;
        Ok(match self.taken.is_empty() {
            true => Turn::Idle(PATIENCE),
            false => Turn::Worked,
        })
    }

    fn wait(&mut self, at_most: Duration) -> anyhow::Result<()> {
        let sensors = &self.sensors;
        self.waiter
            .wait(at_most, || sensors.iter().any(|sensor| sensor.events.has_slices()))?;
        Ok(())
    }

    fn health(&self, entries: &mut Vec<HealthEntry>) {
        let mut of_tracker = self.channel.health(&Counters::default());
        let lost = self.sensors.iter().map(|sensor| sensor.events.counts());
        of_tracker.set(
            Counter::Lost,
            lost.map(|counts| counts.lost + counts.schema_mismatch).sum(),
        );
        let unknown: u64 = self.sensors.iter().map(|sensor| sensor.unknown).sum();
        of_tracker.counters[Counter::DetectionsRejected] += unknown;
        let mut whole = HealthEntry {
            progress_ns: of_tracker.progress_ns,
            ..HealthEntry::default()
        };
        whole.add_sources(std::slice::from_ref(&of_tracker));
        entries.extend([whole, of_tracker]);
        entries.extend(self.sensors.iter().filter_map(TrackedSensor::health));
    }
}

impl TrackedSensor {
    /// Health of an external sensor; that of others is their adapter's.
    fn health(&self) -> Option<HealthEntry> {
        let checks = self.checks.as_ref()?;
        Some(HealthEntry {
            source: self.number,
            progress_ns: checks.progress_ns(),
            counters: checks.counters(),
            note: self.name.clone(),
            ..HealthEntry::default()
        })
    }
}
