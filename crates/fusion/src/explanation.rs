//! What fusion decided, and why (BF-4).
//!
//! The state of a system track says which sources contribute with which weight and accuracy value. What it does not say
//! is how it came about: which gate distance let a sensor track in, what made it leave, why a track is shown. Each such
//! decision is handed out as one record, to whoever wants it; where nobody does, nothing is made of it.

use messages::SystemTrack;

/// Takes what the engine hands out. Every closure that takes a system track is one, and leaves decisions alone.
pub trait Sink {
    /// A system track has a new state.
    fn track(&mut self, track: &SystemTrack);

    /// Something was decided.
    fn decision(&mut self, decision: &Decision) {
        let _ = decision;
    }
}

impl<F: FnMut(&SystemTrack)> Sink for F {
    fn track(&mut self, track: &SystemTrack) {
        self(track);
    }
}

/// Kind of a decision.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum DecisionKind {
    /// A system track was started for a sensor track that fits none.
    Started,
    /// A sensor track joined a system track it fits: value d², limit the gate.
    Joined,
    /// A sensor track joined the system track of its address.
    JoinedByAddress,
    /// A sensor track was recognised as another part of a target that its source already follows: value metres.
    Duplicate,
    /// A sensor track left because its address contradicts the system track's.
    IdentityConflict,
    /// A sensor track left because it kept missing the others: value d², limit the gate.
    Split,
    /// A system track was found to be the same target as another, and merged into it: value d², limit the gate.
    Merged,
    /// A system track was confirmed: value the number of sources, or what a single source's claim is worth.
    Confirmed,
    /// A system track is no longer shown: its sources say that they do not see it. Value the sum of the misses.
    Withheld,
    /// Nothing fresh contributes any more.
    Coasted,
    /// A system track has ended.
    Ended,
    /// The selected source has changed: value the new one's accuracy value, limit the old one's.
    HandOver,
    /// The target's reference point is now that of this source.
    ReferencePoint,
}

impl DecisionKind {
    /// The word that tables use.
    pub fn word(self) -> &'static str {
        match self {
            Self::Started => "started",
            Self::Joined => "joined",
            Self::JoinedByAddress => "joined_by_address",
            Self::Duplicate => "duplicate",
            Self::IdentityConflict => "identity_conflict",
            Self::Split => "split",
            Self::Merged => "merged",
            Self::Confirmed => "confirmed",
            Self::Withheld => "withheld",
            Self::Coasted => "coasted",
            Self::Ended => "ended",
            Self::HandOver => "hand_over",
            Self::ReferencePoint => "reference_point",
        }
    }
}

/// One decision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Decision {
    /// Time of the data, UTC, nanoseconds.
    pub time_ns: i64,
    /// Kind of a decision.
    pub kind: DecisionKind,
    /// System track it is about.
    pub system_track: u32,
    /// The other system track, where there is one; else 0.
    pub other_system_track: u32,
    /// Source it is about; [`messages::NO_SOURCE`] if none.
    pub source: u16,
    /// The other source, where there is one (the one handed over from).
    pub other_source: u16,
    /// Sensor track it is about, at its source; 0 if none.
    pub sensor_track: u32,
    /// Value that was compared; NaN if nothing was.
    pub value: f64,
    /// Limit that the value was compared with; NaN if nothing was.
    pub limit: f64,
}
