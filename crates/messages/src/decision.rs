//! Decisions of fusion: the causes of the picture (BF-4).
//!
//! The state of a system track lists the contributing sources with weight and accuracy value. Each decision has a
//! record with the gate distance that admitted a sensor track, the cause of a removal, and the reason why a track
//! is shown or not.

use crate::codes;
use crate::health::NO_SOURCE;
use crate::layout::sample;

codes! {
    /// Kind of a decision of fusion.
    pub enum DecisionKind: u8 {
        /// A system track was started for a sensor track that fits none.
        Started = 1, "started";
        /// A sensor track joined a system track it fits: value d², limit the gate.
        Joined = 2, "joined";
        /// A sensor track joined the system track of its address.
        JoinedByAddress = 3, "joined_by_address";
        /// A sensor track was recognised as another part of a target that its source already follows: value metres.
        Duplicate = 4, "duplicate";
        /// A sensor track left because its address contradicts the system track's.
        IdentityConflict = 5, "identity_conflict";
        /// A sensor track left because it kept missing the others: value d², limit the gate.
        Split = 6, "split";
        /// A system track was found to be the same target as another, and merged into it: value d², limit the gate.
        Merged = 7, "merged";
        /// A system track was confirmed: value the number of sources, or the log-likelihood ratio of a single
        /// source's claim.
        Confirmed = 8, "confirmed";
        /// A system track is withheld: its sources report that they no longer detect the target. Value the sum of the
        /// misses.
        Withheld = 9, "withheld";
        /// Nothing fresh contributes any more.
        Coasted = 10, "coasted";
        /// A system track has ended.
        Ended = 11, "ended";
        /// The selected source has changed: value the new source's accuracy value, limit the previous source's.
        HandOver = 12, "hand_over";
        /// The target's reference point is now that of this source.
        ReferencePoint = 13, "reference_point";
        /// A sensor track has changed places with another track of its source: value the sum of log-likelihood
        /// ratios.
        Uncrossed = 14, "uncrossed";
        /// An order of an operator has changed a system track: value the number of the order.
        Ordered = 15, "ordered";
        /// An order on system tracks has ended, because the tracks are farther apart than permitted: value the
        /// distance in standard deviations.
        OrderEnded = 16, "order_ended";
        /// A system track that was shown is no longer reported: its number rests.
        Suspended = 17, "suspended";
        /// A target has come back under its former number: value the logarithm of the likelihood ratio of the same
        /// target to another one, limit the least; both NaN by its address, or by its track's number at a source. The
        /// other system track is the number that it had until then, 0 if none.
        Resumed = 18, "resumed";
    }
}

sample! {
    /// One decision of fusion.
    Decision, size 64 {
        /// Time of the data, UTC, nanoseconds since 1970.
        time_ns: i64,
        /// The sample's sequence number at its publisher.
        sequence: u64,
        /// Start of the process that decided, monotonic, nanoseconds: system tracks of the same `epoch` are meant.
        epoch: u64,
        /// Value that was compared; NaN if nothing was.
        value: f64 = f64::NAN,
        /// Limit that the value was compared with; NaN if there was none.
        limit: f64 = f64::NAN,
        /// System track of the decision; 0 if none.
        system_track: u32,
        /// The other system track, where there is one; else 0.
        other_system_track: u32,
        /// Sensor track of the decision, at its source; 0 if none.
        sensor_track: u32,
        /// Source of the decision: its number in the configuration; 65535 for none.
        source: u16 = NO_SOURCE,
        /// The other source, if any (at a hand-over the previous source); 65535 for none.
        other_source: u16 = NO_SOURCE,
        /// A `DecisionKind` code.
        kind: u8,
        /// Reserved, 0.
        reserved: [u8; 7],
    }
}

impl Decision {
    /// Returns the kind; `None` for a code of another schema.
    pub fn kind(&self) -> Option<DecisionKind> {
        DecisionKind::from_code(self.kind)
    }
}
