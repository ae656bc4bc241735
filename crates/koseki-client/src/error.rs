//! Errors, each with a kind for the program and a text with the remedy.

use std::fmt;
use std::io;
use std::path::PathBuf;

use bus::BusError;
use messages::admission::Fault;
use thiserror::Error;

/// An operation on a deployment failed. `{:?}` shows the same sentence as `{}`, since it is what a `main` prints that
/// returns an error.
#[derive(Error)]
#[non_exhaustive]
pub enum Error {
    /// The deployment has ended, or another run has taken its place.
    #[error("instance {instance} has ended, or was restarted: close its ports, and open them again")]
    Ended {
        /// The instance.
        instance: String,
    },

    /// A slice came from a publisher that was built with another layout of its samples.
    #[error(
        "topic {topic}: a publisher uses another layout of its samples (schema): build this program and the deployment \
         from the same version"
    )]
    Schema {
        /// The topic.
        topic: String,
    },

    /// No topic has such a name.
    #[error(
        "\"{name}\" is no topic: the system's are system/tracks, system/smoothed, system/alarms, system/alerts, system/decisions and system/order-states, a source's \
         sensor/NAME/tracks, …/detections, …/bearings and …/cues; also platform/NAME/state, wide-area/NAME/reports \
         and health"
    )]
    TopicName {
        /// The name as given.
        name: String,
    },

    /// The topic does not accept samples of user programs.
    #[error(
        "topic {topic} is not fed from outside: sensor/NAME/tracks, sensor/NAME/detections, wide-area/NAME/reports and \
         platform/NAME/state are"
    )]
    NotFed {
        /// The topic.
        topic: String,
    },

    /// Another process publishes on the topic.
    #[error(
        "topic {topic} has a publisher already, {by}: a source has one; end that process, or feed another external source"
    )]
    Fed {
        /// The topic.
        topic: String,
        /// Process that publishes.
        by: String,
    },

    /// The right to publish could not be claimed.
    #[error("cannot lock {}: {source}", path.display())]
    Claim {
        /// File of the lock.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },

    /// A sample has a fault; none of the samples was published.
    #[error("sample {index} is refused, and none was published: {fault}")]
    Refused {
        /// Place of the sample, from 0.
        index: usize,
        /// Field, value, limit and remedy.
        fault: Box<Fault>,
    },

    /// An observation cannot become a sample; none was published.
    #[error("observation {index} is refused, and none was published: {fault}")]
    Observation {
        /// Place of the observation, from 0.
        index: usize,
        /// Field, value, limit and remedy.
        fault: Box<Fault>,
    },

    /// The topic takes observations of another kind.
    #[error("the source takes {takes}, not {given}: send those, or feed another external source")]
    OtherKind {
        /// What the topic takes.
        takes: &'static str,
        /// What was given.
        given: &'static str,
    },

    /// A limit of the clock is none.
    #[error("the limit of the clock is {limit_s} s: it must be above 0; infinity permits all times")]
    ClockLimit {
        /// As given, seconds.
        limit_s: f64,
    },

    /// The origin of the system frame is not published.
    #[error(
        "instance {instance} does not publish the origin of its frame: `koseki status --instance {instance}` shows \
         whether its monitor runs"
    )]
    NoOrigin {
        /// The instance.
        instance: String,
    },

    /// Words are no order.
    #[error("{text}")]
    Order {
        /// The wrong word and the remedy.
        text: String,
    },

    /// Bytes are no whole number of samples.
    #[error("topic {topic}: {octets} octets are no whole number of samples of {size}")]
    Octets {
        /// The topic.
        topic: String,
        /// How many there are.
        octets: usize,
        /// Bytes of a sample.
        size: usize,
    },

    /// Shared memory has refused.
    #[error(transparent)]
    Bus(#[from] BusError),
}

impl fmt::Debug for Error {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, formatter)
    }
}

/// Kind of an error, by the program's possible reaction. The numbers are those of the C interface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(i32)]
pub enum ErrorKind {
    /// No such deployment runs: start it, or wait for it.
    NotRunning = 1,
    /// The deployment has ended or was replaced: open anew.
    Ended = 2,
    /// The other side was built from another version.
    Schema = 3,
    /// The deployment has no such topic.
    NoSuchTopic = 4,
    /// The topic has no place left.
    Full = 5,
    /// As many slices are kept as may be: give one back.
    Borrowed = 6,
    /// An argument makes no sense.
    Argument = 7,
    /// The system has refused something.
    System = 8,
    /// Another process publishes on the topic: end it. 9 is the outcome of a wait in C.
    Fed = 10,
}

impl Error {
    /// Kind of the error.
    pub fn kind(&self) -> ErrorKind {
        match self {
            Self::Ended { .. } => ErrorKind::Ended,
            Self::Schema { .. } | Self::Bus(BusError::Incompatible { .. }) => ErrorKind::Schema,
            Self::TopicName { .. }
            | Self::NotFed { .. }
            | Self::Refused { .. }
            | Self::Observation { .. }
            | Self::OtherKind { .. }
            | Self::ClockLimit { .. }
            | Self::Order { .. }
            | Self::Octets { .. } => ErrorKind::Argument,
            Self::Bus(BusError::InstanceName { .. } | BusError::PathTooLong { .. } | BusError::Queue { .. }) => {
                ErrorKind::Argument
            }
            Self::Bus(BusError::NotRunning { .. }) => ErrorKind::NotRunning,
            Self::Bus(BusError::NoSuchTopic { .. }) => ErrorKind::NoSuchTopic,
            Self::Bus(BusError::Full { .. }) => ErrorKind::Full,
            Self::Bus(BusError::Borrowed { .. }) => ErrorKind::Borrowed,
            Self::Fed { .. } => ErrorKind::Fed,
            Self::Claim { .. } | Self::NoOrigin { .. } | Self::Bus(_) => ErrorKind::System,
        }
    }
}
