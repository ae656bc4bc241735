//! What fusion publishes.

use crate::layout::sample;
use crate::{Covariance, Identity, StageTimes, TargetType};

/// How many contributions one system track can list; more are counted in `source_count` only.
pub const CONTRIBUTIONS_MAX: usize = 16;

/// Bits of [`Contribution::flags`].
pub mod contribution_bits {
    /// The source's latest report is within its expected period.
    pub const FRESH: u16 = 1;
    /// The accuracy value exists: the source has delivered more than one report.
    pub const SCORED: u16 = 1 << 1;

    pub(crate) const NAMES: &[(&str, u64)] = &[("FRESH", FRESH as u64), ("SCORED", SCORED as u64)];
}

sample! {
    /// One source's share of a system track.
    #[derive(Default)]
    Contribution, size 32 {
        /// Time of measurement of the source's latest report, UTC, nanoseconds.
        time_of_measurement_ns: i64,
        /// Number of the sensor track at its source.
        track_number: u32,
        /// Source number.
        source: u16,
        /// See `contribution_bits`.
        flags: u16,
        /// Coefficient eta in [0, 1]; the weights of one system track sum to 1.
        weight: f64,
        /// Accuracy value lambda (TI-9), smaller is better; NaN where the rule has none.
        accuracy: f64,
    }
}

sample! {
    /// One state of one system track: the fused picture of one target (TI-19).
    #[derive(Default)]
    SystemTrack, size 840 {
        /// Reference time of the state, UTC, nanoseconds since 1970.
        reference_time_ns: i64,
        /// Time of measurement of the report that caused this state, UTC, nanoseconds; of the reference time, if none did.
        time_of_measurement_ns: i64,
        /// The state's sequence number at its publisher.
        sequence: u64,
        /// Stages of the report that caused this state; all but `fused_ns` are 0 if none did.
        stages: StageTimes,
        /// System-track number, unique while fusion runs.
        track_number: u32,
        /// Source of the report that caused this state; 65535 if none did (coasting, ending).
        trigger_source: u16,
        /// Source with the largest weight; 65535 if none contributes.
        selected_source: u16,
        /// Who the target says it is.
        identity: Identity,
        /// Position east, north, up, metres.
        position_m: [f64; 3],
        /// Velocity east, north, up, metres per second.
        velocity_mps: [f64; 3],
        /// Covariance of position and velocity.
        covariance: Covariance,
        /// Contributing sources in the order of their numbers; `contribution_count` of them hold something.
        contributions: [Contribution; 16],
        /// How many sources contribute.
        source_count: u16,
        /// How many of `contributions` hold something.
        contribution_count: u16,
        /// State of the track: a `TrackState` code.
        state: u8,
        /// 1 if some source observes height; otherwise z says nothing.
        height_valid: u8,
        /// Fusion rule: its place in the registry of rules.
        rule: u8,
        /// What a contributing source wants noticed: see `alert_bits`.
        alerts: u8,
        /// Number of the system track into which this one was merged, where it ended by a merge; else 0.
        merged_into: u32,
        /// 1 if a contributing source says that the target is on the ground.
        on_ground: u8,
        /// What the track follows: a `TrackKind` code.
        kind: u8,
        /// Expected number of members of a group; 0 for a single target.
        members: u16,
        /// What type of target it is.
        target_type: TargetType,
    }
}

const _: () = assert!(size_of::<[Contribution; CONTRIBUTIONS_MAX]>() == 16 * size_of::<Contribution>());

impl SystemTrack {
    /// The contributions that hold something.
    pub fn contributions(&self) -> &[Contribution] {
        &self.contributions[..usize::from(self.contribution_count).min(CONTRIBUTIONS_MAX)]
    }
}
