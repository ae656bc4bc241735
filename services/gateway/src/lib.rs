//! The gateway process: sends tracks to other systems, in ASTERIX over the network.
//!
//! The fused picture goes out as CAT062, with the state of the fusion system (CAT065) and of its sensors (CAT063), as
//! displays and neighbouring centres expect it. The sensor tracks of one source can go out as CAT010, 020, 021 or 048,
//! to test other systems with. The process is a subscriber like any other: whatever happens to it, fusion does not
//! notice.

#![forbid(unsafe_code)]

mod agent;
#[cfg(test)]
mod agent_tests;
mod schedule;
mod selection;
mod sensor_states;

use anyhow::Context as _;
use configuration::Process;

/// Runs the gateway that the process is named after, until told to stop.
///
/// # Errors
/// If there is no such gateway, its socket cannot be opened, or shared memory fails.
pub fn run(process: &Process) -> anyhow::Result<()> {
    let gateway = process.config.gateway(&process.name).with_context(|| {
        let path = process.config.path.display();
        format!("{path}: no gateway is named \"{}\"", process.name)
    })?;
    let mut agent = agent::GatewayAgent::new(&process.config, gateway, &process.bus, process.incarnation)?;
    runtime::service::run(process, &mut agent)
}
