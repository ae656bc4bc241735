//! Starts, watches, restarts and stops the processes of a deployment (PL-1, PL-11).
//!
//! The processes of a deployment are separate so that a fault in one does not end the others. Somebody must then see to
//! it that all of them are there. A shell script that starts them one after the other does that until the first one
//! dies, and a general service manager does not know that dead processes leave places and memory in shared memory that
//! their successors need. The launcher does four things, in this order:
//!
//! 1. **It claims the instance** (`runtime::instance`), so that nobody else runs it; removes what a killed run left;
//!    makes sure that the shared memory is large enough; and says what it finds missing on the machine (`preflight`).
//! 2. **It starts the processes** (`part`, `child`): first the [`keeper`], which creates every topic and keeps them in
//!    existence; then the monitor and the recorder, so that they miss nothing, with them fusion and the gateways; when
//!    these say that they run, the adapters, and the simulator last. All are children of the same executable.
//! 3. **It watches them** (`supervisor`): a child that ends with exit code 0 has finished. One that ends otherwise is
//!    noticed at once, its shared memory is taken back, and it is started again, after pauses that grow (`backoff`)
//!    while it keeps failing, for ever: the others do their work meanwhile. One that gives no sign of life has
//!    stopped, and is killed and replaced. Several that fall over one after the other have what they share against them
//!    (`suspicion`): then the deployment is torn down and rebuilt in new shared memory. Only what cannot be cured by
//!    starting again (a configuration that a child refuses, a fusion or a required source that never comes up) ends the
//!    deployment with an error.
//! 4. **It stops them**, sources first and the monitor last, because its final report tells of all the others; then the
//!    keeper; and clears the instance.
//!
//! **The launcher maps no shared memory**: bytes that others write cannot harm it. It knows of its children by the
//! kernel, and by what the keeper hears of them in the health topic and passes on over a socket (`link`). A child's
//! health message is made by its loop and published, where the loop must not make a system call, by its housekeeping
//! thread; so a new message is a sign of life of both. A child has stood still when the keeper has looked for
//! `launcher.watchdog_s` without finding a new one. Time in which the launcher or the keeper did not run themselves
//! does not count: on a machine that stalls, everybody stands still. Nor does a child stand still for long over shared
//! memory that another one had only begun when it was killed: the launcher removes such files ([`bus::Unborn`]).
//!
//! How often each child was restarted, why, and whether it runs is part of the launcher's own health messages, which
//! the keeper publishes, so every monitor and status display can show it. Standard error gets one line per event;
//! standard output belongs to the monitor; a service manager (systemd) is told when the deployment runs, how it is, and
//! that the launcher lives (`service_manager`).
//!
//! Limits: if the launcher itself is killed, the kernel tells the children to stop, and the deployment ends; the next
//! start removes what is left. Corruption that makes nobody fall over or stand still is not noticed here.

#![forbid(unsafe_code)]

mod backoff;
mod child;
mod durable;
mod end;
pub mod keeper;
mod link;
mod part;
mod preflight;
mod records;
mod service_manager;
mod supervisor;
mod suspicion;
mod wake;

use std::time::Duration;

use anyhow::Context as _;
use configuration::Config;
use runtime::instance::{self, Instance};
use runtime::signals::Stop;
use runtime::{Now, Options};

pub use supervisor::ChildRefused;

/// How a deployment is to be run.
#[derive(Clone, Debug)]
pub struct Orders {
    /// What every process is started with.
    pub options: Options,
    /// When to stop, counted from the start of the adapters; `None`: when told to, or when all work is done.
    pub run_for: Option<Duration>,
}

/// Runs the deployment until it is told to stop, its time is over, or all its recordings are worked off.
///
/// Must be called on the thread that lives longest: children follow the end of the thread that started them.
///
/// # Errors
/// If the instance already runs, the machine refuses something, a child that is needed cannot be kept running
/// ([`ChildRefused`] if it is its configuration), or one did not stop as it should.
pub fn run(config: &Config, orders: &Orders) -> anyhow::Result<()> {
    let stop = Stop::on_signals().context("catching signals")?;
    let wake = wake::Wake::on_signals().context("catching signals")?;
    let processes = part::parts(config).len();
    let instance = Instance::claim(config, &orders.options.instance, processes, &stop, say)?;
    let root = instance.root().clone();
    let result = preflight::check(config)
        .and_then(|()| match &config.durable {
            Some(durable) => durable::revive(&root, &durable.folder),
            None => Ok(()),
        })
        .and_then(|()| with_records(config, orders.clone()))
        .and_then(|orders| supervisor::Supervisor::new(config, &orders, &instance, stop, wake)?.run());
    let cleared = instance.clear();
    if let Some(durable) = &config.durable {
        root.remove_copies(&durable.folder);
    }
    result.and(cleared)
}

/// The orders, with a folder of this start's own in the place of the one that is asked for, if anything is written.
fn with_records(config: &Config, mut orders: Orders) -> anyhow::Result<Orders> {
    if config.recorder || config.monitor.files {
        let out = &mut orders.options.out;
        *out = records::begin(out, Now::read().utc_ns)?;
        say(&format!("this start writes to {}", out.display()));
    }
    Ok(orders)
}

/// Most bytes that a deployment takes in shared memory.
pub fn needed_bytes(config: &Config) -> u64 {
    instance::needed_bytes(config, part::parts(config).len())
}

/// One line about one event. Standard error may be closed; that is no reason to end a deployment.
fn say(line: &str) {
    runtime::notice(format_args!("koseki: {line}"));
}
