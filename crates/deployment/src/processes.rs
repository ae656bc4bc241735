//! Facts about the processes of a deployment.

use messages::FusionRule;

use crate::network::NetworkOutput;

settings::words! {
    /// Order in which fusion takes reports.
    pub enum ReportOrder {
        /// As they arrive: lowest latency.
        Arrival = "arrival",
        /// By time of measurement, merged with each source's progress: the result does not depend on scheduling.
        Time = "time",
    }
}

/// Facts about the system tracks that fusion publishes.
#[derive(Clone, Copy, Debug)]
pub struct SystemTracks {
    /// Most system tracks.
    pub max: usize,
    /// Whether a further track picture from local sources only is published.
    pub exchange: bool,
    /// Whether smoothed states are published.
    pub smooths: bool,
    /// Rule that weighs the sources.
    pub rule: FusionRule,
    /// Reports that wait per source in order `time`.
    pub queue: usize,
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
    pub gateways: Vec<NetworkOutput>,
    /// Whether there are alerts on targets.
    pub alerts: bool,
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
