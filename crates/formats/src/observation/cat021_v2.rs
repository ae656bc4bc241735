//! CAT021 from ed 2 on: ADS-B.
//!
//! Three generations of transponders state position accuracy in three ways: an uncertainty category (version 0), or
//! an accuracy category beside an integrity category (versions 1 and 2). The error exceeds the integrity radius with
//! the probability of an integrity level (SIL), once in ten million hours at best. The radius becomes a 95 % error by
//! that probability, and is used without an accuracy category. An accuracy category without integrity counts for less.

use asterix::categories::CAT021_V2;
use asterix::field::added;
use frames::time::NS_PER_S;

use super::navigation::{Integrity, covariance_of_velocity_category, position_quality};
use super::*;

const POSITION_TIME: Elements<1> = whole(CAT021_V2, "071");
const POSITION_RECEPTION: Elements<1> = whole(CAT021_V2, "073");
const POSITION_RECEPTION_FRACTION: Elements<2> = elements(CAT021_V2, "074", ["FSI", "TOMRP"]);
const VELOCITY_TIME: Elements<1> = whole(CAT021_V2, "072");
const VELOCITY_RECEPTION: Elements<1> = whole(CAT021_V2, "075");
const VELOCITY_RECEPTION_FRACTION: Elements<2> = elements(CAT021_V2, "076", ["FSI", "TOMRP"]);
const TRANSMISSION: Elements<1> = whole(CAT021_V2, "077");
const POSITION: Elements<2> = elements(CAT021_V2, "130", ["LAT", "LON"]);
const FINE_POSITION: Elements<2> = elements(CAT021_V2, "131", ["LAT", "LON"]);
const GROUND_VECTOR: Elements<3> = elements(CAT021_V2, "160", ["RE", "GS", "TA"]);
const TRACK_NUMBER: Elements<1> = elements(CAT021_V2, "161", ["TRNUM"]);
const ADDRESS: Elements<1> = whole(CAT021_V2, "080");
const CALLSIGN: Elements<1> = whole(CAT021_V2, "170");
const MODE_3A: Elements<1> = elements(CAT021_V2, "070", ["MODE3A"]);
const PRESSURE_ALTITUDE: Elements<1> = whole(CAT021_V2, "145");
const GEOMETRIC_HEIGHT: Elements<1> = whole(CAT021_V2, "140");
const BAROMETRIC_RATE: Elements<2> = elements(CAT021_V2, "155", ["RE", "BVR"]);
const GEOMETRIC_RATE: Elements<2> = elements(CAT021_V2, "157", ["RE", "GVR"]);
const VERSION: Elements<1> = elements(CAT021_V2, "210", ["VN"]);
const ADVISED: Elements<1> = elements(CAT021_V2, "008", ["RA"]);
const ADVISORY: Frn = item(CAT021_V2, "260");

const DESCRIPTOR: Frn = item(CAT021_V2, "040");
const RAB: Field = field(CAT021_V2, &["040", "RAB"]);
const GBS: Field = field(CAT021_V2, &["040", "GBS"]);
const SIM: Field = field(CAT021_V2, &["040", "SIM"]);
const TST: Field = field(CAT021_V2, &["040", "TST"]);
/// The position is not where other means see the target.
const IPC: Field = field(CAT021_V2, &["040", "IPC"]);
/// The two ways to decode the position disagree.
const CPR: Field = field(CAT021_V2, &["040", "CPR"]);
/// The position jumped.
const LDPJ: Field = field(CAT021_V2, &["040", "LDPJ"]);
/// The position is beyond the station's range.
const RCF: Field = field(CAT021_V2, &["040", "RCF"]);

const QUALITY: Frn = item(CAT021_V2, "090");
const NUCR_OR_NACV: Field = field(CAT021_V2, &["090", "NUCRNACV"]);
const NUCP_OR_NIC: Field = field(CAT021_V2, &["090", "NUCPNIC"]);
const NACP: Field = field(CAT021_V2, &["090", "NACP"]);
const SIL: Field = field(CAT021_V2, &["090", "SIL"]);

const STATUS: Frn = item(CAT021_V2, "200");
const ME: Field = added(CAT021_V2, &["200", "ME"]);
const PS: Field = field(CAT021_V2, &["200", "PS"]);
const SS: Field = field(CAT021_V2, &["200", "SS"]);

/// Seconds in a day.
const DAY_S: i64 = 86_400;

pub(super) fn read(record: &Record<'_>) -> Option<Reading> {
    record
        .table()
        .is_one_of(CAT021_V2)
        .then(|| Reading::Target(observation(record)))
}

fn observation(record: &Record<'_>) -> Observation {
    let (descriptor, quality) = (record.octets(DESCRIPTOR), record.octets(QUALITY));
    let address = ADDRESS.number(record);
    Observation {
        sac_sic: record.sender(),
        time_of_day_ns: time(record),
        field_monitor: RAB.is_set(descriptor),
        test: SIM.is_set(descriptor) || TST.is_set(descriptor),
        suspect: [IPC, CPR, LDPJ, RCF].iter().any(|check| check.is_set(descriptor)),
        track_number: TRACK_NUMBER.number(record).or(address).map(|number| number as u32),
        identity: identity(
            MODE_3A.number(record).map(|code| code as u16),
            address,
            CALLSIGN.number(record),
        ),
        geodetic: FINE_POSITION.quantities(record).or_else(|| POSITION.quantities(record)),
        velocity: GROUND_VECTOR
            .quantities(record)
            .and_then(|[beyond, speed, track]| (beyond == 0.0).then(|| components([speed, track]))),
        axes: Axes::Target,
        velocity_covariance: NUCR_OR_NACV.code(quality).and_then(covariance_of_velocity_category),
        pressure_altitude_m: PRESSURE_ALTITUDE.quantity(record),
        geometric_height_m: geometric_height_m(record),
        ellipsoid_height_m: geometric_height_m(record),
        vertical_rate_mps: rate_mps(record, &BAROMETRIC_RATE).or_else(|| rate_mps(record, &GEOMETRIC_RATE)),
        on_ground: GBS.is_set(descriptor),
        alerts: alerts_of_status(record)
            | ADVISED.number(record).map_or(Alerts::default(), |advised| {
                Alerts::flag(alert_bits::RESOLUTION_ADVISORY, advised == 1)
            })
            | alerts_of_advisory(record.octets(ADVISORY)),
        state: TrackState::Confirmed,
        quality: NUCP_OR_NIC.code(quality).map_or(Quality::Unstated, |category| {
            let integrity = Integrity {
                category,
                level: SIL.code(quality),
            };
            position_quality(VERSION.number(record), integrity, NACP.code(quality))
        }),
        ..Observation::default()
    }
}

/// Time at which the position applied, else was received, else the same of the velocity, which is as new within a
/// second, else when the report was sent.
fn time(record: &Record<'_>) -> Option<i64> {
    time_of_day_ns(record, &POSITION_TIME)
        .or_else(|| reception_ns(record, &POSITION_RECEPTION, &POSITION_RECEPTION_FRACTION))
        .or_else(|| time_of_day_ns(record, &VELOCITY_TIME))
        .or_else(|| reception_ns(record, &VELOCITY_RECEPTION, &VELOCITY_RECEPTION_FRACTION))
        .or_else(|| time_of_day_ns(record, &TRANSMISSION))
}

/// The time of a reception, with the fraction of its second where that was sent.
fn reception_ns(record: &Record<'_>, coarse: &Elements<1>, fine: &Elements<2>) -> Option<i64> {
    let ticks = coarse.number(record)?;
    let second = ticks as i64 / 128;
    // FSI: by how much the whole second is another one than that of the coarse time.
    let step = fine.numbers(record).and_then(|[step, fraction]| match step {
        0 => Some((0, fraction)),
        1 => Some((1, fraction)),
        2 => Some((-1, fraction)),
        _ => None,
    });
    Some(match step {
        Some((step, fraction)) if second < DAY_S => {
            (second + step).rem_euclid(DAY_S) * NS_PER_S + ((fraction as i64 * NS_PER_S) >> 30)
        }
        _ => nanoseconds(ticks),
    })
}

/// The greatest number means "greater than that".
fn geometric_height_m(record: &Record<'_>) -> Option<f64> {
    const GREATEST: u64 = (1 << (GEOMETRIC_HEIGHT.fields[0].bits - 1)) - 1;
    GEOMETRIC_HEIGHT
        .number(record)
        .filter(|number| *number != GREATEST)
        .and(GEOMETRIC_HEIGHT.quantity(record))
}

/// Returns a rate of climb; the bit before the rate marks a rate beyond the range of the item.
fn rate_mps(record: &Record<'_>, rate: &Elements<2>) -> Option<f64> {
    rate.quantities(record)
        .and_then(|[beyond, rate]| (beyond == 0.0).then_some(rate))
}

fn alerts_of_status(record: &Record<'_>) -> Alerts {
    let status = record.octets(STATUS);
    let has_military = record.table().edition >= ME.since && !status.is_empty();
    let military = Alerts::flag(alert_bits::EMERGENCY, has_military && ME.is_set(status));
    let surveillance = SS.code(status).map_or(Alerts::default(), alerts_of_surveillance_status);
    let stated = alerts_of_emergency(PS.code(status)) | surveillance;
    if has_military { stated | military } else { stated }
}
