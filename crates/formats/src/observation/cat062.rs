//! CAT062: tracks of another surveillance data processing system.
//!
//! The geographic position is used if present, otherwise x and y. The plane of x and y is a map around a place
//! unknown outside the sending system; this place must be configured as the source's position. A state from the
//! flight plan alone, or a coasted state, is an extrapolation and no observation.
//!
//! The height is the system's own barometric altitude (I062/135), which is of the time of the state. The transponder's
//! level is the measured one (I062/136) with its age (I062/295), else the system's.

use asterix::categories::CAT062;
use asterix::field::{added, subitem};

use super::*;

const TIME: Elements<1> = whole(CAT062, "070");
const GEODETIC: Elements<2> = elements(CAT062, "105", ["LAT", "LON"]);
const CARTESIAN: Elements<2> = elements(CAT062, "100", ["X", "Y"]);
const VELOCITY: Elements<2> = elements(CAT062, "185", ["VX", "VY"]);
const TRACK_NUMBER: Elements<1> = whole(CAT062, "040");
const CALLSIGN: Elements<1> = elements(CAT062, "245", ["CHR"]);
const MEASURED_ALTITUDE: Elements<1> = whole(CAT062, "136");
const GEOMETRIC_ALTITUDE: Elements<1> = whole(CAT062, "130");
/// QNH: above mean sea level, by the local pressure; otherwise in the standard atmosphere.
const BAROMETRIC_ALTITUDE: Elements<2> = elements(CAT062, "135", ["QNH", "CTB"]);
const VERTICAL_RATE: Elements<1> = whole(CAT062, "220");
const DATA_AGES: Frn = item(CAT062, "295");
const MFL: usize = subitem(CAT062, "295", "MFL");
const MEASURED_ALTITUDE_AGE: Field = field(CAT062, &["295", "MFL"]);

const MODE_3A: Frn = item(CAT062, "060");
const V: Field = added(CAT062, &["060", "V"]);
const G: Field = added(CAT062, &["060", "G"]);
const CODE: Field = field(CAT062, &["060", "MODE3A"]);

const STATUS: Frn = item(CAT062, "080");
const SPI: Field = field(CAT062, &["080", "SPI"]);
const CNF: Field = field(CAT062, &["080", "CNF"]);
const SIM: Field = field(CAT062, &["080", "SIM"]);
const TSE: Field = field(CAT062, &["080", "TSE"]);
const ME: Field = field(CAT062, &["080", "ME"]);
const CST: Field = field(CAT062, &["080", "CST"]);
const EMS: Field = field(CAT062, &["080", "EMS"]);
const FPLT: Field = field(CAT062, &["080", "FPLT"]);
const SFC: Field = added(CAT062, &["080", "SFC"]);

const AIRCRAFT: Frn = item(CAT062, "380");
const ADR: usize = subitem(CAT062, "380", "ADR");
const ADDRESS: Field = field(CAT062, &["380", "ADR"]);
const ID: usize = subitem(CAT062, "380", "ID");
const CHARACTERS: Field = field(CAT062, &["380", "ID"]);
const COM: usize = subitem(CAT062, "380", "COM");
const FLIGHT_STATUS: Field = field(CAT062, &["380", "COM", "STAT"]);
const SAB: usize = subitem(CAT062, "380", "SAB");
const GBS: Field = field(CAT062, &["380", "SAB", "GBS"]);
const EMERGENCY: Field = field(CAT062, &["380", "SAB", "STAT"]);
const ACS: usize = subitem(CAT062, "380", "ACS");
const BVR: usize = subitem(CAT062, "380", "BVR");
const BAROMETRIC_RATE: Field = field(CAT062, &["380", "BVR"]);
const GVR: usize = subitem(CAT062, "380", "GVR");
const GEOMETRIC_RATE: Field = field(CAT062, &["380", "GVR"]);

/// Standard deviations.
const ACCURACY: Frn = item(CAT062, "500");
const APC: usize = subitem(CAT062, "500", "APC");
const SIGMA_X: Field = field(CAT062, &["500", "APC", "X"]);
const SIGMA_Y: Field = field(CAT062, &["500", "APC", "Y"]);
const COV: usize = subitem(CAT062, "500", "COV");
const ROOT_OF_COVARIANCE: Field = field(CAT062, &["500", "COV"]);
const APW: usize = subitem(CAT062, "500", "APW");
const SIGMA_LATITUDE: Field = field(CAT062, &["500", "APW", "LAT"]);
const SIGMA_LONGITUDE: Field = field(CAT062, &["500", "APW", "LON"]);
const ATV: usize = subitem(CAT062, "500", "ATV");
const SIGMA_VX: Field = field(CAT062, &["500", "ATV", "X"]);
const SIGMA_VY: Field = field(CAT062, &["500", "ATV", "Y"]);

/// Mean radius of the earth, metres.
const EARTH_RADIUS_M: f64 = 6_371_000.0;

pub(super) fn read(record: &Record<'_>) -> Option<Reading> {
    record
        .table()
        .is_one_of(CAT062)
        .then(|| Reading::Target(observation(record)))
}

fn observation(record: &Record<'_>) -> Observation {
    let edition = record.table().edition;
    let (status, code) = (record.octets(STATUS), record.octets(MODE_3A));
    let (aircraft, accuracy) = (Aircraft::of(record), EstimatedAccuracy::of(record));
    let geodetic = GEODETIC.quantities(record);
    let is_refuted = edition >= V.since && (V.is_set(code) || G.is_set(code));
    let (in_standard, above_sea) = match BAROMETRIC_ALTITUDE.quantities(record) {
        Some([corrected, altitude]) if corrected != 0.0 => (None, Some(altitude)),
        Some([_, altitude]) => (Some(altitude), None),
        None => (None, None),
    };
    Observation {
        sac_sic: record.sender(),
        time_of_day_ns: time_of_day_ns(record, &TIME),
        test: SIM.is_set(status),
        track_number: TRACK_NUMBER.number(record).map(|number| number as u32),
        identity: identity(
            CODE.number(code).filter(|_| !is_refuted).map(|code| code as u16),
            aircraft.address,
            aircraft
                .characters
                .filter(|characters| callsign(*characters).is_some())
                .or_else(|| CALLSIGN.number(record)),
        ),
        cartesian: CARTESIAN.quantities(record).filter(|_| geodetic.is_none()),
        plane: Plane::Stereographic,
        geodetic,
        velocity: VELOCITY.quantities(record),
        axes: Axes::Target,
        velocity_covariance: accuracy.velocity.and_then(variances),
        pressure_altitude_m: in_standard.or_else(|| MEASURED_ALTITUDE.quantity(record)),
        stated_altitude: MEASURED_ALTITUDE
            .quantity(record)
            .map(|altitude_m| (altitude_m, measured_altitude_age_ns(record))),
        geometric_height_m: GEOMETRIC_ALTITUDE.quantity(record).or(above_sea),
        vertical_rate_mps: VERTICAL_RATE
            .quantity(record)
            .or(aircraft.barometric_rate_mps)
            .or(aircraft.geometric_rate_mps),
        on_ground: (edition >= SFC.since && SFC.is_set(status)) || aircraft.on_ground,
        alerts: Alerts::flag(alert_bits::SPECIAL_IDENTIFICATION, SPI.is_set(status))
            | Alerts::flag(alert_bits::EMERGENCY, ME.is_set(status))
            | alerts_of_emergency(EMS.code(status))
            | aircraft.alerts,
        state: state(
            TSE.is_set(status),
            CNF.is_set(status),
            CST.is_set(status) || FPLT.is_set(status),
        ),
        quality: accuracy.quality(geodetic),
        ..Observation::default()
    }
}

/// Age of the measured altitude; 0 where it is not stated.
fn measured_altitude_age_ns(record: &Record<'_>) -> i64 {
    let mut ages = record.subitems(DATA_AGES);
    let octets = ages.find_map(|(position, octets)| (position == MFL).then_some(octets));
    octets
        .and_then(|octets| MEASURED_ALTITUDE_AGE.quantity(octets))
        .map_or(0, frames::time::ns)
}

/// I062/380: data sent by the aircraft.
#[derive(Default)]
struct Aircraft {
    address: Option<u64>,
    characters: Option<u64>,
    on_ground: bool,
    alerts: Alerts,
    barometric_rate_mps: Option<f64>,
    geometric_rate_mps: Option<f64>,
}

impl Aircraft {
    fn of(record: &Record<'_>) -> Self {
        let mut aircraft = Self::default();
        for (position, octets) in record.subitems(AIRCRAFT) {
            match position {
                ADR => aircraft.address = ADDRESS.number(octets),
                ID => aircraft.characters = CHARACTERS.number(octets),
                COM => {
                    let (alerts, on_ground) = flight_status(FLIGHT_STATUS.code(octets));
                    aircraft.alerts = aircraft.alerts | alerts;
                    aircraft.on_ground |= on_ground;
                }
                SAB => {
                    aircraft.alerts = aircraft.alerts | alerts_of_emergency(EMERGENCY.code(octets));
                    aircraft.on_ground |= GBS.is_set(octets);
                }
                ACS => aircraft.alerts = aircraft.alerts | alerts_of_advisory(octets),
                BVR => aircraft.barometric_rate_mps = BAROMETRIC_RATE.quantity(octets),
                GVR => aircraft.geometric_rate_mps = GEOMETRIC_RATE.quantity(octets),
                _ => {}
            }
        }
        aircraft
    }
}

/// I062/500: the system's estimate of its errors.
#[derive(Default)]
struct EstimatedAccuracy {
    /// Standard deviations of x and y, metres.
    position: Option<[f64; 2]>,
    /// Covariance of x and y, m².
    covariance: f64,
    /// Standard deviations of latitude and longitude, radians.
    geodetic: Option<[f64; 2]>,
    /// Standard deviations of the velocity along x and y, metres per second.
    velocity: Option<[f64; 2]>,
}

impl EstimatedAccuracy {
    fn of(record: &Record<'_>) -> Self {
        let mut accuracy = Self::default();
        for (position, octets) in record.subitems(ACCURACY) {
            let pair = |x: Field, y: Field| Some([x.quantity(octets)?, y.quantity(octets)?]);
            match position {
                APC => accuracy.position = pair(SIGMA_X, SIGMA_Y),
                COV => {
                    // The root of the covariance's size is sent, and its sign.
                    let root_m = ROOT_OF_COVARIANCE.quantity(octets).unwrap_or(0.0);
                    accuracy.covariance = root_m * root_m.abs();
                }
                APW => accuracy.geodetic = pair(SIGMA_LATITUDE, SIGMA_LONGITUDE),
                ATV => accuracy.velocity = pair(SIGMA_VX, SIGMA_VY),
                _ => {}
            }
        }
        accuracy
    }

    /// Accuracy of x and y with their covariance; else of latitude and longitude, as distances.
    fn quality(&self, geodetic: Option<[f64; 2]>) -> Quality {
        if let Some(sigma) = self.position {
            return covariance(sigma, self.covariance);
        }
        match (self.geodetic, geodetic) {
            (Some([sigma_latitude, sigma_longitude]), Some([latitude, _])) => {
                let east_m = sigma_longitude * EARTH_RADIUS_M * latitude.cos();
                covariance([east_m, sigma_latitude * EARTH_RADIUS_M], 0.0)
            }
            _ => Quality::Unstated,
        }
    }
}

fn variances([x, y]: [f64; 2]) -> Option<[f64; 3]> {
    (x > 0.0 && y > 0.0).then_some([x * x, 0.0, y * y])
}
