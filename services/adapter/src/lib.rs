//! The adapter process: one per sensor, it turns the sensor's data into sensor tracks and publishes them.
//!
//! Where the data come from is one file each: `recording` decodes a recorded file, `replay` paces it by its own
//! times, `simulation` observes a simulated world.

#![forbid(unsafe_code)]

pub mod recording;
mod replay;
mod simulation;

use anyhow::Context as _;
use runtime::Process;
use runtime::config::Input;

/// Runs the adapter of the source that the process is named after, until it has finished or is told to stop.
///
/// # Errors
/// If there is no such source, its input cannot be read, or shared memory fails.
pub fn run(process: &Process) -> anyhow::Result<()> {
    let source = process.config.source(&process.name);
    let source = source.with_context(|| {
        format!(
            "{}: no source is named \"{}\"",
            process.config.path.display(),
            process.name
        )
    })?;
    match &source.input {
        Input::Recorded(recorded) => {
            runtime::service::run(process, &mut replay::Replay::new(process, source, recorded)?)
        }
        Input::Simulated(settings) => {
            runtime::service::run(process, &mut simulation::Simulation::new(process, source, settings)?)
        }
    }
}
