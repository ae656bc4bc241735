//! Input of the judge: events; a recorded event is a JSON object on a line.

use serde::{Deserialize, Serialize};

use super::limits::Limits;

/// First line of a recorded input: the run, and the limits by which it is judged.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Conditions {
    pub(crate) seed: u64,
    /// Whether a second fusion stands by.
    pub(crate) standby: bool,
    /// Time without a report after which a track ends, seconds.
    pub(crate) terminate_s: f64,
    pub(crate) limits: Limits,
}

/// An event, with the monotonic time at which the subscriber or the command knew of it, nanoseconds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Event {
    pub(crate) at_ns: i64,
    #[serde(flatten)]
    pub(crate) what: What,
}

/// Kinds of events.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "event", rename_all = "kebab-case")]
pub(crate) enum What {
    /// A subscriber has joined the deployment.
    Joined,
    /// A system track has come.
    State(State),
    /// Time has passed, whether anything came or not.
    Passed,
    /// The subscriber has announced that so many samples are lost.
    Lost { samples: u64 },
    /// The subscriber has left, with its own counts; `whole` if its memory was sound to the end.
    Left { lost: u64, lost_at_end: u64, whole: bool },
    /// The deployment has replaced its shared memory.
    Rebuilt,
    /// A fault is about to be caused.
    FaultBegins {
        fault: String,
        act: String,
        /// Whether every target must keep its number.
        keeps_numbers: bool,
        /// Whether the whole deployment has to start again.
        rebuilds: bool,
    },
    /// The fault is caused. `held`: until now the cause itself kept the picture from going on.
    FaultEnds { held: bool },
    /// Every process runs, and states come again.
    Back,
    /// So much is missing, long after the fault.
    NotBack { missing: String },
    /// The command had to start the deployment again, since it did not heal by itself.
    Helped,
    /// The deployment was stopped.
    Stopped { left_behind: Vec<String> },
}

/// Part of a system track that the judge looks at.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct State {
    /// Time of sending as stated by fusion; monotonic, nanoseconds.
    pub(crate) sent_ns: i64,
    /// Start of its publisher, and the sample's number there.
    pub(crate) incarnation: u64,
    pub(crate) sequence: u64,
    pub(crate) epoch: u64,
    pub(crate) number: u32,
    pub(crate) life: Life,
    /// Number of the track into which this one was merged; 0: none.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub(crate) merged_into: u32,
    /// Whether a report led to it.
    pub(crate) of_report: bool,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) address: Option<u32>,
    /// East and north, metres; `None` if any value of the state is not finite.
    pub(crate) position_m: Option<[f64; 2]>,
    /// Place of the target of this address at the state's reference time; `None` where no truth is known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) truth_m: Option<[f64; 2]>,
}

/// State of a track.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Life {
    Tentative,
    Confirmed,
    Coasted,
    Suspended,
    Terminated,
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde hands out references")]
fn is_zero(number: &u32) -> bool {
    *number == 0
}
