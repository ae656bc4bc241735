//! Start, supervision, restart and stop of the processes of a deployment (PL-1, PL-11).
//!
//! The processes of a deployment are separate, so that a fault of one process does not end the others. A supervisor
//! must keep all processes running. A shell script starts each process only once. A general service manager does not
//! reclaim the places and memory that dead processes leave in shared memory and that the successors need. The launcher
//! works in four steps:
//!
//! 1. **Claim of the instance** (`runtime::instance`): no second launcher runs the instance. The launcher removes
//!    remains of a killed run, checks the size of shared memory, and reports defects of the machine (`preflight`).
//! 2. **Start of the processes** (`part`, `child`), in stages: first the [`keeper`], which creates and holds every
//!    topic; then the monitor and the recorder, so that both miss nothing, with fusion and the gateways; when these
//!    run, the adapters; last the simulator. All are children of the same executable.
//! 3. **Supervision** (`supervisor`): a child with exit code 0 has finished. After any other end, the child's shared
//!    memory is reclaimed at once and the child is restarted, without limit of number, after pauses that grow with each
//!    failure (`backoff`); the others work meanwhile. A child without a sign of life has hung, and is killed and
//!    replaced. If several children fail in succession, the common memory is suspect (`suspicion`): the deployment is
//!    rebuilt in new shared memory. Only faults that no restart can cure end the deployment with an error: a refused
//!    configuration, or a fusion or required source that never comes up.
//! 4. **Stop**: sources first, the monitor last, since the final report covers all others; then the keeper. The
//!    instance is cleared.
//!
//! **The launcher maps no shared memory**: bytes written by others cannot harm the launcher. The kernel reports ends of
//! children, and the keeper passes on health messages over a socket (`link`). A child's loop makes the health message;
//! the housekeeping thread publishes the message where the loop must not make a system call, so that a new message is a
//! sign of life of both. A child has hung when the keeper has looked for `launcher.watchdog_s` without a new message.
//! Time in which the launcher or the keeper did not run does not count, since a stall of the machine stops all
//! processes. Unfinished shared memory of a killed process stops no child for long: the launcher removes such files
//! ([`bus::Unborn`]).
//!
//! Number of restarts, reasons and state of each child are part of the launcher's health messages, which the keeper
//! publishes for monitors and status displays. Standard error receives a line per event; standard output belongs to the
//! monitor. A service manager (systemd) receives the state of the deployment and signs of life of the launcher
//! (`service_manager`).
//!
//! Limits: if the launcher itself is killed, the kernel requests the children to stop, and the deployment ends; the
//! next start removes the remains. Corruption without a crash or hang is not detected here.

#![forbid(unsafe_code)]

mod backoff;
mod child;
mod children;
mod durable;
mod end;
pub mod keeper;
mod last_end;
mod link;
mod part;
mod preflight;
mod records;
mod service_manager;
mod settings;
mod supervisor;
mod suspicion;
mod wake;

use std::path::{Path, PathBuf};
use std::time::Duration;

use anyhow::Context as _;
use bus::Root;
use deployment::Deployment;
use runtime::instance::{self, Instance};
use runtime::signals::Stop;
use runtime::{Now, Options};

pub use last_end::{EndedInstance, ended_instances};
pub use settings::{Keys, Settings};
pub use supervisor::ChildRefused;

/// Options of a run.
#[derive(Clone, Debug)]
pub struct RunOptions {
    /// Options of every process.
    pub options: Options,
    /// Time to stop, counted from the start of the adapters; `None`: at a request, or when all work is done.
    pub run_for: Option<Duration>,
    /// Whether nothing of an earlier run goes on.
    pub fresh: bool,
}

/// Runs the deployment until a stop request, the end of the run time, or the end of all recordings.
///
/// The calling thread must live longest: children end with the thread that started them.
///
/// # Errors
/// If the instance already runs, the machine refuses an operation, a needed child cannot be kept running
/// ([`ChildRefused`] for a refused configuration), or a child did not stop as requested.
pub fn run(config: &Deployment, settings: &Settings, orders: &RunOptions) -> anyhow::Result<()> {
    // All children inherit the mask. Recordings have the same content as shared memory, which belongs to this user
    // alone.
    rustix::process::umask(rustix::fs::Mode::from_raw_mode(settings.file_mode.mask()));
    let stop = Stop::on_signals().context("catching signals")?;
    let wake = wake::Wake::on_signals().context("catching signals")?;
    let processes = part::parts(config).len();
    let mut instance = Instance::claim(config, &orders.options.instance, processes, &stop, say)?;
    let root = instance.root().clone();
    let copies = config.checkpoint.copies().map(|(folder, _)| folder);
    let keeps = config.checkpoint.enabled && !config.is_recorded();
    // The file of the last end is read before copies: the file has the last state, and copies may lack this state.
    let ends: Vec<PathBuf> = [root.base().to_owned()].into_iter().chain(copies.clone()).collect();
    let begin = || {
        if orders.fresh {
            forget(&root, copies.as_deref(), &ends);
        }
        if keeps {
            last_end::take_up(&root, &ends)?;
        }
        if let Some(folder) = &copies {
            durable::revive(&root, folder)?;
        }
        if keeps {
            last_end::note_numbers(&root)?;
        }
        Ok(())
    };
    let result = preflight::check(config)
        .and_then(|()| begin())
        .and_then(|()| with_records(config, orders.clone()))
        .and_then(|orders| {
            supervisor::Supervisor::new((config, settings.watchdog()), &orders, &mut instance, stop, wake)?.run()
        });
    if let Some(folder) = &copies {
        root.remove_copies(folder);
    }
    let kept = if keeps { last_end::keep(&root, &ends) } else { Ok(()) };
    let cleared = instance.clear();
    result.and(kept).and(cleared)
}

/// Removes files that earlier runs have left for this run.
fn forget(root: &Root, copies: Option<&Path>, ends: &[PathBuf]) {
    root.remove_outlasting();
    if let Some(folder) = copies {
        root.remove_copies(folder);
    }
    last_end::remove(root, ends);
}

/// Returns the options with a folder for this start in place of the requested folder, if any file is written.
fn with_records(config: &Deployment, mut orders: RunOptions) -> anyhow::Result<RunOptions> {
    if config.services.recorder || config.services.monitor_files {
        let out = &mut orders.options.out;
        *out = records::begin(out, Now::read().utc_ns)?;
        say(&format!("this start writes to {}", out.display()));
    }
    Ok(orders)
}

/// Returns the maximum size of a deployment in shared memory, bytes.
pub fn needed_bytes(config: &Deployment) -> u64 {
    instance::needed_bytes(config, part::parts(config).len())
}

/// Reports an event. A closed standard error does not end a deployment.
fn say(line: &str) {
    runtime::notice(format_args!("koseki: {line}"));
}
