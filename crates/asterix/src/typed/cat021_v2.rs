//! CAT021 ed 2.1 to 2.7: ADS-B target reports.
//!
//! What is read here lies in the same place in all of these editions. The military emergency of I021/200 came in with
//! ed 2.2 and the list look-up of I021/040 with ed 2.3; before, their bits were spare, and the flags are `false`.

use super::fields::*;
use crate::bits::{i16_at, u16_at};
use crate::categories::CAT021_V2;
use crate::record::Record;
use crate::table::{Edition, Frn, Uap};
use item::*;

/// The field reference numbers of the items read here.
pub mod item {
    use super::{Frn, Uap};
    use crate::categories::CAT021_V2_7;

    const UAP: &Uap = CAT021_V2_7.uap();

    /// I021/010.
    pub const SOURCE: Frn = UAP.frn("010");
    /// I021/040.
    pub const DESCRIPTOR: Frn = UAP.frn("040");
    /// I021/161.
    pub const TRACK_NUMBER: Frn = UAP.frn("161");
    /// I021/015.
    pub const SERVICE: Frn = UAP.frn("015");
    /// I021/071.
    pub const POSITION_TIME: Frn = UAP.frn("071");
    /// I021/130.
    pub const GEODETIC_POSITION: Frn = UAP.frn("130");
    /// I021/131.
    pub const FINE_GEODETIC_POSITION: Frn = UAP.frn("131");
    /// I021/072.
    pub const VELOCITY_TIME: Frn = UAP.frn("072");
    /// I021/080.
    pub const ADDRESS: Frn = UAP.frn("080");
    /// I021/073.
    pub const POSITION_RECEPTION: Frn = UAP.frn("073");
    /// I021/074.
    pub const POSITION_RECEPTION_FRACTION: Frn = UAP.frn("074");
    /// I021/075.
    pub const VELOCITY_RECEPTION: Frn = UAP.frn("075");
    /// I021/076.
    pub const VELOCITY_RECEPTION_FRACTION: Frn = UAP.frn("076");
    /// I021/140.
    pub const GEOMETRIC_HEIGHT: Frn = UAP.frn("140");
    /// I021/090.
    pub const QUALITY: Frn = UAP.frn("090");
    /// I021/210.
    pub const VERSION: Frn = UAP.frn("210");
    /// I021/070.
    pub const MODE_3A: Frn = UAP.frn("070");
    /// I021/145.
    pub const FLIGHT_LEVEL: Frn = UAP.frn("145");
    /// I021/200.
    pub const TARGET_STATUS: Frn = UAP.frn("200");
    /// I021/155.
    pub const BAROMETRIC_RATE: Frn = UAP.frn("155");
    /// I021/157.
    pub const GEOMETRIC_RATE: Frn = UAP.frn("157");
    /// I021/160.
    pub const GROUND_VECTOR: Frn = UAP.frn("160");
    /// I021/077.
    pub const TRANSMISSION: Frn = UAP.frn("077");
    /// I021/170.
    pub const CALLSIGN: Frn = UAP.frn("170");
    /// I021/020.
    pub const EMITTER_CATEGORY: Frn = UAP.frn("020");
    /// I021/008.
    pub const OPERATIONAL_STATUS: Frn = UAP.frn("008");
    /// I021/260.
    pub const RESOLUTION_ADVISORY: Frn = UAP.frn("260");
}

/// I021/040 ATP: what the target address is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AddressType {
    /// The 24-bit ICAO address of the aircraft.
    Icao,
    /// One that several transmitters use.
    Duplicate,
    /// Of a surface vehicle.
    SurfaceVehicle,
    /// Chosen by the aircraft for privacy.
    Anonymous,
    /// A number without meaning.
    Reserved(u8),
}

/// I021/040: properties of a report. A flag whose extension octet was not sent is `false`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Descriptor {
    /// ATP.
    pub address_type: AddressType,
    /// RAB: a fixed transponder that monitors the system, no target.
    pub field_monitor: bool,
    /// GBS: the transponder says it is on the ground.
    pub ground_bit: bool,
    /// SIM: simulated.
    pub simulated: bool,
    /// TST: a test target.
    pub test: bool,
    /// CL: the ground station suspects the report; the reasons follow.
    pub suspect: bool,
    /// LLC: the address is on a list of suspects, or not on one of known targets.
    pub list_failed: bool,
    /// IPC: the position is not where other means see the target.
    pub position_check_failed: bool,
    /// NOGO: the ground station is not to be used.
    pub unreleased: bool,
    /// CPR: the two ways to decode the position disagree.
    pub decoding_failed: bool,
    /// LDPJ: the position jumped.
    pub jumped: bool,
    /// RCF: the position is beyond the station's range.
    pub range_check_failed: bool,
}

impl Descriptor {
    fn new(item: &[u8], edition: Edition) -> Self {
        let (first, second, third) = (item[0], extension(item, 1), extension(item, 2));
        Self {
            address_type: match first >> 5 {
                0 => AddressType::Icao,
                1 => AddressType::Duplicate,
                2 => AddressType::SurfaceVehicle,
                3 => AddressType::Anonymous,
                other => AddressType::Reserved(other),
            },
            field_monitor: first & 0x02 != 0,
            ground_bit: second & 0x40 != 0,
            simulated: second & 0x20 != 0,
            test: second & 0x10 != 0,
            suspect: second >> 1 & 0x03 == 1,
            list_failed: edition >= Edition::new(2, 3) && third & 0x40 != 0,
            position_check_failed: third & 0x20 != 0,
            unreleased: third & 0x10 != 0,
            decoding_failed: third & 0x08 != 0,
            jumped: third & 0x04 != 0,
            range_check_failed: third & 0x02 != 0,
        }
    }
}

/// I021/074 or 076: the fraction of the second in which a message was received.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FineTime {
    /// FSI: the whole second is that of I021/073 or 075 plus this, −1, 0 or 1; `None` for a number without meaning.
    pub second: Option<i8>,
    /// In units of 2^−30 s.
    pub fraction: u32,
}

impl FineTime {
    fn new(item: &[u8]) -> Self {
        let number = u32::from_be_bytes([item[0], item[1], item[2], item[3]]);
        Self {
            second: match number >> 30 {
                0 => Some(0),
                1 => Some(1),
                2 => Some(-1),
                _ => None,
            },
            fraction: number & 0x3FFF_FFFF,
        }
    }
}

/// I021/090: how good position and velocity are, as categories of the link's standard in the version of I021/210. What
/// is in an octet that was not sent is `None`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct QualityIndicators {
    /// NUCr or NACv: category for velocity.
    pub velocity_category: u8,
    /// NUCp (version 0) or NIC: category for position or for its integrity.
    pub integrity_category: u8,
    /// SIL: how improbable it is that the integrity does not hold.
    pub integrity_level: Option<u8>,
    /// NACp: accuracy category for position.
    pub accuracy_category: Option<u8>,
    /// GVA: geometric altitude accuracy.
    pub altitude_accuracy: Option<u8>,
    /// PIC: integrity category for position, the same for all versions.
    pub containment_category: Option<u8>,
}

impl QualityIndicators {
    fn new(item: &[u8]) -> Self {
        let octet = |at: usize| item.get(at).copied();
        Self {
            velocity_category: item[0] >> 5,
            integrity_category: item[0] >> 1 & 0x0F,
            integrity_level: octet(1).map(|second| second >> 5 & 0x03),
            accuracy_category: octet(1).map(|second| second >> 1 & 0x0F),
            altitude_accuracy: octet(2).map(|third| third >> 1 & 0x03),
            containment_category: octet(3).map(|fourth| fourth >> 4),
        }
    }
}

/// I021/200 SS: what the transponder says of its Mode 3/A code.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SurveillanceStatus {
    /// Nothing.
    None,
    /// The code means an emergency.
    PermanentAlert,
    /// The code was changed.
    TemporaryAlert,
    /// Special position identification.
    SpecialIdentification,
}

/// I021/200.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TargetStatus {
    /// PS.
    pub emergency: Emergency,
    /// ME: military emergency.
    pub military_emergency: bool,
    /// SS.
    pub surveillance: SurveillanceStatus,
}

impl TargetStatus {
    fn new(item: &[u8], edition: Edition) -> Self {
        Self {
            emergency: Emergency::new(item[0] >> 2 & 0x07),
            military_emergency: edition >= Edition::new(2, 2) && item[0] & 0x20 != 0,
            surveillance: match item[0] & 0x03 {
                0 => SurveillanceStatus::None,
                1 => SurveillanceStatus::PermanentAlert,
                2 => SurveillanceStatus::TemporaryAlert,
                _ => SurveillanceStatus::SpecialIdentification,
            },
        }
    }
}

/// A target report.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TargetReport {
    /// I021/010.
    pub source: Option<Source>,
    /// I021/015: the service of the ground station.
    pub service: Option<u8>,
    /// I021/071: when the position applied.
    pub position_time: Option<TimeOfDay>,
    /// I021/073: when the position was received.
    pub position_reception: Option<TimeOfDay>,
    /// I021/074: the same time within its second.
    pub position_reception_fraction: Option<FineTime>,
    /// I021/072: when the velocity applied.
    pub velocity_time: Option<TimeOfDay>,
    /// I021/075: when the velocity was received.
    pub velocity_reception: Option<TimeOfDay>,
    /// I021/076: the same time within its second.
    pub velocity_reception_fraction: Option<FineTime>,
    /// I021/077: when the report was sent.
    pub transmission: Option<TimeOfDay>,
    /// I021/040.
    pub descriptor: Option<Descriptor>,
    /// I021/131, else the coarser I021/130.
    pub geodetic_position: Option<GeodeticPosition>,
    /// I021/080: 24-bit address.
    pub address: Option<u32>,
    /// I021/161.
    pub track_number: Option<u16>,
    /// I021/170. `None` also if the item has no letter or digit.
    pub callsign: Option<Callsign>,
    /// I021/070: twelve bits, four octal digits.
    pub mode_3a: Option<u16>,
    /// I021/145: altitude in the standard atmosphere, in m.
    pub pressure_altitude_m: Option<f64>,
    /// I021/140: above the WGS-84 ellipsoid, in m. `None` also if only said to be greater than can be sent.
    pub geometric_height_m: Option<f64>,
    /// I021/155: climb by pressure, in m/s. `None` also if beyond what can be sent; so the next two.
    pub barometric_rate_m_s: Option<f64>,
    /// I021/157: climb by geometry, in m/s.
    pub geometric_rate_m_s: Option<f64>,
    /// I021/160: towards true north at the aircraft.
    pub ground_vector: Option<PolarVelocity>,
    /// I021/090.
    pub quality: Option<QualityIndicators>,
    /// I021/210 VN: 0 DO-260, 1 DO-260A, 2 DO-260B, 3 DO-260C.
    pub version: Option<u8>,
    /// I021/200.
    pub target_status: Option<TargetStatus>,
    /// I021/008 RA: a resolution advisory is active.
    pub advised: Option<bool>,
    /// I021/260.
    pub resolution_advisory: Option<ResolutionAdvisory>,
    /// I021/020: 1 to 6 aircraft by weight, 10 rotorcraft, 20 emergency and 21 service vehicle.
    pub emitter_category: Option<u8>,
}

impl TargetReport {
    /// Reads a target report; `None` for a record of another table.
    pub fn read(record: &Record<'_>) -> Option<Self> {
        record.table().is_one_of(CAT021_V2).then_some(())?;
        let edition = record.table().edition;
        let time = |frn: Frn| record.item(frn).map(time_of_day);
        Some(Self {
            source: record.item(SOURCE).map(source),
            service: record.item(SERVICE).map(|item| item[0]),
            position_time: time(POSITION_TIME),
            position_reception: time(POSITION_RECEPTION),
            position_reception_fraction: record.item(POSITION_RECEPTION_FRACTION).map(FineTime::new),
            velocity_time: time(VELOCITY_TIME),
            velocity_reception: time(VELOCITY_RECEPTION),
            velocity_reception_fraction: record.item(VELOCITY_RECEPTION_FRACTION).map(FineTime::new),
            transmission: time(TRANSMISSION),
            descriptor: record.item(DESCRIPTOR).map(|item| Descriptor::new(item, edition)),
            geodetic_position: record
                .item(FINE_GEODETIC_POSITION)
                .map(|item| GeodeticPosition::from_32_bits(item, 30))
                .or_else(|| record.item(GEODETIC_POSITION).map(GeodeticPosition::from_24_bits)),
            address: record.item(ADDRESS).map(address),
            track_number: record.item(TRACK_NUMBER).map(track_number),
            callsign: record.item(CALLSIGN).and_then(Callsign::from_six_bits),
            mode_3a: record.item(MODE_3A).map(|item| u16_at(item, 0) & 0x0FFF),
            pressure_altitude_m: record.item(FLIGHT_LEVEL).map(pressure_altitude_m),
            geometric_height_m: record.item(GEOMETRIC_HEIGHT).and_then(geometric_height_m),
            barometric_rate_m_s: record.item(BAROMETRIC_RATE).and_then(vertical_rate_in_range_m_s),
            geometric_rate_m_s: record.item(GEOMETRIC_RATE).and_then(vertical_rate_in_range_m_s),
            ground_vector: record.item(GROUND_VECTOR).and_then(ground_vector),
            quality: record.item(QUALITY).map(QualityIndicators::new),
            version: record.item(VERSION).map(|item| item[0] >> 3 & 0x07),
            target_status: record.item(TARGET_STATUS).map(|item| TargetStatus::new(item, edition)),
            advised: record.item(OPERATIONAL_STATUS).map(|item| item[0] & 0x80 != 0),
            resolution_advisory: record.item(RESOLUTION_ADVISORY).map(ResolutionAdvisory::new),
            emitter_category: record.item(EMITTER_CATEGORY).map(|item| item[0]),
        })
    }
}

/// The greatest number means "greater than that".
fn geometric_height_m(item: &[u8]) -> Option<f64> {
    (i16_at(item, 0) != i16::MAX).then(|| height_m(item))
}

/// Behind the bit that says "beyond the range", fifteen bits in two's complement, LSB 6.25 ft/min.
fn vertical_rate_in_range_m_s(item: &[u8]) -> Option<f64> {
    let number = u16_at(item, 0);
    let rate = ((number << 1) as i16) >> 1;
    (number & 0x8000 == 0).then(|| f64::from(rate) * (6.25 * FOOT_M / 60.0))
}

/// Behind the bit that says "beyond the range", fifteen bits of speed.
fn ground_vector(item: &[u8]) -> Option<PolarVelocity> {
    let number = u16_at(item, 0);
    (number & 0x8000 == 0).then(|| PolarVelocity {
        speed_m_s: speed_m_s(f64::from(number)),
        track_rad: angle_rad(item, 2),
    })
}
