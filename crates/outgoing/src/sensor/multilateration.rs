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
//! | 500 SDP | `covariance` | with a correlation only where it is positive: its number has no sign |
//!
//! While coasting, codes are marked as not received just now.

use messages::alert_bits;

use super::super::{items, quantity};
use super::{Report, Site};
use asterix::{Category, RecordWriter};
use item::*;

/// The field reference numbers of CAT020, the same in every edition.
mod item {
    use asterix::categories::CAT020_V1_9;
    use asterix::table::{Frn, Uap};

    const UAP: &Uap = CAT020_V1_9.uap();
    pub(super) const SOURCE: Frn = UAP.frn("010");
    pub(super) const DESCRIPTOR: Frn = UAP.frn("020");
    pub(super) const TIME: Frn = UAP.frn("140");
    pub(super) const GEODETIC_POSITION: Frn = UAP.frn("041");
    pub(super) const CARTESIAN_POSITION: Frn = UAP.frn("042");
    pub(super) const TRACK_NUMBER: Frn = UAP.frn("161");
    pub(super) const TRACK_STATUS: Frn = UAP.frn("170");
    pub(super) const MODE_3A: Frn = UAP.frn("070");
    pub(super) const VELOCITY: Frn = UAP.frn("202");
    pub(super) const FLIGHT_LEVEL: Frn = UAP.frn("090");
    pub(super) const ADDRESS: Frn = UAP.frn("220");
    pub(super) const IDENTIFICATION: Frn = UAP.frn("245");
    pub(super) const GEOMETRIC_HEIGHT: Frn = UAP.frn("105");
    pub(super) const ACCURACY: Frn = UAP.frn("500");
    pub(super) const FLIGHT_STATUS: Frn = UAP.frn("230");
}

/// The field reference numbers of CAT019.
mod status_item {
    use asterix::categories::CAT019_V1_3;
    use asterix::table::{Frn, Uap};

    const UAP: &Uap = CAT019_V1_3.uap();
    pub(super) const SOURCE: Frn = UAP.frn("010");
    pub(super) const MESSAGE_TYPE: Frn = UAP.frn("000");
    pub(super) const TIME: Frn = UAP.frn("140");
    pub(super) const STATUS: Frn = UAP.frn("550");
    pub(super) const REFERENCE_POINT: Frn = UAP.frn("600");
}

/// LSB of positions in the plane, metres.
const POSITION_LSB_M: f64 = 0.5;
/// LSB of velocities (m/s), deviations of position (m) and their correlation.
const QUARTER: f64 = 0.25;
/// I020/230 where any of these is raised.
const FLIGHT_STATUS_ALERTS: u8 =
    items::EMERGENCIES | alert_bits::TRANSPONDER_ALERT | alert_bits::SPECIAL_IDENTIFICATION;

/// What differs between editions.
#[derive(Debug)]
pub(super) struct Form {
    /// Whether I020/020 tells what kind of address it is.
    has_address_kind: bool,
}

impl Form {
    pub(super) fn new(table: &'static Category) -> Self {
        Self {
            has_address_kind: items::element_of(table, "020", "CF").is_some(),
        }
    }

    pub(super) fn write(&self, site: &Site, report: &Report<'_>, record: &mut RecordWriter) {
        let (track, identity) = (report.track, &report.track.identity);
        items::source(record, SOURCE, site.source);
        self.descriptor(site, report, record);
        items::time_of_day(record, TIME, track.time_of_measurement_ns);
        if let Some(place) = &report.place {
            items::geodetic(record, GEODETIC_POSITION, &place.geodetic, 32, 25);
            let [x, y, _] = site.frame.to_cartesian(track.position_m);
            items::pair(record, CARTESIAN_POSITION, [x, y], POSITION_LSB_M, 24);
        }
        record.item(TRACK_NUMBER).bits(u64::from(report.number), 16);
        status_of(report, record);
        items::mode_3a(record, MODE_3A, identity, report.is_received());
        if let Some(velocity) = site.velocity_mps(report) {
            items::pair(record, VELOCITY, velocity, QUARTER, 16);
        }
        if let Some(level) = site
            .barometric(report.height_m())
            .and_then(|height_m| items::level(height_m, 14))
        {
            record.item(FLIGHT_LEVEL).bits(0, 2).signed(level, 14);
        }
        items::address(record, ADDRESS, identity);
        if let Some(call_sign) = items::call_sign(identity) {
            const DOWNLINKED: u64 = 2;
            record
                .item(IDENTIFICATION)
                .bits(DOWNLINKED, 2)
                .bits(0, 6)
                .bits(call_sign, 48);
        }
        if let Some(height) = site.geometric(report.height_m()).and_then(items::height) {
            record.item(GEOMETRIC_HEIGHT).signed(height, 16);
        }
        accuracy(site, report, record);
        if identity.address().is_some() && track.alerts & FLIGHT_STATUS_ALERTS != 0 && !report.is_ended() {
            items::flight_status(record, FLIGHT_STATUS, identity, track.alerts, report.on_ground());
        }
    }

    fn descriptor(&self, site: &Site, report: &Report<'_>, record: &mut RecordWriter) {
        const ADDRESS_KIND_UNKNOWN: u8 = 3;
        let mode_s = report.track.identity.address().is_some();
        let technology = if mode_s { 1 << 5 } else { 1 << 6 };
        let special = u8::from(report.special_identification());
        let on_ground = u8::from(report.on_ground());
        let address_kind = if self.has_address_kind { ADDRESS_KIND_UNKNOWN } else { 0 };
        record.item(DESCRIPTOR).extended(&[
            technology,
            special << 5 | on_ground << 3 | u8::from(site.simulated) << 1,
            address_kind << 5,
        ]);
    }
}

fn status_of(report: &Report<'_>, record: &mut RecordWriter) {
    let (tentative, ended) = (u8::from(report.is_tentative()), u8::from(report.is_ended()));
    let coasted = u8::from(report.is_coasted());
    let climb_mode = items::climb_mode(report.climb_mps()) as u8;
    let smoothed = 1;
    record
        .item(TRACK_STATUS)
        .extended(&[tentative << 6 | ended << 5 | coasted << 4 | climb_mode << 2 | smoothed]);
}

/// Deviations of x, y and of the geometric height, where they are known and fit.
fn accuracy(site: &Site, report: &Report<'_>, record: &mut RecordWriter) {
    let position = site.position_covariance(report).and_then(|[xx, xy, yy]| {
        let (x, y) = (xx.sqrt(), yy.sqrt());
        Some([
            quantity::deviation(x, QUARTER, 16)?,
            quantity::deviation(y, QUARTER, 16)?,
            quantity::capped((xy / (x * y)).min(1.0), QUARTER, 16),
        ])
    });
    let height = site
        .geometric(report.height_sigma_m())
        .and_then(|sigma_m| quantity::deviation(sigma_m, 0.5, 16));
    if position.is_none() && height.is_none() {
        return;
    }
    let present = u64::from(position.is_some()) << 1 | u64::from(height.is_some()) << 2; // SDP, SDH
    record.item(ACCURACY).subitems(present);
    for number in position.into_iter().flatten().chain(height) {
        record.bits(number, 16);
    }
}

/// The periodic status message: in operation, with the reference point of the positions in the plane.
pub(super) fn status(site: &Site, now_utc_ns: i64, record: &mut RecordWriter) {
    use status_item::*;
    items::source(record, SOURCE, site.source);
    record.item(MESSAGE_TYPE).bits(2, 8);
    items::time_of_day(record, TIME, now_utc_ns);
    record.item(STATUS).bits(0, 8);
    let reference = site.system.to_geodetic(site.frame.cartesian([0.0; 3]));
    items::geodetic(record, REFERENCE_POINT, &reference, 32, 30);
}
