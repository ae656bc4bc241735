//! A multilateration system: target reports in CAT020, status in CAT019.
//!
//! | item | from | |
//! | --- | --- | --- |
//! | 020 | identity, alerts, ground state | Mode S or not, SPI, GBS; from ed 1.10 on, kind of address not known |
//! | 041, 042 | `position_m` | on the ellipsoid, and in the plane at the system's reference point |
//! | 070, 220, 245 | `identity` | call signs are downlinked: nothing else brings them to a track |
//! | 090 or 105 | height | see [`HeightReference`](super::super::HeightReference) |
//! | 161 | `track_number` | shortened to 12 bits |
//! | 170 | state, rate of climb | positions are smoothed (STH): they are a tracker's |
//! | 202 | `velocity_mps` | along x and y of 042 |
//! | 230 | alerts | with Mode S targets that raise any, since I020/020 has only SPI |
//! | 500 SDP | `covariance` | with a correlation only if positive: the item's number has no sign |
//!
//! While coasting, codes are marked as not received just now.

use messages::alert_bits;

use super::super::{items, quantity};
use super::{SensorReport, Site};
use asterix::categories::{CAT019, CAT020};
use asterix::field::{Elements, Field, added, elements, field, item, subitem, whole};
use asterix::{Category, Frn, RecordWriter};

const SOURCE: Elements<2> = elements(CAT020, "010", ["SAC", "SIC"]);
const TIME: Elements<1> = whole(CAT020, "140");
const GEODETIC_POSITION: Elements<2> = elements(CAT020, "041", ["LAT", "LON"]);
const CARTESIAN_POSITION: Elements<2> = elements(CAT020, "042", ["X", "Y"]);
const TRACK_NUMBER: Elements<1> = elements(CAT020, "161", ["TRN"]);
const MODE_3A: Elements<2> = elements(CAT020, "070", ["L", "MODE3A"]);
const VELOCITY: Elements<2> = elements(CAT020, "202", ["VX", "VY"]);
const FLIGHT_LEVEL: Elements<1> = elements(CAT020, "090", ["FL"]);
const ADDRESS: Elements<1> = whole(CAT020, "220");
const IDENTIFICATION: Elements<2> = elements(CAT020, "245", ["STI", "CHR"]);
const GEOMETRIC_HEIGHT: Elements<1> = whole(CAT020, "105");
const FLIGHT_STATUS: Elements<2> = elements(CAT020, "230", ["STAT", "AIC"]);

const DESCRIPTOR: Frn = item(CAT020, "020");
const SSR: Field = field(CAT020, &["020", "SSR"]);
const MS: Field = field(CAT020, &["020", "MS"]);
const SPI: Field = field(CAT020, &["020", "SPI"]);
const GBS: Field = field(CAT020, &["020", "GBS"]);
const SIM: Field = field(CAT020, &["020", "SIM"]);
/// Kind of address.
const CF: Field = added(CAT020, &["020", "CF"]);

const STATUS: Frn = item(CAT020, "170");
const CNF: Field = field(CAT020, &["170", "CNF"]);
const TRE: Field = field(CAT020, &["170", "TRE"]);
const CST: Field = field(CAT020, &["170", "CST"]);
const CDM: Field = field(CAT020, &["170", "CDM"]);
const STH: Field = field(CAT020, &["170", "STH"]);

const ACCURACY: Frn = item(CAT020, "500");
const SDP: usize = subitem(CAT020, "500", "SDP");
const SDP_X: Field = field(CAT020, &["500", "SDP", "X"]);
const SDP_Y: Field = field(CAT020, &["500", "SDP", "Y"]);
const SDP_XY: Field = field(CAT020, &["500", "SDP", "XY"]);
const SDH: usize = subitem(CAT020, "500", "SDH");
const SIGMA_HEIGHT: Field = field(CAT020, &["500", "SDH"]);

/// Items of CAT019.
mod service {
    use super::*;

    pub(super) const SOURCE: Elements<2> = elements(CAT019, "010", ["SAC", "SIC"]);
    pub(super) const MESSAGE_TYPE: Elements<1> = whole(CAT019, "000");
    pub(super) const TIME: Elements<1> = whole(CAT019, "140");
    /// System status; all numbers 0 mean operational.
    pub(super) const STATUS: Frn = item(CAT019, "550");
    pub(super) const REFERENCE_POINT: Elements<2> = elements(CAT019, "600", ["LAT", "LON"]);
}

/// I020/230 where any of these is raised.
const FLIGHT_STATUS_ALERTS: u8 =
    items::EMERGENCIES | alert_bits::TRANSPONDER_ALERT | alert_bits::SPECIAL_IDENTIFICATION;

/// Differences between editions.
#[derive(Debug)]
pub(super) struct MultilaterationForm {
    /// True if I020/020 states the kind of address.
    has_address_kind: bool,
}

impl MultilaterationForm {
    pub(super) fn new(table: &'static Category) -> Self {
        Self {
            has_address_kind: table.edition >= CF.since,
        }
    }

    pub(super) fn write(&self, site: &Site, report: &SensorReport<'_>, record: &mut RecordWriter) {
        let (track, identity) = (report.track, &report.track.identity);
        items::source(record, &SOURCE, site.source);
        self.descriptor(site, report, record);
        items::time_of_day(record, &TIME, track.time_of_measurement_ns);
        if let Some(place) = &report.place {
            items::geodetic(record, &GEODETIC_POSITION, &place.geodetic);
            let [x, y, _] = site.frame.to_cartesian(track.position_m);
            items::quantities(record, &CARTESIAN_POSITION, [x, y]);
        }
        record.write(&TRACK_NUMBER, [i64::from(report.number)]);
        status_of(report, record);
        items::mode_3a(record, &MODE_3A, identity, report.is_received());
        if let Some(velocity) = site.velocity_mps(report) {
            items::quantities(record, &VELOCITY, velocity);
        }
        items::level(record, &FLIGHT_LEVEL, site.barometric(report.height_m()));
        items::number(record, &ADDRESS, items::address(identity));
        if let Some(call_sign) = items::call_sign(identity) {
            const DOWNLINKED: i64 = 2;
            record.write(&IDENTIFICATION, [DOWNLINKED, call_sign]);
        }
        items::height(record, &GEOMETRIC_HEIGHT, site.geometric(report.height_m()));
        accuracy(site, report, record);
        if identity.address().is_some() && track.alerts & FLIGHT_STATUS_ALERTS != 0 && !report.is_ended() {
            items::flight_status(record, &FLIGHT_STATUS, identity, track.alerts, report.on_ground());
        }
    }

    fn descriptor(&self, site: &Site, report: &SensorReport<'_>, record: &mut RecordWriter) {
        const ADDRESS_KIND_UNKNOWN: u8 = 3;
        let mode_s = report.track.identity.address().is_some();
        record
            .item(DESCRIPTOR)
            .put(SSR, !mode_s)
            .put(MS, mode_s)
            .put(SPI, report.special_identification())
            .put(GBS, report.on_ground())
            .put(SIM, site.simulated)
            .put(CF, if self.has_address_kind { ADDRESS_KIND_UNKNOWN } else { 0 });
    }
}

fn status_of(report: &SensorReport<'_>, record: &mut RecordWriter) {
    record
        .item(STATUS)
        .put(CNF, report.is_tentative())
        .put(TRE, report.is_ended())
        .put(CST, report.is_coasted())
        .put(CDM, items::climb_mode(report.climb_mps()))
        .put(STH, true);
}

/// Writes deviations of x, y and of the geometric height, where they are known and fit.
fn accuracy(site: &Site, report: &SensorReport<'_>, record: &mut RecordWriter) {
    let position = site.position_covariance(report).and_then(|[xx, xy, yy]| {
        let (x, y) = (xx.sqrt(), yy.sqrt());
        let correlation = quantity::capped(SDP_XY, (xy / (x * y)).min(1.0));
        Some((
            quantity::deviation(SDP_X, x)?,
            quantity::deviation(SDP_Y, y)?,
            correlation,
        ))
    });
    if let Some((x, y, xy)) = position {
        record
            .subitem(ACCURACY, SDP)
            .put(SDP_X, x)
            .put(SDP_Y, y)
            .put(SDP_XY, xy);
    }
    let height = site
        .geometric(report.height_sigma_m())
        .and_then(|sigma_m| quantity::deviation(SIGMA_HEIGHT, sigma_m));
    if let Some(height) = height {
        record.subitem(ACCURACY, SDH).put(SIGMA_HEIGHT, height);
    }
}

/// Writes the periodic status message: in operation, with the reference point of the positions in the plane.
pub(super) fn status(site: &Site, now_utc_ns: i64, record: &mut RecordWriter) {
    items::source(record, &service::SOURCE, site.source);
    record.write(&service::MESSAGE_TYPE, [2]);
    items::time_of_day(record, &service::TIME, now_utc_ns);
    record.item(service::STATUS);
    let reference = site.system.to_geodetic(site.frame.cartesian([0.0; 3]));
    items::geodetic(record, &service::REFERENCE_POINT, &reference);
}
