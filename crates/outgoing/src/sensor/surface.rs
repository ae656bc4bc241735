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
//! **Type.** An address is taken for Mode S multilateration, a code alone for SSR multilateration, neither for primary
//! radar: surface movement radars have no identities, and what has them on an airport locates by time differences. Alerts
//! other than SPI have no place in the category.

use messages::sensor_track_bits as bits;

use super::super::{HeightReference, items, quantity};
use super::{Report, Site};
use asterix::RecordWriter;
use item::*;

/// The field reference numbers of CAT010.
mod item {
    use asterix::categories::CAT010_V1_1;
    use asterix::table::{Frn, Uap};

    const UAP: &Uap = CAT010_V1_1.uap();
    pub(super) const SOURCE: Frn = UAP.frn("010");
    pub(super) const MESSAGE_TYPE: Frn = UAP.frn("000");
    pub(super) const DESCRIPTOR: Frn = UAP.frn("020");
    pub(super) const TIME: Frn = UAP.frn("140");
    pub(super) const GEODETIC_POSITION: Frn = UAP.frn("041");
    pub(super) const POLAR_POSITION: Frn = UAP.frn("040");
    pub(super) const CARTESIAN_POSITION: Frn = UAP.frn("042");
    pub(super) const POLAR_VELOCITY: Frn = UAP.frn("200");
    pub(super) const CARTESIAN_VELOCITY: Frn = UAP.frn("202");
    pub(super) const TRACK_NUMBER: Frn = UAP.frn("161");
    pub(super) const TRACK_STATUS: Frn = UAP.frn("170");
    pub(super) const MODE_3A: Frn = UAP.frn("060");
    pub(super) const ADDRESS: Frn = UAP.frn("220");
    pub(super) const IDENTIFICATION: Frn = UAP.frn("245");
    pub(super) const FLIGHT_LEVEL: Frn = UAP.frn("090");
    pub(super) const MEASURED_HEIGHT: Frn = UAP.frn("091");
    pub(super) const STATUS: Frn = UAP.frn("550");
    pub(super) const DEVIATION: Frn = UAP.frn("500");
}

/// LSB of positions, metres.
const POSITION_LSB_M: f64 = 1.0;
/// LSB of velocities (m/s), of deviations (m) and of their covariance (m²).
const QUARTER: f64 = 0.25;

pub(super) fn write(site: &Site, report: &Report<'_>, record: &mut RecordWriter) {
    let (track, identity) = (report.track, &report.track.identity);
    items::source(record, SOURCE, site.source);
    record.item(MESSAGE_TYPE).bits(1, 8);
    descriptor(site, report, record);
    items::time_of_day(record, TIME, track.time_of_measurement_ns);
    positions(site, report, record);
    if let Some((speed, course)) = report
        .velocity_mps()
        .and_then(|velocity| items::ground_vector(velocity, 16))
    {
        record.item(POLAR_VELOCITY).bits(speed, 16).bits(course, 16);
    }
    if let Some(velocity) = site.velocity_mps(report) {
        items::pair(record, CARTESIAN_VELOCITY, velocity, QUARTER, 16);
    }
    record.item(TRACK_NUMBER).bits(u64::from(report.number), 16);
    status_of(report, record);
    items::mode_3a(record, MODE_3A, identity, report.is_received());
    items::address(record, ADDRESS, identity);
    if let Some(call_sign) = items::call_sign(identity) {
        record.item(IDENTIFICATION).bits(0, 8).bits(call_sign, 48); // downlinked
    }
    height(site, report, record);
    if let Some([x, y, xy]) = deviation(site, report) {
        record
            .item(DEVIATION)
            .bits(x as u64, 8)
            .bits(y as u64, 8)
            .signed(xy, 16);
    }
}

fn descriptor(site: &Site, report: &Report<'_>, record: &mut RecordWriter) {
    let identity = &report.track.identity;
    let kind = match (identity.address(), identity.mode_3a()) {
        (Some(_), _) => 1,
        (None, Some(_)) => 0,
        (None, None) => 3,
    };
    let on_ground = u8::from(report.on_ground());
    record.item(DESCRIPTOR).extended(&[
        kind << 4 | on_ground << 1,
        u8::from(site.simulated) << 6,
        u8::from(report.special_identification()) << 6,
    ]);
}

fn positions(site: &Site, report: &Report<'_>, record: &mut RecordWriter) {
    let Some(place) = &report.place else { return };
    let track = report.track;
    items::geodetic(record, GEODETIC_POSITION, &place.geodetic, 32, 31);
    if report.has(bits::MEASURED) && !report.is_coasted() {
        let sighting = site.frame.sighting(track.measured_m);
        if let Some(range) = quantity::unsigned(sighting.slant_range_m, POSITION_LSB_M, 16) {
            let azimuth = quantity::turn(sighting.azimuth_rad, 16);
            record.item(POLAR_POSITION).bits(range, 16).bits(azimuth, 16);
        }
    }
    let [x, y, _] = site.frame.to_cartesian(track.position_m);
    items::pair(record, CARTESIAN_POSITION, [x, y], POSITION_LSB_M, 16);
}

fn status_of(report: &Report<'_>, record: &mut RecordWriter) {
    let (tentative, ended) = (u8::from(report.is_tentative()), u8::from(report.is_ended()));
    let extrapolated = if report.is_coasted() { 3 } else { 0 };
    let (projected, smoothed) = (1, 1);
    record
        .item(TRACK_STATUS)
        .extended(&[tentative << 6 | ended << 5 | extrapolated << 3 | projected << 1 | smoothed]);
}

fn height(site: &Site, report: &Report<'_>, record: &mut RecordWriter) {
    let Some(height_m) = report.height_m() else { return };
    match site.height {
        HeightReference::Barometric => {
            if let Some(level) = items::level(height_m, 14) {
                record.item(FLIGHT_LEVEL).bits(0, 2).signed(level, 14);
            }
        }
        HeightReference::Geometric => {
            let [_, _, up] = site.frame.to_cartesian(report.track.position_m);
            if let Some(up) = quantity::signed(up, items::HEIGHT_LSB_M, 16) {
                record.item(MEASURED_HEIGHT).signed(up, 16);
            }
        }
    }
}

/// Deviations of x and y and their covariance, where all fit.
fn deviation(site: &Site, report: &Report<'_>) -> Option<[i64; 3]> {
    let [xx, xy, yy] = site.position_covariance(report)?;
    Some([
        quantity::deviation(xx.sqrt(), QUARTER, 8)? as i64,
        quantity::deviation(yy.sqrt(), QUARTER, 8)? as i64,
        quantity::signed(xy, QUARTER, 16)?,
    ])
}

/// The periodic status message: in operation.
pub(super) fn status(site: &Site, now_utc_ns: i64, record: &mut RecordWriter) {
    items::source(record, SOURCE, site.source);
    record.item(MESSAGE_TYPE).bits(3, 8);
    items::time_of_day(record, TIME, now_utc_ns);
    record.item(STATUS).bits(0, 8);
}
