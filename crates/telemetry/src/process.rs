//! Processes as whoever listens to their health messages knows them.

use std::fmt;

use messages::{LifeState, ProcessKind};
use serde::{Serialize, Serializer};

/// One process.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Process {
    /// Kind of the process.
    #[serde(serialize_with = "as_word")]
    pub kind: ProcessKind,
    /// Name of the process.
    pub name: String,
    /// How it is.
    pub state: State,
    /// How often it was started again.
    pub restarts: u32,
    /// How it last ended, where it should not have.
    pub last_end: String,
    /// Note of the process, or of the launcher about it.
    pub note: String,
    /// Number in the operating system, while it has one.
    pub pid: Option<u32>,
}

impl Process {
    /// Name in text.
    pub fn title(&self) -> String {
        process_title(self.kind, &self.name)
    }
}

/// Name of a process in text.
pub fn process_title(kind: ProcessKind, name: &str) -> String {
    if name == kind.word() {
        name.to_owned()
    } else {
        format!("{} {name}", kind.word())
    }
}

/// How a process is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum State {
    /// Nothing was ever said.
    NotHeard,
    /// Nothing was said for a while, though the process has not ended.
    Silent {
        /// For how long, nanoseconds.
        for_ns: i64,
    },
    /// As it says itself, or its launcher of it.
    Life(LifeState),
}

impl State {
    /// Whether a person should look at it.
    pub fn is_troubled(self) -> bool {
        match self {
            Self::NotHeard | Self::Silent { .. } => true,
            Self::Life(life) => life == LifeState::Failed,
        }
    }
}

impl fmt::Display for State {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotHeard => f.write_str("not heard from"),
            Self::Silent { for_ns } => write!(f, "silent for {:.1} s", *for_ns as f64 / 1e9),
            Self::Life(life) => f.write_str(life.word()),
        }
    }
}

impl Serialize for State {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

fn as_word<S: Serializer>(kind: &ProcessKind, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(kind.word())
}
