//! Display of a running instance without its configuration, such as a mirror of another host.
//!
//! The topics of the instance are listed, again and again, since sources may come later. Names of sources come from
//! health messages. Sites, kinds and periods of sensors, and the settings of fusion, remain unknown.

use std::collections::BTreeSet;

use anyhow::Context as _;
use bus::{Bus, BusError, Root, SharedMemory};
use runtime::signals::Stop;
use runtime::{Agent as _, Now, Turn};

use crate::agent::DisplayAgent;
use crate::layers;
use crate::moments::Moments;
use crate::settings::{MapFiles, Settings};
use crate::shared::SharedState;
use crate::world::World;

/// Time between two lists of the topics, nanoseconds.
const LIST_EVERY_NS: i64 = 2_000_000_000;

/// Shows the instance `root` with these settings until its end, or until the process is asked to stop.
///
/// # Errors
/// If the instance does not run, no port is free, or shared memory fails.
pub fn show_instance(root: &Root, settings: &Settings) -> anyhow::Result<()> {
    let stop = Stop::on_signals().context("catching signals")?;
    let name = root.instance();
    let bus: Bus<SharedMemory> = Bus::open(root, &format!("display-of-{name}")).map_err(|error| match error {
        BusError::NotRunning { .. } => anyhow::anyhow!("instance {name} is just being started or stopped"),
        error => error.into(),
    })?;
    let world = World::of_instance(name, settings.history_s.into(), settings.history_bytes());
    let shared = SharedState::new(world, MapFiles::default(), Now::read);
    let server = crate::serve(settings, Moments::of_deployment(shared.clone()))?;
    crate::say(&server, settings);
    let incarnation = Now::read().mono_ns as u64;
    let mut agent = DisplayAgent::of_system_tracks(&bus, incarnation, (shared.clone(), server.counts().clone()))?;
    let mut known = BTreeSet::new();
    let mut list_ns = i64::MIN;
    while !stop.requested() {
        let now = Now::read();
        if now.mono_ns >= list_ns {
            list_ns = now.mono_ns + LIST_EVERY_NS;
            if !bus.goes_on()? {
                runtime::notice(format_args!("koseki: instance {name} has ended"));
                break;
            }
            let topics = bus.topics()?;
            let new: Vec<&String> = topics.iter().filter(|topic| !known.contains(*topic)).collect();
            let streams = new.iter().filter_map(|topic| layers::stream_of(topic));
            agent.subscribe(streams, &bus, incarnation)?;
            shared.world().has_decisions |= topics.iter().any(|topic| topic == messages::decisions().name.as_str());
            known.extend(topics);
        }
        if let Turn::Idle(at_most) = agent.turn(now)? {
            std::thread::sleep(at_most);
        }
    }
    Ok(())
}
