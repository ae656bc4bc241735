//! Facts about the processes of a deployment.

use std::path::PathBuf;
use std::time::Duration;

use bus::WaitMode;
use messages::FusionRule;
use runtime::cores::Placement;

use crate::network::Output;

settings::words! {
    /// Order in which fusion takes reports.
    pub enum ReportOrder {
        /// As they arrive: lowest latency.
        Arrival = "arrival",
        /// By time of measurement, merged with each source's progress: the result does not depend on scheduling.
        Time = "time",
    }
}

/// The fusion process.
#[derive(Clone, Debug)]
pub struct Fusion {
    /// How it waits for work.
    pub wait: WaitMode,
    /// Demands on the machine: core, priority, memory.
    pub placement: Placement,
    /// Whether a refusal of that is an error.
    pub required: bool,
    /// Whether a thread that spins with `SCHED_FIFO` pauses often enough that the kernel does not make it.
    pub rests: bool,
    /// Memory that outlasts the process; `None` if there is none.
    pub checkpoint: Option<Checkpoint>,
    /// The process that stands by; `None` if none does.
    pub standby: Option<Standby>,
    /// Whether decisions are published.
    pub decisions: bool,
    /// Reports that wait per source in order `time`.
    pub queue: usize,
    /// Most system tracks.
    pub system_tracks_max: usize,
    /// Whether a further track picture from local sources only is published.
    pub exchange: bool,
    /// Rule that weighs the sources.
    pub rule: FusionRule,
    /// A report that takes longer through fusion has missed its deadline, nanoseconds.
    pub deadline_ns: i64,
}

/// Copies on disk of what outlasts the processes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Durable {
    /// Folder for them.
    pub folder: PathBuf,
    /// Time between two copies.
    pub every: Duration,
}

/// Memory of fusion for its successor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Checkpoint {
    /// Age beyond which its tracks are not gone on with, nanoseconds.
    pub max_age_ns: i64,
}

/// A fusion that stands by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Standby {
    /// Core to run on.
    pub core: Option<usize>,
    /// Time for which the other one may stand still, nanoseconds.
    pub takeover_ns: i64,
}

/// Containers or captures, one after another.
#[derive(Clone, Copy, Debug)]
pub struct Segments {
    /// Time after which they are written to, nanoseconds.
    pub flush_ns: i64,
    /// Size at which another is begun.
    pub bytes: u64,
    /// Time after which another is begun, nanoseconds.
    pub length_ns: i64,
    /// Size of all beyond which the oldest are deleted; `None` keeps all.
    pub keep_bytes: Option<u64>,
}

/// Text of the configuration that recordings must not contain.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Secret {
    /// The text.
    pub text: String,
    /// Text that replaces it.
    pub placeholder: String,
}

/// Facts about services, which the services add ([`Parts`](crate::Parts)).
#[derive(Clone, Debug, Default)]
pub struct Services {
    /// Outputs to the network; each is a gateway process.
    pub gateways: Vec<Output>,
    /// Whether there is a display.
    pub display: bool,
    /// Whether a recorder runs.
    pub recorder: bool,
    /// Captures of what live sources send, if adapters write them.
    pub captures: Option<Segments>,
    /// Whether the monitor writes files.
    pub monitor_files: bool,
    /// Texts of the configuration that recordings must not contain.
    pub secrets: Vec<Secret>,
}
