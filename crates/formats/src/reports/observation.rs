//! One target report, whatever its format, still in the sensor's own terms.

use messages::{Identity, TrackState};

use crate::asterix::Record;
use crate::asterix::typed::fields::{
    Callsign, CartesianPosition, CartesianVelocity, Extrapolation, GeodeticPosition, Mode3A, PolarPosition,
    PolarVelocity, TimeOfDay, TrackStatus,
};
use crate::asterix::typed::{cat010, cat019, cat020, cat021_v0};

/// A target report in the sensor's own frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Observation {
    /// System area code and system identification code of the sender.
    pub sac_sic: Option<(u8, u8)>,
    /// Time of measurement, nanoseconds since midnight UTC.
    pub time_of_day_ns: Option<i64>,
    /// Whether it reports a fixed transponder that only monitors the system.
    pub field_monitor: bool,
    /// Whether it is simulated or a test.
    pub test: bool,
    /// Number of the track at its source; the address, where the source numbers none.
    pub track_number: Option<u32>,
    /// Who the target says it is.
    pub identity: Identity,
    /// Position towards the sensor's own x (its east) and y (its north).
    pub cartesian: Option<[f64; 2]>,
    /// Range along the ground (m) and azimuth clockwise from the sensor's north (rad).
    pub polar: Option<[f64; 2]>,
    /// Latitude and longitude, radians.
    pub geodetic: Option<[f64; 2]>,
    /// Horizontal velocity along the sensor's own x and y, metres per second.
    pub velocity: Option<[f64; 2]>,
    /// Height above mean sea level or the ellipsoid, whichever the source gives, metres.
    pub height_m: Option<f64>,
    /// Rate of climb, metres per second.
    pub vertical_rate_mps: Option<f64>,
    /// Whether the target says that it is on the ground.
    pub on_ground: bool,
    /// State of the track at its source.
    pub state: TrackState,
    /// The report's own statement of its horizontal accuracy.
    pub quality: Quality,
}

/// A position in one of the forms that sensors use.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Position {
    /// See [`Observation::cartesian`].
    Cartesian([f64; 2]),
    /// See [`Observation::polar`].
    Polar([f64; 2]),
    /// See [`Observation::geodetic`].
    Geodetic([f64; 2]),
}

/// What a report says of its own horizontal accuracy.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Quality {
    /// Nothing.
    #[default]
    Unstated,
    /// Covariance (xx, xy, yy), m².
    Covariance([f64; 3]),
    /// Horizontal dilution of precision: position error per range error.
    Dilution(f64),
    /// Radius within which the position lies with 95 % probability, metres.
    Radius95(f64),
    /// That it is unknown.
    Unknown,
}

/// What a record is to the pipeline.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reading {
    /// A target report.
    Target(Observation),
    /// A record that speaks of the sensor itself, with its time of day (nanoseconds).
    Service(Option<i64>),
    /// A record of a category that reports no targets in any form known here.
    Other,
}

/// Reads an ASTERIX record of any category that reports targets.
pub fn read(record: &Record<'_>) -> Reading {
    if let Some(report) = cat010::TargetReport::read(record) {
        return Reading::Target(of_cat010(&report));
    }
    if let Some(message) = cat010::ServiceMessage::read(record) {
        return Reading::Service(message.time_of_day.map(nanoseconds));
    }
    if let Some(report) = cat020::TargetReport::read(record) {
        return Reading::Target(of_cat020(&report));
    }
    if let Some(report) = cat021_v0::TargetReport::read(record) {
        return Reading::Target(of_cat021_v0_23(&report));
    }
    match cat019::ServiceMessage::read(record) {
        Some(message) => Reading::Service(message.time_of_day.map(nanoseconds)),
        None => Reading::Other,
    }
}

fn of_cat010(report: &cat010::TargetReport) -> Observation {
    let callsign = report.identification.and_then(|identification| identification.callsign);
    let descriptor = report.descriptor;
    Observation {
        sac_sic: report.source.map(|source| (source.sac, source.sic)),
        time_of_day_ns: report.time_of_day.map(nanoseconds),
        field_monitor: descriptor.is_some_and(|descriptor| descriptor.field_monitor),
        test: descriptor.is_some_and(|descriptor| descriptor.simulated || descriptor.test),
        track_number: report.track_number.map(u32::from),
        identity: identity(report.mode_3a, report.address, callsign),
        cartesian: report.cartesian_position.map(cartesian),
        polar: report.polar_position.map(polar),
        geodetic: report.geodetic_position.map(geodetic),
        velocity: report
            .cartesian_velocity
            .map(components)
            .or(report.polar_velocity.map(from_polar)),
        height_m: report
            .flight_level
            .map(|level| level.altitude_m)
            .or(report.measured_height_m),
        vertical_rate_mps: None,
        on_ground: descriptor.is_some_and(|descriptor| descriptor.ground_bit),
        state: state(report.track_status),
        quality: match report.position_deviation {
            Some(deviation) if deviation.sigma_x_m > 0.0 && deviation.sigma_y_m > 0.0 => Quality::Covariance([
                deviation.sigma_x_m.powi(2),
                deviation.covariance_xy_m2,
                deviation.sigma_y_m.powi(2),
            ]),
            _ => Quality::Unstated,
        },
    }
}

fn of_cat020(report: &cat020::TargetReport) -> Observation {
    let callsign = report.identification.and_then(|identification| identification.callsign);
    let descriptor = report.descriptor;
    Observation {
        sac_sic: report.source.map(|source| (source.sac, source.sic)),
        time_of_day_ns: report.time_of_day.map(nanoseconds),
        field_monitor: descriptor.is_some_and(|descriptor| descriptor.field_monitor),
        test: descriptor.is_some_and(|descriptor| descriptor.simulated || descriptor.test),
        track_number: report.track_number.map(u32::from),
        identity: identity(report.mode_3a, report.address, callsign),
        cartesian: report.cartesian_position.map(cartesian),
        polar: None,
        geodetic: report.geodetic_position.map(geodetic),
        velocity: report.cartesian_velocity.map(components),
        // Systems fill the flight level with 0 where they have none, so a level of exactly 0 says nothing.
        height_m: report
            .flight_level
            .map(|level| level.altitude_m)
            .filter(|altitude| *altitude != 0.0)
            .or(report.measured_height_m)
            .or(report.geometric_height_m),
        vertical_rate_mps: None,
        on_ground: descriptor.is_some_and(|descriptor| descriptor.ground_bit),
        state: state(report.track_status),
        quality: cat020_quality(report),
    }
}

/// SDP where it says something, else the dilution of precision; systems send zeros for "not given".
fn cat020_quality(report: &cat020::TargetReport) -> Quality {
    let Some(accuracy) = report.position_accuracy else {
        return Quality::Unstated;
    };
    if let Some(deviation) = accuracy.deviation
        && deviation.sigma_x_m > 0.0
        && deviation.sigma_y_m > 0.0
    {
        let correlation = deviation.correlation_xy.clamp(-0.99, 0.99);
        let cross = correlation * deviation.sigma_x_m * deviation.sigma_y_m;
        return Quality::Covariance([deviation.sigma_x_m.powi(2), cross, deviation.sigma_y_m.powi(2)]);
    }
    match accuracy.dilution {
        Some(dilution) if dilution.xy > 0.0 => Quality::Dilution(dilution.xy),
        _ => Quality::Unstated,
    }
}

fn of_cat021_v0_23(report: &cat021_v0::TargetReport) -> Observation {
    let descriptor = report.descriptor;
    Observation {
        sac_sic: report.source.map(|source| (source.sac, source.sic)),
        time_of_day_ns: report.time_of_day.map(nanoseconds),
        field_monitor: descriptor.is_some_and(|descriptor| descriptor.field_monitor),
        test: descriptor.is_some_and(|descriptor| descriptor.simulated || descriptor.test),
        // The edition has no track number: a transmitter is its own track.
        track_number: report.address,
        identity: identity(None, report.address, report.callsign),
        cartesian: None,
        polar: None,
        geodetic: report.geodetic_position.map(geodetic),
        velocity: report.ground_vector.map(from_polar),
        height_m: report.pressure_altitude_m.or(report.geometric_altitude_m),
        vertical_rate_mps: report.barometric_rate_m_s.or(report.geometric_rate_m_s),
        on_ground: descriptor.is_some_and(|descriptor| descriptor.ground_bit),
        state: TrackState::Confirmed,
        quality: report
            .figure_of_merit
            .map_or(Quality::Unstated, |merit| radius_of_nucp(merit.position_category)),
    }
}

/// Radius of 95 % containment for a navigation uncertainty category (NUCp): RTCA DO-260, table of horizontal position
/// error.
fn radius_of_nucp(category: u8) -> Quality {
    const NAUTICAL_MILE_M: f64 = 1852.0;
    match category {
        9 => Quality::Radius95(3.0),
        8 => Quality::Radius95(10.0),
        7 => Quality::Radius95(0.05 * NAUTICAL_MILE_M),
        6 => Quality::Radius95(0.1 * NAUTICAL_MILE_M),
        5 => Quality::Radius95(0.25 * NAUTICAL_MILE_M),
        4 => Quality::Radius95(0.5 * NAUTICAL_MILE_M),
        3 => Quality::Radius95(NAUTICAL_MILE_M),
        2 => Quality::Radius95(5.0 * NAUTICAL_MILE_M),
        1 => Quality::Radius95(10.0 * NAUTICAL_MILE_M),
        _ => Quality::Unknown,
    }
}

fn nanoseconds(time: TimeOfDay) -> i64 {
    frames::time::time_of_day_ns(time.ticks)
}

fn identity(code: Option<Mode3A>, address: Option<u32>, callsign: Option<Callsign>) -> Identity {
    let mut identity = Identity::default();
    if let Some(code) = code.filter(|code| !code.not_validated && !code.garbled) {
        identity = identity.with_mode_3a(code.code);
    }
    if let Some(address) = address {
        identity = identity.with_address(address);
    }
    if let Some(callsign) = callsign {
        identity = identity.with_callsign(*callsign.as_bytes());
    }
    identity
}

fn state(status: Option<TrackStatus>) -> TrackState {
    match status {
        Some(status) if status.ended => TrackState::Terminated,
        Some(status) if status.tentative => TrackState::Tentative,
        Some(status) if status.extrapolation != Extrapolation::None => TrackState::Coasted,
        _ => TrackState::Confirmed,
    }
}

fn cartesian(position: CartesianPosition) -> [f64; 2] {
    [position.x_m, position.y_m]
}

fn polar(position: PolarPosition) -> [f64; 2] {
    [position.range_m, position.azimuth_rad]
}

fn geodetic(position: GeodeticPosition) -> [f64; 2] {
    [position.latitude_rad, position.longitude_rad]
}

fn components(velocity: CartesianVelocity) -> [f64; 2] {
    [velocity.vx_m_s, velocity.vy_m_s]
}

fn from_polar(velocity: PolarVelocity) -> [f64; 2] {
    let (sine, cosine) = velocity.track_rad.sin_cos();
    [velocity.speed_m_s * sine, velocity.speed_m_s * cosine]
}
