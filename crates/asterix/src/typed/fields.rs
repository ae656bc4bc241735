//! Fields that several categories share.
//!
//! Angles are in radians, azimuths and tracks clockwise from north in [0, 2π), lengths in metres, speeds in metres
//! per second. What "north", x and y refer to (the sensor, an airport's reference point) only the sender's
//! configuration tells.

use std::f64::consts::TAU;
use std::fmt;

use crate::bits::{bits, i16_at, i24_at, i32_at, u16_at, u24_at};
use crate::text::icao_character;

/// Metres in a nautical mile.
pub const NAUTICAL_MILE_M: f64 = 1852.0;
/// Metres in a foot.
pub const FOOT_M: f64 = 0.3048;
/// Metres in a flight level, 100 ft of pressure altitude.
pub const FLIGHT_LEVEL_M: f64 = 100.0 * FOOT_M;
/// Metres per second in a knot.
pub const KNOT_M_S: f64 = NAUTICAL_MILE_M / 3600.0;

/// Who sent the data, as numbered by the EUROCONTROL list of system area codes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Source {
    /// System area code; 0 for data local to an airport.
    pub sac: u8,
    /// System identification code.
    pub sic: u8,
}

/// Time since the last midnight UTC, in ticks of 1/128 s, as sent.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct TimeOfDay {
    /// Ticks of 1/128 s. A day has [`TICKS_PER_DAY`](Self::TICKS_PER_DAY); the field can hold more.
    pub ticks: u32,
}

impl TimeOfDay {
    /// Ticks in a second.
    pub const TICKS_PER_S: u32 = 128;
    /// Ticks in a day.
    pub const TICKS_PER_DAY: u32 = 86_400 * Self::TICKS_PER_S;

    /// The time in s, exactly.
    pub fn seconds(self) -> f64 {
        f64::from(self.ticks) / f64::from(Self::TICKS_PER_S)
    }
}

/// A position as range and azimuth from the sensor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PolarPosition {
    /// Distance in m; whether along the ground or straight to the target, the item says.
    pub range_m: f64,
    /// Clockwise from north, in rad.
    pub azimuth_rad: f64,
}

impl PolarPosition {
    /// A range in parts of a nautical mile, and an azimuth, of 16 bits each: I001/040 and I048/040.
    pub(super) fn from_nautical_miles(item: &[u8], parts: f64) -> Self {
        Self {
            range_m: f64::from(u16_at(item, 0)) * (NAUTICAL_MILE_M / parts),
            azimuth_rad: angle_rad(item, 2),
        }
    }
}

/// A position in a plane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CartesianPosition {
    /// To the east, in m.
    pub x_m: f64,
    /// To the north, in m.
    pub y_m: f64,
}

impl CartesianPosition {
    /// Two numbers of 16 bits in parts of a nautical mile: I001/042 and I048/042.
    pub(super) fn from_nautical_miles(item: &[u8], parts: f64) -> Self {
        Self {
            x_m: f64::from(i16_at(item, 0)) * (NAUTICAL_MILE_M / parts),
            y_m: f64::from(i16_at(item, 2)) * (NAUTICAL_MILE_M / parts),
        }
    }

    /// Two numbers of 24 bits, LSB 0.5 m: I020/042 and I062/100.
    pub(super) fn from_halves(item: &[u8]) -> Self {
        Self {
            x_m: f64::from(i24_at(item, 0)) * 0.5,
            y_m: f64::from(i24_at(item, 3)) * 0.5,
        }
    }
}

/// A position on the WGS-84 ellipsoid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GeodeticPosition {
    /// North positive, in rad.
    pub latitude_rad: f64,
    /// East positive, in rad.
    pub longitude_rad: f64,
}

impl GeodeticPosition {
    /// Two numbers of 24 bits, LSB 180/2^23 degrees.
    pub(super) fn from_24_bits(item: &[u8]) -> Self {
        let lsb_rad = std::f64::consts::PI / (1u64 << 23) as f64;
        Self {
            latitude_rad: f64::from(i24_at(item, 0)) * lsb_rad,
            longitude_rad: f64::from(i24_at(item, 3)) * lsb_rad,
        }
    }

    /// Two numbers of 32 bits, LSB 180/2^`exponent` degrees.
    pub(super) fn from_32_bits(item: &[u8], exponent: u32) -> Self {
        let lsb_rad = std::f64::consts::PI / (1u64 << exponent) as f64;
        Self {
            latitude_rad: f64::from(i32_at(item, 0)) * lsb_rad,
            longitude_rad: f64::from(i32_at(item, 4)) * lsb_rad,
        }
    }
}

/// A horizontal velocity as speed and track.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PolarVelocity {
    /// Ground speed in m/s.
    pub speed_m_s: f64,
    /// Direction of motion, clockwise from north, in rad.
    pub track_rad: f64,
}

impl PolarVelocity {
    /// Two numbers of 16 bits: I001/200, I010/200 and I048/200.
    pub(super) fn new(item: &[u8]) -> Self {
        Self {
            speed_m_s: speed_m_s(f64::from(u16_at(item, 0))),
            track_rad: angle_rad(item, 2),
        }
    }
}

/// A horizontal velocity by components.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CartesianVelocity {
    /// To the east, in m/s.
    pub vx_m_s: f64,
    /// To the north, in m/s.
    pub vy_m_s: f64,
}

impl CartesianVelocity {
    /// Two numbers of 16 bits, LSB 0.25 m/s: I010/202, I020/202 and I062/185.
    pub(super) fn from_quarters(item: &[u8]) -> Self {
        Self {
            vx_m_s: f64::from(i16_at(item, 0)) * 0.25,
            vy_m_s: f64::from(i16_at(item, 2)) * 0.25,
        }
    }
}

/// A horizontal acceleration by components.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CartesianAcceleration {
    /// To the east, in m/s².
    pub ax_m_s2: f64,
    /// To the north, in m/s².
    pub ay_m_s2: f64,
}

impl CartesianAcceleration {
    /// Two numbers of 8 bits, LSB 0.25 m/s²: I010/210, I020/210 and I062/210.
    pub(super) fn from_quarters(item: &[u8]) -> Self {
        Self {
            ax_m_s2: f64::from(item[0] as i8) * 0.25,
            ay_m_s2: f64::from(item[1] as i8) * 0.25,
        }
    }
}

/// A Mode 3/A code with what the receiver says of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Mode3A {
    /// The code, twelve bits: four octal digits.
    pub code: u16,
    /// V: the code was not validated.
    pub not_validated: bool,
    /// G: the reply was garbled, or corrected.
    pub garbled: bool,
    /// L: not from a reply of this update period.
    pub not_extracted: bool,
}

impl Mode3A {
    pub(super) fn new(item: &[u8]) -> Self {
        let number = u16_at(item, 0);
        Self {
            code: number & 0x0FFF,
            not_validated: number & 0x8000 != 0,
            garbled: number & 0x4000 != 0,
            not_extracted: number & 0x2000 != 0,
        }
    }
}

/// A pressure altitude with what the receiver says of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FlightLevel {
    /// Altitude in the standard atmosphere, in m.
    pub altitude_m: f64,
    /// V: the code was not validated.
    pub not_validated: bool,
    /// G: the reply was garbled, or corrected.
    pub garbled: bool,
}

impl FlightLevel {
    /// V, G and fourteen bits of quarter flight levels in two's complement: I001/090, I010/090, I020/090 and I048/090.
    pub(super) fn new(item: &[u8]) -> Self {
        let number = u16_at(item, 0);
        let quarters = ((number << 2) as i16) >> 2;
        Self {
            altitude_m: f64::from(quarters) * 0.25 * FLIGHT_LEVEL_M,
            not_validated: number & 0x8000 != 0,
            garbled: number & 0x4000 != 0,
        }
    }
}

/// A call sign or registration: eight characters, blanks at the end.
///
/// A code outside the six-bit alphabet is a `?`, which the alphabet does not have.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Callsign([u8; 8]);

impl Callsign {
    /// Eight characters of six bits. `None` if none of them is a letter or digit: the sender has no identification.
    pub(super) fn from_six_bits(six_octets: &[u8]) -> Option<Self> {
        let packed = bits(six_octets, 0, 48);
        let mut characters = [0; 8];
        for (i, character) in characters.iter_mut().enumerate() {
            *character = icao_character((packed >> (42 - 6 * i)) as u8).unwrap_or(b'?');
        }
        characters
            .iter()
            .any(u8::is_ascii_alphanumeric)
            .then_some(Self(characters))
    }

    /// All eight characters as sent.
    pub fn as_bytes(&self) -> &[u8; 8] {
        &self.0
    }

    /// The characters without the blanks at the end.
    pub fn as_str(&self) -> &str {
        std::str::from_utf8(&self.0)
            .expect("only ASCII is stored")
            .trim_end_matches(' ')
    }
}

impl fmt::Display for Callsign {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.as_str())
    }
}

impl fmt::Debug for Callsign {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Callsign({:?})", self.as_str())
    }
}

/// A call sign or registration, and where it came from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Identification {
    /// STI, two bits that tell call sign from registration and downlinked from entered on the ground. CAT010 and CAT020
    /// number them differently and senders mix them up: not to be relied on.
    pub origin: u8,
    /// The characters, if there are any.
    pub callsign: Option<Callsign>,
}

impl Identification {
    pub(super) fn new(item: &[u8]) -> Self {
        Self {
            origin: item[0] >> 6,
            callsign: Callsign::from_six_bits(&item[1..7]),
        }
    }
}

/// What a Mode S transponder says of its flight (STAT).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FlightStatus {
    /// An alert: the Mode 3/A code means an emergency, or was changed within the last seconds.
    pub alert: bool,
    /// Special position identification.
    pub special_identification: bool,
    /// Whether it is on the ground; `None` where it does not say.
    pub on_ground: Option<bool>,
}

impl FlightStatus {
    /// Three bits, as in the downlink formats.
    pub(super) fn new(status: u8) -> Self {
        let (alert, special_identification, on_ground) = match status & 0x07 {
            0 => (false, false, Some(false)),
            1 => (false, false, Some(true)),
            2 => (true, false, Some(false)),
            3 => (true, false, Some(true)),
            4 => (true, true, None),
            5 => (false, true, None),
            _ => (false, false, None),
        };
        Self {
            alert,
            special_identification,
            on_ground,
        }
    }
}

/// What a Mode S transponder can, and what it says of its flight: I020/230, I048/230 and I062/380 COM.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Transponder {
    /// COM: capability of communication, 0 (surveillance only) to 4.
    pub communications: u8,
    /// STAT.
    pub flight_status: FlightStatus,
    /// ARC: altitude is reported in steps of 25 ft, not of 100 ft.
    pub fine_altitude: bool,
}

impl Transponder {
    pub(super) fn new(item: &[u8]) -> Self {
        Self {
            communications: item[0] >> 5,
            flight_status: FlightStatus::new(item[0] >> 2),
            fine_altitude: item[1] & 0x40 != 0,
        }
    }
}

/// An emergency, as ADS-B and the systems that use it distinguish them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Emergency {
    /// None, or not reported.
    None,
    /// Of no stated kind.
    General,
    /// A medical flight.
    Medical,
    /// Little fuel left.
    MinimumFuel,
    /// Radio communication has failed.
    CommunicationFailure,
    /// Unlawful interference.
    UnlawfulInterference,
    /// The aircraft is down.
    Downed,
    /// A number without meaning.
    Undefined(u8),
}

impl Emergency {
    pub(super) fn new(number: u8) -> Self {
        match number {
            0 => Self::None,
            1 => Self::General,
            2 => Self::Medical,
            3 => Self::MinimumFuel,
            4 => Self::CommunicationFailure,
            5 => Self::UnlawfulInterference,
            6 => Self::Downed,
            other => Self::Undefined(other),
        }
    }
}

/// What a collision avoidance system advises its crew to do: BDS register 3,0 of ICAO Annex 10 volume IV, 4.3.8.4.2.2,
/// as I020/260, I021/260, I048/260 and I062/380 ACS hold it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ResolutionAdvisory {
    /// ARA: fourteen bits, the first of which says that there is one threat, or that all need the same sense.
    pub advisories: u16,
    /// RAT: the advisory has ended.
    pub terminated: bool,
    /// MTE: more than one threat.
    pub multiple_threats: bool,
}

impl ResolutionAdvisory {
    /// Seven octets, of which the first names the register or the message.
    pub(super) fn new(item: &[u8]) -> Self {
        Self {
            advisories: u16_at(item, 1) >> 2,
            terminated: item[3] & 0x20 != 0,
            multiple_threats: item[3] & 0x10 != 0,
        }
    }

    /// Whether it holds now: there is an advisory, and it has not ended.
    pub fn is_active(&self) -> bool {
        const FIRST: u16 = 1 << 13;
        !self.terminated && (self.advisories & FIRST != 0 || self.multiple_threats)
    }
}

/// A register of a Mode S transponder, as it was read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Register {
    /// BDS number: 0x50 is register 5,0.
    pub number: u8,
    /// Its 56 bits.
    pub content: [u8; 7],
}

impl Register {
    /// A repetitive item's registers: I048/250.
    pub(super) fn all(item: &[u8]) -> impl Iterator<Item = Self> + use<'_> {
        item[1..].chunks_exact(8).map(|octets| Self {
            number: octets[7],
            content: std::array::from_fn(|i| octets[i]),
        })
    }
}

/// What a report's position is, if not measured just now (CST).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Extrapolation {
    /// Measured.
    None,
    /// Extrapolated, for no stated reason.
    Unstated,
    /// Extrapolated as the sensor does not see the whole area in each update period.
    BetweenScans,
    /// Extrapolated through an area the sensor can not see.
    MaskedArea,
    /// Extrapolated because the target was unexpectedly not detected.
    NotDetected,
}

/// What a sensor's tracker says of its track.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TrackStatus {
    /// CNF: still being initialised; otherwise confirmed.
    pub tentative: bool,
    /// TRE: the last report of this track; its number may be given to another.
    pub ended: bool,
    /// CST: whether and why the position is extrapolated.
    pub extrapolation: Extrapolation,
    /// MAH: a horizontal manoeuvre.
    pub manoeuvring: bool,
    /// STH: the position is smoothed; otherwise measured.
    pub smoothed: bool,
    /// GHO: probably no real target; `false` if the sender does not say.
    pub ghost: bool,
}

/// Whether a system may be used (NOGO).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Availability {
    /// In operation.
    Operational,
    /// In operation with restrictions.
    Degraded,
    /// Not to be used.
    Unusable,
    /// The system does not say.
    Undefined,
}

impl Availability {
    /// Two bits.
    pub(super) fn new(number: u8) -> Self {
        match number {
            0 => Self::Operational,
            1 => Self::Degraded,
            2 => Self::Unusable,
            _ => Self::Undefined,
        }
    }
}

/// The state of a sensor system.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SystemStatus {
    /// NOGO.
    pub availability: Availability,
    /// OVL: some targets may be missing.
    pub overloaded: bool,
    /// TSV: time stamps are not to be trusted.
    pub time_source_invalid: bool,
    /// TTF: a test target was not detected.
    pub test_target_failed: bool,
}

impl SystemStatus {
    /// NOGO, OVL and TSV, which all categories have in the same place, and the bit of TTF.
    pub(super) fn new(octet: u8, test_target_bit: u8) -> Self {
        Self {
            availability: Availability::new(octet >> 6),
            overloaded: octet & 0x20 != 0,
            time_source_invalid: octet & 0x10 != 0,
            test_target_failed: octet & test_target_bit != 0,
        }
    }
}

pub(super) fn source(item: &[u8]) -> Source {
    Source {
        sac: item[0],
        sic: item[1],
    }
}

pub(super) fn time_of_day(item: &[u8]) -> TimeOfDay {
    TimeOfDay { ticks: u24_at(item, 0) }
}

pub(super) fn address(item: &[u8]) -> u32 {
    u24_at(item, 0)
}

/// A full circle in 2^8 steps, in rad: I002/020 and I034/020.
pub(super) fn sector_azimuth_rad(item: &[u8]) -> f64 {
    f64::from(item[0]) * (TAU / 256.0)
}

/// Sixteen bits, LSB 1/128 s, in s: I002/041 and I034/041.
pub(super) fn period_s(item: &[u8]) -> f64 {
    f64::from(u16_at(item, 0)) / 128.0
}

/// Sixteen bits, LSB 6.25 ft/min, in m/s.
pub(super) fn vertical_rate_m_s(item: &[u8]) -> f64 {
    f64::from(i16_at(item, 0)) * (6.25 * FOOT_M / 60.0)
}

/// An octet of an extended item, zero if it was not sent.
pub(super) fn extension(item: &[u8], at: usize) -> u8 {
    item.get(at).copied().unwrap_or(0)
}

/// The low twelve bits of two octets.
pub(super) fn track_number(item: &[u8]) -> u16 {
    u16_at(item, 0) & 0x0FFF
}

/// Sixteen bits, LSB 6.25 ft, in m.
pub(super) fn height_m(item: &[u8]) -> f64 {
    f64::from(i16_at(item, 0)) * (6.25 * FOOT_M)
}

/// Sixteen bits of quarter flight levels in two's complement, in m: I021/145 and I062/136.
pub(super) fn pressure_altitude_m(item: &[u8]) -> f64 {
    f64::from(i16_at(item, 0)) * (0.25 * FLIGHT_LEVEL_M)
}

/// A full circle in 2^16 steps, in rad.
pub(super) fn angle_rad(item: &[u8], at: usize) -> f64 {
    f64::from(u16_at(item, at)) * (TAU / 65_536.0)
}

/// Speed without sign, LSB 2^-14 NM/s, in m/s.
pub(super) fn speed_m_s(number: f64) -> f64 {
    number * (NAUTICAL_MILE_M / 16_384.0)
}
