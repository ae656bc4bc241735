//! Everything that a deployment has said, in files of MCAP.
//!
//! MCAP is a container of messages with times, on channels with schemas, that the tools of robotics read. Koseki's
//! samples go into it as they lie in shared memory: with four octets in front they are messages of ROS 2
//! ([`Layout::ros2_schema`](messages::layout::Layout::ros2_schema)). So one file holds the exact bits, for whoever
//! wants to have the same picture again, and is open to viewers and to Python.
//!
//! Each topic has two channels. `<topic>/slices` has the header of each slice, and directly after it in the file come
//! the slice's samples on `<topic>`, up to the next header of the topic. Messages are *logged* when the recorder took
//! them and *published* when their publisher sent them, both UTC. Sequence numbers in the container have 32 bits; those
//! that count are in header and samples.
//!
//! Messages are gathered in memory into a *chunk*, which is written in one piece at the end of a slice. A recorder that
//! is killed loses the chunk that was not written, and may leave a torn one: [`whole`] says up to where a file can be
//! read, and with [`closing`] in the place of the rest it is a file that ends as it should. Container bytes depend on
//! the version of the library: compare what files hold, not files.

#![forbid(unsafe_code)]

mod part;
mod reader;
mod record;
mod survey;
mod tally;
mod whole;
mod writer;

pub use part::{Part, copy};
pub use reader::{Chunks, Item, facts, read};
pub use survey::{Survey, TopicSurvey};
pub use tally::Tally;
pub use whole::{Whole, closing, whole};
pub use writer::{Channel, Writer};

/// Name of the metadata that say where a file comes from.
pub const FACTS: &str = "koseki";

/// What is known at a file's beginning, by name: configuration, build, and [how far its topics were](Tally).
pub type Facts = std::collections::BTreeMap<String, String>;

/// Failure to write or read a recording.
#[derive(Debug, thiserror::Error)]
pub enum RecordingError {
    /// Refusal of the system.
    #[error(transparent)]
    System(#[from] std::io::Error),
    /// Contents that are not as they should be.
    #[error(transparent)]
    Contents(mcap::McapError),
    /// Record or chunk that is damaged.
    #[error("damaged at byte {at}: {reason}")]
    Damaged {
        /// Place of the record, or of its chunk, in the file.
        at: u64,
        /// Finding.
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

/// Name of the metadata of a channel that say which layout its samples have.
const FINGERPRINT: &str = "fingerprint";

/// Returns the fingerprint of a layout as the metadata of a channel state it.
fn fingerprint_of(layout: &messages::layout::Layout) -> String {
    format!("{:016x}", layout.fingerprint())
}

/// Beginning of the names of schemas.
const SCHEMA_PREFIX: &str = "koseki/msg/";

/// Ending of the name of the channel that has a topic's headers.
const SLICES: &str = "/slices";

/// Octets before each sample: CDR, little-endian.
const CDR: [u8; 4] = [0, 1, 0, 0];
