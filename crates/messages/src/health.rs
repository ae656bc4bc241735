//! What every process says about itself, several times a second.

use crate::layout::sample;
use crate::{Counters, Registration};

/// [`Health::source`] of a message that speaks of the whole process.
pub const NO_SOURCE: u16 = u16::MAX;

/// A name in a [`Health`] message: UTF-8, padded with zeros.
pub type HealthName = [u8; 32];

sample! {
    /// State and counters of one process, or of one source within it.
    Health, size 888 {
        /// When this was said, monotonic, nanoseconds.
        said_ns: i64,
        /// Monotonic start time of the process, nanoseconds.
        incarnation: u64,
        /// How far the process has got in the time of its data, UTC, nanoseconds; i64::MIN if unknown.
        progress_ns: i64,
        /// Operating system's process number.
        process_id: u32,
        /// Source that the counters speak of; 65535 for the process as a whole.
        source: u16,
        /// What kind of process: a `ProcessKind` code.
        kind: u8,
        /// A `LifeState` code.
        life: u8,
        /// Restarts of the process so far, as its launcher counts them.
        restarts: u32,
        /// Reserved, 0.
        reserved: u32,
        /// Name of the process, UTF-8, padded with zeros.
        name: [u8; 32],
        /// What is wrong, in a few words; empty if nothing is. Of an adapter's source: its name. UTF-8, padded with zeros.
        note: [u8; 56],
        /// Values of the counters.
        counters: Counters,
        /// Systematic errors of the source, where fusion speaks of one.
        registration: Registration,
    }
}

impl Default for Health {
    fn default() -> Self {
        Self {
            said_ns: 0,
            incarnation: 0,
            progress_ns: i64::MIN,
            process_id: 0,
            source: NO_SOURCE,
            kind: 0,
            life: 0,
            restarts: 0,
            reserved: 0,
            name: [0; 32],
            note: [0; 56],
            counters: Counters::default(),
            registration: Registration::default(),
        }
    }
}

impl Health {
    /// The process's name.
    pub fn name(&self) -> &str {
        text(&self.name)
    }

    /// What is wrong, or an empty string; where an adapter speaks of one of its sources, the source's name.
    pub fn note(&self) -> &str {
        text(&self.note)
    }

    /// This message with another note, cut to what fits.
    #[must_use]
    pub fn with_note(mut self, note: &str) -> Self {
        fill(&mut self.note, note);
        self
    }

    /// This message with another name, cut to what fits.
    #[must_use]
    pub fn with_name(mut self, name: &str) -> Self {
        fill(&mut self.name, name);
        self
    }

    /// The process's kind; `None` for a code of another schema.
    pub fn kind(&self) -> Option<ProcessKind> {
        PROCESS_KINDS.get(usize::from(self.kind)).copied()
    }

    /// Where the process is in its life; `None` for a code of another schema.
    pub fn life(&self) -> Option<LifeState> {
        LifeState::ALL.get(usize::from(self.life)).copied()
    }
}

fn text(bytes: &[u8]) -> &str {
    let end = bytes.iter().position(|byte| *byte == 0).unwrap_or(bytes.len());
    std::str::from_utf8(&bytes[..end]).unwrap_or("?")
}

fn fill(bytes: &mut [u8], text: &str) {
    let mut end = text.len().min(bytes.len());
    while !text.is_char_boundary(end) {
        end -= 1;
    }
    bytes.fill(0);
    bytes[..end].copy_from_slice(&text.as_bytes()[..end]);
}

/// The kinds of processes a deployment is made of (PL-1).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u8)]
pub enum ProcessKind {
    /// Turns one sensor's data into sensor tracks.
    Adapter,
    /// Fuses sensor tracks into system tracks.
    Fusion,
    /// Records latencies and counters.
    Monitor,
    /// Writes tracks to files.
    Recorder,
    /// Starts and watches the others.
    Launcher,
    /// Sends what the simulated sensors observe over the network.
    Simulator,
    /// Sends tracks to other systems over the network.
    Gateway,
}

/// Every kind, in the order of its code.
pub const PROCESS_KINDS: [ProcessKind; 7] = [
    ProcessKind::Adapter,
    ProcessKind::Fusion,
    ProcessKind::Monitor,
    ProcessKind::Recorder,
    ProcessKind::Launcher,
    ProcessKind::Simulator,
    ProcessKind::Gateway,
];

impl ProcessKind {
    /// The word that the command line uses (FM-3).
    pub fn word(self) -> &'static str {
        match self {
            Self::Adapter => "adapter",
            Self::Fusion => "fusion",
            Self::Monitor => "monitor",
            Self::Recorder => "recorder",
            Self::Launcher => "launcher",
            Self::Simulator => "simulator",
            Self::Gateway => "gateway",
        }
    }
}

/// Where a process is in its life.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum LifeState {
    /// Opening its topics.
    Starting,
    /// Doing its work.
    Running,
    /// All its input has been worked off; it will exit by itself.
    Finished,
    /// Cannot go on; the note says why.
    Failed,
}

impl LifeState {
    /// Every state, in the order of its code.
    pub const ALL: [Self; 4] = [Self::Starting, Self::Running, Self::Finished, Self::Failed];

    /// The word that tables use.
    pub fn word(self) -> &'static str {
        match self {
            Self::Starting => "starting",
            Self::Running => "running",
            Self::Finished => "finished",
            Self::Failed => "failed",
        }
    }
}
