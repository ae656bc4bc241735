//! CAT010 ed 1.1: reports and service messages of a surface movement radar or multilateration system.

use std::f64::consts::TAU;

use super::fields::*;
use crate::bits::{i16_at, u16_at};
use crate::categories::CAT010_V1_1;
use crate::record::Record;
use crate::table::{Frn, Uap};
use item::*;

/// The field reference numbers of the items read here.
pub mod item {
    use super::{CAT010_V1_1, Frn, Uap};

    const UAP: &Uap = CAT010_V1_1.uap();

    /// I010/010.
    pub const SOURCE: Frn = UAP.frn("010");
    /// I010/000.
    pub const MESSAGE_TYPE: Frn = UAP.frn("000");
    /// I010/020.
    pub const DESCRIPTOR: Frn = UAP.frn("020");
    /// I010/140.
    pub const TIME_OF_DAY: Frn = UAP.frn("140");
    /// I010/041.
    pub const GEODETIC_POSITION: Frn = UAP.frn("041");
    /// I010/040.
    pub const POLAR_POSITION: Frn = UAP.frn("040");
    /// I010/042.
    pub const CARTESIAN_POSITION: Frn = UAP.frn("042");
    /// I010/200.
    pub const POLAR_VELOCITY: Frn = UAP.frn("200");
    /// I010/202.
    pub const CARTESIAN_VELOCITY: Frn = UAP.frn("202");
    /// I010/161.
    pub const TRACK_NUMBER: Frn = UAP.frn("161");
    /// I010/170.
    pub const TRACK_STATUS: Frn = UAP.frn("170");
    /// I010/060.
    pub const MODE_3A: Frn = UAP.frn("060");
    /// I010/220.
    pub const ADDRESS: Frn = UAP.frn("220");
    /// I010/245.
    pub const IDENTIFICATION: Frn = UAP.frn("245");
    /// I010/300.
    pub const VEHICLE_FLEET: Frn = UAP.frn("300");
    /// I010/090.
    pub const FLIGHT_LEVEL: Frn = UAP.frn("090");
    /// I010/091.
    pub const MEASURED_HEIGHT: Frn = UAP.frn("091");
    /// I010/270.
    pub const SIZE: Frn = UAP.frn("270");
    /// I010/550.
    pub const SYSTEM_STATUS: Frn = UAP.frn("550");
    /// I010/500.
    pub const POSITION_DEVIATION: Frn = UAP.frn("500");
    /// I010/131.
    pub const PLOT_AMPLITUDE: Frn = UAP.frn("131");
    /// I010/210.
    pub const ACCELERATION: Frn = UAP.frn("210");
}

/// I010/000: what a record is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MessageType {
    /// A target report.
    TargetReport,
    /// A new update cycle begins; for a radar, a turn of the antenna.
    StartOfUpdateCycle,
    /// The state of the system, sent regularly.
    PeriodicStatus,
    /// The state of the system, sent as it changed.
    EventStatus,
    /// A number without meaning in this edition.
    Undefined(u8),
}

impl MessageType {
    /// The type of a record; `None` if it is not of this table or lacks the item.
    pub fn read(record: &Record<'_>) -> Option<Self> {
        record.table().is_one_of(&[&CAT010_V1_1]).then_some(())?;
        record.item(MESSAGE_TYPE).map(|item| match item[0] {
            1 => Self::TargetReport,
            2 => Self::StartOfUpdateCycle,
            3 => Self::PeriodicStatus,
            4 => Self::EventStatus,
            other => Self::Undefined(other),
        })
    }
}

/// I010/020 TYP: how a target was detected.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Detection {
    /// Multilateration of replies to secondary radar.
    SsrMultilateration,
    /// Multilateration of Mode S.
    ModeSMultilateration,
    /// ADS-B.
    AdsB,
    /// Primary radar.
    PrimaryRadar,
    /// Magnetic loops.
    MagneticLoop,
    /// HF multilateration.
    HfMultilateration,
    /// Undefined or other.
    Other,
}

/// I010/020 TOT: what was detected.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TargetKind {
    /// Not known.
    Undetermined,
    /// An aircraft.
    Aircraft,
    /// A vehicle.
    GroundVehicle,
    /// A helicopter.
    Helicopter,
}

/// I010/020: properties of a report. A flag whose extension octet was not sent is `false`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Descriptor {
    /// TYP.
    pub detection: Detection,
    /// GBS: the transponder says it is on the ground.
    pub ground_bit: bool,
    /// CRT: replies were corrupted.
    pub corrupted: bool,
    /// SIM: simulated.
    pub simulated: bool,
    /// TST: a test target.
    pub test: bool,
    /// RAB: a fixed transponder that monitors the system, no target.
    pub field_monitor: bool,
    /// TOT.
    pub kind: TargetKind,
    /// SPI: special position identification.
    pub special_identification: bool,
}

impl Descriptor {
    fn new(item: &[u8]) -> Self {
        let (first, second, third) = (item[0], extension(item, 1), extension(item, 2));
        Self {
            detection: match first >> 5 {
                0 => Detection::SsrMultilateration,
                1 => Detection::ModeSMultilateration,
                2 => Detection::AdsB,
                3 => Detection::PrimaryRadar,
                4 => Detection::MagneticLoop,
                5 => Detection::HfMultilateration,
                _ => Detection::Other,
            },
            ground_bit: first & 0x04 != 0,
            corrupted: first & 0x02 != 0,
            simulated: second & 0x80 != 0,
            test: second & 0x40 != 0,
            field_monitor: second & 0x20 != 0,
            kind: match second >> 1 & 0x03 {
                0 => TargetKind::Undetermined,
                1 => TargetKind::Aircraft,
                2 => TargetKind::GroundVehicle,
                _ => TargetKind::Helicopter,
            },
            special_identification: third & 0x80 != 0,
        }
    }
}

/// I010/270: the size of the echo.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TargetSize {
    /// In m.
    pub length_m: f64,
    /// Where the nose points, clockwise from geographical north, in rad.
    pub orientation_rad: Option<f64>,
    /// In m.
    pub width_m: Option<f64>,
}

impl TargetSize {
    fn new(item: &[u8]) -> Self {
        let seven_bits = |at: usize| item.get(at).map(|octet| f64::from(octet >> 1));
        Self {
            length_m: seven_bits(0).unwrap_or(0.0),
            orientation_rad: seven_bits(1).map(|number| number * (TAU / 128.0)),
            width_m: seven_bits(2),
        }
    }
}

/// I010/500: the sender's estimate of its position error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PositionDeviation {
    /// Standard deviation of x, in m.
    pub sigma_x_m: f64,
    /// Standard deviation of y, in m.
    pub sigma_y_m: f64,
    /// Covariance of x and y, in m².
    pub covariance_xy_m2: f64,
}

/// A target report.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TargetReport {
    /// I010/010.
    pub source: Option<Source>,
    /// I010/140.
    pub time_of_day: Option<TimeOfDay>,
    /// I010/020.
    pub descriptor: Option<Descriptor>,
    /// I010/040, from the sensor.
    pub polar_position: Option<PolarPosition>,
    /// I010/042, from the system's reference point. A coordinate of 32,767 m may stand for any larger one.
    pub cartesian_position: Option<CartesianPosition>,
    /// I010/041.
    pub geodetic_position: Option<GeodeticPosition>,
    /// I010/200.
    pub polar_velocity: Option<PolarVelocity>,
    /// I010/202.
    pub cartesian_velocity: Option<CartesianVelocity>,
    /// I010/210.
    pub acceleration: Option<CartesianAcceleration>,
    /// I010/161.
    pub track_number: Option<u16>,
    /// I010/170.
    pub track_status: Option<TrackStatus>,
    /// I010/060.
    pub mode_3a: Option<Mode3A>,
    /// I010/220: 24-bit address.
    pub address: Option<u32>,
    /// I010/245.
    pub identification: Option<Identification>,
    /// I010/300: code of the vehicle fleet.
    pub vehicle_fleet: Option<u8>,
    /// I010/090.
    pub flight_level: Option<FlightLevel>,
    /// I010/091, above the local plane, in m.
    pub measured_height_m: Option<f64>,
    /// I010/270.
    pub size: Option<TargetSize>,
    /// I010/500.
    pub position_deviation: Option<PositionDeviation>,
    /// I010/131: amplitude of the primary plot, in the radar's own unit.
    pub plot_amplitude: Option<u8>,
}

impl TargetReport {
    /// Reads a target report; `None` for any other record.
    pub fn read(record: &Record<'_>) -> Option<Self> {
        if MessageType::read(record)? != MessageType::TargetReport {
            return None;
        }
        Some(Self {
            source: record.item(SOURCE).map(source),
            time_of_day: record.item(TIME_OF_DAY).map(time_of_day),
            descriptor: record.item(DESCRIPTOR).map(Descriptor::new),
            polar_position: record.item(POLAR_POSITION).map(|item| PolarPosition {
                range_m: f64::from(u16_at(item, 0)),
                azimuth_rad: angle_rad(item, 2),
            }),
            cartesian_position: record.item(CARTESIAN_POSITION).map(|item| CartesianPosition {
                x_m: f64::from(i16_at(item, 0)),
                y_m: f64::from(i16_at(item, 2)),
            }),
            geodetic_position: record
                .item(GEODETIC_POSITION)
                .map(|item| GeodeticPosition::from_32_bits(item, 31)),
            polar_velocity: record.item(POLAR_VELOCITY).map(PolarVelocity::new),
            cartesian_velocity: record.item(CARTESIAN_VELOCITY).map(CartesianVelocity::from_quarters),
            acceleration: record.item(ACCELERATION).map(CartesianAcceleration::from_quarters),
            track_number: record.item(TRACK_NUMBER).map(track_number),
            track_status: record.item(TRACK_STATUS).map(track_status),
            mode_3a: record.item(MODE_3A).map(Mode3A::new),
            address: record.item(ADDRESS).map(address),
            identification: record.item(IDENTIFICATION).map(Identification::new),
            vehicle_fleet: record.item(VEHICLE_FLEET).map(|item| item[0]),
            flight_level: record.item(FLIGHT_LEVEL).map(FlightLevel::new),
            measured_height_m: record.item(MEASURED_HEIGHT).map(height_m),
            size: record.item(SIZE).map(TargetSize::new),
            position_deviation: record.item(POSITION_DEVIATION).map(|item| PositionDeviation {
                sigma_x_m: f64::from(item[0]) * 0.25,
                sigma_y_m: f64::from(item[1]) * 0.25,
                covariance_xy_m2: f64::from(i16_at(item, 2)) * 0.25,
            }),
            plot_amplitude: record.item(PLOT_AMPLITUDE).map(|item| item[0]),
        })
    }
}

/// A record about the system itself: message types 2 to 4.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ServiceMessage {
    /// I010/000.
    pub message_type: MessageType,
    /// I010/010.
    pub source: Option<Source>,
    /// I010/140.
    pub time_of_day: Option<TimeOfDay>,
    /// I010/550.
    pub system_status: Option<SystemStatus>,
}

impl ServiceMessage {
    /// Reads a service message; `None` for any other record.
    pub fn read(record: &Record<'_>) -> Option<Self> {
        let message_type = MessageType::read(record)?;
        if matches!(message_type, MessageType::TargetReport | MessageType::Undefined(_)) {
            return None;
        }
        Some(Self {
            message_type,
            source: record.item(SOURCE).map(source),
            time_of_day: record.item(TIME_OF_DAY).map(time_of_day),
            system_status: record.item(SYSTEM_STATUS).map(|item| SystemStatus::new(item[0], 0x04)),
        })
    }
}

fn track_status(item: &[u8]) -> TrackStatus {
    let first = item[0];
    TrackStatus {
        tentative: first & 0x80 != 0,
        ended: first & 0x40 != 0,
        extrapolation: match first >> 4 & 0x03 {
            0 => Extrapolation::None,
            1 => Extrapolation::BetweenScans,
            2 => Extrapolation::MaskedArea,
            _ => Extrapolation::NotDetected,
        },
        manoeuvring: first & 0x08 != 0,
        smoothed: first & 0x02 != 0,
        ghost: extension(item, 2) & 0x80 != 0,
    }
}
