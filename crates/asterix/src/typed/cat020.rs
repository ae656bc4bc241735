//! CAT020 ed 1.9 to 1.11: target reports of a multilateration system.
//!
//! What is read here lies in the same place in all of these editions.

use super::fields::*;
use crate::bits::u16_at;
use crate::categories::CAT020;
use crate::record::Record;
use crate::table::{Frn, Uap};
use item::*;

/// The field reference numbers of the items read here.
pub mod item {
    use super::{Frn, Uap};
    use crate::categories::CAT020_V1_11;

    const UAP: &Uap = CAT020_V1_11.uap();

    /// I020/010.
    pub const SOURCE: Frn = UAP.frn("010");
    /// I020/020.
    pub const DESCRIPTOR: Frn = UAP.frn("020");
    /// I020/140.
    pub const TIME_OF_DAY: Frn = UAP.frn("140");
    /// I020/041.
    pub const GEODETIC_POSITION: Frn = UAP.frn("041");
    /// I020/042.
    pub const CARTESIAN_POSITION: Frn = UAP.frn("042");
    /// I020/161.
    pub const TRACK_NUMBER: Frn = UAP.frn("161");
    /// I020/170.
    pub const TRACK_STATUS: Frn = UAP.frn("170");
    /// I020/070.
    pub const MODE_3A: Frn = UAP.frn("070");
    /// I020/202.
    pub const CARTESIAN_VELOCITY: Frn = UAP.frn("202");
    /// I020/090.
    pub const FLIGHT_LEVEL: Frn = UAP.frn("090");
    /// I020/220.
    pub const ADDRESS: Frn = UAP.frn("220");
    /// I020/245.
    pub const IDENTIFICATION: Frn = UAP.frn("245");
    /// I020/110.
    pub const MEASURED_HEIGHT: Frn = UAP.frn("110");
    /// I020/105.
    pub const GEOMETRIC_HEIGHT: Frn = UAP.frn("105");
    /// I020/210.
    pub const ACCELERATION: Frn = UAP.frn("210");
    /// I020/300.
    pub const VEHICLE_FLEET: Frn = UAP.frn("300");
    /// I020/500.
    pub const POSITION_ACCURACY: Frn = UAP.frn("500");
    /// I020/400.
    pub const CONTRIBUTING_DEVICES: Frn = UAP.frn("400");
    /// I020/230.
    pub const TRANSPONDER: Frn = UAP.frn("230");
    /// I020/260.
    pub const RESOLUTION_ADVISORY: Frn = UAP.frn("260");
}

/// I020/020: properties of a report. A flag whose extension octet was not sent is `false`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Descriptor {
    /// SSR: located by replies that are not Mode S.
    pub ssr: bool,
    /// MS: located by Mode S.
    pub mode_s: bool,
    /// RAB: a fixed transponder that monitors the system, no target.
    pub field_monitor: bool,
    /// SPI: special position identification.
    pub special_identification: bool,
    /// GBS: the transponder says it is on the ground.
    pub ground_bit: bool,
    /// CRT: replies were corrupted.
    pub corrupted: bool,
    /// SIM: simulated.
    pub simulated: bool,
    /// TST: a test target.
    pub test: bool,
}

impl Descriptor {
    fn new(item: &[u8]) -> Self {
        let first = item[0];
        let second = item.get(1).copied().unwrap_or(0);
        Self {
            ssr: first & 0x80 != 0,
            mode_s: first & 0x40 != 0,
            field_monitor: second & 0x80 != 0,
            special_identification: second & 0x40 != 0,
            ground_bit: second & 0x10 != 0,
            corrupted: second & 0x08 != 0,
            simulated: second & 0x04 != 0,
            test: second & 0x02 != 0,
        }
    }
}

/// I020/500 DOP: dilution of precision, without unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dilution {
    /// Along x.
    pub x: f64,
    /// Along y.
    pub y: f64,
    /// Of both.
    pub xy: f64,
}

/// I020/500 SDP: the sender's estimate of its horizontal position error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PositionDeviation {
    /// Standard deviation of x, in m.
    pub sigma_x_m: f64,
    /// Standard deviation of y, in m.
    pub sigma_y_m: f64,
    /// Correlation of x and y. Its LSB is 0.25, so it says little.
    pub correlation_xy: f64,
}

/// I020/500: how good a position is.
///
/// Some systems send the subitems with nothing or nonsense in them; a zero standard deviation means "not given".
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PositionAccuracy {
    /// DOP.
    pub dilution: Option<Dilution>,
    /// SDP.
    pub deviation: Option<PositionDeviation>,
    /// SDH: standard deviation of the geometric height, in m.
    pub sigma_height_m: Option<f64>,
}

impl PositionAccuracy {
    fn new(item: &[u8]) -> Self {
        let announced = item[0];
        // Further FSPEC octets announce nothing in this edition, but may be there.
        let fspec_octets = item.iter().take_while(|&octet| octet & 1 == 1).count() + 1;
        let mut rest = &item[fspec_octets..];
        let mut take = |bit: u8, octets: usize| {
            (announced & bit != 0).then(|| {
                let (subitem, behind) = rest.split_at(octets);
                rest = behind;
                subitem
            })
        };
        let quarters = |subitem: &[u8], at: usize| f64::from(u16_at(subitem, at)) * 0.25;
        Self {
            dilution: take(0x80, 6).map(|dop| Dilution {
                x: quarters(dop, 0),
                y: quarters(dop, 2),
                xy: quarters(dop, 4),
            }),
            deviation: take(0x40, 6).map(|sdp| PositionDeviation {
                sigma_x_m: quarters(sdp, 0),
                sigma_y_m: quarters(sdp, 2),
                correlation_xy: quarters(sdp, 4),
            }),
            sigma_height_m: take(0x20, 2).map(|sdh| f64::from(u16_at(sdh, 0)) * 0.5),
        }
    }
}

/// A target report.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TargetReport {
    /// I020/010.
    pub source: Option<Source>,
    /// I020/140.
    pub time_of_day: Option<TimeOfDay>,
    /// I020/020.
    pub descriptor: Option<Descriptor>,
    /// I020/041.
    pub geodetic_position: Option<GeodeticPosition>,
    /// I020/042, from the system's reference point.
    pub cartesian_position: Option<CartesianPosition>,
    /// I020/202.
    pub cartesian_velocity: Option<CartesianVelocity>,
    /// I020/210.
    pub acceleration: Option<CartesianAcceleration>,
    /// I020/161.
    pub track_number: Option<u16>,
    /// I020/170.
    pub track_status: Option<TrackStatus>,
    /// I020/070.
    pub mode_3a: Option<Mode3A>,
    /// I020/220: 24-bit address.
    pub address: Option<u32>,
    /// I020/245.
    pub identification: Option<Identification>,
    /// I020/300: code of the vehicle fleet.
    pub vehicle_fleet: Option<u8>,
    /// I020/090.
    pub flight_level: Option<FlightLevel>,
    /// I020/110, above the system's reference point, in m.
    pub measured_height_m: Option<f64>,
    /// I020/105, above the WGS-84 ellipsoid, in m.
    pub geometric_height_m: Option<f64>,
    /// I020/500.
    pub position_accuracy: Option<PositionAccuracy>,
    /// I020/400: how many receivers contributed.
    pub contributing_devices: Option<u32>,
    /// I020/230.
    pub transponder: Option<Transponder>,
    /// I020/260.
    pub resolution_advisory: Option<ResolutionAdvisory>,
}

impl TargetReport {
    /// Reads a target report; `None` for a record of another table.
    pub fn read(record: &Record<'_>) -> Option<Self> {
        record.table().is_one_of(CAT020).then_some(())?;
        Some(Self {
            source: record.item(SOURCE).map(source),
            time_of_day: record.item(TIME_OF_DAY).map(time_of_day),
            descriptor: record.item(DESCRIPTOR).map(Descriptor::new),
            geodetic_position: record
                .item(GEODETIC_POSITION)
                .map(|item| GeodeticPosition::from_32_bits(item, 25)),
            cartesian_position: record.item(CARTESIAN_POSITION).map(CartesianPosition::from_halves),
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
            geometric_height_m: record.item(GEOMETRIC_HEIGHT).map(height_m),
            position_accuracy: record.item(POSITION_ACCURACY).map(PositionAccuracy::new),
            contributing_devices: record
                .item(CONTRIBUTING_DEVICES)
                .map(|item| item[1..].iter().map(|octet| octet.count_ones()).sum()),
            transponder: record.item(TRANSPONDER).map(Transponder::new),
            resolution_advisory: record.item(RESOLUTION_ADVISORY).map(ResolutionAdvisory::new),
        })
    }
}

fn track_status(item: &[u8]) -> TrackStatus {
    let first = item[0];
    TrackStatus {
        tentative: first & 0x80 != 0,
        ended: first & 0x40 != 0,
        extrapolation: match first & 0x20 {
            0 => Extrapolation::None,
            _ => Extrapolation::Unstated,
        },
        manoeuvring: first & 0x04 != 0,
        smoothed: first & 0x02 != 0,
        ghost: item.get(1).is_some_and(|second| second & 0x80 != 0),
    }
}
