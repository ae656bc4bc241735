//! The simulator process: observes a simulated world with simulated sensors, and sends what they report over the
//! network as real sensors do.
//!
//! Each sensor speaks the category of its kind: a radar CAT048 with CAT034, multilateration CAT020 with CAT019, ADS-B
//! CAT021 with CAT023 (`feed`). A direction finder sends tables of bearings (`direction_finder`), a wide-area sensor
//! tables of counts, as late as they are to arrive (`wide_area`), both as rows in datagrams (`rows`). All go to the
//! adapter of their source at the deployment's own loopback address. So a demonstration runs through the same sockets,
//! decoders and checks as a deployment with real sensors, and what a category cannot say (a radar's report has no
//! covariance) is missing here as it is there. A radar that delivers plots sends those, false ones among them, and says
//! when its antenna points north.
//!
//! The simulated world goes on while the process is away: started again, it looks at the world as it is by then.

#![forbid(unsafe_code)]

mod direction_finder;
mod feed;
mod rows;
mod sensor;
mod wide_area;

pub use feed::Feed;

use std::fmt;
use std::net::SocketAddr;
use std::time::Duration;

use anyhow::Context as _;
use configuration::{Input, Instrument, Process, Transport};
use messages::NS_PER_S;
use net::{SenderSettings, UdpSender};
use runtime::{Agent, HealthEntry, Now, Turn};
use scenario::Truth;

use crate::direction_finder::DirectionFinder;
use crate::sensor::Sensor;
use crate::wide_area::WideArea;

/// Most octets in a datagram: what fits into one frame of Ethernet.
const DATAGRAM_OCTETS_MAX: usize = 1472;

/// Runs the simulated sensors until told to stop.
///
/// # Errors
/// If there is no simulated world, or a socket cannot be opened.
pub fn run(process: &Process) -> anyhow::Result<()> {
    runtime::service::run(process, &mut Simulator::new(process)?)
}

/// Something that observes the simulated world, with its way out.
trait Observer: fmt::Debug {
    /// Time at which its next delivery is due, seconds from the scenario's start.
    fn due_s(&self) -> f64;

    /// Observes and sends what is due.
    fn deliver(&mut self, truth: &Truth, now_utc_ns: i64);

    /// Adds what it has counted.
    fn count(&self, entry: &mut HealthEntry);
}

/// The agent of the simulated world.
#[derive(Debug)]
struct Simulator {
    truth: Truth,
    start_utc_ns: i64,
    observers: Vec<Box<dyn Observer>>,
}

impl Simulator {
    fn new(process: &Process) -> anyhow::Result<Self> {
        let config = &process.config;
        let world = config.scenario.as_ref().context("there is no [scenario]")?;
        let mut observers: Vec<Box<dyn Observer>> = Vec::new();
        for source in &config.sources {
            let Input::Simulated(simulated) = &source.input else {
                continue;
            };
            let unusable = || format!("simulated sensor {}", source.name);
            observers.push(match &simulated.instrument {
                Instrument::Sensor(settings) => {
                    Box::new(Sensor::new(process, source, settings).with_context(unusable)?)
                }
                Instrument::DirectionFinder(settings) => {
                    Box::new(DirectionFinder::new(process, source, settings).with_context(unusable)?)
                }
            });
        }
        for sensor in &config.wide_area_sensors {
            if let Some(settings) = &sensor.simulated {
                let unusable = || format!("simulated wide-area sensor {}", sensor.name);
                observers.push(Box::new(
                    WideArea::new(process, sensor, settings).with_context(unusable)?,
                ));
            }
        }
        Ok(Self {
            truth: Truth::new(world, process.options.seed)?.round(config.frame),
            start_utc_ns: process.options.scenario_start_ns,
            observers,
        })
    }
}

/// A socket that sends to the receiver of a simulated source or sensor, which is named like its adapter.
fn sender_to(process: &Process, adapter: &str) -> anyhow::Result<UdpSender> {
    let receiver = process.config.receiver(adapter).context("it has no receiver")?;
    let Transport::Loopback { port } = receiver.transport else {
        anyhow::bail!("its receiver is not the deployment's own");
    };
    let destination = SocketAddr::from((process.loopback, port));
    Ok(UdpSender::open(&SenderSettings::new(destination))?)
}

impl Agent for Simulator {
    fn turn(&mut self, now: Now) -> anyhow::Result<Turn> {
        let start_utc_ns = self.start_utc_ns;
        let due_ns = |observer: &dyn Observer| start_utc_ns + (observer.due_s() * NS_PER_S) as i64;
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
