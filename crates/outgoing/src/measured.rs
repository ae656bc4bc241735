//! Measured values of a track's last reports: I062/136, 295 and 340.
//!
//! I062/136 has the newest level of the target's transponder. I062/295 has the ages of this level and of the Mode 3/A
//! code. I062/340 describes the last report that updated the track: its sensor, and the level and the code that this
//! report had. The document excludes ADS-B from I062/340. Place and height as measured are unknown to a system track.
//!
//! A value belongs to the last report if the value is as old as the report.

use asterix::categories::CAT062;
use asterix::field::{Elements, Field, field, subitem, whole};
use asterix::{Frn, RecordWriter};
use deployment::Technology;
use frames::time::NS_PER_S;
use messages::SystemTrack;

use super::items;

const LEVEL: Elements<1> = whole(CAT062, "136");

const AGES: Frn = asterix::field::item(CAT062, "295");
const MFL: usize = subitem(CAT062, "295", "MFL");
const AGE_OF_LEVEL: Field = field(CAT062, &["295", "MFL"]);
const MDA_AGE: usize = subitem(CAT062, "295", "MDA");
const AGE_OF_CODE: Field = field(CAT062, &["295", "MDA"]);

const REPORT: Frn = asterix::field::item(CAT062, "340");
const SID: usize = subitem(CAT062, "340", "SID");
const SAC: Field = field(CAT062, &["340", "SID", "SAC"]);
const SIC: Field = field(CAT062, &["340", "SID", "SIC"]);
const MDC: usize = subitem(CAT062, "340", "MDC");
const MODE_C: Field = field(CAT062, &["340", "MDC", "LMC"]);
const MDA: usize = subitem(CAT062, "340", "MDA");
const CODE: Field = field(CAT062, &["340", "MDA", "MODE3A"]);
const TYP: usize = subitem(CAT062, "340", "TYP");
const TYPE: Field = field(CAT062, &["340", "TYP", "TYP"]);
const SIMULATED: Field = field(CAT062, &["340", "TYP", "SIM"]);

const NS_PER_MS: i64 = 1_000_000;

/// Sensor of a track's last report.
#[derive(Clone, Copy, Debug)]
pub(super) struct ReportingSensor {
    pub(super) technology: Technology,
    /// System area code and system identification code.
    pub(super) code: [u8; 2],
    pub(super) is_simulated: bool,
}

/// Writes I062/295 and I062/136.
pub(super) fn values(track: &SystemTrack, record: &mut RecordWriter) {
    if track.level_valid != 0 {
        age(record, (MFL, AGE_OF_LEVEL), track.level_age_ms);
    }
    if track.identity.mode_3a().is_some() {
        age(record, (MDA_AGE, AGE_OF_CODE), track.identity_ages.mode_3a_ms);
    }
    items::level(record, &LEVEL, track.level_m());
}

/// Writes I062/340 of a track whose last report was from `sensor`.
pub(super) fn last_report(track: &SystemTrack, sensor: ReportingSensor, record: &mut RecordWriter) {
    if sensor.technology == Technology::AdsB {
        return;
    }
    let report_age_ns = track.reference_time_ns.saturating_sub(track.time_of_measurement_ns);
    let is_of_report = |age_ms: u32| (i64::from(age_ms) * NS_PER_MS).abs_diff(report_age_ns) <= NS_PER_MS as u64;
    let [sac, sic] = sensor.code;
    record.subitem(REPORT, SID).put(SAC, sac).put(SIC, sic);
    let level_m = track.level_m().filter(|_| is_of_report(track.level_age_ms));
    if let Some(level) = level_m.and_then(|level_m| items::level_number(MODE_C, level_m)) {
        record.subitem(REPORT, MDC).put(MODE_C, level);
    }
    let is_code_new = is_of_report(track.identity_ages.mode_3a_ms);
    if let Some(code) = track.identity.mode_3a().filter(|_| is_code_new) {
        record.subitem(REPORT, MDA).put(CODE, code & 0o7777);
    }
    // The kind of other technologies' reports is not one kind only.
    let kind = match sensor.technology {
        Technology::Primary => 1u8,
        Technology::Secondary => 2,
        _ => return,
    };
    record
        .subitem(REPORT, TYP)
        .put(TYPE, kind)
        .put(SIMULATED, sensor.is_simulated);
}

/// Writes an age; the greatest means "or more".
fn age(record: &mut RecordWriter, (position, field): (usize, Field), age_ms: u32) {
    let lsb_ns = field.lsb * NS_PER_S as f64;
    let age = (f64::from(age_ms) * NS_PER_MS as f64 / lsb_ns).round() as i64;
    record.subitem(AGES, position).put(field, age.min(field.greatest()));
}
