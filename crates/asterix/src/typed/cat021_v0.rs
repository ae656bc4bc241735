//! CAT021 ed 0.23 to 0.26: ADS-B target reports.
//!
//! From ed 0.24 on the position has 32 bits, and ed 0.26 has the Mode 3/A code.

use super::fields::*;
use crate::bits::{i16_at, u16_at};
use crate::categories::CAT021_V0;
use crate::record::Record;
use crate::table::{Frn, Uap};
use item::*;

/// The field reference numbers of the items read here.
pub mod item {
    use super::{Frn, Uap};
    use crate::categories::CAT021_V0_26;

    /// The last edition's: the items of the others have the same places in it.
    const UAP: &Uap = CAT021_V0_26.uap();

    /// I021/010.
    pub const SOURCE: Frn = UAP.frn("010");
    /// I021/040.
    pub const DESCRIPTOR: Frn = UAP.frn("040");
    /// I021/030.
    pub const TIME_OF_DAY: Frn = UAP.frn("030");
    /// I021/130.
    pub const GEODETIC_POSITION: Frn = UAP.frn("130");
    /// I021/080.
    pub const ADDRESS: Frn = UAP.frn("080");
    /// I021/140.
    pub const GEOMETRIC_ALTITUDE: Frn = UAP.frn("140");
    /// I021/090.
    pub const FIGURE_OF_MERIT: Frn = UAP.frn("090");
    /// I021/230.
    pub const ROLL_ANGLE: Frn = UAP.frn("230");
    /// I021/145.
    pub const FLIGHT_LEVEL: Frn = UAP.frn("145");
    /// I021/150.
    pub const AIR_SPEED: Frn = UAP.frn("150");
    /// I021/151.
    pub const TRUE_AIRSPEED: Frn = UAP.frn("151");
    /// I021/152.
    pub const MAGNETIC_HEADING: Frn = UAP.frn("152");
    /// I021/155.
    pub const BAROMETRIC_RATE: Frn = UAP.frn("155");
    /// I021/157.
    pub const GEOMETRIC_RATE: Frn = UAP.frn("157");
    /// I021/160.
    pub const GROUND_VECTOR: Frn = UAP.frn("160");
    /// I021/165.
    pub const RATE_OF_TURN: Frn = UAP.frn("165");
    /// I021/170.
    pub const CALLSIGN: Frn = UAP.frn("170");
    /// I021/095.
    pub const VELOCITY_ACCURACY: Frn = UAP.frn("095");
    /// I021/032.
    pub const TIME_ACCURACY: Frn = UAP.frn("032");
    /// I021/200.
    pub const TARGET_STATUS: Frn = UAP.frn("200");
    /// I021/020.
    pub const EMITTER_CATEGORY: Frn = UAP.frn("020");
    /// I021/070, of ed 0.26.
    pub const MODE_3A: Frn = UAP.frn("070");
}

/// I021/040 ATP: what the target address is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AddressType {
    /// Not unique.
    NotUnique,
    /// The 24-bit ICAO address of the aircraft.
    Icao,
    /// Of a surface vehicle.
    SurfaceVehicle,
    /// Chosen by the aircraft for privacy.
    Anonymous,
    /// A number without meaning in this edition.
    Reserved(u8),
}

/// I021/040: properties of a report.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Descriptor {
    /// GBS: the transponder says it is on the ground.
    pub ground_bit: bool,
    /// SIM: simulated.
    pub simulated: bool,
    /// TST: a test target.
    pub test: bool,
    /// RAB: a fixed transponder that monitors the system, no target.
    pub field_monitor: bool,
    /// SPI: special position identification.
    pub special_identification: bool,
    /// ATP.
    pub address_type: AddressType,
}

impl Descriptor {
    fn new(item: &[u8]) -> Self {
        Self {
            ground_bit: item[0] & 0x40 != 0,
            simulated: item[0] & 0x20 != 0,
            test: item[0] & 0x10 != 0,
            field_monitor: item[0] & 0x08 != 0,
            special_identification: item[0] & 0x02 != 0,
            address_type: match item[1] >> 5 {
                0 => AddressType::NotUnique,
                1 => AddressType::Icao,
                2 => AddressType::SurfaceVehicle,
                3 => AddressType::Anonymous,
                other => AddressType::Reserved(other),
            },
        }
    }
}

/// I021/090: what the aircraft says of its navigation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FigureOfMerit {
    /// AC: 0 unknown, 1 ACAS not operational, 2 operational.
    pub acas: u8,
    /// MN: 0 unknown, 1 multiple navigation not operational, 2 operational.
    pub multiple_navigation: u8,
    /// DC: 0 unknown, 1 differential correction, 2 none.
    pub differential_correction: u8,
    /// PA: navigational uncertainty category for position, 0 (unknown) to 9 (best), of the ADS-B MASPS DO-242.
    pub position_category: u8,
}

/// I021/150: an air speed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum AirSpeed {
    /// Indicated, in m/s.
    Indicated(f64),
    /// Mach number.
    Mach(f64),
}

/// A target report.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TargetReport {
    /// I021/010.
    pub source: Option<Source>,
    /// I021/030: when the position applied.
    pub time_of_day: Option<TimeOfDay>,
    /// I021/032: the largest error of the time, in s.
    pub time_accuracy_s: Option<f64>,
    /// I021/040.
    pub descriptor: Option<Descriptor>,
    /// I021/130.
    pub geodetic_position: Option<GeodeticPosition>,
    /// I021/080: 24-bit address.
    pub address: Option<u32>,
    /// I021/170. `None` also if the item has no letter or digit.
    pub callsign: Option<Callsign>,
    /// I021/090.
    pub figure_of_merit: Option<FigureOfMerit>,
    /// I021/095: navigational uncertainty category for velocity, 0 (unknown) to 4 (best).
    pub velocity_category: Option<u8>,
    /// I021/145: altitude in the standard atmosphere, in m.
    pub pressure_altitude_m: Option<f64>,
    /// I021/140: above the WGS-84 ellipsoid, in m.
    pub geometric_altitude_m: Option<f64>,
    /// I021/155: climb by pressure, in m/s.
    pub barometric_rate_m_s: Option<f64>,
    /// I021/157: climb by geometry, in m/s.
    pub geometric_rate_m_s: Option<f64>,
    /// I021/160.
    pub ground_vector: Option<PolarVelocity>,
    /// I021/150.
    pub air_speed: Option<AirSpeed>,
    /// I021/151, in m/s.
    pub true_airspeed_m_s: Option<f64>,
    /// I021/152: clockwise from magnetic north, in rad.
    pub magnetic_heading_rad: Option<f64>,
    /// I021/165: positive to the right, in rad/s. `None` also if only the direction of turn was sent.
    pub rate_of_turn_rad_s: Option<f64>,
    /// I021/230: positive right wing down, in rad.
    pub roll_angle_rad: Option<f64>,
    /// I021/020: 1 to 5 aircraft by weight, 10 rotorcraft, 20 emergency and 21 service vehicle.
    pub emitter_category: Option<u8>,
    /// I021/200.
    pub emergency: Option<Emergency>,
    /// I021/070, of ed 0.26.
    pub mode_3a: Option<Mode3A>,
}

impl TargetReport {
    /// Reads a target report; `None` for a record of another table.
    pub fn read(record: &Record<'_>) -> Option<Self> {
        record.table().is_one_of(CAT021_V0).then_some(())?;
        Some(Self {
            source: record.item(SOURCE).map(source),
            time_of_day: record.item(TIME_OF_DAY).map(time_of_day),
            time_accuracy_s: record.item(TIME_ACCURACY).map(|item| f64::from(item[0]) / 256.0),
            descriptor: record.item(DESCRIPTOR).map(Descriptor::new),
            geodetic_position: record.item(GEODETIC_POSITION).map(geodetic_position),
            address: record.item(ADDRESS).map(address),
            callsign: record.item(CALLSIGN).and_then(Callsign::from_six_bits),
            figure_of_merit: record.item(FIGURE_OF_MERIT).map(|item| FigureOfMerit {
                acas: item[0] >> 6,
                multiple_navigation: item[0] >> 4 & 0x03,
                differential_correction: item[0] >> 2 & 0x03,
                position_category: item[1] & 0x0F,
            }),
            velocity_category: record.item(VELOCITY_ACCURACY).map(|item| item[0]),
            pressure_altitude_m: record.item(FLIGHT_LEVEL).map(pressure_altitude_m),
            geometric_altitude_m: record.item(GEOMETRIC_ALTITUDE).map(height_m),
            barometric_rate_m_s: record.item(BAROMETRIC_RATE).map(vertical_rate_m_s),
            geometric_rate_m_s: record.item(GEOMETRIC_RATE).map(vertical_rate_m_s),
            ground_vector: record.item(GROUND_VECTOR).map(|item| PolarVelocity {
                speed_m_s: speed_m_s(f64::from(i16_at(item, 0))),
                track_rad: angle_rad(item, 2),
            }),
            air_speed: record.item(AIR_SPEED).map(air_speed),
            true_airspeed_m_s: record
                .item(TRUE_AIRSPEED)
                .map(|item| f64::from(u16_at(item, 0)) * KNOT_M_S),
            magnetic_heading_rad: record.item(MAGNETIC_HEADING).map(|item| angle_rad(item, 0)),
            rate_of_turn_rad_s: record.item(RATE_OF_TURN).and_then(rate_of_turn_rad_s),
            roll_angle_rad: record
                .item(ROLL_ANGLE)
                .map(|item| (f64::from(i16_at(item, 0)) * 0.01).to_radians()),
            emitter_category: record.item(EMITTER_CATEGORY).map(|item| item[0]),
            emergency: record.item(TARGET_STATUS).map(|item| Emergency::new(item[0])),
            mode_3a: record.item(MODE_3A).map(Mode3A::new),
        })
    }
}

/// Of 24 bits each in ed 0.23, of 32 later.
fn geodetic_position(item: &[u8]) -> GeodeticPosition {
    match item.len() {
        6 => GeodeticPosition::from_24_bits(item),
        _ => GeodeticPosition::from_32_bits(item, 25),
    }
}

fn air_speed(item: &[u8]) -> AirSpeed {
    let number = f64::from(u16_at(item, 0) & 0x7FFF);
    match item[0] & 0x80 {
        0 => AirSpeed::Indicated(speed_m_s(number)),
        _ => AirSpeed::Mach(number * 0.001),
    }
}

/// The second octet: seven bits in two's complement, LSB 0.25 °/s.
fn rate_of_turn_rad_s(item: &[u8]) -> Option<f64> {
    let quarters = (item.get(1)? & 0xFE) as i8 >> 1;
    Some((f64::from(quarters) * 0.25).to_radians())
}
