//! Messages of 25 octets to values. Numbers of several octets have the least one first.

use frames::time::NS_PER_S;
use messages::alert_bits;
use observations::{Alerts, Emergency, Quality, TargetCategory};

use super::reason::{Read, RemoteIdReason};
use crate::observation::items::components;
use crate::observation::navigation::{covariance_of_velocity_category, radius_of_nacp};
use crate::target_message::{Refusal, number_of_name};

/// Octets of a message.
pub(super) const MESSAGE_OCTETS: usize = 25;
/// Type of a message pack.
pub(super) const PACK: u8 = 15;

/// Octets of an identity.
const ID_OCTETS: usize = 20;
/// Degrees per unit of a latitude or longitude.
const DEGREES: f64 = 1e-7;
/// Tenths of a second in an hour: the greatest time since the full hour. The greatest number means unknown.
const HOUR_TENTHS: u16 = 36_000;
/// Greatest vertical speed, half metres per second; one number beyond means unknown.
const VERTICAL_MAX: i8 = 124;

/// A message, as far as its values are used.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Message {
    BasicId(Option<DroneId>, TargetCategory),
    Location(Location),
    Authentication,
    SelfId,
    /// Latitude and longitude of the operator, radians.
    System(Option<[f64; 2]>),
    OperatorId,
}

/// Identity of a drone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct DroneId {
    pub(super) kind: IdKind,
    octets: [u8; ID_OCTETS],
}

/// Kinds of identity, the more lasting ones later.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum IdKind {
    /// Of a flight.
    Session,
    /// Of a flight, by a traffic management.
    Traffic,
    /// Of the authority.
    Registration,
    /// Of the manufacturer (ANSI/CTA-2063).
    Serial,
}

/// Content of a Location. Unknown values are `None`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Location {
    pub(super) emergency: Emergency,
    pub(super) alerts: Alerts,
    pub(super) on_ground: bool,
    /// East and north, metres per second.
    pub(super) velocity: Option<[f64; 2]>,
    pub(super) velocity_covariance: Option<[f64; 3]>,
    pub(super) vertical_rate_mps: Option<f64>,
    /// Latitude and longitude, radians.
    pub(super) position: Option<[f64; 2]>,
    pub(super) pressure_altitude_m: Option<f64>,
    pub(super) ellipsoid_height_m: Option<f64>,
    pub(super) quality: Quality,
    /// Time since a full hour, nanoseconds.
    pub(super) since_hour_ns: Option<i64>,
}

impl Message {
    pub(super) fn read(octets: &[u8; MESSAGE_OCTETS]) -> Read<Self> {
        match octets[0] >> 4 {
            0 => Ok(Self::BasicId(DroneId::read(octets)?, category(octets[1] & 0xf))),
            1 => Location::read(octets).map(Self::Location),
            2 => Ok(Self::Authentication),
            3 => Ok(Self::SelfId),
            4 => position(octets, 2).map(Self::System),
            5 => Ok(Self::OperatorId),
            kind => Err(Refusal::new(RemoteIdReason::Kind, "type", kind)),
        }
    }
}

impl DroneId {
    fn read(message: &[u8; MESSAGE_OCTETS]) -> Read<Option<Self>> {
        let octets: [u8; ID_OCTETS] = part(message, 2);
        let kind = match message[1] >> 4 {
            1 => IdKind::Serial,
            2 => IdKind::Registration,
            3 => IdKind::Traffic,
            4 => IdKind::Session,
            _ => return Ok(None),
        };
        let id = Self { kind, octets };
        let is_text = || id.used().iter().all(|octet| octet.is_ascii_graphic() || *octet == b' ');
        if kind >= IdKind::Registration && !is_text() {
            return Err(Refusal::new(
                RemoteIdReason::Identity,
                "identity",
                octets.escape_ascii(),
            ));
        }
        Ok((!id.used().is_empty()).then_some(id))
    }

    /// The octets without the padding.
    fn used(&self) -> &[u8] {
        let end = self.octets.iter().rposition(|octet| ![0, b' '].contains(octet));
        &self.octets[..end.map_or(0, |last| last + 1)]
    }

    /// Number of the drone's track.
    pub(super) fn number(&self) -> u32 {
        number_of_name(self.used())
    }

    /// Name for readers, if the identity is a text.
    pub(super) fn name(&self) -> Option<&str> {
        let text = std::str::from_utf8(self.used()).ok();
        text.filter(|_| self.kind >= IdKind::Registration)
    }
}

impl Location {
    fn read(message: &[u8; MESSAGE_OCTETS]) -> Read<Self> {
        let flags = message[1];
        let status = flags >> 4;
        let altitude = |place: usize| {
            let half_metres = u16::from_le_bytes(part(message, place));
            (half_metres > 0).then(|| f64::from(half_metres) / 2.0 - 1000.0)
        };
        let vertical = message[4] as i8;
        let tenths = u16::from_le_bytes(part(message, 21));
        Ok(Self {
            emergency: match status {
                1 | 2 => Emergency::None,
                3 => Emergency::General,
                _ => Emergency::Unknown,
            },
            alerts: match status {
                1..=3 => Alerts::flag(alert_bits::EMERGENCY, status == 3),
                _ => Alerts::default(),
            },
            on_ground: status == 1,
            velocity: velocity(flags, message[2], message[3]),
            velocity_covariance: covariance_of_velocity_category(message[20] & 0xf),
            vertical_rate_mps: (-VERTICAL_MAX..=VERTICAL_MAX)
                .contains(&vertical)
                .then(|| f64::from(vertical) / 2.0),
            position: position(message, 5)?,
            pressure_altitude_m: altitude(13),
            ellipsoid_height_m: altitude(15),
            quality: match message[19] & 0xf {
                12 => Quality::Radius95(1.0),
                // Up to here the classes are those of aircraft.
                class => radius_of_nacp(class),
            },
            since_hour_ns: (tenths <= HOUR_TENTHS).then(|| i64::from(tenths) * (NS_PER_S / 10)),
        })
    }
}

/// East and north, metres per second. A drone at rest needs no direction.
fn velocity(flags: u8, direction: u8, speed: u8) -> Option<[f64; 2]> {
    let is_coarse = flags & 1 != 0;
    let is_west = flags & 2 != 0;
    let speed_mps = match (is_coarse, speed) {
        (true, u8::MAX) => return None,
        (true, _) => f64::from(speed) * 0.75 + f64::from(u8::MAX) * 0.25,
        (false, 0) => return Some([0.0; 2]),
        (false, _) => f64::from(speed) * 0.25,
    };
    let track_degrees = f64::from(direction) + if is_west { 180.0 } else { 0.0 };
    (direction <= 180).then(|| components([speed_mps, track_degrees.to_radians()]))
}

/// Latitude and longitude at a place, radians; both are zero if they are unknown.
fn position(message: &[u8; MESSAGE_OCTETS], place: usize) -> Read<Option<[f64; 2]>> {
    let [latitude, longitude] = [place, place + 4].map(|place| i32::from_le_bytes(part(message, place)));
    if latitude == 0 && longitude == 0 {
        return Ok(None);
    }
    let degrees = [latitude, longitude].map(|number| f64::from(number) * DEGREES);
    if degrees[0].abs() > 90.0 || degrees[1].abs() > 180.0 {
        let shown = format!("{} {}", degrees[0], degrees[1]);
        return Err(Refusal::new(RemoteIdReason::Position, "position", shown));
    }
    Ok(Some(degrees.map(f64::to_radians)))
}

/// Category by the type of the aircraft: all are unmanned, except an obstacle on the ground.
fn category(kind: u8) -> TargetCategory {
    match kind {
        14 => TargetCategory::Obstacle,
        _ => TargetCategory::Unmanned,
    }
}

/// Octets from a place on.
///
/// # Panics
/// If the message ends before; places are constants.
fn part<const COUNT: usize>(message: &[u8; MESSAGE_OCTETS], place: usize) -> [u8; COUNT] {
    std::array::from_fn(|at| message[place + at])
}
