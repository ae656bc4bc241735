//! The simulator process: observes a simulated world with simulated sensors, and sends what they report as real sensors do,
//! in ASTERIX over the network.
//!
//! Each sensor speaks the category of its kind: a radar CAT048 with CAT034, multilateration CAT020 with CAT019, ADS-B
//! CAT021 with CAT023. Its datagrams go to the adapter of its source at the deployment's own loopback address. So a
//! demonstration runs through the same sockets, decoders and checks as a deployment with real sensors, and what a
//! category cannot say (a radar's report has no covariance) is missing here as it is there. A radar that delivers plots sends
//! those, false ones among them, and says when its antenna points north.
//!
//! The simulated world goes on while the process is away: started again, it looks at the world as it is by then.

#![forbid(unsafe_code)]

use std::net::SocketAddr;
use std::time::Duration;

use anyhow::Context as _;
use formats::asterix::{Category, registry};
use formats::outgoing::{HeightReference, SensorReports};
use messages::{Counter, NS_PER_S, SensorTrack};
use net::{SenderSettings, UdpSender};
use runtime::config::{Input, Source, Transport};
use runtime::{Agent, HealthEntry, Now, Process, Turn};
use scenario::{Plot, SensorKind, SensorSettings, SimulatedSensor, Truth};

/// Most octets in a datagram: what fits into one frame of Ethernet.
const DATAGRAM_OCTETS_MAX: usize = 1472;
/// Time between two status messages of a sensor, nanoseconds.
const STATUS_PERIOD_NS: i64 = 1_000_000_000;
/// Most reports of one delivery; more need more memory.
const DELIVERY_MAX: usize = 4096;

/// Runs the simulated sensors until told to stop.
///
/// # Errors
/// If there is no simulated world, or a socket cannot be opened.
pub fn run(process: &Process) -> anyhow::Result<()> {
    runtime::service::run(process, &mut Simulator::new(process)?)
}

/// The agent of the simulated world.
#[derive(Debug)]
struct Simulator {
    truth: Truth,
    start_utc_ns: i64,
    sensors: Vec<Sensor>,
    delivery: Vec<SensorTrack>,
    plots: Vec<Plot>,
}

/// One simulated sensor with its way out.
#[derive(Debug)]
struct Sensor {
    simulated: SimulatedSensor,
    reports: SensorReports,
    sender: UdpSender,
    next_status_ns: i64,
    sends_plots: bool,
}

impl Simulator {
    fn new(process: &Process) -> anyhow::Result<Self> {
        let config = &process.config;
        let world = config.scenario.as_ref().context("there is no [scenario]")?;
        let mut sensors = Vec::new();
        for source in &config.sources {
            if let Input::Simulated(simulated) = &source.input {
                let sensor = Sensor::new(process, source, &simulated.sensor);
                sensors.push(sensor.with_context(|| format!("simulated sensor {}", source.name))?);
            }
        }
        Ok(Self {
            truth: Truth::new(world, process.options.seed)?,
            start_utc_ns: process.options.scenario_start_ns,
            sensors,
            delivery: Vec::with_capacity(DELIVERY_MAX),
            plots: Vec::with_capacity(DELIVERY_MAX),
        })
    }
}

impl Sensor {
    fn new(process: &Process, source: &Source, settings: &SensorSettings) -> anyhow::Result<Self> {
        let (seed, start_utc_ns) = (process.options.seed, process.options.scenario_start_ns);
        let mut simulated = SimulatedSensor::new(settings, seed, source.number, start_utc_ns)?;
        simulated.restart_at(((Now::read().utc_ns - start_utc_ns) as f64 / NS_PER_S).max(0.0));
        let receiver = process.config.receiver(&source.adapter).context("it has no receiver")?;
        let Transport::Loopback { port } = receiver.transport else {
            anyhow::bail!("its receiver is not the deployment's own");
        };
        let destination = SocketAddr::from((process.loopback, port));
        let (sac, sic) = source.model.sac_sic.context("it has no SAC and SIC")?;
        let model = &source.model;
        let table = table(settings.kind).context("there is no table for it")?;
        Ok(Self {
            simulated,
            // Sensors report flight levels; the height of the simulated world is pressure altitude.
            reports: SensorReports::new(table, sac, sic, model.frame, model.system, DATAGRAM_OCTETS_MAX)?
                .with_height(HeightReference::Barometric),
            sender: UdpSender::open(&SenderSettings::new(destination))?,
            next_status_ns: i64::MIN,
            sends_plots: settings.plots,
        })
    }

    /// Sends `delivery` and, when it is time, a status message.
    fn send(&mut self, delivery: &[SensorTrack], now_utc_ns: i64) {
        let sender = &mut self.sender;
        // What could not be sent is counted by the sender; a sensor does not stop because nobody listens.
        let mut send = |datagram: &[u8]| drop(sender.send(datagram));
        if now_utc_ns >= self.next_status_ns {
            self.reports.status(now_utc_ns, &mut send);
            self.next_status_ns = now_utc_ns + STATUS_PERIOD_NS;
        }
        for track in delivery {
            self.reports.report(track, &mut send);
        }
        self.reports.flush(&mut send);
    }
}

impl Sensor {
    /// Sends `plots`, after a north marker if a turn began at `north_ns`.
    fn send_plots(&mut self, plots: &[Plot], north_ns: Option<i64>) {
        let sender = &mut self.sender;
        let mut send = |datagram: &[u8]| drop(sender.send(datagram));
        if let Some(north_ns) = north_ns {
            self.reports.status(north_ns, &mut send);
        }
        for plot in plots {
            self.reports
                .plot(plot.time_of_measurement_ns, plot.position_m, plot.height, &mut send);
        }
        self.reports.flush(&mut send);
    }
}

/// What a sensor of this kind speaks.
fn table(kind: SensorKind) -> Option<&'static Category> {
    registry::default_edition(match kind {
        SensorKind::Radar => 48,
        SensorKind::Multilateration => 20,
        SensorKind::AdsB => 21,
    })
}

impl Agent for Simulator {
    fn turn(&mut self, now: Now) -> anyhow::Result<Turn> {
        let start_utc_ns = self.start_utc_ns;
        let due_ns = |sensor: &Sensor| start_utc_ns + (sensor.simulated.next_scan_time_s() * NS_PER_S) as i64;
        let next = self.sensors.iter_mut().min_by_key(|sensor| due_ns(sensor));
        let Some(sensor) = next else { return Ok(Turn::Finished) };
        let due_ns = due_ns(sensor);
        if now.utc_ns < due_ns {
            return Ok(Turn::Idle(Duration::from_nanos((due_ns - now.utc_ns) as u64)));
        }
        self.delivery.clear();
        if sensor.sends_plots {
            self.plots.clear();
            let north_s = sensor.simulated.period_begins_s();
            let simulated = &mut sensor.simulated;
            simulated.scan_with_plots(&self.truth, &mut self.delivery, &mut self.plots);
            sensor.send_plots(
                &self.plots,
                north_s.map(|north_s| start_utc_ns + (north_s * NS_PER_S) as i64),
            );
        } else {
            sensor.simulated.scan(&self.truth, &mut self.delivery);
            sensor.send(&self.delivery, now.utc_ns);
        }
        Ok(Turn::Worked)
    }

    fn health(&self, entries: &mut Vec<HealthEntry>) {
        let mut entry = HealthEntry::default();
        let sum = |of: fn(&Sensor) -> u64| self.sensors.iter().map(of).sum();
        entry.set(Counter::RecordsSent, sum(|sensor| sensor.reports.counts().records));
        entry.set(Counter::RefusedTracks, sum(|sensor| sensor.reports.counts().refused()));
        entry.set(Counter::DatagramsSent, sum(|sensor| sensor.sender.counters().sent));
        entry.set(Counter::SendFailures, sum(|sensor| sensor.sender.counters().failed));
        entries.push(entry);
    }
}
