//! State of processes for readers of their health messages.

use std::fmt;

use messages::{LifeState, ProcessKind};
use serde::{Serialize, Serializer};

/// One process.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct ObservedProcess {
    /// Kind; `None` for a child of the launcher without any health message.
    #[serde(serialize_with = "as_word")]
    pub kind: Option<ProcessKind>,
    /// Name.
    pub name: String,
    /// State.
    pub state: ProcessState,
    /// Number of restarts.
    pub restarts: u32,
    /// Last unexpected end.
    pub last_end: String,
    /// Note of the process, or of the launcher about it.
    pub note: String,
    /// Process number, while there is a process.
    pub pid: Option<u32>,
}

impl ObservedProcess {
    /// Returns the name as text.
    pub fn title(&self) -> String {
        match self.kind {
            Some(kind) => process_title(kind, &self.name),
            None => self.name.clone(),
        }
    }

    /// Returns last unexpected end and note as one text; empty without either.
    pub fn remark(&self) -> String {
        remark(&self.last_end, &self.note)
    }
}

/// Returns the name of a process as text.
pub fn process_title(kind: ProcessKind, name: &str) -> String {
    if name == kind.word() {
        name.to_owned()
    } else {
        format!("{} {name}", kind.word())
    }
}

/// Returns the last unexpected end of a process and its note as one text; empty without either.
pub fn remark(last_end: &str, note: &str) -> String {
    match (last_end, note) {
        ("", note) => note.to_owned(),
        (end, "") => format!("the last one {end}"),
        (end, note) => format!("the last one {end}; {note}"),
    }
}

/// State of a process.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ProcessState {
    /// Without any health message.
    NotHeard,
    /// Without recent health messages, though the process has not ended.
    Silent {
        /// Time of silence, nanoseconds.
        for_ns: i64,
    },
    /// State of life by its own message, or by the launcher's facts.
    Life(LifeState),
}

impl ProcessState {
    /// Whether the state needs attention.
    pub fn is_troubled(self) -> bool {
        match self {
            Self::NotHeard | Self::Silent { .. } => true,
            Self::Life(life) => life == LifeState::Failed,
        }
    }
}

impl fmt::Display for ProcessState {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotHeard => f.write_str("not heard from"),
            Self::Silent { for_ns } => write!(f, "silent for {:.1} s", *for_ns as f64 / messages::NS_PER_S),
            Self::Life(life) => f.write_str(life.word()),
        }
    }
}

impl Serialize for ProcessState {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

fn as_word<S: Serializer>(kind: &Option<ProcessKind>, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(kind.map_or("", ProcessKind::word))
}
