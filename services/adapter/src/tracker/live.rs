//! Live tracker process: takes the sensors' detections from topics.
//!
//! The events of a turn are taken in the order of receipt, across all topics: after a pause of the machine, one
//! sensor's backlog must not make the others late. Detections of an external publisher have passed no adapter, so times
//! and places are checked here.

use std::time::Duration;

use bus::{SharedMemory, Subscriber, WaitMode, Waiter};
use deployment::{Input, Source};
use messages::{Counter, Counters, PlatformState, SensorDetection};
use observations::{Sampled, SensorEvent};
use platform::State;
use runtime::Process;
use runtime::clock::SteadyClock;
use runtime::{Agent, HealthEntry, Now, Turn};
use sources::carrying::Carrying;
use sources::silence::{SilenceRules, SilentSensor};
use sources::{Pipeline, Readings, Samples, SourceReading, TrackerSettings};
use tracking::wide_area::arrivals::Arrivals;

use crate::Processed;
use crate::channel::SourceChannel;
use crate::platform::FAR_M;

use super::on_board;
use super::orders::Orders;

/// Longest wait for detections in a turn, bounded by health messages and stop requests.
const PATIENCE: Duration = Duration::from_millis(50);
/// Slices taken at a time from the topic of a sensor.
const SLICES_PER_TURN: usize = 64;

/// Agent of a live tracker process.
#[derive(Debug)]
pub(super) struct TrackerAgent {
    channel: SourceChannel,
    sensors: Vec<TrackedSensor>,
    /// Orders of operators, if any of the sensors takes orders.
    orders: Option<Orders>,
    waiter: Waiter<SharedMemory>,
    steady: SteadyClock,
    /// Events of a turn: monotonic time of receipt (nanoseconds), place of the sensor, event.
    taken: Vec<(i64, usize, SensorEvent)>,
    /// States of the platforms that carry sensors.
    platforms: Vec<Subscriber<SharedMemory, PlatformState>>,
    carrying: Carrying<i64>,
    /// Longest time for which detections wait for states, nanoseconds.
    wait_ns: i64,
    /// Events for the tracker: place of the sensor, event, monotonic time of receipt.
    carried: Vec<(usize, SensorEvent, i64)>,
    /// Distance from the frame's origin of the sensor that measured the latest detection, metres.
    distance_m: f64,
}

/// Sensor of the tracker.
#[derive(Debug)]
struct TrackedSensor {
    number: u16,
    name: String,
    /// Whether the sensor may move: its position comes from the detections, or from its platform.
    may_move: bool,
    events: Subscriber<SharedMemory, SensorDetection>,
    /// Checks of an external sensor.
    checks: Option<Box<Pipeline>>,
    /// With a stated period.
    silent: Option<(SilentSensor, SilenceRules)>,
    /// Samples with codes of another schema.
    unknown: u64,
}

impl TrackerAgent {
    /// Opens the topics of the sensors, and the tracker.
    pub(super) fn open(process: &Process, tracker: Processed<'_>) -> anyhow::Result<Self> {
        let mut waiter = process.bus.waiter(WaitMode::Event);
        let mut sensors = Vec::new();
        for (place, sensor) in process.config.sensors_of(tracker.source).iter().enumerate() {
            let topic = messages::sensor_detections(&sensor.name);
            waiter.watch(&process.bus, &topic)?;
            sensors.push(TrackedSensor {
                number: sensor.number,
                name: sensor.name.clone(),
                may_move: sensor.on_board.is_some() || sensor.has_rows(),
                events: process.bus.subscriber(&topic, || process.incarnation)?,
                checks: checks(process, sensor, tracker.readings)?,
                silent: silence(tracker.reading().processing.tracker(), place, sensor),
                unknown: 0,
            });
        }
        let of_tracker = (tracker.source.number, process.config.sensors_of(tracker.source));
        let orders = Orders::open(&process.bus, of_tracker, process.config.frame, process.incarnation)?;
        let mut platforms = Vec::new();
        for platform in on_board::platforms(process, tracker) {
            let topic = messages::platform_states(&platform.name);
            waiter.watch(&process.bus, &topic)?;
            platforms.push(process.bus.subscriber(&topic, || process.incarnation)?);
        }
        Ok(Self {
            channel: SourceChannel::open(process, tracker)?,
            orders,
            platforms,
            carrying: on_board::carrying(process, tracker, None),
            wait_ns: on_board::longest_wait_ns(process, tracker),
            carried: Vec::new(),
            distance_m: 0.0,
            sensors,
            waiter,
            steady: SteadyClock::of(Now::read()),
            taken: Vec::new(),
        })
    }

    /// Takes the published events, in the order of receipt.
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

    /// Puts the detections of sensors on board into the system frame. The states of the turn come first: whether a
    /// detection has waited too long should depend as little as possible on the load of the machine.
    fn carry(&mut self) -> anyhow::Result<()> {
        self.carried.clear();
        let (carrying, carried) = (&mut self.carrying, &mut self.carried);
        for (place, states) in self.platforms.iter_mut().enumerate() {
            states.take(SLICES_PER_TURN, |_, samples| {
                let states = samples.iter().map(State::of_sample);
                states.for_each(|state| carrying.state(place, &state));
            })?;
        }
        let mut out = |place, event, came_ns| carried.push((place, event, came_ns));
        carrying.release(&mut out);
        for (came_ns, place, event) in &self.taken {
            carrying.take(*place, *event, *came_ns, &mut out);
        }
        // A state sets free the detections of sensor after sensor. In the order of receipt, a single sensor's backlog
        // does not make the other sensors' detections late.
        self.carried.sort_by_key(|(_, _, came_ns)| *came_ns);
        Ok(())
    }
}

/// Checks of a sensor with detections that pass no adapter.
fn checks(process: &Process, sensor: &Source, readings: &Readings) -> anyhow::Result<Option<Box<Pipeline>>> {
    let is_external = matches!(sensor.input, Input::External);
    let SourceReading { model, processing, .. } = &readings.sources[usize::from(sensor.number)];
    let pipeline = || Pipeline::new(*model, processing, process.first_day_ns(), Arrivals::new());
    Ok(is_external.then(pipeline).transpose()?.map(Box::new))
}

/// The silence of a sensor with a stated period.
fn silence(settings: Option<&TrackerSettings>, place: usize, sensor: &Source) -> Option<(SilentSensor, SilenceRules)> {
    let cutter = settings?.joining.cutters.get(place)?;
    let rules = SilenceRules::new(cutter, cutter.period_ns?, sensor.silent_after_ns);
    Some((SilentSensor::default(), rules))
}

impl Agent for TrackerAgent {
    fn turn(&mut self, now: Now) -> anyhow::Result<Turn> {
        self.take(now)?;
        self.channel.listen()?;
        for (came_ns, place, event) in &self.taken {
            if let Some((silent, _)) = &mut self.sensors[*place].silent {
                silent.came(event.time_ns(), *came_ns);
            }
        }
        // The substitutes for a silent sensor's events pass through the same queue as its detections.
        for (place, sensor) in self.sensors.iter_mut().enumerate() {
            let silent = sensor.silent.as_mut().filter(|_| !sensor.events.has_slices());
            let due = silent.and_then(|(silent, rules)| silent.statement(now.mono_ns, rules));
            self.taken.extend(due.map(|(event, came_ns)| (came_ns, place, event)));
        }
        if let Some(orders) = &mut self.orders {
            self.taken.iter().for_each(|(_, _, event)| orders.came(event.time_ns()));
            orders.turn(now.mono_ns, &mut self.taken)?;
        }
        self.carry()?;
        for (place, event, came_ns) in &self.carried {
            if let SensorEvent::Detection(detection) = event
                && self.sensors[*place].may_move
            {
                let [east, north, _] = detection.platform_m;
                self.distance_m = east.hypot(north);
            }
            self.channel.event(*place, event, *came_ns)?;
        }
        if self.taken.is_empty() {
            // Detections may wait for states of a platform.
            self.channel.clock(now.mono_ns.saturating_sub(self.wait_ns))?;
        }
        self.channel.publish()?;
        Ok(match self.taken.is_empty() && self.carried.is_empty() {
            true => Turn::Idle(PATIENCE),
            false => Turn::Worked,
        })
    }

    /// Waiting detections are carried with the available states, or refused and counted.
    fn close(&mut self, _: Now) -> anyhow::Result<()> {
        self.carried.clear();
        self.carrying.states_end();
        let carried = &mut self.carried;
        self.carrying
            .release(&mut |place, event, came_ns| carried.push((place, event, came_ns)));
        for (place, event, came_ns) in &self.carried {
            self.channel.event(*place, event, *came_ns)?;
        }
        self.channel.publish()
    }

    fn wait(&mut self, at_most: Duration) -> anyhow::Result<()> {
        let (sensors, platforms) = (&self.sensors, &self.platforms);
        self.waiter.wait(at_most, || {
            let has_states = platforms.iter().any(Subscriber::has_slices);
            has_states || sensors.iter().any(|sensor| sensor.events.has_slices())
        })?;
        Ok(())
    }

    fn health(&self, entries: &mut Vec<HealthEntry>) {
        let mut of_tracker = self.channel.health(&Counters::default());
        let lost = self.sensors.iter().map(|sensor| sensor.events.counts());
        let lost = lost.chain(self.platforms.iter().map(Subscriber::counts));
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
        if self.distance_m > FAR_M {
            whole.set(Counter::PlatformFarKm, (self.distance_m / 1e3) as u64);
        }
        entries.extend([whole, of_tracker]);
        entries.extend(self.sensors.iter().filter_map(TrackedSensor::health));
    }
}

impl TrackedSensor {
    /// Health of an external sensor; the health of other sensors comes from the adapter.
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
