//! Gateway process: sends tracks to other systems over the network, as ASTERIX or as Cursor on Target events.
//!
//! The fused picture is sent as CAT062, with the state of the fusion system (CAT065) and of its sensors (CAT063), for
//! displays and neighbouring centres. The sensor tracks of one source can be sent as CAT010, 020, 021 or 048, to test
//! other systems. A cue outlet sends search regions to sensor controllers. A gateway is a subscriber like any other; a
//! fault of a gateway has no effect on fusion.

#![forbid(unsafe_code)]

mod agent;
#[cfg(test)]
mod agent_tests;
mod cue_outlet;
mod cue_settings;
mod destination;
mod outlet;
mod schedule;
mod selection;
mod sensor_states;
mod settings;
#[cfg(test)]
mod settings_tests;

use anyhow::Context as _;
use runtime::Process;

pub use cue_settings::CueOutletSettings;
pub use destination::Destination;
pub use settings::{Area, Keys, OutputFormat, Settings};

/// Runs the gateway of `keys` named in `process` until a stop request.
///
/// # Errors
/// If the configuration has no such gateway, if the socket cannot be opened, or if shared memory fails.
pub fn run(process: &Process, keys: &Keys) -> anyhow::Result<()> {
    if let Some(outlet) = keys.cue_outlet(&process.name) {
        let mut agent = cue_outlet::CueOutlet::new(outlet, &process.bus, process.incarnation)?;
        return runtime::service::run(process, &mut agent);
    }
    let gateway = keys.gateway(&process.name).with_context(|| {
        let path = process.config.path.display();
        format!("{path}: no gateway is named \"{}\"", process.name)
    })?;
    let mut agent = agent::GatewayAgent::new(&process.config, gateway, &process.bus, process.incarnation)?;
    runtime::service::run(process, &mut agent)
}
