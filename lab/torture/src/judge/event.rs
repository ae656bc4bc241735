//! Input of the judge: events; a recorded event is a JSON object on a line.

use serde::{Deserialize, Serialize};

/// First line of a recorded input: the run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Conditions {
    pub(crate) seed: u64,
    /// Time without a report after which a track ends, seconds.
    pub(crate) terminate_s: f64,
    /// Time between two reports of a target by the slowest source, seconds.
    pub(crate) period_s: f64,
    /// Begin of the simulated world, monotonic and UTC, nanoseconds.
    pub(crate) begin_ns: [i64; 2],
}

/// An event, with the monotonic time of detection by the subscriber or the command, nanoseconds.
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
    /// A whole second of the world; comes before that second.
    Second(Second),
    /// Time has passed, whether anything came or not.
    Passed,
    /// The subscriber has announced that so many samples are lost.
    Lost { samples: u64 },
    /// The subscriber has left, with the subscriber's counts; `whole` if the memory was sound to the end.
    Left { lost: u64, lost_at_end: u64, whole: bool },
    /// The deployment has replaced the shared memory.
    Rebuilt,
    /// A fault is about to be caused.
    FaultBegins {
        fault: String,
        act: String,
        /// Parts that the fault takes away.
        takes: Vec<Part>,
    },
    /// The cause of the fault is over.
    FaultEnds,
    /// Every process runs, and states come again.
    Back,
    /// So much is missing, long after the fault.
    NotBack { missing: String },
    /// The command had to start the deployment again, for lack of self-healing.
    Helped,
    /// The deployment was stopped.
    Stopped { left_behind: Vec<String> },
}

/// Inherent effects of a fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Part {
    /// The fusion that leads ends, or stands still.
    Fusion,
    /// The adapter of a sensor ends or stands still; the sensor goes on.
    Adapter,
    /// All sensors end or stand still, and begin anew.
    Sensors,
    /// The deployment begins anew, with other shared memory.
    Memory,
    /// The numbers of all targets: no source of the numbers is left for a fusion.
    Numbers,
}

/// Part of a system track that the judge looks at.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct State {
    /// Time of sending as stated by fusion; monotonic, nanoseconds.
    pub(crate) sent_ns: i64,
    /// Start of the publisher, and the sample's number there.
    pub(crate) incarnation: u64,
    pub(crate) sequence: u64,
    pub(crate) epoch: u64,
    /// Whether the epoch goes on with the tracks of the epoch before.
    pub(crate) continues: bool,
    pub(crate) number: u32,
    pub(crate) life: Life,
    /// Number of the track into which this track was merged; 0: none.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub(crate) merged_into: u32,
    /// Whether a report led to this state.
    pub(crate) of_report: bool,
    /// Whether that is the report of a locator: of targets nearer to each other than the locator's errors, the report
    /// may follow a different target than in the run without faults.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub(crate) of_locator: bool,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) address: Option<u32>,
    /// Reference time, UTC, nanoseconds.
    pub(crate) time_ns: i64,
    /// East, north, up, metres; `None` if any value of the state is not finite.
    pub(crate) position_m: Option<[f64; 3]>,
    /// East, north, up, metres per second; `None` if unknown.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) velocity_mps: Option<[f64; 3]>,
    /// Whether the third axis of both is known.
    pub(crate) has_height: bool,
    /// Sources that contribute, for the reader of a finding: the judge does not use the sources.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) sources: Vec<u16>,
}

/// The simulated world at a whole second, and a run without faults for comparison.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Second {
    /// Number of the second, from the begin of the world.
    pub(crate) second: u32,
    /// All targets, seen by a sensor or not.
    pub(crate) targets: Vec<Target>,
    /// Places of the other tracks of the run without faults: second tracks of targets, and false targets of sensors.
    /// East, north, metres.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) strangers_m: Vec<[f64; 2]>,
}

/// A target at a whole second.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Target {
    pub(crate) address: u32,
    /// East, north, up, metres.
    pub(crate) position_m: [f64; 3],
    pub(crate) velocity_mps: [f64; 3],
    /// The target in a run without faults; `None`: not shown.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) undisturbed: Option<Undisturbed>,
}

/// A target in a run without faults at a whole second: the freshest track.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Undisturbed {
    /// States in the second that ends.
    pub(crate) states: u32,
    /// Whether the newest state states the address, the height and the velocity.
    pub(crate) has_address: bool,
    pub(crate) has_height: bool,
    pub(crate) has_velocity: bool,
    /// Age of the newest state, seconds.
    pub(crate) age_s: f64,
    /// Errors of the newest state, moved along the state's velocity: position in the plane, height, velocity in the
    /// plane.
    pub(crate) errors: [f64; 3],
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
