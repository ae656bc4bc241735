//! CAT021 before ed 1: ADS-B.

use asterix::categories::{CAT021_V0, CAT021_V0_23, CAT021_V0_24, CAT021_V0_25, CAT021_V0_26};

use super::navigation::{covariance_of_velocity_category, radius_of_nucp};
use super::*;

const TIME: Elements<1> = whole(CAT021_V0, "030");
/// Position of 24 bits each in the first edition, of 32 later.
const GEODETIC_V0_23: Elements<2> = elements(&[&CAT021_V0_23], "130", ["LAT", "LON"]);
const GEODETIC: Elements<2> = elements(&[&CAT021_V0_24, &CAT021_V0_25, &CAT021_V0_26], "130", ["LAT", "LON"]);
const GROUND_VECTOR: Elements<2> = elements(CAT021_V0, "160", ["GS", "TA"]);
const ADDRESS: Elements<1> = whole(CAT021_V0, "080");
const CALLSIGN: Elements<1> = whole(CAT021_V0, "170");
const POSITION_CATEGORY: Elements<1> = elements(CAT021_V0, "090", ["PA"]);
const VELOCITY_CATEGORY: Elements<1> = whole(CAT021_V0, "095");
const PRESSURE_ALTITUDE: Elements<1> = whole(CAT021_V0, "145");
const GEOMETRIC_ALTITUDE: Elements<1> = whole(CAT021_V0, "140");
const BAROMETRIC_RATE: Elements<1> = whole(CAT021_V0, "155");
const GEOMETRIC_RATE: Elements<1> = whole(CAT021_V0, "157");
const EMERGENCY: Elements<1> = whole(CAT021_V0, "200");
const MODE_3A: Reply = Reply::of(&[&CAT021_V0_26], "070", "MODE3A");

const DESCRIPTOR: Frn = item(CAT021_V0, "040");
const GBS: Field = field(CAT021_V0, &["040", "GBS"]);
const SIM: Field = field(CAT021_V0, &["040", "SIM"]);
const TST: Field = field(CAT021_V0, &["040", "TST"]);
const RAB: Field = field(CAT021_V0, &["040", "RAB"]);
const SPI: Field = field(CAT021_V0, &["040", "SPI"]);

pub(super) fn read(record: &Record<'_>) -> Option<Reading> {
    record
        .table()
        .is_one_of(CAT021_V0)
        .then(|| Reading::Target(observation(record)))
}

fn observation(record: &Record<'_>) -> Observation {
    let descriptor = record.octets(DESCRIPTOR);
    let address = ADDRESS.number(record);
    let is_coarse = record.table().is_one_of(&[&CAT021_V0_23]);
    Observation {
        sac_sic: record.sender(),
        time_of_day_ns: time_of_day_ns(record, &TIME),
        field_monitor: RAB.is_set(descriptor),
        test: SIM.is_set(descriptor) || TST.is_set(descriptor),
        // These editions have no track number: a transmitter is its own track.
        track_number: address.map(|address| address as u32),
        identity: identity(MODE_3A.code(record), address, CALLSIGN.number(record)),
        geodetic: if is_coarse { &GEODETIC_V0_23 } else { &GEODETIC }.quantities(record),
        velocity: GROUND_VECTOR.quantities(record).map(components),
        axes: Axes::Target,
        velocity_covariance: VELOCITY_CATEGORY
            .number(record)
            .and_then(|category| covariance_of_velocity_category(category as u8)),
        pressure_altitude_m: PRESSURE_ALTITUDE.quantity(record),
        geometric_height_m: GEOMETRIC_ALTITUDE.quantity(record),
        ellipsoid_height_m: GEOMETRIC_ALTITUDE.quantity(record),
        vertical_rate_mps: BAROMETRIC_RATE
            .quantity(record)
            .or_else(|| GEOMETRIC_RATE.quantity(record)),
        on_ground: GBS.is_set(descriptor),
        alerts: Alerts::flag(alert_bits::SPECIAL_IDENTIFICATION, SPI.is_set(descriptor))
            | alerts_of_emergency(EMERGENCY.number(record).map(|number| number as u8)),
        state: TrackState::Confirmed,
        quality: POSITION_CATEGORY
            .number(record)
            .map_or(Quality::Unstated, |category| radius_of_nucp(category as u8)),
        ..Observation::default()
    }
}
