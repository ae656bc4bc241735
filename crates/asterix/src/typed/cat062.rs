//! CAT062 ed 1.16 to 1.21: tracks of a surveillance data processing system.
//!
//! What is read here lies in the same place in all of these editions. The validation of I062/060 came in with ed 1.17
//! and the surface flag of I062/080 with ed 1.18; before, their bits were spare, and the flags are `false`.

use super::fields::*;
use super::subitems::subitems;
use crate::bits::{i16_at, u16_at};
use crate::categories::CAT062;
use crate::record::Record;
use crate::table::{Edition, Frn, Uap};
use item::*;

/// The field reference numbers of the items read here.
pub mod item {
    use super::{Frn, Uap};
    use crate::categories::CAT062_V1_21;

    const UAP: &Uap = CAT062_V1_21.uap();

    /// I062/010.
    pub const SOURCE: Frn = UAP.frn("010");
    /// I062/015.
    pub const SERVICE: Frn = UAP.frn("015");
    /// I062/070.
    pub const TIME_OF_DAY: Frn = UAP.frn("070");
    /// I062/105.
    pub const GEODETIC_POSITION: Frn = UAP.frn("105");
    /// I062/100.
    pub const CARTESIAN_POSITION: Frn = UAP.frn("100");
    /// I062/185.
    pub const CARTESIAN_VELOCITY: Frn = UAP.frn("185");
    /// I062/210.
    pub const ACCELERATION: Frn = UAP.frn("210");
    /// I062/060.
    pub const MODE_3A: Frn = UAP.frn("060");
    /// I062/245.
    pub const IDENTIFICATION: Frn = UAP.frn("245");
    /// I062/380.
    pub const AIRCRAFT_DATA: Frn = UAP.frn("380");
    /// I062/040.
    pub const TRACK_NUMBER: Frn = UAP.frn("040");
    /// I062/080.
    pub const TRACK_STATUS: Frn = UAP.frn("080");
    /// I062/136.
    pub const FLIGHT_LEVEL: Frn = UAP.frn("136");
    /// I062/130.
    pub const GEOMETRIC_ALTITUDE: Frn = UAP.frn("130");
    /// I062/135.
    pub const BAROMETRIC_ALTITUDE: Frn = UAP.frn("135");
    /// I062/220.
    pub const VERTICAL_RATE: Frn = UAP.frn("220");
    /// I062/300.
    pub const VEHICLE_FLEET: Frn = UAP.frn("300");
    /// I062/500.
    pub const ACCURACY: Frn = UAP.frn("500");
}

/// I062/060: a Mode 3/A code.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TrackCode {
    /// The code, twelve bits: four octal digits.
    pub code: u16,
    /// V: the code was not validated.
    pub not_validated: bool,
    /// G: the reply was garbled.
    pub garbled: bool,
    /// CH: the code has changed.
    pub changed: bool,
}

impl TrackCode {
    fn new(item: &[u8], edition: Edition) -> Self {
        let number = u16_at(item, 0);
        let told = edition >= Edition::new(1, 17);
        Self {
            code: number & 0x0FFF,
            not_validated: told && number & 0x8000 != 0,
            garbled: told && number & 0x4000 != 0,
            changed: number & 0x2000 != 0,
        }
    }
}

/// I062/080: what the system says of its track. A flag whose extension octet was not sent is `false`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SystemTrackStatus {
    /// MON: of one sensor only.
    pub one_sensor: bool,
    /// SPI: special position identification.
    pub special_identification: bool,
    /// MRH: the geometric height is more reliable than the barometric one.
    pub geometric_height_better: bool,
    /// CNF: tentative; otherwise confirmed.
    pub tentative: bool,
    /// SIM: simulated.
    pub simulated: bool,
    /// TSE: the last message of this track.
    pub ended: bool,
    /// TSB: the first message of this track.
    pub begun: bool,
    /// ME: military emergency.
    pub military_emergency: bool,
    /// CST: coasting, for want of any report.
    pub coasting: bool,
    /// EMS.
    pub emergency: Emergency,
    /// PFT: possibly a false track.
    pub doubtful: bool,
    /// FPLT: made with the flight plan, as no sensor saw it.
    pub from_flight_plan: bool,
    /// SFC: on the surface.
    pub on_surface: bool,
}

impl SystemTrackStatus {
    fn new(item: &[u8], edition: Edition) -> Self {
        let octet = |at: usize| extension(item, at);
        Self {
            one_sensor: octet(0) & 0x80 != 0,
            special_identification: octet(0) & 0x40 != 0,
            geometric_height_better: octet(0) & 0x20 != 0,
            tentative: octet(0) & 0x02 != 0,
            simulated: octet(1) & 0x80 != 0,
            ended: octet(1) & 0x40 != 0,
            begun: octet(1) & 0x20 != 0,
            military_emergency: octet(2) & 0x10 != 0,
            coasting: octet(3) & 0x80 != 0,
            emergency: Emergency::new(octet(4) >> 3 & 0x07),
            doubtful: octet(4) & 0x04 != 0,
            from_flight_plan: octet(4) & 0x02 != 0,
            on_surface: edition >= Edition::new(1, 18) && octet(5) & 0x10 != 0,
        }
    }
}

/// I062/135: a barometric altitude.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BarometricAltitude {
    /// In m.
    pub altitude_m: f64,
    /// QNH: above mean sea level, by the local pressure; otherwise in the standard atmosphere.
    pub corrected: bool,
}

impl BarometricAltitude {
    fn new(item: &[u8]) -> Self {
        let number = u16_at(item, 0);
        let quarters = ((number << 1) as i16) >> 1;
        Self {
            altitude_m: f64::from(quarters) * (0.25 * FLIGHT_LEVEL_M),
            corrected: number & 0x8000 != 0,
        }
    }
}

/// I062/380 SAB: what the aircraft says of itself by ADS-B.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct AdsBStatus {
    /// GBS: the transponder says it is on the ground.
    pub ground_bit: bool,
    /// STAT.
    pub emergency: Emergency,
}

/// I062/380: what the aircraft said, of which each field has its own age.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct AircraftData {
    /// ADR: 24-bit address.
    pub address: Option<u32>,
    /// ID. `None` also if it has no letter or digit.
    pub callsign: Option<Callsign>,
    /// COM.
    pub transponder: Option<Transponder>,
    /// SAB.
    pub ads_b: Option<AdsBStatus>,
    /// ACS.
    pub resolution_advisory: Option<ResolutionAdvisory>,
    /// BVR: climb by pressure, in m/s.
    pub barometric_rate_m_s: Option<f64>,
    /// GVR: climb by geometry, in m/s.
    pub geometric_rate_m_s: Option<f64>,
    /// EMC: 1 to 5 aircraft by weight, 10 rotorcraft, 20 emergency and 21 service vehicle.
    pub emitter_category: Option<u8>,
}

impl AircraftData {
    fn read(record: &Record<'_>) -> Self {
        let mut data = Self::default();
        for (place, subitem) in subitems(record, AIRCRAFT_DATA) {
            match place {
                1 => data.address = Some(address(subitem)),
                2 => data.callsign = Callsign::from_six_bits(subitem),
                10 => data.transponder = Some(Transponder::new(subitem)),
                11 => {
                    data.ads_b = Some(AdsBStatus {
                        ground_bit: subitem[0] & 0x02 != 0,
                        emergency: Emergency::new(subitem[1] & 0x07),
                    });
                }
                12 => data.resolution_advisory = Some(ResolutionAdvisory::new(subitem)),
                13 => data.barometric_rate_m_s = Some(vertical_rate_m_s(subitem)),
                14 => data.geometric_rate_m_s = Some(vertical_rate_m_s(subitem)),
                21 => data.emitter_category = Some(subitem[0]),
                _ => {}
            }
        }
        data
    }
}

/// I062/500: the system's estimate of its errors, standard deviations. Maxima mean "or more".
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Accuracy {
    /// APC: of x and y, in m.
    pub sigma_position_m: Option<[f64; 2]>,
    /// COV: covariance of x and y, in m².
    pub covariance_xy_m2: Option<f64>,
    /// APW: of latitude and longitude, in rad.
    pub sigma_geodetic_rad: Option<[f64; 2]>,
    /// AGA: of the geometric altitude, in m.
    pub sigma_geometric_altitude_m: Option<f64>,
    /// ABA: of the barometric altitude, in m.
    pub sigma_barometric_altitude_m: Option<f64>,
    /// ATV: of the velocity along x and y, in m/s.
    pub sigma_velocity_m_s: Option<[f64; 2]>,
    /// ARC: of the rate of climb, in m/s.
    pub sigma_vertical_rate_m_s: Option<f64>,
}

impl Accuracy {
    fn read(record: &Record<'_>) -> Self {
        let mut accuracy = Self::default();
        for (place, subitem) in subitems(record, ACCURACY) {
            let octet = |at: usize| f64::from(subitem[at]);
            let two = |at: usize| f64::from(u16_at(subitem, at));
            match place {
                1 => accuracy.sigma_position_m = Some([two(0) * 0.5, two(2) * 0.5]),
                2 => {
                    // The root of the covariance's size is sent, and its sign.
                    let root_m = f64::from(i16_at(subitem, 0)) * 0.5;
                    accuracy.covariance_xy_m2 = Some(root_m * root_m.abs());
                }
                3 => {
                    let lsb_rad = std::f64::consts::PI / (1u64 << 25) as f64;
                    accuracy.sigma_geodetic_rad = Some([two(0) * lsb_rad, two(2) * lsb_rad]);
                }
                4 => accuracy.sigma_geometric_altitude_m = Some(octet(0) * (6.25 * FOOT_M)),
                5 => accuracy.sigma_barometric_altitude_m = Some(octet(0) * (0.25 * FLIGHT_LEVEL_M)),
                6 => accuracy.sigma_velocity_m_s = Some([octet(0) * 0.25, octet(1) * 0.25]),
                8 => accuracy.sigma_vertical_rate_m_s = Some(octet(0) * (6.25 * FOOT_M / 60.0)),
                _ => {}
            }
        }
        accuracy
    }
}

/// A state of a system track: every record of this category.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrackMessage {
    /// I062/010.
    pub source: Option<Source>,
    /// I062/015: the service of the system.
    pub service: Option<u8>,
    /// I062/070: of the state.
    pub time_of_day: Option<TimeOfDay>,
    /// I062/105.
    pub geodetic_position: Option<GeodeticPosition>,
    /// I062/100: in the plane of the system's projection.
    pub cartesian_position: Option<CartesianPosition>,
    /// I062/185: towards east and north at the target.
    pub cartesian_velocity: Option<CartesianVelocity>,
    /// I062/210: towards east and north at the target.
    pub acceleration: Option<CartesianAcceleration>,
    /// I062/060.
    pub mode_3a: Option<TrackCode>,
    /// I062/245.
    pub identification: Option<Identification>,
    /// I062/380.
    pub aircraft: AircraftData,
    /// I062/040.
    pub track_number: Option<u16>,
    /// I062/080.
    pub track_status: Option<SystemTrackStatus>,
    /// I062/136: as measured last, altitude in the standard atmosphere, in m.
    pub measured_altitude_m: Option<f64>,
    /// I062/130: above the WGS-84 ellipsoid, in m.
    pub geometric_altitude_m: Option<f64>,
    /// I062/135.
    pub barometric_altitude: Option<BarometricAltitude>,
    /// I062/220: positive up, in m/s.
    pub vertical_rate_m_s: Option<f64>,
    /// I062/300: code of the vehicle fleet.
    pub vehicle_fleet: Option<u8>,
    /// I062/500.
    pub accuracy: Accuracy,
}

impl TrackMessage {
    /// Reads a track's state; `None` for a record of another table.
    pub fn read(record: &Record<'_>) -> Option<Self> {
        record.table().is_one_of(CAT062).then_some(())?;
        let edition = record.table().edition;
        Some(Self {
            source: record.item(SOURCE).map(source),
            service: record.item(SERVICE).map(|item| item[0]),
            time_of_day: record.item(TIME_OF_DAY).map(time_of_day),
            geodetic_position: record
                .item(GEODETIC_POSITION)
                .map(|item| GeodeticPosition::from_32_bits(item, 25)),
            cartesian_position: record.item(CARTESIAN_POSITION).map(CartesianPosition::from_halves),
            cartesian_velocity: record.item(CARTESIAN_VELOCITY).map(CartesianVelocity::from_quarters),
            acceleration: record.item(ACCELERATION).map(CartesianAcceleration::from_quarters),
            mode_3a: record.item(MODE_3A).map(|item| TrackCode::new(item, edition)),
            identification: record.item(IDENTIFICATION).map(Identification::new),
            aircraft: AircraftData::read(record),
            track_number: record.item(TRACK_NUMBER).map(|item| u16_at(item, 0)),
            track_status: record
                .item(TRACK_STATUS)
                .map(|item| SystemTrackStatus::new(item, edition)),
            measured_altitude_m: record.item(FLIGHT_LEVEL).map(pressure_altitude_m),
            geometric_altitude_m: record.item(GEOMETRIC_ALTITUDE).map(height_m),
            barometric_altitude: record.item(BAROMETRIC_ALTITUDE).map(BarometricAltitude::new),
            vertical_rate_m_s: record.item(VERTICAL_RATE).map(vertical_rate_m_s),
            vehicle_fleet: record.item(VEHICLE_FLEET).map(|item| item[0]),
            accuracy: Accuracy::read(record),
        })
    }
}
