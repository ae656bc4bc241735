//! Items that several categories have alike.

use std::ops::RangeInclusive;

use asterix::RecordWriter;
use asterix::field::{Elements, FLIGHT_LEVEL_M, FOOT_M, Field};
use asterix::text::icao_code;
use frames::time::{NS_PER_DAY, NS_PER_S};
use messages::{Identity, alert_bits, identity_bits};

use super::quantity;

/// Slowest climb that is one, metres per second: 100 ft/min, the step in which transponders report.
const LEVEL_FLIGHT_MPS: f64 = 100.0 * FOOT_M / 60.0;
/// Geometric heights that documents allow, metres: -1500 to 150,000 ft.
const HEIGHTS_M: RangeInclusive<f64> = -1500.0 * FOOT_M..=150_000.0 * FOOT_M;
/// Flight levels that documents allow, metres: -15 to 1500.
const LEVELS_M: RangeInclusive<f64> = -15.0 * FLIGHT_LEVEL_M..=1500.0 * FLIGHT_LEVEL_M;

/// Alerts that are an emergency in the sense of Mode S: codes 7700, 7600 and 7500.
pub(super) const EMERGENCIES: u8 =
    alert_bits::EMERGENCY | alert_bits::COMMUNICATION_FAILURE | alert_bits::UNLAWFUL_INTERFERENCE;

/// Writes system area code and system identification code of a sender.
pub(super) fn source(record: &mut RecordWriter, item: &Elements<2>, source: [u8; 2]) {
    record.write(item, source.map(i64::from));
}

/// Writes a time of day in UTC. The last half tick of a day is midnight.
pub(super) fn time_of_day(record: &mut RecordWriter, item: &Elements<1>, utc_ns: i64) {
    let ticks_per_s = (1.0 / item.fields[0].lsb) as i64;
    let ticks = (utc_ns.rem_euclid(NS_PER_DAY) * ticks_per_s + NS_PER_S / 2) / NS_PER_S;
    record.write(item, [ticks % (86_400 * ticks_per_s)]);
}

/// Writes latitude and longitude.
pub(super) fn geodetic(record: &mut RecordWriter, item: &Elements<2>, place: &frames::Geodetic) {
    let [latitude, longitude] = item.fields;
    let latitude = quantity::latitude(latitude, place.latitude_deg());
    record.write(item, [latitude, quantity::longitude(longitude, place.longitude_deg())]);
}

/// Writes quantities in SI units, where all fit.
pub(super) fn quantities<const N: usize>(record: &mut RecordWriter, item: &Elements<N>, quantities: [f64; N]) {
    if let Some(numbers) = quantity::nearest(item, quantities) {
        record.write(item, numbers);
    }
}

/// Writes a number, where there is one.
pub(super) fn number(record: &mut RecordWriter, item: &Elements<1>, number: Option<i64>) {
    if let Some(number) = number {
        record.write(item, [number]);
    }
}

/// Writes a Mode 3/A code; the item's first element, L, marks a code not received in this scan.
pub(super) fn mode_3a(record: &mut RecordWriter, item: &Elements<2>, identity: &Identity, received: bool) {
    if let Some(code) = identity.mode_3a() {
        record.write(item, [i64::from(!received), i64::from(code & 0o7777)]);
    }
}

/// Aircraft address.
pub(super) fn address(identity: &Identity) -> Option<i64> {
    identity.address().map(|address| i64::from(address & 0x00FF_FFFF))
}

/// Returns the call sign as eight characters of six bits; `None` without a call sign. Small letters become capitals;
/// characters outside the alphabet become the code for "no character".
pub(super) fn call_sign(identity: &Identity) -> Option<i64> {
    if identity.valid & identity_bits::CALLSIGN == 0 {
        return None;
    }
    let code = |character: u8| match character {
        0 => icao_code(b' '),
        character => icao_code(character.to_ascii_uppercase()),
    };
    let packed = identity.callsign.iter().fold(0, |packed, character| {
        packed << 6 | i64::from(code(*character).unwrap_or(0))
    });
    let says_something = identity.callsign.iter().any(u8::is_ascii_alphanumeric);
    says_something.then_some(packed)
}

/// Writes a height as flight level, where there is one that aircraft report and the bits can hold.
pub(super) fn level(record: &mut RecordWriter, item: &Elements<1>, height_m: Option<f64>) {
    let [field] = item.fields;
    number(
        record,
        item,
        height_m.and_then(|height_m| number_within(field, LEVELS_M, height_m)),
    );
}

/// Returns the number of a level that aircraft report and the bits can hold.
pub(super) fn level_number(field: Field, level_m: f64) -> Option<i64> {
    number_within(field, LEVELS_M, level_m)
}

/// Writes an altitude, after the element that marks the local pressure, where there is one that the bits can hold.
pub(super) fn altitude(record: &mut RecordWriter, item: &Elements<2>, altitude_m: f64) {
    let [_, field] = item.fields;
    if let Some(number) = number_within(field, LEVELS_M, altitude_m) {
        record.write(item, [1, number]);
    }
}

/// Writes a height above the ellipsoid, where there is one that the documents allow.
pub(super) fn height(record: &mut RecordWriter, item: &Elements<1>, height_m: Option<f64>) {
    let [field] = item.fields;
    number(
        record,
        item,
        height_m.and_then(|height_m| number_within(field, HEIGHTS_M, height_m)),
    );
}

fn number_within(field: Field, allowed: RangeInclusive<f64>, quantity: f64) -> Option<i64> {
    field.nearest(quantity).filter(|_| allowed.contains(&quantity))
}

/// Writes ground speed and direction of motion of components towards east and north, where the speed fits.
pub(super) fn ground_vector(record: &mut RecordWriter, item: &Elements<2>, [east, north]: [f64; 2]) {
    let [speed, course] = item.fields;
    if let Some(speed) = speed.nearest(east.hypot(north)) {
        record.write(item, [speed, quantity::turn(course, east.atan2(north))]);
    }
}

/// CDM: 0 level, 1 climbing, 2 descending, 3 not known.
pub(super) fn climb_mode(climb_mps: Option<f64>) -> i64 {
    match climb_mps {
        Some(climb) if climb >= LEVEL_FLIGHT_MPS => 1,
        Some(climb) if climb <= -LEVEL_FLIGHT_MPS => 2,
        Some(climb) if climb.is_finite() => 0,
        _ => 3,
    }
}

/// Returns the emergency by the numbers of CAT021 and CAT062: of several emergencies the most serious of known kind.
pub(super) fn emergency(alerts: u8) -> i64 {
    let raised = |bit: u8| alerts & bit != 0;
    if raised(alert_bits::UNLAWFUL_INTERFERENCE) {
        5
    } else if raised(alert_bits::COMMUNICATION_FAILURE) {
        4
    } else if raised(alert_bits::MINIMUM_FUEL) {
        3
    } else if raised(alert_bits::MEDICAL) {
        2
    } else {
        i64::from(raised(alert_bits::EMERGENCY))
    }
}

/// True while the pilot presses the button for special position identification.
pub(super) fn special_identification(alerts: u8) -> bool {
    alerts & alert_bits::SPECIAL_IDENTIFICATION != 0
}

/// Writes STAT and AIC of a Mode S transponder (I048/230, I020/230): the flight status, which is known, and of the
/// capabilities only that there is an aircraft identification.
pub(super) fn flight_status(
    record: &mut RecordWriter,
    item: &Elements<2>,
    identity: &Identity,
    alerts: u8,
    on_ground: bool,
) {
    let alert = alerts & (EMERGENCIES | alert_bits::TRANSPONDER_ALERT) != 0;
    let status = match (alert, special_identification(alerts), on_ground) {
        (false, false, false) => 0,
        (false, false, true) => 1,
        (true, false, false) => 2,
        (true, false, true) => 3,
        (true, true, _) => 4,
        (false, true, _) => 5,
    };
    record.write(item, [status, i64::from(call_sign(identity).is_some())]);
}

#[cfg(test)]
mod tests {
    use super::*;
    use asterix::categories::{CAT034, CAT034_V1_29, CAT048, CAT062};
    use asterix::field::{field, whole};

    fn ticks(utc_ns: i64) -> Vec<u8> {
        let mut record = RecordWriter::new(&CAT034_V1_29);
        time_of_day(&mut record, &whole(CAT034, "030"), utc_ns);
        record.finish()[1..].to_vec()
    }

    #[test]
    fn times_are_rounded_and_midnight_is_zero() {
        assert_eq!(ticks(NS_PER_S), [0, 0, 128]);
        assert_eq!(ticks(NS_PER_S + 3_906_249), [0, 0, 128]);
        assert_eq!(ticks(NS_PER_S + 3_906_250), [0, 0, 129]);
        assert_eq!(
            ticks(NS_PER_DAY - 3_906_251),
            [0xA8, 0xBF, 0xFF],
            "the last tick of a day"
        );
        assert_eq!(ticks(NS_PER_DAY - 3_906_250), [0, 0, 0]);
        assert_eq!(ticks(-1), [0, 0, 0]);
        assert_eq!(ticks(20_000 * NS_PER_DAY + 2 * NS_PER_S), [0, 1, 0]);
    }

    #[test]
    fn call_signs_keep_their_places() {
        let packed = |callsign: &[u8; 8]| call_sign(&Identity::default().with_callsign(*callsign));
        let codes = [0x09, 0x02, 0x0B, 0x33, 0x1A, 0x12, 0x20, 0x20]; // I, B, K, 3, Z, R, space, space
        let expected = codes.iter().fold(0, |packed, code| packed << 6 | code);
        assert_eq!(packed(b"IBK3ZR  "), Some(expected));
        assert_eq!(packed(b"ibk3zr\0\0"), packed(b"IBK3ZR  "));
        assert_eq!(packed(b"A?      ").map(|packed| packed >> 36), Some(0b000001_000000));
        assert_eq!(packed(b"        "), None);
        assert_eq!(call_sign(&Identity::default()), None);
    }

    #[test]
    fn emergencies_name_their_kind() {
        use messages::alert_bits::*;
        assert_eq!(emergency(0), 0);
        assert_eq!(emergency(EMERGENCY), 1);
        assert_eq!(emergency(EMERGENCY | MEDICAL), 2);
        assert_eq!(emergency(MINIMUM_FUEL | MEDICAL), 3);
        assert_eq!(emergency(COMMUNICATION_FAILURE | EMERGENCY), 4);
        assert_eq!(emergency(u8::MAX), 5);
        assert_eq!(
            emergency(SPECIAL_IDENTIFICATION | TRANSPONDER_ALERT | RESOLUTION_ADVISORY),
            0
        );
    }

    #[test]
    fn climbs_begin_at_a_hundred_feet_a_minute() {
        assert_eq!(climb_mode(Some(0.5)), 0);
        assert_eq!(climb_mode(Some(0.51)), 1);
        assert_eq!(climb_mode(Some(-0.51)), 2);
        assert_eq!(climb_mode(None), 3);
        assert_eq!(climb_mode(Some(f64::NAN)), 3);
    }

    #[test]
    fn heights_beyond_the_documents_limits_have_no_number() {
        const LEVEL: Field = field(CAT048, &["090", "FL"]);
        const HEIGHT: Field = field(CAT062, &["130"]);
        assert_eq!(number_within(LEVEL, LEVELS_M, -457.3), None);
        assert_eq!(number_within(LEVEL, LEVELS_M, -457.1), Some(-60));
        assert_eq!(number_within(LEVEL, LEVELS_M, 10_668.0), Some(1400));
        assert_eq!(number_within(HEIGHT, HEIGHTS_M, -457.1), Some(-240));
        assert_eq!(number_within(HEIGHT, HEIGHTS_M, 46_000.0), None);
        assert_eq!(number_within(HEIGHT, HEIGHTS_M, f64::NAN), None);
    }
}
