//! Samples published by fusion.

use crate::codes;
use crate::codes::bits;
use crate::layout::sample;
use crate::{Covariance, Extent, Identity, IdentityAges, Movement, StageTimes, TargetType, altitude_m};

/// Maximum number of listed contributions of a system track; `source_count` includes further contributions.
pub const CONTRIBUTIONS_MAX: usize = 16;

bits! {
    /// Bits of [`Contribution::flags`].
    contribution_bits: u16 {
        /// The source's latest report is within its expected period.
        FRESH = 1;
        /// The accuracy value exists: the source has delivered more than one report.
        SCORED = 1 << 1;
        /// The contribution is a system track of another centre. If not fresh, it is listed for a while without
        /// weight.
        CENTRE = 1 << 2;
    }
}

codes! {
    /// Motion models of the system filter, in the order of [`SystemTrack::mode_probabilities`]: five models of the
    /// plane, then three models of the vertical.
    pub enum MotionMode: u8 {
        /// Constant velocity in the plane.
        Steady = 0, "steady";
        /// Nearly constant velocity in the plane with strong process noise.
        Agile = 1, "agile";
        /// Coordinated turn to the left.
        LeftTurn = 2, "left_turn";
        /// Coordinated turn to the right.
        RightTurn = 3, "right_turn";
        /// Change of speed along the course.
        SpeedChange = 4, "speed_change";
        /// Constant height.
        Level = 5, "level";
        /// Constant climb rate.
        Climb = 6, "climb";
        /// Change of the climb rate.
        ClimbChange = 7, "climb_change";
    }
}

sample! {
    /// Share of one source in a system track.
    Contribution, size 64 {
        /// Time of measurement of the source's latest report, UTC, nanoseconds.
        time_of_measurement_ns: i64,
        /// Coefficient eta in [0, 1]; the weights of one system track sum to 1.
        weight: f64,
        /// Accuracy value lambda (TI-9), smaller is better; NaN where the rule has none.
        accuracy: f64,
        /// Number of the sensor track at its source.
        track_number: u32,
        /// Identity of the sensor, the same in every deployment; 0: unknown.
        sensor_uid: u32,
        /// Original deployment of the sensor track, if another; 0: this deployment.
        origin: u32,
        /// Source number.
        source: u16,
        /// Flags: see `contribution_bits`.
        flags: u16,
        /// Coefficient eta by axis, east, north, up; their mean is `weight`.
        axis_weights: [f32; 3],
        /// Accuracy value lambda by axis, east, north, up; 0 where the rule has none for the axis.
        axis_accuracies: [f32; 3],
    }
}

sample! {
    /// State of one system track at one time: the fused picture of one target (TI-19).
    SystemTrack, size 1552 {
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
        /// System-track number: not assigned to another target within a day, across all restarts.
        track_number: u32,
        /// Deployment of the track: `origin` of its configuration; 0: not stated.
        origin: u32,
        /// Number of the track at the deployment that owns the target, where another does; else 0.
        owner_track_number: u32,
        /// Number of the system track into which this track was merged, if merged; else 0.
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
        /// 1 if a source observes height; otherwise z has no meaning.
        height_valid: u8,
        /// Fusion rule: a `FusionRule` code; 0: unknown.
        rule: u8,
        /// Alerts of the contributing sources: see `alert_bits`.
        alerts: u8,
        /// 1 if a contributing source reports the target on the ground.
        on_ground: u8,
        /// Kind of the tracked object: a `TrackKind` code.
        kind: u8,
        /// Expected number of members of a group; 0 for a single target.
        members: u16,
        /// Identity of the target, as far as known to its sources.
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
        /// Contributing sources in the order of their numbers; the first `contribution_count` are used.
        contributions: [Contribution; 16],
        /// Normalised innovation squared (NIS) of the report that caused this state, in the plane; 0 if there was none.
        /// About 2 on average where covariances are honest, above 5.99 once in twenty.
        nis: f32,
        /// Newest level of the target's transponder, in steps of 25 feet at 1013.25 hPa; 0 if there is none.
        level: i16,
        /// 1 if `level` is known, and no older than two periods of the source that has it.
        level_valid: u8,
        /// 1 if the horizontal velocity is known: a source states it, or positions have shown it; else `velocity_mps`
        /// has no meaning.
        velocity_valid: u8,
        /// Age of `level` at the reference time, milliseconds.
        level_age_ms: u32,
        /// Ages of the values of `identity` at the reference time.
        identity_ages: IdentityAges,
        /// Probability that the target exists, in (0, 1]; 0: not estimated.
        existence: f32,
        /// Altitude above mean sea level by `qnh_hpa`, metres, of a target below the transition level.
        altitude_m: f32,
        /// Pressure at mean sea level in the target's region, hPa; 0: no altitude, the flight level counts.
        qnh_hpa: f32,
        /// Height by pressure minus height above the ellipsoid in the region and layer of the target, metres, as
        /// learned from reports with both: to be subtracted from the height of `position_m`.
        pressure_offset_m: f32,
        /// Standard deviation of `pressure_offset_m` for one aircraft, metres; 0: unknown.
        pressure_offset_sigma_m: f32,
        /// Rate of climb by the vertical filter, metres per second; 0 if it is unknown.
        climb_rate_mps: f32,
        /// Variance of `climb_rate_mps`, square metres per square second; 0: unknown.
        climb_rate_variance: f32,
        /// Rate of turn, clockwise from above, radians per second.
        turn_rate_radps: f32,
        /// Standard deviation of `turn_rate_radps`, radians per second; 0: unknown.
        turn_rate_sigma_radps: f32,
        /// Probabilities of the motion models in the order of `MotionMode`; all 0: not estimated.
        mode_probabilities: [f32; 8],
        /// Number of reports in the state since the start of the track.
        updates: u32,
        /// Number of published extrapolations since the last report.
        extrapolations: u32,
        /// Wait of the report that caused this state for the end of its scan, microseconds; 0: the report did not wait.
        /// No deadline counts this time.
        held_us: u32,
        /// Covariance of `velocity_mps` in straight flight: xx, xy, yy of the axes east and north, m²/s²; 0: unknown.
        /// `mode_probabilities` of `steady` is the probability of straight flight. `covariance` includes manoeuvres.
        steady_velocity_covariance: [f32; 3],
        /// Variance of the climb rate in `velocity_mps` in level flight or in a constant climb, m²/s²; 0: unknown.
        /// The more probable of both counts, by `mode_probabilities`.
        steady_climb_variance: f32,
    }
}

const _: () = assert!(size_of::<[Contribution; CONTRIBUTIONS_MAX]>() == 16 * size_of::<Contribution>());

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

    /// Returns the probability of straight flight, and the covariance of the velocity in straight flight (east, east ×
    /// north, north), m²/s²; `None` if it is unknown.
    pub fn steady_velocity(&self) -> Option<(f64, [f64; 3])> {
        let [steady, ..] = self.mode_probabilities;
        let [xx, _, yy] = self.steady_velocity_covariance;
        let is_known = xx > 0.0 && yy > 0.0;
        is_known.then(|| (f64::from(steady), self.steady_velocity_covariance.map(f64::from)))
    }

    /// Returns the probability of level flight or of a constant climb, whichever is greater, and the variance of the
    /// climb rate in this case, m²/s²; `None` if it is unknown.
    pub fn steady_climb(&self) -> Option<(f64, f64)> {
        let probability = |mode: MotionMode| self.mode_probabilities[mode as usize];
        let steady = probability(MotionMode::Level).max(probability(MotionMode::Climb));
        let variance = f64::from(self.steady_climb_variance);
        (variance > 0.0).then(|| (f64::from(steady), variance))
    }

    /// Returns the height by pressure minus the height above the ellipsoid, metres; `None` where the deployment has not
    /// learned the difference, so that the heights of positions are all that is known.
    pub fn pressure_offset(&self) -> Option<f64> {
        (self.pressure_offset_sigma_m > 0.0).then(|| f64::from(self.pressure_offset_m))
    }

    /// Returns the altitude above mean sea level by the pressure of the region, metres; `None` where the flight level
    /// counts.
    pub fn altitude(&self) -> Option<f64> {
        (self.qnh_hpa > 0.0).then(|| f64::from(self.altitude_m))
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
