//! An ADS-B ground station: target reports in CAT021 from ed 2.1 on, status in CAT023.
//!
//! A report tells what a transmitter has sent, so there is none without an address, and none for a coasted or ended track.
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
//! I021/160 is the *airborne* ground vector; the one for the surface is in the reserved expansion field, in steps of 2.8°.
//! Its content is as true on the ground, and many stations send it there; so does this one. I021/020 stays out: a track
//! does not know what kind of aircraft it is.
//!
//! # Quality
//!
//! A transmitter tells its accuracy by class. NACp, NACv and GVA are classes of 95 % bounds of horizontal position,
//! horizontal velocity and geometric altitude, with the bounds of ED-102A/DO-260B, whose version I021/210 names. Each is
//! the best class whose bound holds for the track's covariance, by the longest axis of its ellipse. Integrity (NIC, SIL,
//! PIC) says how surely bounds hold; no covariance tells that, and it is sent as not known.

use messages::alert_bits;

use super::super::items::NAUTICAL_MILE_M;
use super::super::{items, quantity};
use super::{Report, Site};
use asterix::RecordWriter;
use item::*;

/// The field reference numbers of CAT021, the same in editions 2.1 to 2.7.
mod item {
    use asterix::categories::CAT021_V2_4;
    use asterix::table::{Frn, Uap};

    const UAP: &Uap = CAT021_V2_4.uap();
    pub(super) const SOURCE: Frn = UAP.frn("010");
    pub(super) const DESCRIPTOR: Frn = UAP.frn("040");
    pub(super) const TRACK_NUMBER: Frn = UAP.frn("161");
    pub(super) const POSITION_TIME: Frn = UAP.frn("071");
    pub(super) const POSITION: Frn = UAP.frn("131");
    pub(super) const VELOCITY_TIME: Frn = UAP.frn("072");
    pub(super) const ADDRESS: Frn = UAP.frn("080");
    pub(super) const POSITION_RECEPTION: Frn = UAP.frn("073");
    pub(super) const VELOCITY_RECEPTION: Frn = UAP.frn("075");
    pub(super) const GEOMETRIC_HEIGHT: Frn = UAP.frn("140");
    pub(super) const QUALITY: Frn = UAP.frn("090");
    pub(super) const VERSION: Frn = UAP.frn("210");
    pub(super) const MODE_3A: Frn = UAP.frn("070");
    pub(super) const FLIGHT_LEVEL: Frn = UAP.frn("145");
    pub(super) const TARGET_STATUS: Frn = UAP.frn("200");
    pub(super) const BAROMETRIC_CLIMB: Frn = UAP.frn("155");
    pub(super) const GEOMETRIC_CLIMB: Frn = UAP.frn("157");
    pub(super) const GROUND_VECTOR: Frn = UAP.frn("160");
    pub(super) const IDENTIFICATION: Frn = UAP.frn("170");
    pub(super) const OPERATIONAL_STATUS: Frn = UAP.frn("008");
}

/// The field reference numbers of CAT023, the same in every edition.
mod status_item {
    use asterix::categories::CAT023_V1_3;
    use asterix::table::{Frn, Uap};

    const UAP: &Uap = CAT023_V1_3.uap();
    pub(super) const SOURCE: Frn = UAP.frn("010");
    pub(super) const REPORT_TYPE: Frn = UAP.frn("000");
    pub(super) const TIME: Frn = UAP.frn("070");
    pub(super) const STATUS: Frn = UAP.frn("100");
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

/// The best class, from 1, whose bound holds; 0 if none does. Bounds become narrower.
pub(super) fn class(error: f64, bounds: &[f64]) -> u8 {
    bounds.iter().take_while(|bound| error < **bound).count() as u8
}

/// Half the length of the longest axis of an ellipse with this covariance (xx, xy, yy), in its unit's root.
pub(super) fn longest_sigma([xx, xy, yy]: [f64; 3]) -> Option<f64> {
    let (mean, half) = ((xx + yy) / 2.0, (xx - yy) / 2.0);
    quantity::sigma(mean + half.hypot(xy))
}

pub(super) fn write(site: &Site, report: &Report<'_>, record: &mut RecordWriter) {
    let (track, identity) = (report.track, &report.track.identity);
    let time_ns = track.time_of_measurement_ns;
    let velocity = report.velocity_mps();
    items::source(record, SOURCE, site.source);
    descriptor(site, report, record);
    record.item(TRACK_NUMBER).bits(u64::from(report.number), 16);
    items::time_of_day(record, POSITION_TIME, time_ns);
    if let Some(place) = &report.place {
        items::geodetic(record, POSITION, &place.geodetic, 32, 30);
    }
    if velocity.is_some() {
        items::time_of_day(record, VELOCITY_TIME, time_ns);
    }
    items::address(record, ADDRESS, identity);
    items::time_of_day(record, POSITION_RECEPTION, time_ns);
    if velocity.is_some() {
        items::time_of_day(record, VELOCITY_RECEPTION, time_ns);
    }
    if let Some(height) = site.geometric(report.height_m()).and_then(items::height) {
        record.item(GEOMETRIC_HEIGHT).signed(height, 16);
    }
    quality(site, report, record);
    if let Some(code) = identity.mode_3a() {
        record.item(MODE_3A).bits(u64::from(code & 0o7777), 16);
    }
    if let Some(level) = site
        .barometric(report.height_m())
        .and_then(|height_m| items::level(height_m, 16))
    {
        record.item(FLIGHT_LEVEL).signed(level, 16);
    }
    target_status(report, record);
    let climb = |climb_mps: f64| quantity::signed(climb_mps, items::CLIMB_LSB_MPS, 15);
    if let Some(climb) = site.barometric(report.climb_mps()).and_then(climb) {
        record.item(BAROMETRIC_CLIMB).bits(0, 1).signed(climb, 15);
    }
    if let Some(climb) = site.geometric(report.climb_mps()).and_then(climb) {
        record.item(GEOMETRIC_CLIMB).bits(0, 1).signed(climb, 15);
    }
    if let Some((speed, course)) = velocity.and_then(|velocity| items::ground_vector(velocity, 15)) {
        record.item(GROUND_VECTOR).bits(0, 1).bits(speed, 15).bits(course, 16);
    }
    if let Some(call_sign) = items::call_sign(identity) {
        record.item(IDENTIFICATION).bits(call_sign, 48);
    }
    if track.alerts & alert_bits::RESOLUTION_ADVISORY != 0 {
        record.item(OPERATIONAL_STATUS).bits(0b1000_0000, 8); // RA active, so TCAS operates; no other capability known
    }
}

fn descriptor(site: &Site, report: &Report<'_>, record: &mut RecordWriter) {
    const STEP_UNKNOWN: u8 = 2;
    let second = u8::from(report.on_ground()) << 5 | u8::from(site.simulated) << 4;
    // A second part must say whether a selected altitude can be had. None is sent.
    let no_selected_altitude = if second == 0 { 0 } else { 1 << 2 };
    record
        .item(DESCRIPTOR)
        .extended(&[STEP_UNKNOWN << 2, second | no_selected_altitude]);
}

fn quality(site: &Site, report: &Report<'_>, record: &mut RecordWriter) {
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
        .extended(&[velocity_class << 4, position_class, height_class]);
    const VERSION_2: u64 = 2;
    const EXTENDED_SQUITTER: u64 = 2;
    record
        .item(VERSION)
        .bits(0, 2)
        .bits(VERSION_2, 3)
        .bits(EXTENDED_SQUITTER, 3);
}

/// I021/200: the emergency, and what Mode S calls surveillance status.
fn target_status(report: &Report<'_>, record: &mut RecordWriter) {
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
    const LNAV_UNKNOWN: u64 = 1; // the document's value for "not told"
    record
        .item(TARGET_STATUS)
        .bits(0, 1)
        .bits(LNAV_UNKNOWN, 1)
        .bits(0, 1)
        .bits(emergency, 3)
        .bits(surveillance_status, 2);
}

/// The ground station status report: its data may be used.
pub(super) fn status(site: &Site, now_utc_ns: i64, record: &mut RecordWriter) {
    use status_item::*;
    items::source(record, SOURCE, site.source);
    record.item(REPORT_TYPE).bits(1, 8);
    items::time_of_day(record, TIME, now_utc_ns);
    record.item(STATUS).extended(&[0]);
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
