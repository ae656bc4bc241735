use std::f64::consts::FRAC_PI_2;

use frames::Geodetic;
use messages::{
    DetectionKind, IdentityText, SensorDetection, SensorTrack, TrackState, sensor_detection_bits, sensor_track_bits,
};

use super::*;

const NOW_NS: i64 = 1_800_000_000_123_456_789;

fn frame() -> SystemFrame {
    SystemFrame::at(Geodetic::from_degrees(41.0, 2.0, 0.0).unwrap())
}

fn detected(detection: Detection) -> Result<SensorDetection, Fault> {
    detection.sample(&frame(), NOW_NS)
}

fn tracked(report: TrackReport) -> Result<SensorTrack, Fault> {
    report.sample(&frame(), NOW_NS)
}

/// Distance between a position and that of a place, metres.
fn apart_m(position_m: [f64; 3], latitude: f64, longitude: f64, height_m: f64) -> f64 {
    let place = frame().to_local(Geodetic::from_degrees(latitude, longitude, height_m).unwrap());
    let squares = [0, 1, 2].map(|axis| (place[axis] - position_m[axis]).powi(2));
    squares.iter().sum::<f64>().sqrt()
}

#[test]
fn degrees_become_metres_of_the_round_earth() {
    // 100 km north-east of the origin.
    let (latitude, longitude, height_m) = (41.632, 2.848, 900.0);
    let stated = Detection::at(latitude, longitude).height_m(height_m).sigma_m(20.0);
    let found = detected(stated).unwrap();
    let [east, north, up] = found.values;
    assert!((east.hypot(north) - 100e3).abs() < 1e3, "{:?}", found.values);
    assert!(apart_m(found.values, latitude, longitude, height_m) < 1e-3);
    let flat = 100e3_f64.powi(2) / (2.0 * 6371e3);
    assert!(
        (up - (height_m - flat)).abs() < 10.0,
        "the Earth falls away by 785 m: {up}"
    );
    let place = frame().to_geodetic(found.values);
    assert!((place.latitude_deg() - latitude).abs() < 1e-9 && (place.longitude_deg() - longitude).abs() < 1e-9);
    assert!((place.height_m() - height_m).abs() < 1e-3);
    assert_eq!(found.kind, DetectionKind::Position3 as u8);
    assert_eq!(
        (found.sigmas, found.time_of_measurement_ns),
        ([20.0, 20.0, 20.0, 0.0], NOW_NS)
    );
    assert_eq!(detected(stated.height_sigma_m(50.0)).unwrap().sigmas[2], 50.0);

    let flat = detected(Detection::at(latitude, longitude).sigma_m(20.0)).unwrap();
    assert_eq!((flat.kind, flat.values[2]), (DetectionKind::Position2 as u8, 0.0));
    let report = tracked(TrackReport::of(1, latitude, longitude).height_m(height_m).sigma_m(20.0)).unwrap();
    assert!(apart_m(report.position_m, latitude, longitude, height_m) < 1e-3);
}

#[test]
fn metres_stay_metres() {
    let metres = Detection::default().east_m(10.0).north_m(20.0).sigma_m(5.0);
    assert_eq!(detected(metres).unwrap().values, [10.0, 20.0, 0.0]);
    assert_eq!(detected(metres.up_m(30.0)).unwrap().values, [10.0, 20.0, 30.0]);
    let report = TrackReport {
        track: Some(7),
        state: Some(TrackState::Tentative),
        ..TrackReport::default()
    };
    let report = report
        .east_m(1.0)
        .north_m(2.0)
        .sigma_m(3.0)
        .velocity_east_mps(4.0)
        .velocity_north_mps(5.0);
    let found = tracked(report.velocity_sigma_mps(6.0)).unwrap();
    assert_eq!(
        (found.position_m, found.velocity_mps),
        ([1.0, 2.0, 0.0], [4.0, 5.0, 0.0])
    );
    assert_eq!((found.track_number, found.state), (7, TrackState::Tentative as u8));
    assert_eq!(
        found.valid,
        sensor_track_bits::OWN_COVARIANCE | sensor_track_bits::VELOCITY
    );
}

#[test]
fn directions_begin_at_the_sensor() {
    let sensor = Detection::from_sensor(41.0, 2.0).sensor_height_m(0.0);
    let found = detected(sensor.bearing_deg(90.0).bearing_sigma_deg(0.5)).unwrap();
    assert_eq!(found.kind, DetectionKind::Bearing as u8);
    assert!((found.values[0] - FRAC_PI_2).abs() < 1e-9);
    assert!((found.sigmas[0] - 0.5_f64.to_radians()).abs() < 1e-15 && found.platform_m[0].abs() < 1e-6);
    let ranged = sensor.bearing_deg(90.0).bearing_sigma_deg(0.5).range_m(900.0);
    assert_eq!(detected(ranged).unwrap_err().field, "range_sigma_m");
    let found = detected(ranged.range_sigma_m(5.0)).unwrap();
    assert_eq!(
        (found.kind, found.values[0]),
        (DetectionKind::RangeBearing as u8, 900.0)
    );
    assert!((found.values[1] - FRAC_PI_2).abs() < 1e-9);
    let rated = ranged.range_sigma_m(5.0).range_rate_mps(-30.0);
    assert_eq!(detected(rated).unwrap_err().field, "range_rate_sigma_mps");
    let found = detected(rated.range_rate_sigma_mps(2.0)).unwrap();
    assert_eq!((found.range_rate_mps, found.sigmas[3]), (-30.0, 2.0));
}

/// A target straight north of a sensor 250 km east of the origin, 10 km above its horizon's plane.
#[test]
fn directions_are_those_of_the_sensors_place() {
    let (sensor, target) = ([41.0, 5.0, 0.0], [41.5, 5.0, 10e3]);
    let local = |[latitude, longitude, height_m]: [f64; 3]| {
        frame().to_local(Geodetic::from_degrees(latitude, longitude, height_m).unwrap())
    };
    let (from, to) = (local(sensor), local(target));
    let way = [0, 1, 2].map(|axis| to[axis] - from[axis]);
    let range = way.iter().map(|part| part * part).sum::<f64>().sqrt();
    // North of the sensor; the elevation is lowered by half of the arc between both.
    let arc = 0.5_f64.to_radians() * 6_362e3 / 6_371e3;
    let elevation_deg = (10e3 / range).asin().to_degrees() - (arc / 2.0).to_degrees();
    let stated = Detection::from_sensor(41.0, 5.0).sensor_height_m(0.0).range_m(range);
    let stated = stated.bearing_deg(0.0).elevation_deg(elevation_deg);
    let stated = stated
        .range_sigma_m(5.0)
        .bearing_sigma_deg(0.1)
        .elevation_sigma_deg(0.1);
    let [_, bearing, elevation] = detected(stated).unwrap().values;
    assert!((bearing - way[0].atan2(way[1])).abs() < 1e-5, "{bearing} {way:?}");
    assert!(
        (elevation - (way[2] / range).asin()).abs() < 2e-4,
        "{elevation} {way:?}"
    );
    // Without an elevation the bearing turns likewise; at a sensor in metres it stays.
    let flat = Detection {
        elevation_deg: None,
        elevation_sigma_deg: None,
        ..stated
    };
    let convergence = 3.0_f64.to_radians() * 41.0_f64.to_radians().sin();
    assert!((detected(flat).unwrap().values[1] + convergence).abs() < 1e-3);
    let metres = Detection {
        sensor_latitude: None,
        sensor_longitude: None,
        sensor_height_m: None,
        ..flat
    };
    let metres = metres.sensor_east_m(from[0]).sensor_north_m(from[1]);
    assert_eq!(detected(metres).unwrap().values[1], 0.0);
}

#[test]
fn standard_deviations_may_be_those_of_the_configuration() {
    let stated = Detection::at(41.0, 2.0);
    assert_eq!(detected(stated).unwrap_err().field, "sigma_m");
    let found = detected(Detection {
        has_configured_sigmas: true,
        ..stated
    })
    .unwrap();
    assert_eq!(found.valid & sensor_detection_bits::SIGMAS, 0);
}

#[test]
fn a_course_is_from_true_north_at_the_target() {
    // 3 degrees of longitude east of the origin, true north is 2 degrees west of the frame's north.
    let report = TrackReport::of(1, 41.0, 5.0).height_m(0.0).sigma_m(30.0);
    let found = tracked(
        report
            .speed_mps(100.0)
            .course_deg(0.0)
            .climb_mps(0.0)
            .velocity_sigma_mps(3.0),
    )
    .unwrap();
    let later = [0, 1, 2].map(|axis| found.position_m[axis] + found.velocity_mps[axis]);
    let (begin, end) = (frame().to_geodetic(found.position_m), frame().to_geodetic(later));
    assert!((end.longitude_deg() - begin.longitude_deg()).abs() < 1e-9);
    assert!(end.latitude_deg() > begin.latitude_deg() && (end.height_m() - begin.height_m()).abs() < 0.01);
    let speed = found.velocity_mps.iter().map(|part| part * part).sum::<f64>().sqrt();
    assert!((speed - 100.0).abs() < 1e-6);
    assert!(found.velocity_mps[0].atan2(found.velocity_mps[1]).to_degrees() < -1.5);
    assert!(found.valid & sensor_track_bits::VERTICAL_RATE != 0);
}

#[test]
fn each_mistake_is_named_by_field_and_remedy() {
    let at = |latitude, longitude| Detection::at(latitude, longitude).sigma_m(5.0);
    let sensor = Detection::from_sensor(41.0, 2.0).bearing_sigma_deg(1.0);
    let half = Detection {
        longitude: None,
        ..at(41.0, 2.0)
    };
    for (detection, field, text) in [
        (at(91.0, 2.0), "latitude", "exchanged"),
        (at(-90.1, 100.0), "latitude", "from -90 to 90"),
        (at(f64::NAN, 2.0), "latitude", "NaN"),
        (at(45e3, 2e3), "latitude", "position_m"),
        (at(41.0, 190.0), "longitude", "from -180 to 180"),
        (at(41.0, f64::NAN), "longitude", "NaN"),
        (half, "longitude", "both"),
        (at(41.0, 2.0).height_m(1e6), "height_m", "metres"),
        (at(41.0, 2.0).height_m(f64::NAN), "height_m", "NaN"),
        (at(41.0, 2.0).sigma_m(0.0), "sigma_m", "above 0"),
        (at(41.0, 2.0).sigma_m(f64::NAN), "sigma_m", "NaN"),
        (
            at(41.0, 2.0).height_m(1.0).height_sigma_m(-1.0),
            "height_sigma_m",
            "above 0",
        ),
        (at(41.0, 2.0).east_m(5.0), "east_m", "beside"),
        (Detection::default().east_m(5.0), "north_m", "both"),
        (sensor.bearing_deg(400.0), "bearing_deg", "360"),
        (sensor.bearing_deg(f64::NAN), "bearing_deg", "NaN"),
        (
            Detection::default().bearing_deg(4.0),
            "sensor_latitude",
            "sensor_longitude",
        ),
        (
            Detection::from_sensor(41.0, 2.0).bearing_deg(4.0),
            "bearing_sigma_deg",
            "standard",
        ),
        (
            Detection::from_sensor(95.0, 2.0).bearing_deg(4.0),
            "sensor_latitude",
            "exchanged",
        ),
        (Detection::default(), "latitude", "bearing_deg"),
        (at(0.0, 0.0), "latitude", "with longitude 0 it is 44"),
        (at(0.0, 0.0), "latitude", "at most 2000 km"),
        // The other side of the earth is near on the plane of the frame.
        (at(-41.0, -178.0), "latitude", "with longitude -178 it is 127"),
        (
            Detection::default().east_m(0.0).north_m(-2.1e6).sigma_m(5.0),
            "east_m",
            "with north_m -2100000 it is 2100 km",
        ),
        (
            Detection::from_sensor(2.0, 141.0).bearing_deg(4.0),
            "sensor_latitude",
            "with sensor_longitude 141 it is",
        ),
    ] {
        let found = detected(detection).unwrap_err();
        assert_eq!(found.field, field, "{detection:?}: {found}");
        assert!(found.to_string().contains(text), "{detection:?}: {found}");
    }
    let report = TrackReport::of(1, 41.0, 2.0).sigma_m(5.0);
    for (report, field) in [
        (TrackReport { track: None, ..report }, "track"),
        (
            TrackReport {
                sigma_m: None,
                ..report
            },
            "sigma_m",
        ),
        (
            TrackReport {
                track: Some(1),
                ..TrackReport::default()
            },
            "latitude",
        ),
        (report.speed_mps(5.0), "course_deg"),
        (report.course_deg(5.0), "speed_mps"),
        (report.climb_mps(5.0), "velocity_sigma_mps"),
        (report.speed_mps(5.0).course_deg(400.0), "course_deg"),
        (report.speed_mps(5.0).course_deg(40.0), "velocity_sigma_mps"),
        (report.velocity_east_mps(5.0), "velocity_north_mps"),
        (report.velocity_east_mps(5.0).speed_mps(5.0), "velocity_east_mps"),
    ] {
        assert_eq!(tracked(report).unwrap_err().field, field, "{report:?}");
    }
}

#[test]
fn identities_are_checked() {
    let none = Identity::default();
    let [address, mmsi, code] = IdentityText::ALL;
    assert_eq!(numbered(none, address, 0x3c_6589), Ok(none.with_address(0x3c_6589)));
    assert_eq!(numbered(none, mmsi, 211_000_000), Ok(none.with_mmsi(211_000_000)));
    assert_eq!(
        numbered(none.with_mmsi(5), code, 0o7000),
        Ok(none.with_mmsi(5).with_mode_3a(0o7000))
    );
    for (before, kind, number) in [
        (none, address, 1 << 24),
        (none, mmsi, 0),
        (none, mmsi, 1_000_000_000),
        (none, code, 0o10000),
        // Neither number of two is taken, so that none is lost without a word.
        (none.with_address(0x87_bec0), mmsi, 227_000_000),
        (none.with_mmsi(227_000_000), address, 0x87_bec0),
    ] {
        assert_eq!(numbered(before, kind, number).unwrap_err().field, kind.key);
    }
    assert_eq!(name_of("QUEEN MARY 2"), Ok("QUEEN MARY 2"));
    for wrong in ["", "A NAME OF TWENTY-ONE..", "é"] {
        assert_eq!(name_of(wrong).unwrap_err().field, "name");
    }
    assert_eq!(callsign_of("DLH1"), Ok(*b"DLH1    "));
    for wrong in ["", "LUFTHANSA", "é"] {
        assert_eq!(callsign_of(wrong).unwrap_err().field, "callsign");
    }
}

#[test]
fn seconds_become_nanoseconds_without_losing_digits() {
    assert_eq!(time_ns_of(1_800_000_000.25), Ok(1_800_000_000_250_000_000));
    assert_eq!(time_ns_of(-1.5), Ok(-1_500_000_000));
    for wrong in [1.8e18, f64::NAN] {
        assert_eq!(time_ns_of(wrong).unwrap_err().field, "time_s");
    }
}

#[test]
fn numbers_are_reached_by_their_names() {
    let mut detection = Detection::default();
    for (value, name) in Detection::NUMBERS.iter().enumerate() {
        *detection.number_mut(name).unwrap() = Some(value as f64);
    }
    assert_eq!(
        (detection.latitude, detection.range_rate_sigma_mps),
        (Some(0.0), Some(21.0))
    );
    assert_eq!(detection.number_mut("heigth_m"), None);
}
