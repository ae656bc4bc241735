use frames::{Geodetic, SystemFrame};
use koseki_client::observation::Observation as _;
use messages::{Covariance, DetectionKind, SensorDetection, SensorTrack};

use super::*;

const NOW_NS: i64 = 1_800_000_000_123_456_789;

fn frame() -> SystemFrame {
    SystemFrame::at(Geodetic::from_degrees(41.0, 2.0, 0.0).unwrap())
}

fn fields(line: &str) -> Result<Fields, Fault> {
    Fields::of_line(line.as_bytes())
}

fn detected(line: &str) -> Result<(SensorDetection, bool), Fault> {
    let stated = detection(fields(line)?, false)?;
    Ok((stated.sample(&frame(), NOW_NS)?, stated.scan.is_some()))
}

fn tracked(line: &str) -> Result<SensorTrack, Fault> {
    track(fields(line)?)?.sample(&frame(), NOW_NS)
}

#[test]
fn a_line_in_degrees_is_the_detection_of_the_library() {
    let (found, has_scan) =
        detected(r#"{"latitude": 41.5, "longitude": 2.5, "height_m": 900, "sigma_m": 20}"#).unwrap();
    let stated = Detection::at(41.5, 2.5).height_m(900.0).sigma_m(20.0);
    assert_eq!((found, has_scan), (stated.sample(&frame(), NOW_NS).unwrap(), false));
    let (_, has_scan) = detected(r#"{"latitude": 41.5, "longitude": 2.5, "sigma_m": 20, "scan": 7}"#).unwrap();
    assert!(has_scan);
}

#[test]
fn a_course_is_that_of_the_library() {
    let line = r#"{"track": 1, "latitude": 41, "longitude": 5, "height_m": 0, "sigma_m": 30, "speed_mps": 100,
        "course_deg": 90, "climb_mps": 0, "velocity_sigma_mps": 3}"#;
    let report = TrackReport::of(1, 41.0, 5.0)
        .height_m(0.0)
        .sigma_m(30.0)
        .speed_mps(100.0)
        .course_deg(90.0);
    let stated = report.climb_mps(0.0).velocity_sigma_mps(3.0);
    assert_eq!(tracked(line).unwrap(), stated.sample(&frame(), NOW_NS).unwrap());
}

#[test]
fn names_of_columns_stand_for_the_fields_in_their_own_units() {
    let own = r#"{"time": "2026-05-01T10:00:00.5Z", "track": 7, "latitude": 41, "longitude": 5, "height_m": 3048,
        "sigma_m": 30, "speed_mps": 51.44444444444444, "course_deg": 90, "velocity_sigma_mps": 3, "address": "3C6589"}"#;
    let own = tracked(own).unwrap();
    for time in [r#""2026-05-01T10:00:00.5Z""#, "1777629600.5", "1777629600500"] {
        let line = format!(
            r#"{{"timestamp": {time}, "id": 7, "lat": 41, "lon": 5, "FL": 100, "sigma_m": 30, "SOG_knots": 100,
                "cog": 90, "velocity_sigma_mps": 3, "icao24": "3c6589"}}"#
        );
        let found = tracked(&line).unwrap();
        assert_eq!(found.time_of_measurement_ns, own.time_of_measurement_ns, "{time}");
        assert_eq!((found.track_number, found.identity), (own.track_number, own.identity));
        let near =
            |one: [f64; 3], other: [f64; 3]| one.iter().zip(other).all(|(one, other)| (one - other).abs() < 1e-6);
        assert!(near(found.position_m, own.position_m) && near(found.velocity_mps, own.velocity_mps));
    }
    let fault = tracked(r#"{"track": 7, "latitude": 41, "lat": 41, "longitude": 5, "sigma_m": 30}"#).unwrap_err();
    assert_eq!(fault.field, "latitude");
    assert!(fault.limit.contains("must not stand beside lat"), "{fault}");
    let fault = detected(r#"{"bearing": 40}"#).unwrap_err();
    assert_eq!(fault.field, "bearing");
}

#[test]
fn bearings_need_a_sensor_and_may_be_degrees_or_radians() {
    let sensor = r#""sensor_latitude": 41.0, "sensor_longitude": 2.0, "sensor_height_m": 0"#;
    let (found, _) = detected(&format!(r#"{{"bearing_deg": 90, "bearing_sigma_deg": 0.5, {sensor}}}"#)).unwrap();
    assert_eq!(found.kind, DetectionKind::Bearing as u8);
    assert!((found.values[0] - std::f64::consts::FRAC_PI_2).abs() < 1e-9);
    assert!((found.sigmas[0] - 0.5_f64.to_radians()).abs() < 1e-15 && found.platform_m[0].abs() < 1e-6);
    let line =
        format!(r#"{{"range_m": 900, "range_sigma_m": 5, "bearing_rad": 1, "bearing_sigma_rad": 0.01, {sensor}}}"#);
    let (found, _) = detected(&line).unwrap();
    assert_eq!(
        (found.kind, found.values[0]),
        (DetectionKind::RangeBearing as u8, 900.0)
    );
    assert!((found.values[1] - 1.0).abs() < 1e-9);
    assert_eq!(
        detected(r#"{"bearing_deg": 90, "bearing_sigma_deg": 1}"#)
            .unwrap_err()
            .field,
        "sensor_latitude"
    );
}

#[test]
fn times_are_text_seconds_or_nanoseconds() {
    let time_of = |time: &str| {
        let line = format!(r#"{{{time}, "position_m": [1, 2], "sigma_m": 5}}"#);
        detected(&line).map(|(found, _)| found.time_of_measurement_ns)
    };
    assert_eq!(time_of(r#""time": "1970-01-01T00:00:01.5Z""#).unwrap(), 1_500_000_000);
    assert_eq!(
        time_of(r#""time_s": 1800000000.25"#).unwrap(),
        1_800_000_000_250_000_000
    );
    assert_eq!(
        time_of(r#""time_ns": 1800000000123456789"#).unwrap(),
        1_800_000_000_123_456_789
    );
    for wrong in [
        r#""time": 1800000000"#,
        r#""time": "noon""#,
        r#""time_s": 1.8e18"#,
        r#""time_ns": 1.5"#,
    ] {
        assert!(time_of(wrong).unwrap_err().field.starts_with("time"), "{wrong}");
    }
}

#[test]
fn identities_are_read() {
    let line = r#"{"track": 1, "position_m": [1, 2, 3], "sigma_m": 30, "address": "3C6589", "callsign": "DLH1", "mode_3a": "7000"}"#;
    let found = tracked(line).unwrap();
    assert_eq!(found.identity.address(), Some(0x3c_6589));
    assert_eq!(
        (found.identity.callsign(), found.identity.mode_3a()),
        (Some("DLH1"), Some(0o7000))
    );
    assert_eq!(found.covariance, Covariance::diagonal([30.0; 3], [0.0; 3]));
}

#[test]
fn a_byte_order_mark_and_many_decimals_change_nothing() {
    let line = r#"{"track": 1, "position_m": [1, 2], "sigma_m": 30, "time": "2026-05-01T10:00:00.123456789Z"}"#;
    let plain = tracked(line).unwrap();
    assert_eq!(tracked(&format!("\u{feff}{line}")).unwrap(), plain);
    for decimals in ["123456789012", "1234567890123456789012345"] {
        assert_eq!(tracked(&line.replace("123456789", decimals)).unwrap(), plain);
    }
}

#[test]
fn a_ships_number_is_digits_with_or_without_quotation_marks() {
    let identity = |fields: &str| {
        let line = format!(r#"{{"track": 1, "position_m": [1, 2], "sigma_m": 30, {fields}}}"#);
        tracked(&line).map(|found| found.identity)
    };
    for (text, mmsi) in [
        (r#""227000000""#, 227_000_000),
        ("227000000", 227_000_000),
        (r#""002275400""#, 2_275_400),
        ("2275400", 2_275_400),
        (r#""023320001""#, 23_320_001),
    ] {
        let found = identity(&format!(r#""mmsi": {text}, "name": "QUEEN MARY 2""#)).unwrap();
        assert_eq!(
            (found.mmsi(), found.name()),
            (Some(mmsi), Some("QUEEN MARY 2")),
            "{text}"
        );
        assert_eq!(found.address(), None);
    }
    for (fields, field, expected) in [
        (r#""mmsi": "22700000A""#, "mmsi", "write it as in \"211234560\""),
        (r#""mmsi": 2270000000"#, "mmsi", "nine digits"),
        (r#""mmsi": 0"#, "mmsi", "nine digits"),
        // 001193046 would be a coast station of the country 119, which there is not.
        (r#""mmsi": 1193046"#, "mmsi", "nine digits"),
        (r#""mmsi": "12345""#, "mmsi", "nine digits"),
        (r#""mmsi": 227000000, "mmsi": 227000001"#, "mmsi", "must be given once"),
        (r#""mmsi": -5"#, "mmsi", "nine digits"),
        (
            r#""mmsi": 227000000, "address": "87BEC0""#,
            "mmsi",
            "leave one of the two out",
        ),
        (r#""address": 8863583"#, "address", "write it as in \"3C6589\""),
        (r#""mode_3a": 1216"#, "mode_3a", "octal"),
        (r#""mode_3a": "1218""#, "mode_3a", "octal"),
        (r#""name": "A NAME OF TWENTY-ONE..""#, "name", "shorten it"),
    ] {
        let fault = identity(fields).unwrap_err();
        assert_eq!(fault.field, field, "{fields}");
        assert!(fault.to_string().contains(expected), "{fields}: {fault}");
    }
}

#[test]
fn each_mistake_is_named_by_field_and_remedy() {
    let mistakes = [
        ("41.3, 2.1", "line", "must be JSON"),
        ("[1, 2]", "line", "must be a JSON object"),
        ("12.5", "line", "must be a JSON object"),
        ("\"track\"", "line", "must be a JSON object"),
        ("null", "line", "must be a JSON object"),
        (
            r#"{"track": 1, "sigma_m": 30, "track": 2}"#,
            "track",
            "must be given once",
        ),
        (
            r#"{"latitude": 91, "longitude": 2, "sigma_m": 5}"#,
            "latitude",
            "exchanged",
        ),
        (
            r#"{"latitude": 45000, "longitude": 2000, "sigma_m": 5}"#,
            "latitude",
            "position_m",
        ),
        (
            r#"{"latitude": 41, "longitude": 190, "sigma_m": 5}"#,
            "longitude",
            "from -180 to 180",
        ),
        (r#"{"latitude": 41, "sigma_m": 5}"#, "longitude", "both"),
        (
            r#"{"latitude": "41", "longitude": 2, "sigma_m": 5}"#,
            "latitude",
            "quotation",
        ),
        (
            r#"{"latitude": 41, "longitude": 2, "height_m": 1e6, "sigma_m": 5}"#,
            "height_m",
            "metres",
        ),
        (r#"{"latitude": 41, "longitude": 2}"#, "sigma_m", "sigmas"),
        (
            r#"{"latitude": 41, "longitude": 2, "sigma_m": 0}"#,
            "sigma_m",
            "above 0",
        ),
        (
            r#"{"latitude": 41, "longitude": 2, "sigma_m": 5, "position_m": [1, 2]}"#,
            "position_m",
            "beside",
        ),
        (
            r#"{"latitude": 41, "longtude": 2, "sigma_m": 5}"#,
            "longtude",
            "did you mean longitude?",
        ),
        (
            r#"{"latitude": 41, "longitude": 2, "sigma_m": 5, "heigth_m": 3}"#,
            "heigth_m",
            "did you mean height_m?",
        ),
        (r#"{"bearing_deg": 400}"#, "bearing_deg", "360"),
        (r#"{}"#, "latitude", "bearing_deg"),
        (r#"{"position_m": [1], "sigma_m": 5}"#, "position_m", "array of 2 to 3"),
        (
            r#"{"position_m": [1, 2], "sigma_m": 5, "address": "XYZ"}"#,
            "address",
            "hexadecimal",
        ),
        (
            r#"{"position_m": [1, 2], "sigma_m": 5, "scan": -1}"#,
            "scan",
            "whole number",
        ),
        (
            r#"{"position_m": [1, 2], "sigma_m": 5, "range_rate_mps": 3}"#,
            "range_rate_sigma_mps",
            "all standard",
        ),
    ];
    for (line, field, text) in mistakes {
        let found = detected(line).map(|(sample, _)| sample.values).unwrap_err();
        assert_eq!(found.field, field, "{line}: {found}");
        assert!(found.to_string().contains(text), "{line}: {found}");
    }
    for (line, field) in [
        (r#"{"position_m": [1, 2], "sigma_m": 5}"#, "track"),
        (r#"{"track": 1, "sigma_m": 5}"#, "latitude"),
        (r#"{"track": 1, "position_m": [1, 2]}"#, "sigma_m"),
        (
            r#"{"track": 1, "position_m": [1, 2], "sigma_m": 5, "speed_mps": 5}"#,
            "course_deg",
        ),
        (
            r#"{"track": 1, "position_m": [1, 2], "sigma_m": 5, "velocity_mps": [5, 5]}"#,
            "velocity_sigma_mps",
        ),
        (
            r#"{"track": 1, "position_m": [1, 2], "sigma_m": 5, "state": "new"}"#,
            "state",
        ),
        (
            r#"{"track": 1, "position_m": [1, 2], "sigma_m": 5, "bearing_deg": 5}"#,
            "bearing_deg",
        ),
    ] {
        assert_eq!(tracked(line).unwrap_err().field, field, "{line}");
    }
}
