//! A radar: target reports in CAT048, north markers and sector crossings in CAT034.
//!
//! | item | from | |
//! | --- | --- | --- |
//! | 020 | state, identity, alerts | what detected it, see below |
//! | 040 | `measured_m`, else `position_m` | slant range and azimuth from the antenna; not at a track's end |
//! | 042 | `position_m` | in the radar plane (TCC 0 in 170): slant range and azimuth as x and y |
//! | 070, 220, 240 | `identity` | |
//! | 090 | height | as flight level: a radar has no other; not while coasting, as none was received |
//! | 161 | `track_number` | shortened to 12 bits |
//! | 170 | state, identity, rate of climb | |
//! | 200 | `velocity_mps` | course from true north at the target, as the document wants |
//! | 210 | `covariance` | if all four deviations fit |
//! | 230 | alerts, ground state | with Mode S targets, as the document wants |
//!
//! A plot has the first four of these items (010, 140, 020, 040) and its flight level, if it has one.
//!
//! **Type of detection.** A sensor track does not say which part of the radar saw it, but its identity does: an address
//! comes from Mode S, a code or a height from a reply to secondary radar, and without any of them it was primary radar. A
//! coasted track is "no detection", with its extrapolated position. That a primary radar saw the target too is not known
//! and not said.
//!
//! **Radar plane.** I048/042 is either the slant range turned down into the plane, or a projection of the ground, whichever
//! I048/170 says. Which projection that is the document leaves open, and at 200 km two usual ones are 300 m apart for a
//! high aircraft; the slant range has one meaning.
//!
//! **Flight levels below zero** have two's complement numbers from ed 1.32 on. Earlier editions say nothing of a sign and
//! their tables have none, so such a level would be read as one above 4000: it is left out.
//!
//! Positions farther than 256 NM from the antenna are beyond I048/040 and 042; such reports are refused.

use messages::sensor_track_bits as bits;

use super::super::items::{self, NAUTICAL_MILE_M, SPEED_LSB_MPS};
use super::super::{Unsent, quantity};
use super::{Report, Site};
use asterix::RecordWriter;
use asterix::table::{Category, Content};
use item::*;

/// The field reference numbers of CAT048, the same in every edition.
mod item {
    use asterix::categories::CAT048_V1_31;
    use asterix::table::{Frn, Uap};

    const UAP: &Uap = CAT048_V1_31.uap();
    pub(super) const SOURCE: Frn = UAP.frn("010");
    pub(super) const TIME: Frn = UAP.frn("140");
    pub(super) const DESCRIPTOR: Frn = UAP.frn("020");
    pub(super) const POLAR_POSITION: Frn = UAP.frn("040");
    pub(super) const MODE_3A: Frn = UAP.frn("070");
    pub(super) const FLIGHT_LEVEL: Frn = UAP.frn("090");
    pub(super) const ADDRESS: Frn = UAP.frn("220");
    pub(super) const IDENTIFICATION: Frn = UAP.frn("240");
    pub(super) const TRACK_NUMBER: Frn = UAP.frn("161");
    pub(super) const CARTESIAN_POSITION: Frn = UAP.frn("042");
    pub(super) const VELOCITY: Frn = UAP.frn("200");
    pub(super) const TRACK_STATUS: Frn = UAP.frn("170");
    pub(super) const TRACK_QUALITY: Frn = UAP.frn("210");
    pub(super) const FLIGHT_STATUS: Frn = UAP.frn("230");
}

/// The field reference numbers of CAT034, the same in every edition.
mod service_item {
    use asterix::categories::CAT034_V1_29;
    use asterix::table::{Frn, Uap};

    const UAP: &Uap = CAT034_V1_29.uap();
    pub(super) const SOURCE: Frn = UAP.frn("010");
    pub(super) const MESSAGE_TYPE: Frn = UAP.frn("000");
    pub(super) const TIME: Frn = UAP.frn("030");
    pub(super) const SECTOR: Frn = UAP.frn("020");
    pub(super) const ROTATION: Frn = UAP.frn("041");
}

/// LSB of slant range, metres.
const RANGE_LSB_M: f64 = NAUTICAL_MILE_M / 256.0;
/// LSB of positions in the plane and their deviations, metres.
const POSITION_LSB_M: f64 = NAUTICAL_MILE_M / 128.0;
/// LSB of the deviation of the course, radians.
const COURSE_LSB_RAD: f64 = std::f64::consts::TAU / 4096.0;

/// A boundary between sectors, calculated, may be this much of a sector before itself.
const SECTOR_SLACK: f64 = 1e-6;

/// What differs between editions.
#[derive(Debug)]
pub(super) struct Form {
    level_is_signed: bool,
}

/// What saw a target.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Detection {
    Primary,
    Secondary,
    ModeS,
}

impl Form {
    pub(super) fn new(table: &'static Category) -> Self {
        let level = items::element_of(table, "090", "FL");
        Self {
            level_is_signed: matches!(level, Some((_, Content::Quantity { signed: true, .. }))),
        }
    }

    pub(super) fn write(&self, site: &Site, report: &Report<'_>, record: &mut RecordWriter) -> Result<(), Unsent> {
        let track = report.track;
        let position = Position::new(site, report)?;
        items::source(record, SOURCE, site.source);
        items::time_of_day(record, TIME, track.time_of_measurement_ns);
        descriptor(site, report, record);
        if let Some(position) = &position {
            let (range, azimuth) = position.polar;
            record.item(POLAR_POSITION).bits(range, 16).bits(azimuth, 16);
        }
        items::mode_3a(record, MODE_3A, &track.identity, report.is_received());
        self.flight_level(report.height_m().filter(|_| report.is_received()), record);
        items::address(record, ADDRESS, &track.identity);
        if let Some(call_sign) = items::call_sign(&track.identity) {
            record.item(IDENTIFICATION).bits(call_sign, 48);
        }
        record.item(TRACK_NUMBER).bits(u64::from(report.number), 16);
        if let Some(position) = &position {
            let (x, y) = position.cartesian;
            record.item(CARTESIAN_POSITION).signed(x, 16).signed(y, 16);
        }
        if let Some((speed, course)) = report
            .velocity_mps()
            .and_then(|velocity| items::ground_vector(velocity, 16))
        {
            record.item(VELOCITY).bits(speed, 16).bits(course, 16);
        }
        status(report, record);
        if let Some(deviations) = quality(site, report) {
            record.item(TRACK_QUALITY);
            for deviation in deviations {
                record.bits(deviation, 8);
            }
        }
        if track.identity.address().is_some() && !report.is_ended() {
            items::flight_status(record, FLIGHT_STATUS, &track.identity, track.alerts, report.on_ground());
        }
        Ok(())
    }

    pub(super) fn write_plot(
        &self,
        site: &Site,
        time_ns: i64,
        position_m: [f64; 3],
        height_m: Option<f64>,
        record: &mut RecordWriter,
    ) -> Result<(), Unsent> {
        let sighting = site.frame.sighting(position_m);
        let range = quantity::unsigned(sighting.slant_range_m, RANGE_LSB_M, 16).ok_or(Unsent::Position)?;
        items::source(record, SOURCE, site.source);
        items::time_of_day(record, TIME, time_ns);
        let kind: u8 = if height_m.is_some() { 2 } else { 1 };
        record
            .item(DESCRIPTOR)
            .extended(&[kind << 4 | u8::from(site.simulated) << 3]);
        record
            .item(POLAR_POSITION)
            .bits(range, 16)
            .bits(quantity::turn(sighting.azimuth_rad, 16), 16);
        self.flight_level(height_m, record);
        Ok(())
    }

    fn flight_level(&self, height_m: Option<f64>, record: &mut RecordWriter) {
        if let Some(level) = height_m.and_then(|height_m| items::level(height_m, 14))
            && (level >= 0 || self.level_is_signed)
        {
            record.item(FLIGHT_LEVEL).bits(0, 2).signed(level, 14);
        }
    }
}

/// The numbers of a report's position.
struct Position {
    /// Slant range and azimuth.
    polar: (u64, u64),
    /// x and y.
    cartesian: (i64, i64),
}

impl Position {
    /// `None` at the end of a track.
    fn new(site: &Site, report: &Report<'_>) -> Result<Option<Self>, Unsent> {
        if report.is_ended() {
            return Ok(None);
        }
        let track = report.track;
        let is_measured = report.has(bits::MEASURED) && !report.is_coasted();
        let calculated = site.frame.sighting(track.position_m);
        let sighting = if is_measured {
            site.frame.sighting(track.measured_m)
        } else {
            calculated
        };
        let (sin, cos) = calculated.azimuth_rad.sin_cos();
        let [x, y] = [sin, cos].map(|share| share * calculated.slant_range_m);
        let in_plane = |value: f64| quantity::signed(value, POSITION_LSB_M, 16);
        let range = quantity::unsigned(sighting.slant_range_m, RANGE_LSB_M, 16);
        let (Some(range), Some(x), Some(y)) = (range, in_plane(x), in_plane(y)) else {
            return Err(Unsent::Position);
        };
        Ok(Some(Self {
            polar: (range, quantity::turn(sighting.azimuth_rad, 16)),
            cartesian: (x, y),
        }))
    }
}

fn detection(report: &Report<'_>) -> Detection {
    let identity = &report.track.identity;
    if identity.address().is_some() {
        Detection::ModeS
    } else if identity.mode_3a().is_some() || report.has(bits::HEIGHT) {
        Detection::Secondary
    } else {
        Detection::Primary
    }
}

fn descriptor(site: &Site, report: &Report<'_>, record: &mut RecordWriter) {
    let kind = match detection(report) {
        _ if report.is_coasted() || report.is_ended() => 0,
        Detection::Primary => 1,
        Detection::Secondary => 2,
        Detection::ModeS => 5, // roll-call: it is tracked
    };
    let special = u8::from(report.special_identification());
    record
        .item(DESCRIPTOR)
        .extended(&[kind << 4 | u8::from(site.simulated) << 3 | special << 1]);
}

fn status(report: &Report<'_>, record: &mut RecordWriter) {
    let tentative = u8::from(report.is_tentative());
    let maintained_by = if detection(report) == Detection::Primary { 1 } else { 2 };
    let climb_mode = items::climb_mode(report.climb_mps()) as u8;
    let ended = u8::from(report.is_ended());
    record
        .item(TRACK_STATUS)
        .extended(&[tentative << 6 | maintained_by << 4 | climb_mode, ended << 6]);
}

/// Deviations of x, y, ground speed and course, where all are known and fit.
fn quality(site: &Site, report: &Report<'_>) -> Option<[u64; 4]> {
    let [xx, _, yy] = site.position_covariance(report)?;
    let [east, north] = report.velocity_mps()?;
    let [ee, en, nn] = report.velocity_covariance()?;
    let speed_mps = east.hypot(north);
    let (sin, cos) = (east / speed_mps, north / speed_mps);
    let along = quantity::sigma(sin * sin * ee + 2.0 * sin * cos * en + cos * cos * nn)?;
    let across = quantity::sigma(cos * cos * ee - 2.0 * sin * cos * en + sin * sin * nn)?;
    Some([
        quantity::deviation(xx.sqrt(), POSITION_LSB_M, 8)?,
        quantity::deviation(yy.sqrt(), POSITION_LSB_M, 8)?,
        quantity::deviation(along, SPEED_LSB_MPS, 8)?,
        quantity::deviation(across / speed_mps, COURSE_LSB_RAD, 8)?,
    ])
}

/// The antenna points north.
pub(super) fn north_marker(site: &Site, now_utc_ns: i64, record: &mut RecordWriter) {
    service_message(site, 1, now_utc_ns, record);
    rotation(site, record);
}

/// The antenna crosses into a sector, which is numbered by the eight most significant bits of its azimuth.
pub(super) fn sector_crossing(site: &Site, now_utc_ns: i64, azimuth_rad: f64, record: &mut RecordWriter) {
    let circles = azimuth_rad / std::f64::consts::TAU;
    let sector = (circles.rem_euclid(1.0) * 256.0 + SECTOR_SLACK) as u64 % 256;
    service_message(site, 2, now_utc_ns, record);
    record.item(service_item::SECTOR).bits(sector, 8);
    rotation(site, record);
}

fn service_message(site: &Site, message: u64, now_utc_ns: i64, record: &mut RecordWriter) {
    items::source(record, service_item::SOURCE, site.source);
    record.item(service_item::MESSAGE_TYPE).bits(message, 8);
    items::time_of_day(record, service_item::TIME, now_utc_ns);
}

fn rotation(site: &Site, record: &mut RecordWriter) {
    let period_s = site.rotation_ns.map(frames::time::seconds);
    if let Some(period) = period_s.and_then(|period_s| quantity::unsigned(period_s, 1.0 / 128.0, 16)) {
        record.item(service_item::ROTATION).bits(period, 16);
    }
}
