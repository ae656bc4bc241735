//! Made-up tracks, and what they mean in other frames, worked out another way than by the code under test.

use frames::{Geodetic, SensorFrame, SystemFrame};
use messages::{
    CONTRIBUTIONS_MAX, Contribution, Covariance, Identity, IdentityAges, Movement, SensorTrack, SystemTrack,
    TrackState, contribution_bits,
};
use proptest::prelude::*;

pub(crate) const FOOT_M: f64 = 0.3048;
pub(crate) const LEVEL_M: f64 = 30.48;
pub(crate) const NM_M: f64 = 1852.0;

/// A system, a sensor in it, and where they are.
#[derive(Clone, Copy, Debug)]
pub(crate) struct World {
    pub(crate) system: SystemFrame,
    pub(crate) place: Geodetic,
    pub(crate) sensor: SensorFrame,
    north_offset_rad: f64,
}

impl World {
    pub(crate) fn new(origin: [f64; 3], sensor_m: [f64; 2], north_offset_rad: f64) -> Self {
        let origin = Geodetic::from_degrees(origin[0], origin[1], origin[2]).unwrap();
        let system = SystemFrame::at(origin);
        let place = system.to_geodetic([sensor_m[0], sensor_m[1], plane_height(sensor_m, 50.0)]);
        let sensor = SensorFrame::new(&system, place, north_offset_rad);
        Self {
            system,
            place,
            sensor,
            north_offset_rad,
        }
    }

    /// A system and sensor in one place, at sea level, aligned to true north.
    pub(crate) fn simple(latitude_deg: f64, longitude_deg: f64) -> Self {
        let place = Geodetic::from_degrees(latitude_deg, longitude_deg, 0.0).unwrap();
        let system = SystemFrame::at(place);
        Self {
            system,
            place,
            sensor: SensorFrame::new(&system, place, 0.0),
            north_offset_rad: 0.0,
        }
    }

    /// The sensor's x, y and up of a system position.
    pub(crate) fn in_sensor(&self, position_m: [f64; 3]) -> [f64; 3] {
        let [east, north, up] = SystemFrame::at(self.place).to_local(self.system.to_geodetic(position_m));
        let (sin, cos) = self.north_offset_rad.sin_cos();
        [east * cos - north * sin, east * sin + north * cos, up]
    }

    /// East, north and up at the target, of a vector in the system frame at its position.
    pub(crate) fn at_target(&self, position_m: [f64; 3], vector: [f64; 3]) -> [f64; 3] {
        let local = SystemFrame::at(self.system.to_geodetic(position_m));
        let tip = [0, 1, 2].map(|axis| position_m[axis] + SPAN * vector[axis]);
        local
            .to_local(self.system.to_geodetic(tip))
            .map(|component| component / SPAN)
    }

    /// The sensor's x, y and up, of a vector in the system frame.
    pub(crate) fn vector_in_sensor(&self, vector: [f64; 3]) -> [f64; 3] {
        let origin = self.in_sensor([0.0; 3]);
        let tip = self.in_sensor(vector.map(|component| SPAN * component));
        [0, 1, 2].map(|axis| (tip[axis] - origin[axis]) / SPAN)
    }

    /// The velocity at the target; with an unknown vertical component, of a level flight.
    pub(crate) fn velocity(&self, position_m: [f64; 3], velocity: [f64; 3], vertical_known: bool) -> [f64; 3] {
        if vertical_known {
            return self.at_target(position_m, velocity);
        }
        let [vx, vy, _] = velocity;
        let (flat, up) = (
            self.at_target(position_m, [vx, vy, 0.0]),
            self.at_target(position_m, [0.0, 0.0, 1.0]),
        );
        let vz = -flat[2] / up[2];
        self.at_target(position_m, [vx, vy, vz])
    }

    /// Variance of a linear function of velocity, from its values for the unit vectors.
    pub(crate) fn velocity_covariance(covariance: &Covariance, a: [f64; 3], b: [f64; 3]) -> f64 {
        quadratic(covariance, 3, a, b)
    }

    /// Variance of a linear function of position.
    pub(crate) fn position_covariance(covariance: &Covariance, a: [f64; 3], b: [f64; 3]) -> f64 {
        quadratic(covariance, 0, a, b)
    }
}

/// Vectors are made this many times longer, so that rounding in the conversions does not show.
const SPAN: f64 = 100.0;

fn quadratic(covariance: &Covariance, first: usize, a: [f64; 3], b: [f64; 3]) -> f64 {
    let pairs = (0..3).flat_map(|i| (0..3).map(move |j| (i, j)));
    pairs
        .map(|(i, j)| a[i] * covariance.get(first + i, first + j) * b[j])
        .sum()
}

/// Values of a linear function for the three unit vectors.
pub(crate) fn gradient(function: impl Fn([f64; 3]) -> f64) -> [f64; 3] {
    [
        function([1.0, 0.0, 0.0]),
        function([0.0, 1.0, 0.0]),
        function([0.0, 0.0, 1.0]),
    ]
}

/// The third coordinate, nearly, at which a place in the system's plane is so high above the ellipsoid.
fn plane_height([east, north]: [f64; 2], height_m: f64) -> f64 {
    height_m - (east * east + north * north) / (2.0 * 6_371_000.0)
}

prop_compose! {
    pub(crate) fn world()(
        latitude in -75.0..75.0f64, longitude in prop_oneof![-180.0..180.0f64, 179.0..180.0f64],
        height in 0.0..500.0f64,
        sensor_m in prop::array::uniform2(-100e3..100e3f64), offset in -0.3..0.3f64,
    ) -> World {
        World::new([latitude, longitude, height], sensor_m, offset)
    }
}

prop_compose! {
    fn position(range_m: f64)(
        plane in prop::array::uniform2(-range_m..range_m),
        height in prop_oneof![8 => -400.0..15e3f64, 1 => -600.0..60e3f64],
    ) -> [f64; 3] {
        [plane[0], plane[1], plane_height(plane, height)]
    }
}

fn velocity() -> impl Strategy<Value = [f64; 3]> {
    (prop::array::uniform2(-350.0..350.0f64), -40.0..40.0f64).prop_map(|([x, y], z)| [x, y, z])
}

/// Covariances from perfect to hopeless.
fn covariance() -> impl Strategy<Value = Covariance> {
    let sigma = || (-3.0..4.5f64).prop_map(|exponent| 10f64.powf(exponent));
    let sigmas = || prop::array::uniform3(sigma());
    (sigmas(), sigmas(), -0.95..0.95f64, -0.95..0.95f64).prop_map(|(position, velocity, of_position, of_velocity)| {
        let mut covariance = Covariance::diagonal(position, velocity);
        covariance.set(0, 1, of_position * position[0] * position[1]);
        covariance.set(3, 4, of_velocity * velocity[0] * velocity[1]);
        covariance
    })
}

fn identity() -> impl Strategy<Value = Identity> {
    let call_sign = "[A-Z0-9 ]{8}".prop_map(|text| <[u8; 8]>::try_from(text.as_bytes()).unwrap());
    let fields = (
        prop::option::of(0..1u32 << 24),
        prop::option::of(0..0o10000u16),
        prop::option::of(call_sign),
    );
    fields.prop_map(|(address, code, call_sign)| {
        let mut identity = Identity::default();
        if let Some(address) = address {
            identity = identity.with_address(address);
        }
        if let Some(code) = code {
            identity = identity.with_mode_3a(code);
        }
        if let Some(call_sign) = call_sign {
            identity = identity.with_callsign(call_sign);
        }
        identity
    })
}

/// Times near midnight more often than a day has midnights.
fn time_ns() -> impl Strategy<Value = i64> {
    const DAY_NS: i64 = 86_400_000_000_000;
    let near_midnight = (-8_000_000..8_000_000i64).prop_map(|off_ns| 20_000 * DAY_NS + off_ns);
    prop_oneof![2 => near_midnight, 5 => (0..DAY_NS).prop_map(|of_day| 20_000 * DAY_NS + of_day)]
}

fn state() -> impl Strategy<Value = u8> {
    prop_oneof![
        4 => Just(TrackState::Confirmed as u8),
        1 => Just(TrackState::Tentative as u8),
        2 => Just(TrackState::Coasted as u8),
        1 => Just(TrackState::Suspended as u8),
        1 => Just(TrackState::Terminated as u8),
    ]
}

/// Sources of system tracks in these tests have numbers below this.
pub(crate) const SOURCES: u16 = 8;

fn contribution(reference_ns: i64) -> impl Strategy<Value = Contribution> {
    let age_ns = prop_oneof![5 => 0..12_000_000_000i64, 1 => -1_000_000_000..100_000_000_000i64];
    (0..SOURCES, age_ns, prop::bool::weighted(0.8)).prop_map(move |(source, age_ns, fresh)| Contribution {
        time_of_measurement_ns: reference_ns - age_ns,
        source,
        flags: if fresh { contribution_bits::FRESH } else { 0 },
        ..Contribution::default()
    })
}

prop_compose! {
    fn movement()(
        acceleration_mps2 in prop::array::uniform3(-20.0..20.0f32), horizontal in 0..4u8, vertical in 0..4u8,
        longitudinal in 0..4u8, valid in 0..4u8,
    ) -> Movement {
        Movement { acceleration_mps2, horizontal, vertical, longitudinal, valid }
    }
}

/// Source and age (ms) of the last report; level, whether it is known, its age; age of the code. Ages are those of the
/// report, or other ones.
fn measured() -> impl Strategy<Value = (u16, u32, i16, u8, u32, u32)> {
    let source = prop_oneof![4 => 0..SOURCES, 1 => Just(messages::NO_SOURCE)];
    let level = prop_oneof![5 => -60..6000i16, 1 => any::<i16>()];
    let other = || prop_oneof![1 => Just(None), 1 => prop_oneof![10_000..60_000u32, 10_000..u32::MAX].prop_map(Some)];
    let ages = (0..9_000u32, other(), other());
    (source, level, 0..2u8, ages).prop_map(|(source, level, is_known, (report_ms, level_ms, code_ms))| {
        let [level_ms, code_ms] = [level_ms, code_ms].map(|age_ms| age_ms.unwrap_or(report_ms));
        (source, report_ms, level, is_known, level_ms, code_ms)
    })
}

prop_compose! {
    /// A system track with one of a few numbers, so that histories come about.
    pub(crate) fn system_track()(reference_ns in time_ns())(
        track_number in prop_oneof![1..6u32, Just(65_536 + 3), any::<u32>()],
        position_m in position(400e3), velocity_mps in velocity(), covariance in covariance(), identity in identity(),
        state in state(), alerts in prop_oneof![Just(0), any::<u8>()], height_valid in 0..2u8, velocity_valid in 0..2u8, on_ground in 0..2u8,
        contributions in prop::collection::vec(contribution(reference_ns), 0..4), movement in movement(),
        reference_time_ns in Just(reference_ns), rates in prop::array::uniform3(0..3u8),
        pressure_offset_m in -500.0..500.0f32, altitude_m in -600.0..6e3f32, has_qnh in any::<bool>(),
        climb_rate_mps in -40.0..40.0f32, climb_sigma_mps in 0.01..20.0f32, turn_rate_radps in -0.05..0.05f32,
        measured in measured(),
    ) -> SystemTrack {
        let (trigger_source, report_ms, level, level_valid, level_age_ms, mode_3a_ms) = measured;
        let mut listed = [Contribution::default(); CONTRIBUTIONS_MAX];
        listed[..contributions.len()].copy_from_slice(&contributions);
        SystemTrack {
            reference_time_ns, track_number, identity, position_m, velocity_mps, covariance, state, alerts,
            height_valid, velocity_valid, on_ground, movement, climb_rate_mps, turn_rate_radps,
            pressure_offset_m,
            trigger_source,
            time_of_measurement_ns: reference_time_ns - i64::from(report_ms) * 1_000_000,
            level,
            level_valid,
            level_age_ms,
            identity_ages: IdentityAges { mode_3a_ms, ..IdentityAges::default() },
            altitude_m,
            qnh_hpa: if has_qnh { 1_003.0 } else { 0.0 },
            pressure_offset_sigma_m: if rates[2] > 0 { 30.0 } else { 0.0 },
            climb_rate_variance: if rates[0] > 0 { climb_sigma_mps * climb_sigma_mps } else { 0.0 },
            // Not known, sure, or noise.
            turn_rate_sigma_radps: [0.0, 0.4, 0.6][usize::from(rates[1])] * turn_rate_radps.abs(),
            contributions: listed,
            contribution_count: contributions.len() as u16,
            source_count: contributions.len() as u16,
            ..SystemTrack::default()
        }
    }
}

prop_compose! {
    /// A sensor track within `range_m` of the system's origin along each axis.
    pub(crate) fn sensor_track(range_m: f64)(
        time_of_measurement_ns in time_ns(),
        track_number in prop_oneof![1..6u32, Just(4095 + 3), any::<u32>()],
        position_m in position(range_m), measured_off_m in prop::array::uniform3(-200.0..200.0f64),
        velocity_mps in velocity(), covariance in covariance(), identity in identity(),
        state in state(), alerts in prop_oneof![Just(0), any::<u8>()], valid in 0..256u16,
    ) -> SensorTrack {
        SensorTrack {
            time_of_measurement_ns, track_number, identity, position_m, velocity_mps, covariance, state, alerts, valid,
            measured_m: [0, 1, 2].map(|axis| position_m[axis] + measured_off_m[axis]),
            ..SensorTrack::default()
        }
    }
}

/// The call sign as it is read back: eight characters, if there is any.
pub(crate) fn call_sign(identity: &Identity) -> Option<String> {
    identity.callsign()?;
    let text = String::from_utf8(identity.callsign.to_vec()).unwrap();
    text.contains(|character: char| character.is_ascii_alphanumeric())
        .then_some(text)
}

/// The code as it is read back: four octal digits.
pub(crate) fn code(identity: &Identity) -> Option<String> {
    identity.mode_3a().map(|code| format!("{code:04o}"))
}

/// The emergency as CAT021 and CAT062 number it.
pub(crate) fn emergency(alerts: u8) -> u64 {
    use messages::alert_bits::*;
    let by_gravity = [
        (UNLAWFUL_INTERFERENCE, 5),
        (COMMUNICATION_FAILURE, 4),
        (MINIMUM_FUEL, 3),
        (MEDICAL, 2),
        (EMERGENCY, 1),
    ];
    by_gravity
        .iter()
        .find(|(bit, _)| alerts & bit != 0)
        .map_or(0, |(_, number)| *number)
}
