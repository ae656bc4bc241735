//! The fusion process: takes sensor tracks from shared memory, lets the engine fuse them, publishes system tracks.
//!
//! This crate decides *when* and *which*: which source is read next, when a report's turn has come, when time has passed.
//! *How* reports become system tracks is the `fusion` crate's business.

#![forbid(unsafe_code)]

mod agent;
mod inputs;
mod output;

pub use agent::FusionAgent;

use runtime::{Process, cores};

/// Runs fusion until every source has ended or the process is told to stop.
///
/// # Errors
/// If the machine refuses what the configuration requires of it, or shared memory fails.
pub fn run(process: &Process) -> anyhow::Result<()> {
    let fusion = &process.config.fusion;
    let mut agent = FusionAgent::new(&process.config, &process.bus, process.incarnation)?;
    let refused = cores::take_place(fusion.placement).join("; ");
    if !refused.is_empty() {
        anyhow::ensure!(!fusion.required, "{refused}; grant it, or set fusion.required = false");
        eprintln!("warning: {refused}; going on without");
        agent.set_note(refused);
    }
    runtime::service::run(process, &mut agent)
}
