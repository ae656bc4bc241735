//! An ADS-B ground station: target reports in CAT021 from ed 2.1 on, status in CAT023.
//!
//! A report repeats the data sent by a transmitter. Therefore there are no reports without an address, and no reports
//! for coasted or terminated tracks.
//!
//! | item | from | |
//! | --- | --- | --- |
//! | 040 | ground state | GBS; address type ICAO, altitude step not known |
//! | 071, 073 | `time_of_measurement_ns` | when the position held and was received: on these tracks one time |
//! | 072, 075 | the same | for the velocity |
//! | 070, 080, 170 | `identity` | |
//! | 131 | `position_m` | in high resolution |
//! | 140 or 145 | height | see [`HeightReference`](super::super::HeightReference) |
//! | 155 or 157 | rate of climb | likewise |
//! | 090, 210 | `covariance` | see below |
//! | 160 | `velocity_mps` | speed over ground and course from true north at the target |
//! | 161 | `track_number` | shortened to 12 bits |
//! | 200, 008 | alerts | where any is raised |
//!
//! I021/160 is the *airborne* ground vector; the surface vector is in the reserved expansion field, in steps of 2.8°.
//! The airborne item is also correct on the ground, and many stations use it there; so does this sender. I021/020 is
//! omitted: a track does not contain the aircraft's category.
//!
//! # Quality
//!
//! A transmitter states its accuracy by class. NACp, NACv and GVA are classes of 95 % bounds of horizontal position,
//! horizontal velocity and geometric altitude, with the bounds of ED-102A/DO-260B, the version named by I021/210.
//! Each is the best class whose bound holds for the longest axis of the track's covariance ellipse. Integrity (NIC,
//! SIL, PIC) is the reliability of bounds, which a covariance does not contain; integrity is sent as unknown.

use messages::alert_bits;

use super::super::{items, quantity};
use super::{SensorReport, Site};
use asterix::categories::{CAT021_V2, CAT023};
use asterix::field::{Elements, Field, NAUTICAL_MILE_M, elements, field, item, whole};
use asterix::{Frn, RecordWriter};

const SOURCE: Elements<2> = elements(CAT021_V2, "010", ["SAC", "SIC"]);
const TRACK_NUMBER: Elements<1> = elements(CAT021_V2, "161", ["TRNUM"]);
const POSITION_TIME: Elements<1> = whole(CAT021_V2, "071");
const POSITION: Elements<2> = elements(CAT021_V2, "131", ["LAT", "LON"]);
const VELOCITY_TIME: Elements<1> = whole(CAT021_V2, "072");
const ADDRESS: Elements<1> = whole(CAT021_V2, "080");
const POSITION_RECEPTION: Elements<1> = whole(CAT021_V2, "073");
const VELOCITY_RECEPTION: Elements<1> = whole(CAT021_V2, "075");
const GEOMETRIC_HEIGHT: Elements<1> = whole(CAT021_V2, "140");
const VERSION: Elements<2> = elements(CAT021_V2, "210", ["VN", "LTT"]);
const MODE_3A: Elements<1> = elements(CAT021_V2, "070", ["MODE3A"]);
const FLIGHT_LEVEL: Elements<1> = whole(CAT021_V2, "145");
const BAROMETRIC_CLIMB: Elements<1> = elements(CAT021_V2, "155", ["BVR"]);
const GEOMETRIC_CLIMB: Elements<1> = elements(CAT021_V2, "157", ["GVR"]);
const GROUND_VECTOR: Elements<2> = elements(CAT021_V2, "160", ["GS", "TA"]);
const IDENTIFICATION: Elements<1> = whole(CAT021_V2, "170");
const TARGET_STATUS: Elements<3> = elements(CAT021_V2, "200", ["LNAV", "PS", "SS"]);
/// An advisory is active, so the system for it operates; no other capability is known.
const OPERATIONAL_STATUS: Elements<1> = elements(CAT021_V2, "008", ["RA"]);

const DESCRIPTOR: Frn = item(CAT021_V2, "040");
const ARC: Field = field(CAT021_V2, &["040", "ARC"]);
const GBS: Field = field(CAT021_V2, &["040", "GBS"]);
const SIM: Field = field(CAT021_V2, &["040", "SIM"]);
const SAA: Field = field(CAT021_V2, &["040", "SAA"]);

const QUALITY: Frn = item(CAT021_V2, "090");
const NACV: Field = field(CAT021_V2, &["090", "NUCRNACV"]);
const NACP: Field = field(CAT021_V2, &["090", "NACP"]);
const GVA: Field = field(CAT021_V2, &["090", "GVA"]);

/// Items of CAT023.
mod service {
    use super::*;

    pub(super) const SOURCE: Elements<2> = elements(CAT023, "010", ["SAC", "SIC"]);
    pub(super) const REPORT_TYPE: Elements<1> = whole(CAT023, "000");
    pub(super) const TIME: Elements<1> = whole(CAT023, "070");
    /// Ground station status; all numbers 0 mean that the station's data may be used.
    pub(super) const STATUS: Frn = item(CAT023, "100");
}

/// Ratio of the radius that holds 95 % of a circular normal distribution to its standard deviation per axis. Of an
/// ellipse's long axis it holds more.
pub(super) const RADIUS95_SIGMAS: f64 = 2.447_746_8;
/// Half the interval that holds 95 % of a normal distribution, in standard deviations.
const INTERVAL95_SIGMAS: f64 = 1.959_964;

/// Bounds of the horizontal position error, metres, of NACp 1 to 11.
const NACP_BOUNDS_M: [f64; 11] = [
    10.0 * NAUTICAL_MILE_M,
    4.0 * NAUTICAL_MILE_M,
    2.0 * NAUTICAL_MILE_M,
    NAUTICAL_MILE_M,
    0.5 * NAUTICAL_MILE_M,
    0.3 * NAUTICAL_MILE_M,
    0.1 * NAUTICAL_MILE_M,
    0.05 * NAUTICAL_MILE_M,
    30.0,
    10.0,
    3.0,
];
/// Bounds of the horizontal velocity error, metres per second, of NACv (and NUCr) 1 to 4.
pub(super) const VELOCITY_BOUNDS_MPS: [f64; 4] = [10.0, 3.0, 1.0, 0.3];
/// Bounds of the error of geometric altitude, metres, of GVA 1 and 2.
const GVA_BOUNDS_M: [f64; 2] = [150.0, 45.0];

/// Returns the best class, from 1, whose bound holds; 0 without such a class. The bounds decrease.
pub(super) fn class(error: f64, bounds: &[f64]) -> u8 {
    bounds.iter().take_while(|bound| error < **bound).count() as u8
}

/// Half the length of the longest axis of an ellipse with this covariance (xx, xy, yy), in its unit's root.
pub(super) fn longest_sigma([xx, xy, yy]: [f64; 3]) -> Option<f64> {
    let (mean, half) = ((xx + yy) / 2.0, (xx - yy) / 2.0);
    quantity::sigma(mean + half.hypot(xy))
}

pub(super) fn write(site: &Site, report: &SensorReport<'_>, record: &mut RecordWriter) {
    let (track, identity) = (report.track, &report.track.identity);
    let time_ns = track.time_of_measurement_ns;
    let velocity = report.velocity_mps();
    items::source(record, &SOURCE, site.source);
    descriptor(site, report, record);
    record.write(&TRACK_NUMBER, [i64::from(report.number)]);
    items::time_of_day(record, &POSITION_TIME, time_ns);
    if let Some(place) = &report.place {
        items::geodetic(record, &POSITION, &place.geodetic);
    }
    if velocity.is_some() {
        items::time_of_day(record, &VELOCITY_TIME, time_ns);
    }
    items::number(record, &ADDRESS, items::address(identity));
    items::time_of_day(record, &POSITION_RECEPTION, time_ns);
    if velocity.is_some() {
        items::time_of_day(record, &VELOCITY_RECEPTION, time_ns);
    }
    items::height(record, &GEOMETRIC_HEIGHT, site.geometric(report.height_m()));
    quality(site, report, record);
    let code = identity.mode_3a().map(|code| i64::from(code & 0o7777));
    items::number(record, &MODE_3A, code);
    items::level(record, &FLIGHT_LEVEL, site.barometric(report.height_m()));
    target_status(report, record);
    if let Some(climb_mps) = site.barometric(report.climb_mps()) {
        items::quantities(record, &BAROMETRIC_CLIMB, [climb_mps]);
    }
    if let Some(climb_mps) = site.geometric(report.climb_mps()) {
        items::quantities(record, &GEOMETRIC_CLIMB, [climb_mps]);
    }
    if let Some(velocity) = velocity {
        items::ground_vector(record, &GROUND_VECTOR, velocity);
    }
    items::number(record, &IDENTIFICATION, items::call_sign(identity));
    if track.alerts & alert_bits::RESOLUTION_ADVISORY != 0 {
        record.write(&OPERATIONAL_STATUS, [1]);
    }
}

fn descriptor(site: &Site, report: &SensorReport<'_>, record: &mut RecordWriter) {
    const STEP_UNKNOWN: i64 = 2;
    // A second part would have to state whether a selected altitude is available. No second part is sent.
    let has_second_part = report.on_ground() || site.simulated;
    record
        .item(DESCRIPTOR)
        .put(ARC, STEP_UNKNOWN)
        .put(GBS, report.on_ground())
        .put(SIM, site.simulated)
        .put(SAA, has_second_part);
}

fn quality(site: &Site, report: &SensorReport<'_>, record: &mut RecordWriter) {
    let Some(position) = site.position_covariance(report).and_then(longest_sigma) else {
        return;
    };
    let velocity = report.velocity_covariance().and_then(longest_sigma);
    let velocity_class = velocity.map_or(0, |sigma| class(RADIUS95_SIGMAS * sigma, &VELOCITY_BOUNDS_MPS));
    let position_class = class(RADIUS95_SIGMAS * position, &NACP_BOUNDS_M);
    let height = site.geometric(report.height_sigma_m());
    let height_class = height.map_or(0, |sigma| class(INTERVAL95_SIGMAS * sigma, &GVA_BOUNDS_M));
    record
        .item(QUALITY)
        .put(NACV, velocity_class)
        .put(NACP, position_class)
        .put(GVA, height_class);
    const VERSION_2: i64 = 2;
    const EXTENDED_SQUITTER: i64 = 2;
    record.write(&VERSION, [VERSION_2, EXTENDED_SQUITTER]);
}

/// Writes I021/200: the emergency, and the surveillance status of Mode S.
fn target_status(report: &SensorReport<'_>, record: &mut RecordWriter) {
    let alerts = report.track.alerts;
    let emergency = items::emergency(alerts);
    let surveillance_status = if alerts & items::EMERGENCIES != 0 {
        1
    } else if alerts & alert_bits::TRANSPONDER_ALERT != 0 {
        2
    } else if report.special_identification() {
        3
    } else {
        0
    };
    if emergency == 0 && surveillance_status == 0 {
        return;
    }
    const LNAV_UNKNOWN: i64 = 1; // the document's value for "not told"
    record.write(&TARGET_STATUS, [LNAV_UNKNOWN, emergency, surveillance_status]);
}

/// Writes the ground station status report: its data may be used.
pub(super) fn status(site: &Site, now_utc_ns: i64, record: &mut RecordWriter) {
    items::source(record, &service::SOURCE, site.source);
    record.write(&service::REPORT_TYPE, [1]);
    items::time_of_day(record, &service::TIME, now_utc_ns);
    record.item(service::STATUS);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn classes_hold_what_they_promise() {
        assert_eq!(class(2.99, &NACP_BOUNDS_M), 11);
        assert_eq!(class(3.0, &NACP_BOUNDS_M), 10, "less than 3 m, says the document");
        assert_eq!(class(0.3 * NAUTICAL_MILE_M, &NACP_BOUNDS_M), 5);
        assert_eq!(class(20_000.0, &NACP_BOUNDS_M), 0);
        assert_eq!(class(f64::INFINITY, &NACP_BOUNDS_M), 0);
        assert_eq!(class(0.31, &VELOCITY_BOUNDS_MPS), 3);
        assert_eq!(class(44.0, &GVA_BOUNDS_M), 2);
    }

    #[test]
    fn the_longest_axis_is_found_in_any_direction() {
        assert_eq!(longest_sigma([9.0, 0.0, 4.0]), Some(3.0));
        assert_eq!(longest_sigma([4.0, 0.0, 9.0]), Some(3.0));
        // The first turned by 45°.
        assert!((longest_sigma([6.5, 2.5, 6.5]).unwrap() - 3.0).abs() < 1e-12);
        assert_eq!(longest_sigma([0.0, 0.0, 0.0]), None);
    }
}
