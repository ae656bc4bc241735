//! A radar: target reports in CAT048, north markers and sector crossings in CAT034.
//!
//! | item | from | |
//! | --- | --- | --- |
//! | 020 | state, identity, alerts | kind of detection, see below |
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
//! A plot has the first four of these items (010, 140, 020, 040), and of its reply what is known: 070, 090, 220, 240.
//!
//! **Type of detection.** A sensor track does not contain the detecting part of the radar, but its identity implies
//! the part: an address comes from Mode S, a code or a height from a reply to secondary radar; without any of these
//! the primary radar detected the target. A coasted track is "no detection", with its extrapolated position. A
//! simultaneous detection by primary radar is unknown and not reported.
//!
//! **Radar plane.** I048/042 is either the slant range turned down into the plane, or a projection of the ground, as
//! stated by I048/170. The document does not define the projection; at 200 km two usual projections are 300 m apart
//! for a high aircraft. The slant range is unambiguous.
//!
//! **Flight levels below zero** are in two's complement from ed 1.32 on. Earlier editions state no sign, and a
//! receiver that follows their words would read such a level as a level above 4000: the level is omitted.
//!
//! Positions farther than 256 NM from the antenna are beyond I048/040 and 042; such reports are refused.

use messages::{Identity, sensor_track_bits as bits};

use super::super::{Unsent, items, quantity};
use super::{SensorReport, Site};
use asterix::categories::{CAT034, CAT048};
use asterix::field::{Elements, Field, elements, field, item, whole};
use asterix::{Category, Edition, Frn, RecordWriter};

const SOURCE: Elements<2> = elements(CAT048, "010", ["SAC", "SIC"]);
const TIME: Elements<1> = whole(CAT048, "140");
const POLAR_POSITION: Elements<2> = elements(CAT048, "040", ["RHO", "THETA"]);
const MODE_3A: Elements<2> = elements(CAT048, "070", ["L", "MODE3A"]);
const FLIGHT_LEVEL: Elements<1> = elements(CAT048, "090", ["FL"]);
/// Edition from which on the document states a sign.
const SIGNED_LEVELS_SINCE: Edition = Edition::new(1, 32);
const ADDRESS: Elements<1> = whole(CAT048, "220");
const IDENTIFICATION: Elements<1> = whole(CAT048, "240");
const TRACK_NUMBER: Elements<1> = elements(CAT048, "161", ["TRN"]);
const CARTESIAN_POSITION: Elements<2> = elements(CAT048, "042", ["X", "Y"]);
const VELOCITY: Elements<2> = elements(CAT048, "200", ["GSP", "HDG"]);
const DEVIATIONS: Elements<4> = elements(CAT048, "210", ["SIGX", "SIGY", "SIGV", "SIGH"]);
const FLIGHT_STATUS: Elements<2> = elements(CAT048, "230", ["STAT", "AIC"]);

const DESCRIPTOR: Frn = item(CAT048, "020");
const TYP: Field = field(CAT048, &["020", "TYP"]);
const SIM: Field = field(CAT048, &["020", "SIM"]);
const SPI: Field = field(CAT048, &["020", "SPI"]);

const STATUS: Frn = item(CAT048, "170");
const CNF: Field = field(CAT048, &["170", "CNF"]);
const RAD: Field = field(CAT048, &["170", "RAD"]);
const CDM: Field = field(CAT048, &["170", "CDM"]);
const TRE: Field = field(CAT048, &["170", "TRE"]);

/// Items of CAT034.
mod service {
    use super::*;

    pub(super) const SOURCE: Elements<2> = elements(CAT034, "010", ["SAC", "SIC"]);
    pub(super) const MESSAGE_TYPE: Elements<1> = whole(CAT034, "000");
    pub(super) const TIME: Elements<1> = whole(CAT034, "030");
    pub(super) const SECTOR: Elements<1> = whole(CAT034, "020");
}

/// A boundary between sectors, calculated, may be this much of a sector before itself.
const SECTOR_SLACK: f64 = 1e-6;

/// Differences between editions.
#[derive(Debug)]
pub(super) struct RadarForm {
    /// Whether every receiver reads flight levels with their sign.
    has_signed_levels: bool,
}

/// Part of the radar that saw a target.
#[derive(Clone, Copy, PartialEq, Eq)]
enum DetectionType {
    Primary,
    Secondary,
    ModeS,
}

impl RadarForm {
    pub(super) fn new(table: &'static Category) -> Self {
        Self {
            has_signed_levels: table.edition >= SIGNED_LEVELS_SINCE,
        }
    }

    pub(super) fn write(
        &self,
        site: &Site,
        report: &SensorReport<'_>,
        record: &mut RecordWriter,
    ) -> Result<(), Unsent> {
        let track = report.track;
        let position = RadarPosition::new(site, report)?;
        items::source(record, &SOURCE, site.source);
        items::time_of_day(record, &TIME, track.time_of_measurement_ns);
        descriptor(site, report, record);
        if let Some(position) = &position {
            record.write(&POLAR_POSITION, position.polar);
        }
        items::mode_3a(record, &MODE_3A, &track.identity, report.is_received());
        let received = report.height_m().filter(|_| report.is_received());
        items::level(record, &FLIGHT_LEVEL, self.understood(received));
        items::number(record, &ADDRESS, items::address(&track.identity));
        items::number(record, &IDENTIFICATION, items::call_sign(&track.identity));
        record.write(&TRACK_NUMBER, [i64::from(report.number)]);
        if let Some(position) = &position {
            record.write(&CARTESIAN_POSITION, position.cartesian);
        }
        if let Some(velocity) = report.velocity_mps() {
            items::ground_vector(record, &VELOCITY, velocity);
        }
        status(report, record);
        if let Some(deviations) = deviations(site, report) {
            record.write(&DEVIATIONS, deviations);
        }
        if track.identity.address().is_some() && !report.is_ended() {
            items::flight_status(
                record,
                &FLIGHT_STATUS,
                &track.identity,
                track.alerts,
                report.on_ground(),
            );
        }
        Ok(())
    }

    /// Returns a height whose level no receiver misreads.
    fn understood(&self, height_m: Option<f64>) -> Option<f64> {
        let [field] = FLIGHT_LEVEL.fields;
        let is_above = |height_m: &f64| field.nearest(*height_m).is_some_and(|number| number >= 0);
        height_m.filter(|height_m| self.has_signed_levels || is_above(height_m))
    }

    pub(super) fn write_plot(
        &self,
        site: &Site,
        time_ns: i64,
        position_m: [f64; 3],
        (height_m, identity): (Option<f64>, &Identity),
        record: &mut RecordWriter,
    ) -> Result<(), Unsent> {
        let sighting = site.frame.sighting(position_m);
        let polar = polar(sighting.slant_range_m, sighting.azimuth_rad).ok_or(Unsent::Position)?;
        items::source(record, &SOURCE, site.source);
        items::time_of_day(record, &TIME, time_ns);
        record
            .item(DESCRIPTOR)
            .put(TYP, part_code(identity, height_m.is_some()))
            .put(SIM, site.simulated);
        record.write(&POLAR_POSITION, polar);
        items::mode_3a(record, &MODE_3A, identity, true);
        items::level(record, &FLIGHT_LEVEL, self.understood(height_m));
        items::number(record, &ADDRESS, items::address(identity));
        items::number(record, &IDENTIFICATION, items::call_sign(identity));
        Ok(())
    }
}

/// The numbers of a slant range and an azimuth; `None` if the range does not fit.
fn polar(range_m: f64, azimuth_rad: f64) -> Option<[i64; 2]> {
    let [range, azimuth] = POLAR_POSITION.fields;
    Some([range.nearest(range_m)?, quantity::turn(azimuth, azimuth_rad)])
}

/// The numbers of a report's position.
struct RadarPosition {
    /// Slant range and azimuth.
    polar: [i64; 2],
    /// x and y.
    cartesian: [i64; 2],
}

impl RadarPosition {
    /// `None` at the end of a track.
    fn new(site: &Site, report: &SensorReport<'_>) -> Result<Option<Self>, Unsent> {
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
        let polar = polar(sighting.slant_range_m, sighting.azimuth_rad).ok_or(Unsent::Position)?;
        let cartesian = quantity::nearest(&CARTESIAN_POSITION, [x, y]).ok_or(Unsent::Position)?;
        Ok(Some(Self { polar, cartesian }))
    }
}

fn detection(report: &SensorReport<'_>) -> DetectionType {
    detection_type(&report.track.identity, report.has(bits::HEIGHT))
}

fn detection_type(identity: &Identity, height: bool) -> DetectionType {
    if identity.address().is_some() {
        DetectionType::ModeS
    } else if identity.mode_3a().is_some() || height {
        DetectionType::Secondary
    } else {
        DetectionType::Primary
    }
}

/// The code of I048/020 for a detection.
fn part_code(identity: &Identity, height: bool) -> u8 {
    match detection_type(identity, height) {
        DetectionType::Primary => 1,
        DetectionType::Secondary => 2,
        DetectionType::ModeS => 5, // roll-call: it is tracked
    }
}

fn descriptor(site: &Site, report: &SensorReport<'_>, record: &mut RecordWriter) {
    let kind = if report.is_coasted() || report.is_ended() {
        0
    } else {
        part_code(&report.track.identity, report.has(bits::HEIGHT))
    };
    record
        .item(DESCRIPTOR)
        .put(TYP, kind)
        .put(SIM, site.simulated)
        .put(SPI, report.special_identification());
}

fn status(report: &SensorReport<'_>, record: &mut RecordWriter) {
    let maintained_by = if detection(report) == DetectionType::Primary {
        1
    } else {
        2
    };
    record
        .item(STATUS)
        .put(CNF, report.is_tentative())
        .put(RAD, maintained_by)
        .put(CDM, items::climb_mode(report.climb_mps()))
        .put(TRE, report.is_ended());
}

/// Deviations of x, y, ground speed and course, where all are known and fit.
fn deviations(site: &Site, report: &SensorReport<'_>) -> Option<[i64; 4]> {
    let [xx, _, yy] = site.position_covariance(report)?;
    let [east, north] = report.velocity_mps()?;
    let [ee, en, nn] = report.velocity_covariance()?;
    let speed_mps = east.hypot(north);
    let (sin, cos) = (east / speed_mps, north / speed_mps);
    let along = quantity::sigma(sin * sin * ee + 2.0 * sin * cos * en + cos * cos * nn)?;
    let across = quantity::sigma(cos * cos * ee - 2.0 * sin * cos * en + sin * sin * nn)?;
    let [sigma_x, sigma_y, sigma_speed, sigma_course] = DEVIATIONS.fields;
    Some([
        quantity::deviation(sigma_x, xx.sqrt())?,
        quantity::deviation(sigma_y, yy.sqrt())?,
        quantity::deviation(sigma_speed, along)?,
        quantity::deviation(sigma_course, across / speed_mps)?,
    ])
}

/// The antenna points north.
pub(super) fn north_marker(site: &Site, now_utc_ns: i64, record: &mut RecordWriter) {
    service_message(site, 1, now_utc_ns, record);
}

/// The antenna crosses into a sector, which is numbered by the eight most significant bits of its azimuth.
pub(super) fn sector_crossing(site: &Site, now_utc_ns: i64, azimuth_rad: f64, record: &mut RecordWriter) {
    let circles = azimuth_rad / std::f64::consts::TAU;
    let sector = (circles.rem_euclid(1.0) * 256.0 + SECTOR_SLACK) as i64 % 256;
    service_message(site, 2, now_utc_ns, record);
    record.write(&service::SECTOR, [sector]);
}

fn service_message(site: &Site, message: i64, now_utc_ns: i64, record: &mut RecordWriter) {
    items::source(record, &service::SOURCE, site.source);
    record.write(&service::MESSAGE_TYPE, [message]);
    items::time_of_day(record, &service::TIME, now_utc_ns);
}
