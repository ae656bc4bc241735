//! A simulated sensor that observes the simulated world, live.

use std::time::Duration;

use anyhow::Context as _;
use bus::{Mark, Publisher, SharedMemory};
use messages::{Counter, NS_PER_S, SensorTrack};
use runtime::clock::mono_ns;
use runtime::config::Source;
use runtime::{Agent, HealthEntry, Now, Process, Turn};
use scenario::{SensorSettings, SimulatedSensor, Truth};

/// The agent of a simulated source.
#[derive(Debug)]
pub(crate) struct Simulation {
    truth: Truth,
    sensor: SimulatedSensor,
    publisher: Publisher<SharedMemory, SensorTrack>,
    start_utc_ns: i64,
    scan: Vec<SensorTrack>,
    progress_ns: i64,
}

impl Simulation {
    pub(crate) fn new(process: &Process, source: &Source, settings: &SensorSettings) -> anyhow::Result<Self> {
        let world = process.config.scenario.as_ref().context("there is no [scenario]")?;
        let (seed, start_utc_ns) = (process.options.seed, process.options.scenario_start_ns);
        let mut sensor = SimulatedSensor::new(settings, seed, source.number, start_utc_ns)?;
        // The world goes on while a sensor is away: it looks again from now on.
        sensor.restart_at(((Now::read().utc_ns - start_utc_ns) as f64 / NS_PER_S).max(0.0));
        Ok(Self {
            truth: Truth::new(world, seed)?,
            sensor,
            publisher: process
                .bus
                .publisher(&messages::sensor_tracks(&source.name), process.incarnation)?,
            start_utc_ns,
            scan: Vec::with_capacity(4096),
            progress_ns: i64::MIN,
        })
    }
}

impl Agent for Simulation {
    fn turn(&mut self, now: Now) -> anyhow::Result<Turn> {
        let due_ns = self.start_utc_ns + (self.sensor.next_scan_time_s() * NS_PER_S) as i64;
        if now.utc_ns < due_ns {
            return Ok(Turn::Idle(Duration::from_nanos((due_ns - now.utc_ns) as u64)));
        }
        self.progress_ns = self.start_utc_ns + (self.sensor.progress_s() * NS_PER_S) as i64;
        self.scan.clear();
        self.sensor.scan(&self.truth, &mut self.scan);
        let (scan, sent_ns) = (&self.scan, mono_ns());
        let mark = Mark {
            progress_ns: self.progress_ns,
            sent_ns,
            end: false,
        };
        self.publisher.send(mark, scan.len(), |index, sequence| {
            let mut report = scan[index];
            report.sequence = sequence;
            // The scan came into being when its delivery was due and this turn began.
            report.stages.ingested_ns = now.mono_ns;
            report.stages.published_ns = sent_ns;
            report
        })?;
        Ok(Turn::Worked)
    }

    fn health(&self, entries: &mut Vec<HealthEntry>) {
        let mut entry = HealthEntry {
            progress_ns: self.progress_ns,
            ..HealthEntry::default()
        };
        let published = self.publisher.counts().samples;
        entry.set(Counter::Records, published);
        entry.set(Counter::Reports, published);
        entry.set(Counter::Published, published);
        entries.push(entry);
    }
}
