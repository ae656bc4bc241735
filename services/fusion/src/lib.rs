//! Fusion process: takes sensor tracks from shared memory, runs the engine, and publishes system tracks.
//!
//! This crate decides *when* and *which*: the source to read next, the time of a report's turn, the passage of time.
//! *How* reports become system tracks is the subject of the crate `fusion`.

#![forbid(unsafe_code)]

//! # The loop
//!
//! Fusion responds within microseconds, so that the fusing thread does nothing else: a second thread publishes counters
//! and receives orders (`runtime::housekeeping`), and a third thread smooths on request (`smoothing`). Each turn takes
//! a report of each source with waiting reports, fuses the report, and publishes the result. With `wait = "spin"` on a
//! separate core, a turn makes no system call, takes no lock and allocates nothing (tests/allocation.rs;
//! docs/real-time.md has the trace).

mod agent;
mod clocks;
mod continuity;
mod forecast;
mod health;
mod inputs;
mod log;
mod output;
mod part;
#[cfg(test)]
mod quarantine_tests;
mod smoothing;
mod source_time;
mod standby;
mod standby_looks;

pub use agent::FusionAgent;
pub use smoothing::{SmoothingQueue, SmoothingWorker};

use std::sync::Arc;

use deployment::WaitWord;
use fusion::Settings;
use runtime::Process;
use runtime::cores::Placement;
use runtime::housekeeping::{Housekeeper, Queues};
use runtime::{Now, Rest, WakeUpLimit, cores};

use crate::part::FusionPart;
use crate::smoothing::SmoothingThread;
use crate::standby::LeadLock;

/// Pauses of a loop that would otherwise never sleep: 6 % of the time, more than the kernel would take by force.
const REST: Rest = Rest {
    every_ns: 1_000_000,
    for_ns: 60_000,
};

/// Runs fusion with the engine of `settings` until every source has ended or a stop is requested.
///
/// # Errors
/// If the machine refuses a required setting or a limit of wake-ups, or shared memory fails.
pub fn run(process: &Process, settings: &Settings) -> anyhow::Result<()> {
    let config = &process.config;
    let fusion = &config.fusion;
    let limit_us = config.machine.cpu_dma_latency_us;
    let _limit = (limit_us.map(WakeUpLimit::request).transpose()).map_err(anyhow::Error::msg)?;
    let queues = Queues::new(config.decision_use());
    // An entry for the process as a whole, and an entry for each source.
    let entries_max = 1 + config.sources.len();
    let has_standby = config.has_standby();
    let lock = has_standby.then(|| LeadLock::open(process)).transpose()?;
    // With a standby, each fusion starts as a standby: `fusion.core` belongs to the leader.
    let placement = match has_standby {
        true => Placement {
            core: fusion.standby_core,
            ..Placement::from(fusion)
        },
        false => Placement::from(fusion),
    };
    // Before this thread takes the core: threads inherit core and priority.
    let housekeeper = Housekeeper::start(process, fusion.core, entries_max, Arc::clone(&queues))?;
    let start = |lag_ns| {
        let root = process.bus.root().clone();
        let name = format!("{}-{}-smoothing", process.kind.word(), process.name);
        let (tracks, incarnation) = (config.system_tracks.max, process.incarnation);
        SmoothingThread::start((root, name), fusion.core, (lag_ns, tracks, incarnation))
    };
    let smoothing = settings.smoothing_lag_ns().map(start).transpose()?;
    let queue = smoothing.as_ref().map(SmoothingThread::queue);
    let mut part = FusionPart::new(process, settings, lock, (queues, queue), Now::read())?;
    let refused = cores::take_place(placement).join("; ");
    if !refused.is_empty() {
        anyhow::ensure!(!fusion.required, "{refused}; grant it, or set fusion.required = false");
        runtime::notice(format_args!("warning: {refused}; going on without"));
        housekeeper.set_note(refused);
    }
    let hardly_sleeps = fusion.wait != WaitWord::Event && fusion.realtime_priority.is_some();
    let rest = hardly_sleeps.then_some(REST).filter(|_| fusion.rests);
    runtime::service::run_apart(process, &mut part, rest, housekeeper)?;
    smoothing.map_or(Ok(()), SmoothingThread::close)
}
