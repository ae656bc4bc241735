//! One target report, whatever its format, still in the sensor's own terms.
//!
//! Each category has a file of its own that says what its items mean; this one holds what they are brought into. What an
//! observation lacks its source did not say: nothing is made up here, and nothing converted but units.

mod cat001;
mod cat010;
mod cat020;
mod cat021_v0;
mod cat021_v2;
mod cat048;
mod cat062;
mod navigation;

use messages::{Identity, TrackState, alert_bits};

use asterix::Record;
use asterix::typed::fields::{
    Callsign, CartesianPosition, CartesianVelocity, Emergency, Extrapolation, FlightLevel, FlightStatus,
    GeodeticPosition, Mode3A, PolarPosition, PolarVelocity, ResolutionAdvisory, Source, TimeOfDay, TrackStatus,
};
use asterix::typed::{cat002, cat019, cat023, cat034, cat063, cat065};

/// A target report in the sensor's own frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Observation {
    /// System area code and system identification code of the sender; `None` where it is the same as in the record
    /// before.
    pub sac_sic: Option<(u8, u8)>,
    /// Time of measurement, nanoseconds since midnight UTC.
    pub time_of_day_ns: Option<i64>,
    /// Time of measurement, nanoseconds since the last whole [`TRUNCATION_NS`](super::TRUNCATION_NS) after midnight UTC, of
    /// a source that sends no more of it.
    pub truncated_time_ns: Option<i64>,
    /// Whether it reports a fixed transponder that only monitors the system.
    pub field_monitor: bool,
    /// Whether it is simulated or a test.
    pub test: bool,
    /// Whether its sender says that the position has failed a check.
    pub suspect: bool,
    /// Number of the track at its source; the address, where the source numbers none.
    pub track_number: Option<u32>,
    /// Whether it is a plot: what the sensor saw just now, not yet part of any track of its own.
    pub plot: bool,
    /// Who the target says it is.
    pub identity: Identity,
    /// Position towards the sensor's own x (its east) and y (its north).
    pub cartesian: Option<[f64; 2]>,
    /// What the plane of `cartesian` is.
    pub plane: Plane,
    /// Range along the ground (m) and azimuth clockwise from the sensor's north (rad).
    pub polar: Option<[f64; 2]>,
    /// Straight distance (m) and azimuth clockwise from the sensor's north (rad).
    pub slant_polar: Option<[f64; 2]>,
    /// Latitude and longitude, radians.
    pub geodetic: Option<[f64; 2]>,
    /// Horizontal velocity along two axes, metres per second.
    pub velocity: Option<[f64; 2]>,
    /// Which axes those of `velocity` are.
    pub axes: Axes,
    /// The report's own covariance (xx, xy, yy) of `velocity`, m²/s².
    pub velocity_covariance: Option<[f64; 3]>,
    /// Altitude in the standard atmosphere, metres.
    pub pressure_altitude_m: Option<f64>,
    /// Height above mean sea level or the ellipsoid, whichever the source gives, metres.
    pub geometric_height_m: Option<f64>,
    /// Rate of climb, metres per second.
    pub vertical_rate_mps: Option<f64>,
    /// Whether the target says that it is on the ground.
    pub on_ground: bool,
    /// What the target or its source wants noticed: see [`alert_bits`]. What the Mode 3/A code alone says is not in it.
    pub alerts: u8,
    /// State of the track at its source.
    pub state: TrackState,
    /// The report's own statement of its horizontal accuracy: that of the position that comes first in
    /// [`PositionForm::Any`](super::PositionForm::Any).
    pub quality: Quality,
}

/// What the plane of a Cartesian position is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Plane {
    /// It touches the earth at the sensor, and the position lies straight below or above the target.
    #[default]
    Tangent,
    /// The target, turned down into the horizon: its distance from the sensor is the straight one.
    Slant,
    /// A map of the ground around the sensor, in stereographic projection.
    Stereographic,
}

/// Which axes those of a velocity are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Axes {
    /// The sensor's own x and y.
    #[default]
    Sensor,
    /// True east and north at the target. Meridians converge: at 45° of latitude and 300 km east of the sensor, north is
    /// almost 3° off the sensor's.
    Target,
}

/// A position in one of the forms that sensors use.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Position {
    /// See [`Observation::cartesian`].
    Cartesian([f64; 2], Plane),
    /// See [`Observation::polar`].
    Polar([f64; 2]),
    /// See [`Observation::slant_polar`].
    Slant([f64; 2]),
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

impl Observation {
    /// The position as the source's tracker calculated it, or the only one there is.
    pub fn position(&self) -> Option<Position> {
        let cartesian = self.cartesian.map(|position| Position::Cartesian(position, self.plane));
        let geodetic = || self.geodetic.map(Position::Geodetic);
        cartesian.or_else(|| self.polar_position()).or_else(geodetic)
    }

    /// The position as range and azimuth: as measured, where the source has a tracker as well.
    pub fn polar_position(&self) -> Option<Position> {
        let slant = || self.slant_polar.map(Position::Slant);
        self.polar.map(Position::Polar).or_else(slant)
    }
}

/// What a record is to the pipeline.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(
    clippy::large_enum_variant,
    reason = "it is taken apart at once, and must not allocate"
)]
pub enum Reading {
    /// A target report.
    Target(Observation),
    /// A record that speaks of the sensor itself.
    Service(Service),
    /// A record of a category that reports no targets in any form known here.
    Other,
}

/// What a record says of the sensor itself.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Service {
    /// Time of the message, nanoseconds since midnight UTC.
    pub time_of_day_ns: Option<i64>,
    /// Whether the sensor's next look all around begins: its antenna points north, or a new update cycle starts.
    pub turn_begins: bool,
}

/// Reads an ASTERIX record of any category that reports targets.
pub fn read(record: &Record<'_>) -> Reading {
    let service = |time: Option<TimeOfDay>| turn(time, false);
    let reading = match record.table().number {
        1 => cat001::read(record),
        2 => cat002::ServiceMessage::read(record).map(|message| {
            let north = message.message_type == Some(cat002::MessageType::NorthMarker);
            turn(message.time_of_day, north)
        }),
        10 => cat010::read(record),
        19 => cat019::ServiceMessage::read(record).map(|message| {
            let cycle = message.message_type == Some(cat019::MessageType::StartOfUpdateCycle);
            turn(message.time_of_day, cycle)
        }),
        20 => cat020::read(record),
        21 => cat021_v2::read(record).or_else(|| cat021_v0::read(record)),
        23 => cat023::ServiceMessage::read(record).map(|message| service(message.time_of_day)),
        34 => cat034::ServiceMessage::read(record).map(|message| {
            let north = message.message_type == Some(cat034::MessageType::NorthMarker);
            turn(message.time_of_day, north)
        }),
        48 => cat048::read(record),
        62 => cat062::read(record),
        63 => cat063::SensorMessage::read(record).map(|message| service(message.time_of_day)),
        65 => cat065::ServiceMessage::read(record).map(|message| service(message.time_of_day)),
        _ => None,
    };
    reading.unwrap_or(Reading::Other)
}

fn turn(time: Option<TimeOfDay>, turn_begins: bool) -> Reading {
    Reading::Service(Service {
        time_of_day_ns: time.map(nanoseconds),
        turn_begins,
    })
}

/// Covariance from standard deviations and correlation, if neither deviation is zero: senders mean "not given" by that.
fn covariance(sigma: [f64; 2], cross: f64) -> Quality {
    let [x, y] = sigma;
    if x > 0.0 && y > 0.0 {
        // No larger than the deviations allow, whatever was sent.
        let most = 0.99 * x * y;
        Quality::Covariance([x * x, cross.clamp(-most, most), y * y])
    } else {
        Quality::Unstated
    }
}

fn alerts_of_emergency(emergency: Emergency) -> u8 {
    match emergency {
        Emergency::None | Emergency::Undefined(_) => 0,
        Emergency::General | Emergency::Downed => alert_bits::EMERGENCY,
        Emergency::Medical => alert_bits::MEDICAL,
        Emergency::MinimumFuel => alert_bits::MINIMUM_FUEL,
        Emergency::CommunicationFailure => alert_bits::COMMUNICATION_FAILURE,
        Emergency::UnlawfulInterference => alert_bits::UNLAWFUL_INTERFERENCE,
    }
}

fn alerts_of_flight_status(status: FlightStatus) -> u8 {
    when(status.alert, alert_bits::TRANSPONDER_ALERT)
        | when(status.special_identification, alert_bits::SPECIAL_IDENTIFICATION)
}

fn alerts_of_advisory(advisory: Option<ResolutionAdvisory>) -> u8 {
    let active = advisory.is_some_and(|advisory| advisory.is_active());
    when(active, alert_bits::RESOLUTION_ADVISORY)
}

fn when(condition: bool, bits: u8) -> u8 {
    if condition { bits } else { 0 }
}

fn nanoseconds(time: TimeOfDay) -> i64 {
    frames::time::time_of_day_ns(time.ticks)
}

fn sac_sic(source: Option<Source>) -> Option<(u8, u8)> {
    source.map(|source| (source.sac, source.sic))
}

fn identity(code: Option<u16>, address: Option<u32>, callsign: Option<Callsign>) -> Identity {
    let mut identity = Identity::default();
    if let Some(code) = code {
        identity = identity.with_mode_3a(code);
    }
    if let Some(address) = address {
        identity = identity.with_address(address);
    }
    if let Some(callsign) = callsign {
        identity = identity.with_callsign(*callsign.as_bytes());
    }
    identity
}

/// A code that was received well.
fn code(code: Option<Mode3A>) -> Option<u16> {
    code.filter(|code| !code.not_validated && !code.garbled)
        .map(|code| code.code)
}

/// An altitude that was received well.
fn altitude(level: Option<FlightLevel>) -> Option<f64> {
    level
        .filter(|level| !level.not_validated && !level.garbled)
        .map(|level| level.altitude_m)
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

#[cfg(test)]
mod tests;
