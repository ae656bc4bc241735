//! Items that several categories have alike.

use frames::time::{NS_PER_DAY, NS_PER_S};
use messages::{Identity, alert_bits, identity_bits};

use super::quantity;
use asterix::table::{Category, Content, Frn, Layout, Part};
use asterix::text::icao_code;
use asterix::{RecordWriter, field::FOOT_M};

pub(super) use asterix::field::{FLIGHT_LEVEL_M, NAUTICAL_MILE_M};

/// LSB of geometric heights: 6.25 ft, in metres.
pub(super) const HEIGHT_LSB_M: f64 = 6.25 * FOOT_M;
/// LSB of flight levels: a quarter, in metres.
pub(super) const LEVEL_LSB_M: f64 = FLIGHT_LEVEL_M / 4.0;
/// LSB of rates of climb: 6.25 ft/min, in metres per second.
pub(super) const CLIMB_LSB_MPS: f64 = 6.25 * FOOT_M / 60.0;
/// LSB of ground speeds: 2^-14 NM/s, in metres per second.
pub(super) const SPEED_LSB_MPS: f64 = NAUTICAL_MILE_M / 16_384.0;
/// Slower than this a climb is none, metres per second: 100 ft/min, the step in which transponders report.
const LEVEL_FLIGHT_MPS: f64 = 100.0 * FOOT_M / 60.0;
/// Geometric heights that documents allow, metres: -1500 to 150,000 ft.
const HEIGHTS_M: std::ops::RangeInclusive<f64> = -1500.0 * FOOT_M..=150_000.0 * FOOT_M;
/// Flight levels that documents allow, metres: -15 to 1500.
const LEVELS_M: std::ops::RangeInclusive<f64> = -15.0 * FLIGHT_LEVEL_M..=1500.0 * FLIGHT_LEVEL_M;

/// Alerts that are an emergency in the sense of Mode S: codes 7700, 7600 and 7500.
pub(super) const EMERGENCIES: u8 =
    alert_bits::EMERGENCY | alert_bits::COMMUNICATION_FAILURE | alert_bits::UNLAWFUL_INTERFERENCE;

/// System area code and system identification code of a sender.
pub(super) fn source(record: &mut RecordWriter, frn: Frn, [sac, sic]: [u8; 2]) {
    record.item(frn).bits(u64::from(sac), 8).bits(u64::from(sic), 8);
}

/// Time of day, LSB 1/128 s. The last half tick of a day is midnight.
pub(super) fn time_of_day(record: &mut RecordWriter, frn: Frn, utc_ns: i64) {
    const TICKS_PER_S: i64 = 128;
    let ticks = (utc_ns.rem_euclid(NS_PER_DAY) * TICKS_PER_S + NS_PER_S / 2) / NS_PER_S;
    record.item(frn).bits((ticks % (86_400 * TICKS_PER_S)) as u64, 24);
}

/// Two angles of `bits` bits, LSB 180/2^`exponent` degrees.
pub(super) fn geodetic(record: &mut RecordWriter, frn: Frn, place: &frames::Geodetic, bits: usize, exponent: u32) {
    record
        .item(frn)
        .signed(quantity::latitude(place.latitude_deg(), exponent), bits)
        .signed(quantity::longitude(place.longitude_deg(), exponent), bits);
}

/// Two components of a vector as numbers of `bits` bits, where both fit.
pub(super) fn pair(record: &mut RecordWriter, frn: Frn, [x, y]: [f64; 2], lsb: f64, bits: u32) {
    let number = |value: f64| quantity::signed(value, lsb, bits);
    if let (Some(x), Some(y)) = (number(x), number(y)) {
        record.item(frn).signed(x, bits as usize).signed(y, bits as usize);
    }
}

/// A Mode 3/A code behind V, G, L and a spare bit; L says that it was not received just now.
pub(super) fn mode_3a(record: &mut RecordWriter, frn: Frn, identity: &Identity, received: bool) {
    if let Some(code) = identity.mode_3a() {
        record
            .item(frn)
            .bits(0, 2)
            .bits(u64::from(!received), 1)
            .bits(u64::from(code & 0o7777), 13);
    }
}

/// An aircraft address.
pub(super) fn address(record: &mut RecordWriter, frn: Frn, identity: &Identity) {
    if let Some(address) = identity.address() {
        record.item(frn).bits(u64::from(address & 0x00FF_FFFF), 24);
    }
}

/// The call sign as eight characters of six bits; `None` where there is none. Small letters become capitals, and what the
/// alphabet does not have becomes the code that stands for nothing.
pub(super) fn call_sign(identity: &Identity) -> Option<u64> {
    if identity.valid & identity_bits::CALLSIGN == 0 {
        return None;
    }
    let code = |character: u8| match character {
        0 => icao_code(b' '),
        character => icao_code(character.to_ascii_uppercase()),
    };
    let packed = identity.callsign.iter().fold(0, |packed, character| {
        packed << 6 | u64::from(code(*character).unwrap_or(0))
    });
    let says_something = identity.callsign.iter().any(u8::is_ascii_alphanumeric);
    says_something.then_some(packed)
}

/// A flight level of a height, LSB a quarter, in `bits` bits; `None` for one that no aircraft reports.
pub(super) fn level(height_m: f64, bits: u32) -> Option<i64> {
    let height_m = Some(height_m).filter(|height| LEVELS_M.contains(height))?;
    quantity::signed(height_m, LEVEL_LSB_M, bits)
}

/// A height above the ellipsoid, LSB 6.25 ft; `None` for one that the documents do not allow.
pub(super) fn height(height_m: f64) -> Option<i64> {
    let height_m = Some(height_m).filter(|height| HEIGHTS_M.contains(height))?;
    quantity::signed(height_m, HEIGHT_LSB_M, 16)
}

/// Ground speed (LSB 2^-14 NM/s, `bits` bits) and direction of motion (16 bits), from components towards east and north.
pub(super) fn ground_vector([east, north]: [f64; 2], bits: u32) -> Option<(u64, u64)> {
    let speed = quantity::unsigned(east.hypot(north), SPEED_LSB_MPS, bits)?;
    Some((speed, quantity::turn(east.atan2(north), 16)))
}

/// CDM: 0 level, 1 climbing, 2 descending, 3 not known.
pub(super) fn climb_mode(climb_mps: Option<f64>) -> u64 {
    match climb_mps {
        Some(climb) if climb >= LEVEL_FLIGHT_MPS => 1,
        Some(climb) if climb <= -LEVEL_FLIGHT_MPS => 2,
        Some(climb) if climb.is_finite() => 0,
        _ => 3,
    }
}

/// The emergency as CAT021 and CAT062 number them. Of several, the one that names its kind, and of those the gravest.
pub(super) fn emergency(alerts: u8) -> u64 {
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
        u64::from(raised(alert_bits::EMERGENCY))
    }
}

/// Whether the pilot has pressed the button for special position identification.
pub(super) fn special_identification(alerts: u8) -> bool {
    alerts & alert_bits::SPECIAL_IDENTIFICATION != 0
}

/// Communications capability and flight status of a Mode S transponder (I048/230, I020/230): the status is known, of the
/// capabilities only that there is an aircraft identification.
pub(super) fn flight_status(record: &mut RecordWriter, frn: Frn, identity: &Identity, alerts: u8, on_ground: bool) {
    let alert = alerts & (EMERGENCIES | alert_bits::TRANSPONDER_ALERT) != 0;
    let status = match (alert, special_identification(alerts), on_ground) {
        (false, false, false) => 0,
        (false, false, true) => 1,
        (true, false, false) => 2,
        (true, false, true) => 3,
        (true, true, _) => 4,
        (false, true, _) => 5,
    };
    let has_call_sign = call_sign(identity).is_some();
    record
        .item(frn)
        .bits(0, 3)
        .bits(status, 3)
        .bits(0, 4)
        .bits(u64::from(has_call_sign), 1)
        .bits(0, 5);
}

/// Width and content of an element of a group or an extended item, where the edition has it.
pub(super) fn element_of(table: &Category, item: &str, element: &str) -> Option<(u8, &'static Content)> {
    let parts: &[&[Part]] = match &table.item(item)?.layout {
        Layout::Extended(parts) => parts,
        Layout::Group(parts) => &[parts],
        _ => return None,
    };
    parts.iter().copied().flatten().find_map(|part| match part {
        Part::Element { name, bits, content } if *name == element => Some((*bits, content)),
        _ => None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use asterix::categories::{CAT021_V0_23, CAT034_V1_29, CAT062_V1_17, CAT062_V1_18};

    fn ticks(utc_ns: i64) -> Vec<u8> {
        let mut record = RecordWriter::new(&CAT034_V1_29);
        time_of_day(&mut record, CAT034_V1_29.uap().frn("030"), utc_ns);
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
        assert_eq!(level(-457.3, 14), None);
        assert_eq!(level(-457.1, 14), Some(-60));
        assert_eq!(level(10_668.0, 14), Some(1400));
        assert_eq!(height(-457.1), Some(-240));
        assert_eq!(height(46_000.0), None);
        assert_eq!(height(f64::NAN), None);
    }

    #[test]
    fn elements_are_found_by_edition() {
        assert!(element_of(&CAT062_V1_17, "080", "SFC").is_none());
        assert!(element_of(&CAT062_V1_18, "080", "SFC").is_some());
        assert_eq!(element_of(&CAT021_V0_23, "130", "LAT").map(|(bits, _)| bits), Some(24));
    }
}
