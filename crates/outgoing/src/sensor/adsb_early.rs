//! An ADS-B ground station of the first generation: CAT021, editions 0.23 to 0.26.
//!
//! As in the [later editions](super::adsb), only received data are reported. There are no track numbers: the address
//! identifies the track. The position has 24 bits (2.4 m) in ed 0.23 and 32 bits later; Mode 3/A codes are present
//! from ed 0.26 on. SPI is in I021/040, emergencies are in I021/200; other alerts have no place.
//!
//! **Quality** is a class each for position (NUCp, I021/090) and velocity (NUCr, I021/095): the best class whose 95 %
//! bound holds, by the bounds of RTCA DO-260. These bounds differ from the bounds of the later NACp.

use super::super::items;
use super::adsb::{RADIUS95_SIGMAS, VELOCITY_BOUNDS_MPS, class, longest_sigma};
use super::{SensorReport, Site};
use asterix::categories::{CAT021_V0, CAT021_V0_26};
use asterix::field::{Elements, NAUTICAL_MILE_M, elements, whole};
use asterix::{Category, RecordWriter};

const SOURCE: Elements<2> = elements(CAT021_V0, "010", ["SAC", "SIC"]);
const DESCRIPTOR: Elements<5> = elements(CAT021_V0, "040", ["GBS", "SIM", "SAA", "SPI", "ATP"]);
const TIME: Elements<1> = whole(CAT021_V0, "030");
const ADDRESS: Elements<1> = whole(CAT021_V0, "080");
const GEOMETRIC_ALTITUDE: Elements<1> = whole(CAT021_V0, "140");
const POSITION_CATEGORY: Elements<1> = elements(CAT021_V0, "090", ["PA"]);
const LINK_TECHNOLOGY: Elements<1> = elements(CAT021_V0, "210", ["MDS"]);
const FLIGHT_LEVEL: Elements<1> = whole(CAT021_V0, "145");
const BAROMETRIC_CLIMB: Elements<1> = whole(CAT021_V0, "155");
const GEOMETRIC_CLIMB: Elements<1> = whole(CAT021_V0, "157");
const GROUND_VECTOR: Elements<2> = elements(CAT021_V0, "160", ["GS", "TA"]);
const IDENTIFICATION: Elements<1> = whole(CAT021_V0, "170");
const VELOCITY_CATEGORY: Elements<1> = whole(CAT021_V0, "095");
const TARGET_STATUS: Elements<1> = whole(CAT021_V0, "200");
/// Mode 3/A code, from ed 0.26 on.
const MODE_3A: Elements<2> = elements(&[&CAT021_V0_26], "070", ["L", "MODE3A"]);

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

/// Differences between editions.
#[derive(Debug)]
pub(super) struct AdsbForm {
    position: Elements<2>,
    has_mode_3a: bool,
}

impl AdsbForm {
    pub(super) fn new(table: &'static Category) -> Self {
        Self {
            position: elements(&[table], "130", ["LAT", "LON"]),
            has_mode_3a: table.item("070").is_some(),
        }
    }

    pub(super) fn write(&self, site: &Site, report: &SensorReport<'_>, record: &mut RecordWriter) {
        let (track, identity) = (report.track, &report.track.identity);
        items::source(record, &SOURCE, site.source);
        descriptor(site, report, record);
        items::time_of_day(record, &TIME, track.time_of_measurement_ns);
        if let Some(place) = &report.place {
            items::geodetic(record, &self.position, &place.geodetic);
        }
        items::number(record, &ADDRESS, items::address(identity));
        items::height(record, &GEOMETRIC_ALTITUDE, site.geometric(report.height_m()));
        if let Some(sigma) = site.position_covariance(report).and_then(longest_sigma) {
            let class = class(RADIUS95_SIGMAS * sigma, &NUCP_BOUNDS_M);
            record.write(&POSITION_CATEGORY, [i64::from(class)]);
        }
        record.write(&LINK_TECHNOLOGY, [1]);
        items::level(record, &FLIGHT_LEVEL, site.barometric(report.height_m()));
        if let Some(climb_mps) = site.barometric(report.climb_mps()) {
            items::quantities(record, &BAROMETRIC_CLIMB, [climb_mps]);
        }
        if let Some(climb_mps) = site.geometric(report.climb_mps()) {
            items::quantities(record, &GEOMETRIC_CLIMB, [climb_mps]);
        }
        if let Some(velocity) = report.velocity_mps() {
            items::ground_vector(record, &GROUND_VECTOR, velocity);
        }
        items::number(record, &IDENTIFICATION, items::call_sign(identity));
        if let Some(sigma) = report.velocity_covariance().and_then(longest_sigma) {
            let class = class(RADIUS95_SIGMAS * sigma, &VELOCITY_BOUNDS_MPS);
            record.write(&VELOCITY_CATEGORY, [i64::from(class)]);
        }
        let emergency = items::emergency(track.alerts);
        items::number(
            record,
            &TARGET_STATUS,
            Some(emergency).filter(|emergency| *emergency != 0),
        );
        if self.has_mode_3a {
            items::mode_3a(record, &MODE_3A, identity, true);
        }
    }
}

fn descriptor(site: &Site, report: &SensorReport<'_>, record: &mut RecordWriter) {
    const NO_SELECTED_ALTITUDE: i64 = 1;
    const ICAO_ADDRESS: i64 = 1;
    let flags = [report.on_ground(), site.simulated, report.special_identification()];
    let [on_ground, simulated, special] = flags.map(i64::from);
    record.write(
        &DESCRIPTOR,
        [on_ground, simulated, NO_SELECTED_ALTITUDE, special, ICAO_ADDRESS],
    );
}
