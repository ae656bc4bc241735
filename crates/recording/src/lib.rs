//! Recording of all topics of a deployment in MCAP files.
//!
//! MCAP is a container of messages with times, on channels with schemas, and is common in robotics. Samples are
//! stored as they are in shared memory: with four bytes in front they are ROS 2 messages
//! ([`Layout::ros2_schema`](messages::layout::Layout::ros2_schema)). One file therefore holds the exact bits for a
//! replay, and viewers and Python can open the same file.
//!
//! Each topic has two channels. `<topic>/slices` has the header of each slice. The slice's samples follow directly on
//! `<topic>`, up to the topic's next header. The *log time* of a message is the time at which the recorder took the
//! slice; its *publish time* is the time at which the publisher sent the slice; both are UTC. Sequence numbers of the
//! container have 32 bits; the sequence numbers of Koseki are in headers and samples.
//!
//! Messages are collected in memory into a *chunk*, which is written in one piece at the end of a slice. A killed
//! recorder loses its unwritten chunk and may leave a torn chunk. [`whole`] returns the length of the readable part
//! of a file, and the bytes of [`closing`] in place of the rest make a complete file. Chunks may be compressed
//! ([`Compression`]); a reader reads both kinds. Compare contents of files, not files.

#![forbid(unsafe_code)]

mod contents;
mod damage;
mod part;
mod reader;
mod record;
mod survey;
mod tally;
mod whole;
mod writer;

pub use contents::{Contents, bag};
pub use part::{Copied, RecordingPart, copy};
pub use reader::{Chunks, Item, UNENDED, facts, is_unended, read};
pub use survey::{Survey, TopicSurvey};
pub use tally::Tally;
pub use whole::{ReadablePart, closing, whole};
pub use writer::{Channel, Compression, Writer};

/// Name of the metadata with the origin of a file.
pub const FACTS: &str = "koseki";

/// Longest time between two records of a message that its publisher repeats unchanged, nanoseconds.
pub const REPEATED_NS: i64 = 5_000_000_000;

/// Facts at the beginning of a file, by name: configuration, build, and [progress of the topics](Tally).
pub type Facts = std::collections::BTreeMap<String, String>;

/// Failure to write or read a recording.
#[derive(Debug, thiserror::Error)]
pub enum RecordingError {
    /// Refusal of the system.
    #[error(transparent)]
    System(#[from] std::io::Error),
    /// Invalid contents.
    #[error(transparent)]
    Contents(mcap::McapError),
    /// Chunk with a compression that no recorder uses.
    #[error("has chunks with the compression {0}; those with zstd, and without compression, can be read")]
    UnknownCompression(String),
    /// File of another kind.
    #[error("is no recording of all topics: it does not begin as MCAP does")]
    OtherKind,
    /// Topic that the recording does not have.
    #[error("has no topic {wanted}; its topics: {}", known.join(", "))]
    UnknownTopic {
        /// The topic, or the beginning of topics.
        wanted: String,
        /// The topics there are.
        known: Vec<String>,
    },
    /// Damaged record or chunk.
    #[error("damaged at byte {at}: {reason}")]
    Damaged {
        /// Offset of the record, or of its chunk, in the file.
        at: u64,
        /// Kind of damage.
        reason: &'static str,
    },
}

impl RecordingError {
    fn damaged(at: u64, reason: &'static str) -> Self {
        Self::Damaged { at, reason }
    }
}

impl From<mcap::McapError> for RecordingError {
    fn from(error: mcap::McapError) -> Self {
        match error {
            mcap::McapError::Io(error) => Self::System(error),
            other => Self::Contents(other),
        }
    }
}

/// Name of the metadata of a channel with the layout of the samples.
const FINGERPRINT: &str = "fingerprint";

/// Returns the fingerprint of a layout as the metadata of a channel state it.
fn fingerprint_of(layout: &messages::layout::Layout) -> String {
    format!("{:016x}", layout.fingerprint())
}

/// Beginning of the names of schemas.
const SCHEMA_PREFIX: &str = "koseki/msg/";

/// Ending of the name of the channel with a topic's headers.
const SLICES: &str = "/slices";

/// Returns the name of the schema of a sample with this layout.
pub fn schema_name(layout: &messages::layout::Layout) -> String {
    format!("{SCHEMA_PREFIX}{}", layout.name)
}

/// Bytes before each sample: CDR, little-endian.
pub const CDR: [u8; 4] = [0, 1, 0, 0];
