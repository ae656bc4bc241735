//! Simulator process: observes a simulated world with simulated sensors, and sends their reports over the network
//! like real sensors.
//!
//! Each sensor uses the category of its kind: a radar CAT048 with CAT034, multilateration CAT020 with CAT019, ADS-B
//! CAT021 with CAT023 (`feed`). Receivers of AIS send lines of NMEA 0183 (`ais`). A direction finder sends tables of
//! bearings, or the snapshots of its antenna array (`direction_finder`). A wide-area sensor sends tables of counts with
//! the configured delay (`wide_area`). Both send rows in datagrams (`rows`). A ship sends sentences of NMEA 0183, and
//! its radar rows of detections (`ship`). All
//! datagrams go to the adapter of their source at the deployment's own loopback address. A demonstration thus runs
//! through the same sockets, decoders and checks as a deployment with real sensors. Values that a category cannot
//! express (a radar's report has no covariance) are missing as in reality. A radar configured for plots sends plots
//! including false plots, and a marker when the antenna points north.
//!
//! The simulated world continues while the process is stopped: after a restart, the process observes the world at
//! the current time.

#![forbid(unsafe_code)]

mod ais;
mod direction_finder;
mod feed;
mod rows;
mod sensor;
mod ship;
mod wide_area;

pub use ais::AisFeed;
pub use feed::SensorFeed;

use std::fmt;
use std::net::SocketAddr;
use std::time::Duration;

use anyhow::Context as _;
use deployment::{Feed, FeedLink, ReceiverTransport};
use messages::NS_PER_S;
use net::{SenderSettings, UdpSender};
use runtime::Process;
use runtime::{Agent, HealthEntry, Now, Turn};
use scenario::{Instrument, ScenarioSettings, Truth, World};

use crate::ais::AisReceivers;
use crate::direction_finder::{ArrayFinder, DirectionFinder};
use crate::sensor::AsterixSensor;
use crate::ship::Ship;
use crate::wide_area::SimulatedWideArea;

/// Maximum size of a datagram, bytes: the payload of one Ethernet frame.
const DATAGRAM_OCTETS_MAX: usize = 1472;

/// Runs the simulated sensors of `world` until a stop is requested.
///
/// # Errors
/// If there is no simulated world, or a socket cannot be opened.
pub fn run(process: &Process, world: &World) -> anyhow::Result<()> {
    runtime::service::run(process, &mut Simulator::new(process, world)?)
}

/// Observer of the simulated world; sends the observations.
trait WorldObserver: fmt::Debug {
    /// Returns the time of the next delivery, seconds from the scenario's start.
    fn due_s(&self) -> f64;

    /// Makes and sends the due observations.
    fn deliver(&mut self, truth: &Truth, now_utc_ns: i64);

    /// Adds the observer's counts.
    fn count(&self, entry: &mut HealthEntry);
}

/// Agent of the simulated world.
#[derive(Debug)]
struct Simulator {
    truth: Truth,
    start_utc_ns: i64,
    observers: Vec<Box<dyn WorldObserver>>,
}

impl Simulator {
    fn new(process: &Process, world: &World) -> anyhow::Result<Self> {
        let config = &process.config;
        // Ships bring their targets along, so nothing observes this world.
        let targets = match &world.targets {
            Some(targets) => targets.clone(),
            None if !world.ships.is_empty() => ScenarioSettings::default(),
            None => anyhow::bail!("there is no [scenario]"),
        };
        let mut observers: Vec<Box<dyn WorldObserver>> = Vec::new();
        for (number, instrument) in &world.instruments {
            let source = &config.sources[usize::from(*number)];
            let unusable = || format!("simulated sensor {}", source.name);
            observers.push(match instrument {
                Instrument::Sensor(settings) => {
                    Box::new(AsterixSensor::new(process, source, settings).with_context(unusable)?)
                }
                Instrument::DirectionFinder {
                    settings,
                    array: Some(array),
                } => Box::new(ArrayFinder::new(process, source, settings, array).with_context(unusable)?),
                Instrument::DirectionFinder { settings, array: None } => {
                    Box::new(DirectionFinder::new(process, source, settings).with_context(unusable)?)
                }
                Instrument::Ais(settings) => {
                    Box::new(AisReceivers::new(process, source, settings).with_context(unusable)?)
                }
            });
        }
        for (number, settings) in &world.counting {
            let sensor = &config.wide_area_sensors[usize::from(*number)];
            let unusable = || format!("simulated wide-area sensor {}", sensor.name);
            observers.push(Box::new(
                SimulatedWideArea::new(process, sensor, settings).with_context(unusable)?,
            ));
        }
        for (number, settings) in &world.ships {
            let platform = &config.platforms[usize::from(*number)];
            let ship = Ship::new(process, platform, settings);
            let ship = ship.with_context(|| format!("simulated platform {}", platform.name))?;
            observers.push(Box::new(ship));
        }
        Ok(Self {
            truth: Truth::new(&targets, process.options.seed)?.round(config.frame),
            start_utc_ns: process.options.scenario_start_ns,
            observers,
        })
    }
}

/// Creates a socket to the receiver of a simulated source or sensor; the receiver has the name of the adapter.
fn sender_to(process: &Process, adapter: &str) -> anyhow::Result<UdpSender> {
    let receiver = process.config.receiver(adapter).context("it has no receiver")?;
    let port = match &receiver.transport {
        ReceiverTransport::Loopback { port } => *port,
        ReceiverTransport::Feed(Feed {
            link: FeedLink::Loopback { port },
            ..
        }) => *port,
        _ => anyhow::bail!("its receiver is not the deployment's own"),
    };
    let destination = SocketAddr::from((process.loopback, port));
    Ok(UdpSender::open(&SenderSettings::new(destination))?)
}

impl Agent for Simulator {
    fn turn(&mut self, now: Now) -> anyhow::Result<Turn> {
        let start_utc_ns = self.start_utc_ns;
        let due_ns = |observer: &dyn WorldObserver| start_utc_ns + (observer.due_s() * NS_PER_S) as i64;
        let next = self
            .observers
            .iter_mut()
            .min_by_key(|observer| due_ns(observer.as_ref()));
        let Some(observer) = next else {
            return Ok(Turn::Finished);
        };
        let due_ns = due_ns(observer.as_ref());
        if now.utc_ns < due_ns {
            return Ok(Turn::Idle(Duration::from_nanos((due_ns - now.utc_ns) as u64)));
        }
        observer.deliver(&self.truth, now.utc_ns);
        Ok(Turn::Worked)
    }

    fn health(&self, entries: &mut Vec<HealthEntry>) {
        let mut entry = HealthEntry::default();
        for observer in &self.observers {
            observer.count(&mut entry);
        }
        entries.push(entry);
    }
}
