//! Facts about the processes of a deployment.

use std::net::SocketAddr;
use std::path::PathBuf;
use std::time::Duration;

use bus::WaitMode;
use messages::FusionRule;
use runtime::cores::Placement;
use telemetry::Deadlines;

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

/// The monitor process.
#[derive(Clone, Debug, PartialEq)]
pub struct Monitor {
    /// Time between two tables, nanoseconds.
    pub interval_ns: i64,
    /// Whether the monitor writes its files (histogram log, percentiles, JSON).
    pub files: bool,
    /// How it waits for system tracks.
    pub wait: MonitorWait,
    /// How long each stage may take; fusion's own stage always has a deadline.
    pub deadlines: Deadlines,
    /// Where it serves metrics for Prometheus, if it does.
    pub metrics: Option<SocketAddr>,
    /// Names by which they may be asked for, besides the machine's own for itself, in small letters.
    pub metrics_hosts: Vec<String>,
    /// Limits beyond which alarms are raised.
    pub alarms: alarms::Limits,
}

/// The display process.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Display {
    /// Where it is.
    pub listen: SocketAddr,
    /// How many ports after that one are tried where it is taken.
    pub more_ports: u32,
    /// Names by which it may be asked for, besides the machine's own for itself, in small letters.
    pub hosts: Vec<String>,
    /// Token that every browser has to show.
    pub token: Option<String>,
    /// Token of the operators, who give orders; `None`: no orders.
    pub operator_token: Option<String>,
    /// Time for which the past is kept, seconds.
    pub history_s: i64,
    /// Most memory that it takes, octets.
    pub history_octets: usize,
    /// Files that are drawn under the tracks, relative to the data folder unless absolute.
    pub overlays: Vec<PathBuf>,
}

/// How the monitor waits for system tracks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MonitorWait {
    /// Woken for each slice: exact, at the price of a system call of fusion's per slice.
    Event,
    /// Looks now and then, which costs fusion nothing: what comes after fusion is not measured.
    Poll {
        /// Time between two looks.
        pause: Duration,
    },
}

/// Forms of a recording.
#[derive(Clone, Copy, Debug)]
pub struct Recording {
    /// Whether rows of text are written.
    pub csv: bool,
    /// Containers of all topics, if they are written.
    pub mcap: Option<Segments>,
    /// Captures of what live sources send, if adapters write them.
    pub captures: Option<Segments>,
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
