//! A surface movement sensor: target reports and status in CAT010.
//!
//! | item | from | |
//! | --- | --- | --- |
//! | 020 | identity, alerts, ground state | type, GBS, SPI |
//! | 041 | `position_m` | on the ellipsoid |
//! | 040 | `measured_m` | range and azimuth, where there is a measurement; to 65.5 km |
//! | 042 | `position_m` | in the plane at the sensor; to 32.7 km, beyond that only 041 is sent |
//! | 060, 220, 245 | `identity` | |
//! | 090 or 091 | height | flight level, or height above the sensor's plane; see [`HeightReference`] |
//! | 161 | `track_number` | shortened to 12 bits |
//! | 170 | state | coasting is "absence of detection"; positions are projected (TCC) and smoothed (STH) |
//! | 200, 202 | `velocity_mps` | from true north at the target; along x and y of 042 |
//! | 500 | `covariance` | where deviations (to 63.75 m) and covariance fit |
//!
//! **Type.** A target with an address is reported as Mode S multilateration, with a code only as SSR multilateration,
//! without both as primary radar: surface movement radars have no identities, and other sensors on an airport locate
//! by time differences. Alerts other than SPI have no place in the category.

use messages::sensor_track_bits as bits;

use super::super::{HeightReference, items, quantity};
use super::{SensorReport, Site};
use asterix::categories::CAT010;
use asterix::field::{Elements, Field, elements, field, item, whole};
use asterix::{Frn, RecordWriter};

const SOURCE: Elements<2> = elements(CAT010, "010", ["SAC", "SIC"]);
const MESSAGE_TYPE: Elements<1> = whole(CAT010, "000");
const TIME: Elements<1> = whole(CAT010, "140");
const GEODETIC_POSITION: Elements<2> = elements(CAT010, "041", ["LAT", "LON"]);
const POLAR_POSITION: Elements<2> = elements(CAT010, "040", ["RHO", "TH"]);
const CARTESIAN_POSITION: Elements<2> = elements(CAT010, "042", ["X", "Y"]);
const POLAR_VELOCITY: Elements<2> = elements(CAT010, "200", ["GSP", "TRA"]);
const CARTESIAN_VELOCITY: Elements<2> = elements(CAT010, "202", ["VX", "VY"]);
const TRACK_NUMBER: Elements<1> = elements(CAT010, "161", ["TRK"]);
const MODE_3A: Elements<2> = elements(CAT010, "060", ["L", "MODE3A"]);
const ADDRESS: Elements<1> = whole(CAT010, "220");
/// Sent by the target (STI 0).
const IDENTIFICATION: Elements<1> = elements(CAT010, "245", ["CHR"]);
const FLIGHT_LEVEL: Elements<1> = elements(CAT010, "090", ["FL"]);
const MEASURED_HEIGHT: Elements<1> = whole(CAT010, "091");
/// System status; all numbers 0 mean operational.
const SYSTEM_STATUS: Frn = item(CAT010, "550");
const DEVIATION: Elements<3> = elements(CAT010, "500", ["DEVX", "DEVY", "COVXY"]);

const DESCRIPTOR: Frn = item(CAT010, "020");
const TYP: Field = field(CAT010, &["020", "TYP"]);
const GBS: Field = field(CAT010, &["020", "GBS"]);
const SIM: Field = field(CAT010, &["020", "SIM"]);
const SPI: Field = field(CAT010, &["020", "SPI"]);

const STATUS: Frn = item(CAT010, "170");
const CNF: Field = field(CAT010, &["170", "CNF"]);
const TRE: Field = field(CAT010, &["170", "TRE"]);
const CST: Field = field(CAT010, &["170", "CST"]);
const TCC: Field = field(CAT010, &["170", "TCC"]);
const STH: Field = field(CAT010, &["170", "STH"]);

pub(super) fn write(site: &Site, report: &SensorReport<'_>, record: &mut RecordWriter) {
    let (track, identity) = (report.track, &report.track.identity);
    items::source(record, &SOURCE, site.source);
    record.write(&MESSAGE_TYPE, [1]);
    descriptor(site, report, record);
    items::time_of_day(record, &TIME, track.time_of_measurement_ns);
    positions(site, report, record);
    if let Some(velocity) = report.velocity_mps() {
        items::ground_vector(record, &POLAR_VELOCITY, velocity);
    }
    if let Some(velocity) = site.velocity_mps(report) {
        items::quantities(record, &CARTESIAN_VELOCITY, velocity);
    }
    record.write(&TRACK_NUMBER, [i64::from(report.number)]);
    status_of(report, record);
    items::mode_3a(record, &MODE_3A, identity, report.is_received());
    items::number(record, &ADDRESS, items::address(identity));
    items::number(record, &IDENTIFICATION, items::call_sign(identity));
    height(site, report, record);
    if let Some(deviation) = deviation(site, report) {
        record.write(&DEVIATION, deviation);
    }
}

fn descriptor(site: &Site, report: &SensorReport<'_>, record: &mut RecordWriter) {
    let identity = &report.track.identity;
    let kind = match (identity.address(), identity.mode_3a()) {
        (Some(_), _) => 1,
        (None, Some(_)) => 0,
        (None, None) => 3,
    };
    record
        .item(DESCRIPTOR)
        .put(TYP, kind)
        .put(GBS, report.on_ground())
        .put(SIM, site.simulated)
        .put(SPI, report.special_identification());
}

fn positions(site: &Site, report: &SensorReport<'_>, record: &mut RecordWriter) {
    let Some(place) = &report.place else { return };
    let track = report.track;
    items::geodetic(record, &GEODETIC_POSITION, &place.geodetic);
    if report.has(bits::MEASURED) && !report.is_coasted() {
        let sighting = site.frame.sighting(track.measured_m);
        let [range, azimuth] = POLAR_POSITION.fields;
        if let Some(range) = range.nearest(sighting.slant_range_m) {
            record.write(&POLAR_POSITION, [range, quantity::turn(azimuth, sighting.azimuth_rad)]);
        }
    }
    let [x, y, _] = site.frame.to_cartesian(track.position_m);
    items::quantities(record, &CARTESIAN_POSITION, [x, y]);
}

fn status_of(report: &SensorReport<'_>, record: &mut RecordWriter) {
    record
        .item(STATUS)
        .put(CNF, report.is_tentative())
        .put(TRE, report.is_ended())
        .put(CST, if report.is_coasted() { 3 } else { 0 })
        .put(TCC, true)
        .put(STH, true);
}

fn height(site: &Site, report: &SensorReport<'_>, record: &mut RecordWriter) {
    let Some(height_m) = report.height_m() else { return };
    match site.height {
        HeightReference::Barometric => items::level(record, &FLIGHT_LEVEL, Some(height_m)),
        HeightReference::Geometric => {
            let [_, _, up] = site.frame.to_cartesian(report.track.position_m);
            items::quantities(record, &MEASURED_HEIGHT, [up]);
        }
    }
}

/// Deviations of x and y and their covariance, where all fit.
fn deviation(site: &Site, report: &SensorReport<'_>) -> Option<[i64; 3]> {
    let [xx, xy, yy] = site.position_covariance(report)?;
    let [sigma_x, sigma_y, covariance] = DEVIATION.fields;
    Some([
        quantity::deviation(sigma_x, xx.sqrt())?,
        quantity::deviation(sigma_y, yy.sqrt())?,
        covariance.nearest(xy)?,
    ])
}

/// Writes the periodic status message: in operation.
pub(super) fn status(site: &Site, now_utc_ns: i64, record: &mut RecordWriter) {
    items::source(record, &SOURCE, site.source);
    record.write(&MESSAGE_TYPE, [3]);
    items::time_of_day(record, &TIME, now_utc_ns);
    record.item(SYSTEM_STATUS);
}
