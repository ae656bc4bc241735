//! Process of a deployment: its arguments, and its connection to shared memory.

use std::net::Ipv4Addr;
use std::path::PathBuf;

use anyhow::Context as _;
use bus::{Bus, Root, SharedMemory};
use deployment::Deployment;
use messages::{Health, ProcessKind};

use crate::clock::mono_ns;
use crate::cores;
use crate::health::Reporter;
use crate::loopback::loopback_of;
use crate::signals::{self, Stop};

/// Speed of replay.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Speed {
    /// Seconds of the recording per second.
    Factor(f64),
    /// Maximum speed that the consumers permit.
    Max,
}

/// Arguments of the processes of a deployment, besides its configuration file.
#[derive(Clone, Debug)]
pub struct Options {
    /// Values that replace values of the file: `key.path=value`.
    pub overrides: Vec<String>,
    /// Instance name; several deployments run side by side under different names.
    pub instance: String,
    /// Folder with recordings.
    pub data: PathBuf,
    /// Folder for new recordings.
    pub out: PathBuf,
    /// Replay speed of recorded inputs.
    pub speed: Speed,
    /// Seed of the simulated world.
    pub seed: u64,
    /// Start of the simulated world, UTC, nanoseconds.
    pub scenario_start_ns: i64,
    /// Process number of the launcher, if a launcher started this process.
    pub launcher: Option<u32>,
}

/// Process of a deployment, connected and ready.
#[derive(Debug)]
pub struct Process {
    /// Deployment.
    pub config: Deployment,
    /// Arguments.
    pub options: Options,
    /// Kind.
    pub kind: ProcessKind,
    /// Name: of the source for an adapter, else of the kind.
    pub name: String,
    /// Connection to shared memory.
    pub bus: Bus<SharedMemory>,
    /// Monotonic start time, nanoseconds: distinguishes the process from an earlier process of the same name.
    pub incarnation: u64,
    /// Loopback address of the deployment.
    pub loopback: Ipv4Addr,
    pub(crate) stop: Stop,
}

impl Process {
    /// Connects a process to its deployment. From now on, the process ends with its launcher.
    ///
    /// # Errors
    /// If the deployment does not run, or the operating system refuses an operation.
    pub fn connect(config: Deployment, options: Options, kind: ProcessKind, name: &str) -> anyhow::Result<Self> {
        let stop = follow(options.launcher)?;
        // Fusion's core is for fusion alone.
        if kind != ProcessKind::Fusion
            && let Some(core) = config.fusion.core
        {
            cores::stay_away_from(core);
        }
        let bus = open(&options.instance, kind, name)?;
        Ok(Self {
            config,
            options,
            kind,
            name: name.to_owned(),
            incarnation: mono_ns() as u64,
            loopback: loopback_of(bus.root().path()),
            bus,
            stop,
        })
    }

    /// Creates an empty health message of this process.
    pub(crate) fn blank_health(&self) -> Health {
        let blank = Health {
            incarnation: self.incarnation,
            process_id: std::process::id(),
            kind: self.kind as u8,
            ..Health::default()
        };
        blank.with_name(&self.name)
    }

    /// Opens the publisher of health messages.
    pub(crate) fn reporter(&self) -> anyhow::Result<Reporter> {
        Reporter::new(&self.bus, self.incarnation, self.blank_health())
    }

    /// Returns midnight of the day from which files count seconds, UTC, nanoseconds.
    pub fn first_day_ns(&self) -> i64 {
        let live = || self.options.scenario_start_ns.div_euclid(frames::time::NS_PER_DAY) * frames::time::NS_PER_DAY;
        self.config.first_day_ns.unwrap_or_else(live)
    }
}

/// Catches stop requests. If `launcher` started this process, the launcher's end is a stop request.
fn follow(launcher: Option<u32>) -> anyhow::Result<Stop> {
    let stop = Stop::on_signals().context("catching signals")?;
    if let Some(launcher) = launcher
        && !signals::stop_with_parent(launcher).context("following the launcher")?
    {
        anyhow::bail!("the launcher (process {launcher}) is gone");
    }
    Ok(stop)
}

fn open(instance: &str, kind: ProcessKind, name: &str) -> anyhow::Result<Bus<SharedMemory>> {
    let root = Root::new(instance)?;
    let process = format!("{}-{name}", kind.word());
    // Fusion reads one publisher per topic, many times.
    Ok(match kind {
        ProcessKind::Fusion => Bus::open_for_few(&root, &process)?,
        _ => Bus::open(&root, &process)?,
    })
}
