//! Reports of direction finders, made of records that are written by hand, byte by byte.

use std::f64::consts::TAU;

use asterix::categories::CAT205_V1_0;
use asterix::{Decoder, Mode};
use frames::time::{NS_PER_DAY, NS_PER_S};
use frames::{Geodetic, SystemFrame};
use observations::{Bearing, EmitterMeasurement, RADIUS95_SIGMAS};
use proptest::prelude::*;

use super::{DirectionFinder, FinderRefusal, FinderReport, FinderReportKind, Reading, finder_report, read};

/// 12:00:00.5 of the 20,001st day since 1970.
const NOON: &[u8] = &[0x54, 0x60, 0x40];
const NOON_NS: i64 = 20_000 * NS_PER_DAY + 43_200 * NS_PER_S + NS_PER_S / 2;
const SIGMA_RAD: f64 = 0.03;

fn report(parts: &[&[u8]]) -> FinderReport {
    let body = parts.concat();
    let block = [&[205, 0, body.len() as u8 + 3], &body[..]].concat();
    let mut decoder = Decoder::new(Mode::Strict).with_table(&CAT205_V1_0);
    let mut records = decoder.records(&block);
    let record = records.next().unwrap().unwrap();
    assert_eq!(read(&record), Reading::Other, "a bearing is no target");
    finder_report(&record).unwrap()
}

/// A finder at 47° N, 8° E, 500 m high; the system frame has its origin `east_deg` west of it.
fn finder(east_deg: f64) -> DirectionFinder {
    let place = |longitude_deg| Geodetic::from_degrees(47.0, longitude_deg, 500.0).unwrap();
    let frame = SystemFrame::at(place(8.0 - east_deg));
    DirectionFinder::new(&frame, place(8.0), SIGMA_RAD).unwrap()
}

fn degrees(value: f64) -> [u8; 4] {
    ((value / 180.0 * f64::from(1 << 25)).round() as i32).to_be_bytes()
}

/// Type 5: channel 121.500, local bearing 45°.
fn sensor_data() -> FinderReport {
    report(&[
        &[0xBD, 0x41, 0x10],
        &[25, 9],
        &[5],
        NOON,
        &[1],
        b"121.500",
        &4500_u16.to_be_bytes(),
        &[7],
    ])
}

/// Type 2 with a position and a bearing, local or of the system.
fn system_bearing(bearing: u16, is_local: bool) -> FinderReport {
    let (first, second) = if is_local { (0xB3, 0x40) } else { (0xB1, 0xA0) };
    let position = if is_local {
        [degrees(47.0), degrees(9.0)].concat()
    } else {
        vec![0x00, 0x27, 0x10, 0xFF, 0xF0, 0x60] // 5 km east, 2 km south
    };
    report(&[
        &[first, second],
        &[25, 9],
        &[2],
        NOON,
        &position,
        &bearing.to_be_bytes(),
    ])
}

fn bearing(measurement: Result<EmitterMeasurement, FinderRefusal>) -> Bearing {
    match measurement {
        Ok(EmitterMeasurement::Bearing(bearing)) => bearing,
        other => panic!("{other:?}"),
    }
}

#[test]
fn the_data_of_a_sensor_are_a_bearing_from_its_place() {
    let report = sensor_data();
    assert_eq!(
        (report.kind, report.sac_sic, report.sensor),
        (FinderReportKind::Sensor, Some((25, 9)), Some(7))
    );
    let found = bearing(report.measurement(&finder(0.0), NOON_NS + 3 * NS_PER_S));
    assert_eq!(found.time_of_measurement_ns, NOON_NS);
    assert!((found.bearing_rad - TAU / 8.0).abs() < 1e-9, "{found:?}");
    assert!(found.platform_m.iter().all(|metres| metres.abs() < 1e-6), "{found:?}");
    assert_eq!(
        (found.sigma_rad, found.emitter_id, found.heading_rad),
        (SIGMA_RAD, None, None)
    );
    assert_eq!(found.frequency_hz, Some(121.5e6));
}

#[test]
fn bearings_count_from_north_of_the_system_frame() {
    // Meridians converge by sin 47° a degree: north at a place east of the origin points west of the frame's north.
    let convergence = |degrees: f64| degrees.to_radians() * 47_f64.to_radians().sin();
    let local = bearing(system_bearing(9000, true).measurement(&finder(1.0), NOON_NS));
    assert!(
        (local.bearing_rad - TAU / 4.0 + convergence(2.0)).abs() < 1e-4,
        "{local:?}"
    );
    assert!((local.platform_m[0] - 152_000.0).abs() < 1000.0, "{local:?}");
    // From north of the reference point, which the origin is 1° west of.
    let of_system = bearing(system_bearing(9000, false).measurement(&finder(1.0), NOON_NS));
    assert!(
        (of_system.bearing_rad - TAU / 4.0 + convergence(1.0)).abs() < 1e-4,
        "{of_system:?}"
    );
    let at_reference = bearing(system_bearing(27_000, false).measurement(&finder(0.0), NOON_NS));
    assert!((at_reference.bearing_rad - 0.75 * TAU).abs() < 1e-9, "{at_reference:?}");
    let [east, north, up] = at_reference.platform_m;
    assert!(
        (east - 5000.0).abs() < 1e-3 && (north + 2000.0).abs() < 1e-3 && up.abs() < 3.0,
        "{at_reference:?}"
    );
}

#[test]
fn a_position_is_a_fix_with_its_radius() {
    // Type 1: WGS-84, uncertainty 500 m, track 300.
    let report = report(&[
        &[0xB3, 0x09, 0x20],
        &[25, 9],
        &[1],
        NOON,
        &degrees(47.0),
        &degrees(8.0),
        &[5],
        &[1, 44],
    ]);
    let Ok(EmitterMeasurement::Fix(fix)) = report.measurement(&finder(0.0), NOON_NS) else {
        panic!("{report:?}");
    };
    assert_eq!((fix.emitter_id, fix.time_of_measurement_ns), (300, NOON_NS));
    assert!(fix.position_m.iter().all(|metres| metres.abs() < 0.5), "{fix:?}");
    let variance = (500.0 / RADIUS95_SIGMAS).powi(2);
    assert_eq!(fix.covariance_m2, [variance, 0.0, variance]);
    let without = |change: fn(&mut FinderReport)| {
        let mut changed = report;
        change(&mut changed);
        changed.measurement(&finder(0.0), NOON_NS).unwrap_err()
    };
    assert_eq!(
        without(|report| report.uncertainty_m = Some(0.0)),
        FinderRefusal::Uncertainty
    );
    assert_eq!(without(|report| report.track_number = None), FinderRefusal::TrackNumber);
    assert_eq!(without(|report| report.geodetic = None), FinderRefusal::Position);
    assert_eq!(
        without(|report| report.geodetic = Some([1.6, 0.0])),
        FinderRefusal::PositionRange
    );
    assert_eq!(without(|report| report.time_of_day_ns = None), FinderRefusal::Time);
    assert_eq!(
        without(|report| report.kind = FinderReportKind::Conflict),
        FinderRefusal::Kind
    );
    assert_eq!(
        without(|report| report.kind = FinderReportKind::Bearing),
        FinderRefusal::Bearing
    );
}

#[test]
fn a_bearing_of_more_than_a_turn_is_refused() {
    let measured = |bearing| system_bearing(bearing, true).measurement(&finder(0.0), NOON_NS);
    assert!(measured(36_000).is_ok());
    assert_eq!(measured(36_001), Err(FinderRefusal::BearingRange));
    let mut report = system_bearing(0, true);
    report.geodetic = None;
    assert_eq!(report.measurement(&finder(0.0), NOON_NS), Err(FinderRefusal::Position));
}

#[test]
fn the_deviation_of_a_finder_is_above_0_and_at_most_1() {
    let place = Geodetic::from_degrees(47.0, 8.0, 0.0).unwrap();
    let frame = SystemFrame::at(place);
    let is_made = |sigma_rad| DirectionFinder::new(&frame, place, sigma_rad).is_some();
    assert_eq!(
        [0.0, -0.1, 1.1, f64::NAN, 1e-3, 1.0].map(is_made),
        [false, false, false, false, true, true]
    );
}

#[test]
fn names_of_channels_are_frequencies() {
    let frequency = |name: &[u8; 7]| {
        let channel = report(&[&[0xA4], &[25, 9], &[5], name]);
        channel.frequency_hz.map(|hertz| hertz.round())
    };
    for (name, expected) in [
        (b"121.500", Some(121_500_000.0)),
        (b"132.005", Some(132_000_000.0)),
        (b"132.010", Some(132_008_333.0)),
        (b"132.040", Some(132_041_667.0)),
        (b"243.010", Some(243_010_000.0)),
        (b"121.5  ", Some(121_500_000.0)),
        (b"000.000", None),
        (b"TOWER 1", None),
        (b"1e6.000", None),
        (b"\xff\xff\xff\xff\xff\xff\xff", None),
    ] {
        assert_eq!(frequency(name), expected, "{}", String::from_utf8_lossy(name));
    }
}

proptest! {
    /// Any values: a measurement with finite numbers, or a refusal.
    #[test]
    fn any_record_is_measured_or_refused(body in prop::collection::vec(any::<u8>(), 60), kind in 0_u8..7) {
        let mut body = body;
        body[..3].copy_from_slice(&[0xBF, 0xFF, 0xF0]);
        body[5] = kind;
        let block = [&[205, 0, body.len() as u8 + 3], &body[..]].concat();
        let mut decoder = Decoder::new(Mode::Lenient).with_table(&CAT205_V1_0);
        for record in decoder.records(&block).flatten() {
            let report = finder_report(&record).unwrap();
            match report.measurement(&finder(0.5), NOON_NS) {
                Ok(EmitterMeasurement::Bearing(found)) => {
                    prop_assert!((0.0..=TAU).contains(&found.bearing_rad));
                    prop_assert!(found.platform_m.iter().all(|metres| metres.is_finite()));
                }
                Ok(EmitterMeasurement::Fix(found)) => {
                    prop_assert!(found.position_m.iter().all(|metres| metres.is_finite()));
                }
                other => prop_assert!(other.is_err()),
            }
        }
    }
}
