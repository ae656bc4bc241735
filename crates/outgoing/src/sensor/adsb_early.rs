//! An ADS-B ground station of the first generation: CAT021, editions 0.23 to 0.26.
//!
//! As with the [later editions](super::adsb) there is a report only of what was received. Here there is no track number:
//! the address stands for the track. Position is in 24 bits (2.4 m) in ed 0.23 and in 32 bits later; Mode 3/A codes have a
//! place from ed 0.26 on. SPI is in I021/040, other alerts in I021/200, as far as they are emergencies.
//!
//! **Quality** is one class each for position (NUCp, I021/090) and velocity (NUCr, I021/095): the best whose 95 % bound
//! holds, by the bounds of RTCA DO-260. They are not those of the later NACp.

use super::super::items::NAUTICAL_MILE_M;
use super::super::{items, quantity};
use super::adsb::{RADIUS95_SIGMAS, VELOCITY_BOUNDS_MPS, class, longest_sigma};
use super::{Report, Site};
use asterix::RecordWriter;
use asterix::table::{Category, Frn};
use item::*;

/// The field reference numbers, the same in editions 0.23 to 0.26.
mod item {
    use asterix::categories::{CAT021_V0_23, CAT021_V0_26};
    use asterix::table::{Frn, Uap};

    const UAP: &Uap = CAT021_V0_23.uap();
    pub(super) const SOURCE: Frn = UAP.frn("010");
    pub(super) const DESCRIPTOR: Frn = UAP.frn("040");
    pub(super) const TIME: Frn = UAP.frn("030");
    pub(super) const POSITION: Frn = UAP.frn("130");
    pub(super) const ADDRESS: Frn = UAP.frn("080");
    pub(super) const GEOMETRIC_ALTITUDE: Frn = UAP.frn("140");
    pub(super) const FIGURE_OF_MERIT: Frn = UAP.frn("090");
    pub(super) const LINK_TECHNOLOGY: Frn = UAP.frn("210");
    pub(super) const FLIGHT_LEVEL: Frn = UAP.frn("145");
    pub(super) const BAROMETRIC_CLIMB: Frn = UAP.frn("155");
    pub(super) const GEOMETRIC_CLIMB: Frn = UAP.frn("157");
    pub(super) const GROUND_VECTOR: Frn = UAP.frn("160");
    pub(super) const IDENTIFICATION: Frn = UAP.frn("170");
    pub(super) const VELOCITY_ACCURACY: Frn = UAP.frn("095");
    pub(super) const TARGET_STATUS: Frn = UAP.frn("200");
    /// From ed 0.26 on.
    pub(super) const MODE_3A: Frn = CAT021_V0_26.uap().frn("070");
}

/// Bounds of the horizontal position error, metres, of NUCp 1 to 9.
const NUCP_BOUNDS_M: [f64; 9] = [
    10.0 * NAUTICAL_MILE_M,
    5.0 * NAUTICAL_MILE_M,
    NAUTICAL_MILE_M,
    0.5 * NAUTICAL_MILE_M,
    0.25 * NAUTICAL_MILE_M,
    0.1 * NAUTICAL_MILE_M,
    0.05 * NAUTICAL_MILE_M,
    10.0,
    3.0,
];

/// What differs between editions.
#[derive(Debug)]
pub(super) struct Form {
    /// Bits of latitude and longitude, and exponent of their LSB of 180/2^exponent degrees.
    position: (usize, u32),
    mode_3a: Option<Frn>,
}

impl Form {
    pub(super) fn new(table: &'static Category) -> Self {
        let is_coarse = matches!(items::element_of(table, "130", "LAT"), Some((24, _)));
        Self {
            position: if is_coarse { (24, 23) } else { (32, 25) },
            mode_3a: table.item("070").map(|_| MODE_3A),
        }
    }

    pub(super) fn write(&self, site: &Site, report: &Report<'_>, record: &mut RecordWriter) {
        let (track, identity) = (report.track, &report.track.identity);
        items::source(record, SOURCE, site.source);
        descriptor(site, report, record);
        items::time_of_day(record, TIME, track.time_of_measurement_ns);
        if let Some(place) = &report.place {
            let (bits, exponent) = self.position;
            items::geodetic(record, POSITION, &place.geodetic, bits, exponent);
        }
        items::address(record, ADDRESS, identity);
        if let Some(height) = site.geometric(report.height_m()).and_then(items::height) {
            record.item(GEOMETRIC_ALTITUDE).signed(height, 16);
        }
        if let Some(sigma) = site.position_covariance(report).and_then(longest_sigma) {
            let class = class(RADIUS95_SIGMAS * sigma, &NUCP_BOUNDS_M);
            record.item(FIGURE_OF_MERIT).bits(0, 12).bits(u64::from(class), 4);
        }
        record.item(LINK_TECHNOLOGY).bits(1 << 3, 8); // extended squitter
        if let Some(level) = site
            .barometric(report.height_m())
            .and_then(|height_m| items::level(height_m, 16))
        {
            record.item(FLIGHT_LEVEL).signed(level, 16);
        }
        let climb = |climb_mps: f64| quantity::signed(climb_mps, items::CLIMB_LSB_MPS, 16);
        if let Some(climb) = site.barometric(report.climb_mps()).and_then(climb) {
            record.item(BAROMETRIC_CLIMB).signed(climb, 16);
        }
        if let Some(climb) = site.geometric(report.climb_mps()).and_then(climb) {
            record.item(GEOMETRIC_CLIMB).signed(climb, 16);
        }
        // The speed is in two's complement and never negative: 15 bits.
        let vector = report
            .velocity_mps()
            .and_then(|velocity| items::ground_vector(velocity, 15));
        if let Some((speed, course)) = vector {
            record.item(GROUND_VECTOR).bits(speed, 16).bits(course, 16);
        }
        if let Some(call_sign) = items::call_sign(identity) {
            record.item(IDENTIFICATION).bits(call_sign, 48);
        }
        if let Some(sigma) = report.velocity_covariance().and_then(longest_sigma) {
            let class = class(RADIUS95_SIGMAS * sigma, &VELOCITY_BOUNDS_MPS);
            record.item(VELOCITY_ACCURACY).bits(u64::from(class), 8);
        }
        let emergency = items::emergency(track.alerts);
        if emergency != 0 {
            record.item(TARGET_STATUS).bits(emergency, 8);
        }
        if let Some(frn) = self.mode_3a {
            items::mode_3a(record, frn, identity, true);
        }
    }
}

fn descriptor(site: &Site, report: &Report<'_>, record: &mut RecordWriter) {
    const ICAO_ADDRESS: u64 = 1;
    record
        .item(DESCRIPTOR)
        .bits(0, 1)
        .bits(u64::from(report.on_ground()), 1)
        .bits(u64::from(site.simulated), 1)
        .bits(0, 2)
        .bits(1, 1) // SAA: no selected altitude is sent
        .bits(u64::from(report.special_identification()), 1)
        .bits(0, 1)
        .bits(ICAO_ADDRESS, 3)
        .bits(0, 5); // altitude step not known
}
