//! Alerts process: finds events and dangers about targets, and publishes them on `system/alerts`.
//!
//! The engine is the crate [`alerts`]; this process is a subscriber like any other, so that a fault of it has no effect
//! on fusion. Alerts in force outlast the process (`memory`).

#![forbid(unsafe_code)]

mod agent;
mod memory;

use std::path::Path;

use alerts::{AlertEngine, AlertRules, NamedArea, named_areas};
use anyhow::Context as _;
use areas::Ground;
use frames::SystemFrame;
use runtime::Process;

use agent::AlertAgent;
use memory::AlertMemory;

/// Reads the areas of a deployment; files are relative to the folder `data`.
///
/// # Errors
/// If a file cannot be read, or has no usable area: with the number of its table.
pub fn read_areas(rules: &AlertRules, frame: SystemFrame, data: &Path) -> Result<Vec<NamedArea>, String> {
    let read = |file: &str| std::fs::read_to_string(data.join(file));
    named_areas(&rules.areas, &Ground::of(frame), &read).map_err(|refusal| refusal.to_string())
}

/// Runs the process until a stop request.
///
/// # Errors
/// If an area cannot be used, or shared memory fails.
pub fn run(process: &Process, rules: &AlertRules) -> anyhow::Result<()> {
    let config = &process.config;
    let areas = read_areas(rules, config.frame, &process.options.data).map_err(anyhow::Error::msg)?;
    let engine = AlertEngine::new(&rules.rules, areas, config.frame, config.system_tracks.max);
    let memory = AlertMemory::open(process).context("memory for the alerts in force")?;
    let mut agent = AlertAgent::new((config, engine), memory, &process.bus, process.incarnation)?;
    runtime::service::run(process, &mut agent)
}
