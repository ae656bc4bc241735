//! Samples published by fusion.

use crate::codes::bits;
use crate::layout::sample;
use crate::{Covariance, Extent, Identity, Movement, StageTimes, TargetType, altitude_m};

/// Maximum number of listed contributions of a system track; `source_count` includes further contributions.
pub const CONTRIBUTIONS_MAX: usize = 16;

bits! {
    /// Bits of [`Contribution::flags`].
    contribution_bits: u16 {
        /// The source's latest report is within its expected period.
        FRESH = 1;
        /// The accuracy value exists: the source has delivered more than one report.
        SCORED = 1 << 1;
        /// It is a system track of another centre. Not fresh, it is listed for a while without weight.
        CENTRE = 1 << 2;
    }
}

bits! {
    /// Bits of [`ContributorSet::flags`].
    contributor_set_bits: u16 {
        /// More sensors have contributed than `sensor_uids` can hold: any sensor must be taken to be among them.
        OVERFLOW = 1;
    }
}

sample! {
    /// Share of one source in a system track.
    Contribution, size 40 {
        /// Time of measurement of the source's latest report, UTC, nanoseconds.
        time_of_measurement_ns: i64,
        /// Coefficient eta in [0, 1]; the weights of one system track sum to 1.
        weight: f64,
        /// Accuracy value lambda (TI-9), smaller is better; NaN where the rule has none.
        accuracy: f64,
        /// Number of the sensor track at its source.
        track_number: u32,
        /// Identity of the sensor, the same in every deployment that hears it; 0: unknown.
        sensor_uid: u32,
        /// Deployment that the sensor track comes from, where not the one at hand; 0: the one at hand.
        origin: u32,
        /// Source number.
        source: u16,
        /// Flags: see `contribution_bits`.
        flags: u16,
    }
}

sample! {
    /// State of one system track at one time: the fused picture of one target (TI-19).
    SystemTrack, size 1064 {
        /// Reference time of the state, UTC, nanoseconds since 1970.
        reference_time_ns: i64,
        /// Time of measurement of the report that caused this state, else the reference time; UTC, nanoseconds.
        time_of_measurement_ns: i64,
        /// The state's sequence number at its publisher.
        sequence: u64,
        /// Start-up number of the fusion that made it, rising with each start; 0: unknown.
        epoch: u64,
        /// Stages of the report that caused this state; all but `fused_ns` are 0 if none did.
        stages: StageTimes,
        /// System-track number: another target has none like it for a day, whatever restarts.
        track_number: u32,
        /// Deployment that made it: `origin` of its configuration; 0: not stated.
        origin: u32,
        /// Number of the track at the deployment that owns the target, where another does; else 0.
        owner_track_number: u32,
        /// Number of the system track into which this one was merged, where it ended by a merge; else 0.
        merged_into: u32,
        /// Source of the report that caused this state; 65535 if none did (coasting, ending).
        trigger_source: u16,
        /// Source with the largest weight; 65535 if none contributes.
        selected_source: u16,
        /// How many sources contribute.
        source_count: u16,
        /// How many of `contributions` hold something.
        contribution_count: u16,
        /// State of the track: a `TrackState` code.
        state: u8,
        /// 1 if some source observes height; otherwise z says nothing.
        height_valid: u8,
        /// Fusion rule: a `FusionRule` code; 0: unknown.
        rule: u8,
        /// Alerts of the contributing sources: see `alert_bits`.
        alerts: u8,
        /// 1 if a contributing source says that the target is on the ground.
        on_ground: u8,
        /// Kind of what the track follows: a `TrackKind` code.
        kind: u8,
        /// Expected number of members of a group; 0 for a single target.
        members: u16,
        /// Identity of the target, as far as its sources say.
        identity: Identity,
        /// Type of the target.
        target_type: TargetType,
        /// Position east, north, up, metres.
        position_m: [f64; 3],
        /// Velocity east, north, up, metres per second.
        velocity_mps: [f64; 3],
        /// Modes of movement and acceleration.
        movement: Movement,
        /// Size of the target.
        extent: Extent,
        /// Covariance of position and velocity.
        covariance: Covariance,
        /// Contributing sources in the order of their numbers; `contribution_count` of them hold something.
        contributions: [Contribution; 16],
        /// Normalised innovation squared (NIS) of the report that caused this state, in the plane; 0 if there was none.
        /// About 2 on average where covariances are honest, above 5.99 once in twenty.
        nis: f32,
        /// Newest level of the target's transponder, in steps of 25 feet at 1013.25 hPa; 0 if there is none.
        level: i16,
        /// 1 if `level` is known, and no older than two periods of the source that has it.
        level_valid: u8,
        /// Reserved, 0.
        reserved: u8,
        /// Age of `level` at the reference time, milliseconds.
        level_age_ms: u32,
        /// Reserved, 0.
        spare: u32,
    }
}

const _: () = assert!(size_of::<[Contribution; CONTRIBUTIONS_MAX]>() == 16 * size_of::<Contribution>());

/// Number of sensors that a [`ContributorSet`] can hold.
pub const CONTRIBUTORS_MAX: usize = 64;

sample! {
    /// Set of all sensors that have contributed to one system track since the start of the track. A deployment that
    /// receives the track fuses the track as independent only if the deployments share no sensor. No process
    /// publishes this set yet.
    ContributorSet, size 304 {
        /// Reference time of the state up to which the set is complete, UTC, nanoseconds since 1970.
        reference_time_ns: i64,
        /// Sequence number at its publisher.
        sequence: u64,
        /// Start-up number of the fusion that made the track, rising with each start; 0: unknown.
        epoch: u64,
        /// System-track number.
        track_number: u32,
        /// Deployment that made the track: `origin` of its configuration; 0: not stated.
        origin: u32,
        /// How many of `sensor_uids` hold something.
        count: u16,
        /// Flags: see `contributor_set_bits`.
        flags: u16,
        /// Reserved, 0.
        reserved: [u32; 3],
        /// Identities of the sensors, rising.
        sensor_uids: [u32; 64] = [0; CONTRIBUTORS_MAX],
    }
}

impl SystemTrack {
    /// Returns the contributions to the state.
    pub fn contributions(&self) -> &[Contribution] {
        let listed = self.listed();
        let last = listed.iter().rposition(|part| !part.is_of_silent_centre());
        &listed[..last.map_or(0, |last| last + 1)]
    }

    /// Returns the contributions to the state, followed by those of other centres that reported the target and have
    /// fallen silent.
    pub fn listed(&self) -> &[Contribution] {
        &self.contributions[..usize::from(self.contribution_count).min(CONTRIBUTIONS_MAX)]
    }

    /// Returns the pressure altitude of the transponder's newest level, metres; `None` without a sufficiently
    /// recent level.
    pub fn level_m(&self) -> Option<f64> {
        (self.level_valid != 0).then(|| altitude_m(self.level))
    }
}

impl Contribution {
    /// Whether the contribution is from another centre that has fallen silent: it has no part in the state.
    pub fn is_of_silent_centre(&self) -> bool {
        self.flags & (contribution_bits::CENTRE | contribution_bits::FRESH) == contribution_bits::CENTRE
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_silent_centre_is_listed_and_has_no_part_in_the_state() {
        let mut track = SystemTrack {
            contribution_count: 3,
            ..SystemTrack::default()
        };
        let (fresh, centre) = (contribution_bits::FRESH, contribution_bits::CENTRE);
        for (part, flags) in track.contributions.iter_mut().zip([0, centre | fresh, centre]) {
            part.flags = flags;
        }
        assert_eq!((track.contributions().len(), track.listed().len()), (2, 3));
        let silent = track.contributions[2];
        track.contributions[..2].fill(silent);
        assert_eq!((track.contributions().len(), track.listed().len()), (0, 3));
    }
}
