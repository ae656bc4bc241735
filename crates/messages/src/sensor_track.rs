//! Reports from adapters to fusion.

use crate::codes::bits;
use crate::layout::sample;
use crate::{Contribution, Covariance, Extent, Identity, IdentityAges, Movement, StageTimes, SystemTrack, TargetType};

bits! {
    /// Bits of [`SensorTrack::valid`].
    sensor_track_bits: u16 {
        /// Height (`position[2]`) was observed; otherwise z is 0 and its variance has no meaning.
        HEIGHT = 1;
        /// Horizontal velocity was delivered or derived.
        VELOCITY = 1 << 1;
        /// Vertical velocity was delivered or derived.
        VERTICAL_RATE = 1 << 2;
        /// The covariance is the source's own statement; otherwise it is derived from configured accuracies.
        OWN_COVARIANCE = 1 << 3;
        /// `measured_m` holds the measurement from which the source updated its track.
        MEASURED = 1 << 4;
        /// The source reports that the target is on the ground.
        ON_GROUND = 1 << 5;
        /// The velocity was derived by the adapter from successive positions.
        DERIVED_VELOCITY = 1 << 6;
        /// `trace` holds the source's own covariance trace (TI-16).
        TRACE = 1 << 7;
        /// The time of measurement is not believed: it lies far from that of receipt, or the source's clock jumps.
        WILD_CLOCK = 1 << 8;
        /// `shared_sources` is known: the track is a system track of another centre, which names its sensors.
        CONTRIBUTORS = 1 << 9;
        /// `level` holds the level of the target's transponder.
        LEVEL = 1 << 10;
        /// `turn_rate_radps` is known.
        TURN_RATE = 1 << 11;
        /// `pressure_offset_m` is known: the report states its height in both ways.
        PRESSURE_OFFSET = 1 << 12;
        /// The sensors move: `measured_m` is the platform's place (east, north) and heading, no measurement.
        PLATFORM = 1 << 13;
    }
}

bits! {
    /// Bits of [`SensorTrack::alerts`] and [`SystemTrack::alerts`](crate::SystemTrack::alerts).
    alert_bits: u8 {
        /// Special position identification: the pilot has pressed the button.
        SPECIAL_IDENTIFICATION = 1;
        /// An emergency of any kind; Mode 3/A code 7700.
        EMERGENCY = 1 << 1;
        /// Radio communication has failed; code 7600.
        COMMUNICATION_FAILURE = 1 << 2;
        /// Unlawful interference; code 7500.
        UNLAWFUL_INTERFERENCE = 1 << 3;
        /// Medical flight.
        MEDICAL = 1 << 4;
        /// Minimum fuel.
        MINIMUM_FUEL = 1 << 5;
        /// The Mode 3/A code was changed lately, or the transponder raises its alert for another reason.
        TRANSPONDER_ALERT = 1 << 6;
        /// A collision avoidance system advises the crew to manoeuvre.
        RESOLUTION_ADVISORY = 1 << 7;
    }
}

sample! {
    /// One report of one sensor track (TI-1): state in the system's East-North-Up frame at the time of measurement.
    SensorTrack, size 448 {
        /// Time of measurement, UTC, nanoseconds since 1970.
        time_of_measurement_ns: i64,
        /// The report's sequence number at its publisher.
        sequence: u64,
        /// Stages passed so far.
        stages: StageTimes,
        /// Number of the sensor track at its source.
        track_number: u32,
        /// Source: its number in the configuration (TI-2).
        source: u16,
        /// Which fields hold something: see `sensor_track_bits`.
        valid: u16,
        /// Identity of the target, as far as it is known.
        identity: Identity,
        /// Position east, north, up, metres.
        position_m: [f64; 3],
        /// Velocity east, north, up, metres per second. A component with a variance of 0 is unknown.
        velocity_mps: [f64; 3],
        /// Covariance of position and velocity; all 0 where the source gives its `trace_m2` instead. A variance of 0
        /// means that the component is unknown, except those of east and north, which every report needs.
        covariance: Covariance,
        /// Measured position, before the source's own filter, metres. See the bit `PLATFORM`.
        measured_m: [f64; 3],
        /// Trace of the source's position covariance over east and north, square metres.
        trace_m2: f64,
        /// State of the track at its source: a `TrackState` code.
        state: u8,
        /// Observation method at the source, as numbered by its format; 0 for a single method.
        method: u8,
        /// Alerts of the target or its source: see `alert_bits`.
        alerts: u8,
        /// Kind of the tracked object: a `TrackKind` code.
        kind: u8,
        /// Expected number of members of a group; 0 for a single target.
        members: u16,
        /// Level that the transponder stated last, in steps of 25 feet at 1013.25 hPa; 0 without the bit `LEVEL`.
        level: i16,
        /// Type of the target.
        target_type: TargetType,
        /// Size of the target, as stated or measured by its source.
        extent: Extent,
        /// Modes of movement and acceleration, as the source states them.
        movement: Movement,
        /// Local sources whose sensors have contributed to a system track of another centre, as bits by number; sources
        /// from number 64 on have none.
        shared_sources: u64,
        /// Original deployment of a system track of another centre; else 0.
        origin: u32,
        /// Age of `level` at the time of measurement, milliseconds.
        level_age_ms: u32,
        /// Ages of the values of `identity` at the time of measurement.
        identity_ages: IdentityAges,
        /// Probability that the target exists according to the source, in (0, 1]; 0: not stated.
        existence: f32,
        /// Rate of turn according to the source, clockwise from above, radians per second.
        turn_rate_radps: f32,
        /// Height by pressure, as in `position_m`, minus the height above the ellipsoid that the report states, metres.
        pressure_offset_m: f32,
    }
}

impl SensorTrack {
    /// Converts a system track of another centre to a sensor track of `source`, for the deployment with the number
    /// `origin` and with the sensors `sensor_uids`. `None` if tracks of this deployment contributed: such an echo
    /// contains no new information.
    pub fn of_centre(track: &SystemTrack, source: u16, origin: u32, sensor_uids: &[u32]) -> Option<Self> {
        let contributions = track.contributions();
        let is_echo = |of: u32| origin != 0 && of == origin;
        if is_echo(track.origin) || contributions.iter().any(|contribution| is_echo(contribution.origin)) {
            return None;
        }
        let has_all = usize::from(track.source_count) == contributions.len();
        // A contribution of another centre identifies no sensor.
        let names_sensor = |contribution: &Contribution| contribution.sensor_uid != 0 && contribution.origin == 0;
        let is_known = has_all && contributions.iter().all(names_sensor);
        let shares = |uid: &u32| *uid == 0 || contributions.iter().any(|contribution| contribution.sensor_uid == *uid);
        let shared = (0..).zip(sensor_uids).filter(|(_, uid)| shares(uid));
        // Sources beyond have no bit: with one of these, the contributors count as unknown.
        let has_bits = shared.clone().all(|(number, _): (u32, _)| number < u64::BITS);
        let flag = |is_set: bool, bits| if is_set { bits } else { 0 };
        let has_climb = track.height_valid != 0 && track.covariance.knows_climb();
        Some(Self {
            time_of_measurement_ns: track.reference_time_ns,
            stages: track.stages,
            track_number: track.track_number,
            source,
            valid: sensor_track_bits::OWN_COVARIANCE
                | flag(track.velocity_valid != 0, sensor_track_bits::VELOCITY)
                | flag(track.height_valid != 0, sensor_track_bits::HEIGHT)
                | flag(has_climb, sensor_track_bits::VERTICAL_RATE)
                | flag(track.on_ground != 0, sensor_track_bits::ON_GROUND)
                | flag(is_known && has_bits, sensor_track_bits::CONTRIBUTORS)
                | flag(track.level_valid != 0, sensor_track_bits::LEVEL),
            identity: track.identity,
            position_m: track.position_m,
            velocity_mps: track.velocity_mps,
            covariance: track.covariance,
            state: track.state,
            alerts: track.alerts,
            kind: track.kind,
            members: track.members,
            level: track.level,
            level_age_ms: track.level_age_ms,
            target_type: track.target_type,
            extent: track.extent,
            movement: track.movement,
            shared_sources: shared.fold(0, |bits, (number, _)| bits | 1_u64.checked_shl(number).unwrap_or(0)),
            origin: track.origin,
            ..Self::default()
        })
    }

    /// Whether all of `bits` (see [`sensor_track_bits`]) are set.
    pub fn has(&self, bits: u16) -> bool {
        self.valid & bits == bits
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// System track of deployment 2 with contributions of these sensors, received by those deployments.
    fn of_two(contributors: &[(u32, u32)]) -> SystemTrack {
        let mut track = SystemTrack {
            origin: 2,
            source_count: contributors.len() as u16,
            contribution_count: contributors.len() as u16,
            ..SystemTrack::default()
        };
        for (contribution, (sensor_uid, origin)) in track.contributions.iter_mut().zip(contributors) {
            (contribution.sensor_uid, contribution.origin) = (*sensor_uid, *origin);
        }
        track
    }

    #[test]
    fn sensors_in_common_are_named_and_where_one_is_unknown_none_are() {
        let uids = [7, 8, 0];
        let report = SensorTrack::of_centre(&of_two(&[(8, 0), (9, 0)]), 4, 1, &uids).unwrap();
        assert!(report.has(sensor_track_bits::CONTRIBUTORS));
        assert_eq!((report.source, report.origin), (4, 2));
        assert_eq!(report.shared_sources, 0b110, "a sensor without identity may be any");
        let mut more = of_two(&[(9, 0)]);
        more.source_count = 17;
        for track in [of_two(&[(0, 0)]), of_two(&[(9, 3)]), more] {
            let report = SensorTrack::of_centre(&track, 4, 1, &uids).unwrap();
            assert!(!report.has(sensor_track_bits::CONTRIBUTORS));
        }
    }

    #[test]
    fn an_echo_is_left_out() {
        assert!(SensorTrack::of_centre(&of_two(&[(9, 1)]), 4, 1, &[]).is_none());
        assert!(SensorTrack::of_centre(&of_two(&[]), 4, 2, &[]).is_none());
        assert!(SensorTrack::of_centre(&of_two(&[(9, 3)]), 4, 1, &[]).is_some());
    }

    #[test]
    fn a_level_goes_on_with_its_age() {
        let mut track = of_two(&[(9, 0)]);
        let of_none = SensorTrack::of_centre(&track, 4, 1, &[]).unwrap();
        assert!(!of_none.has(sensor_track_bits::LEVEL));
        (track.level, track.level_valid, track.level_age_ms) = (-3, 1, 250);
        let report = SensorTrack::of_centre(&track, 4, 1, &[]).unwrap();
        assert!(report.has(sensor_track_bits::LEVEL));
        assert_eq!((report.level, report.level_age_ms), (-3, 250));
    }
}
