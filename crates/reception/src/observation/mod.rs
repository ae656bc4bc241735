//! ASTERIX target reports into observations.
//!
//! Each category has a file of its own that says what its items mean.

mod cat001;
mod cat010;
mod cat020;
mod cat021_v0;
mod cat021_v2;
mod cat048;
mod cat062;
mod navigation;

use messages::{Identity, TrackState, alert_bits};
use observations::{Axes, Observation, Plane, Quality, Service};

use asterix::Record;
use asterix::typed::fields::{
    Callsign, CartesianPosition, CartesianVelocity, Emergency, Extrapolation, FlightLevel, FlightStatus,
    GeodeticPosition, Mode3A, PolarPosition, PolarVelocity, ResolutionAdvisory, Source, TimeOfDay, TrackStatus,
};
use asterix::typed::{cat002, cat019, cat023, cat034, cat063, cat065};

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
