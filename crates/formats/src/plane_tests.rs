use frames::{Geodetic, SystemFrame};
use observations::{Bearing, Detection, DetectionKind, EmitterMeasurement};

use super::*;
use crate::emitter_rows_csv::EmitterRowReader;
use crate::scan_rows_csv::{ScanRow, ScanRowReader};

fn frame() -> SystemFrame {
    SystemFrame::at(Geodetic::from_degrees(51.0, -1.0, 0.0).unwrap())
}

/// Outcome of each row of a table of detections.
fn detections(text: &str) -> Vec<Result<Detection, String>> {
    let reader = ScanRowReader::new(text.as_bytes(), 0).unwrap();
    let rows = reader.placed_in(Plane::Given(frame()));
    let detection = |row| match row {
        ScanRow::Detection(detection) => detection,
        ScanRow::Empty(_) => panic!("a scan without detections"),
    };
    rows.map(|row| row.map(detection).map_err(|error| error.to_string()))
        .collect()
}

fn measurements(text: &str) -> Vec<Result<EmitterMeasurement, String>> {
    let reader = EmitterRowReader::new(text.as_bytes(), 0).unwrap();
    let rows = reader.placed_in(Plane::Given(frame()));
    rows.map(|row| row.map_err(|error| error.to_string())).collect()
}

fn bearing(text: &str) -> Bearing {
    match measurements(text).remove(0).unwrap() {
        EmitterMeasurement::Bearing(bearing) => bearing,
        other => panic!("{other:?}"),
    }
}

/// A place in metres, in degrees.
fn in_degrees(position_m: [f64; 3]) -> (f64, f64, f64) {
    let place = frame().to_geodetic(position_m);
    (place.latitude_deg(), place.longitude_deg(), place.height_m())
}

fn is_near(one: &[f64], other: &[f64], within: f64) -> bool {
    one.iter().zip(other).all(|(one, other)| (one - other).abs() < within)
}

#[test]
fn a_detection_in_degrees_is_that_in_metres() {
    let position_m = [12_000.0, -7_000.0, 2_500.0];
    let (latitude, longitude, height_m) = in_degrees(position_m);
    let metres = "time_s,sensor_id,scan,detection_id,kind,m0,m1,m2,m3,s0,s1,s2,s3,px,py,pz,address\n\
                  5,1,1,1,position3,12000,-7000,2500,,20,20,30,,0,0,0,3C6589\n";
    let expected = detections(metres).remove(0).unwrap();
    for text in [
        format!("time,lat,lon,altitude (m),sigma_m,icao24\n5,{latitude},{longitude},{height_m},20,3c6589\n"),
        "Time,x,y,z,sigma_m,hex,scan,plot_id,sensor\n00:00:05,12000,-7000,2500,20,3C6589,1,1,1\n".to_owned(),
    ] {
        let found = detections(&text).remove(0).unwrap();
        assert!(is_near(&found.values, &expected.values, 1e-4), "{found:?}");
        let values = expected.values;
        assert_eq!(Detection { values, ..found }, expected, "{text}");
    }
}

#[test]
fn directions_in_degrees_are_those_in_radians() {
    let metres = "time_s,sensor_id,scan,detection_id,kind,m0,m1,m2,m3,s0,s1,s2,s3,px,py,pz\n\
                  5,1,1,1,range_bearing_elevation,1852,0.5,0.1,-9,10,0.01,0.02,1,100,200,30\n";
    let expected = detections(metres).remove(0).unwrap();
    let degrees = [0.5_f64, 0.1, 0.01, 0.02].map(f64::to_degrees);
    let [bearing, elevation, bearing_sigma, elevation_sigma] = degrees;
    let text = format!(
        "time,range_nmi,azimuth_deg,elevation_deg,range_sigma_m,sigma_deg,elevation_sigma_deg,range_rate_mps,\
         range_rate_sigma_mps,sensor_x,sensor_y,sensor_z\n\
         5,1,{bearing},{elevation},10,{bearing_sigma},{elevation_sigma},-9,1,100,200,30\n"
    );
    let found = detections(&text).remove(0).unwrap();
    assert_eq!((found.kind, found.platform_m), (expected.kind, expected.platform_m));
    assert_eq!(found.range_rate_mps, expected.range_rate_mps);
    assert!(is_near(&found.values, &expected.values, 1e-9), "{found:?}");
    assert!(
        is_near(&found.sigmas.unwrap(), &expected.sigmas.unwrap(), 1e-9),
        "{found:?}"
    );
}

#[test]
fn bearings_turn_from_true_north_into_the_plane() {
    // At 51° of latitude, 5° further east: the meridian there leans by about 5° sin 51° = 3.9° to the left.
    let text = "time,latitude,longitude,bearing_deg,sigma_deg\n1,51,4,90,1\n";
    let found = bearing(text);
    assert!((found.bearing_rad.to_degrees() - 86.11).abs() < 0.02, "{found:?}");
    assert!((found.sigma_rad.to_degrees() - 1.0).abs() < 1e-9 && found.emitter_id.is_none());
    let detection = detections(text).remove(0).unwrap();
    assert_eq!(detection.kind, DetectionKind::Bearing);
    assert_eq!(
        (detection.values[0], detection.platform_m),
        (found.bearing_rad, found.platform_m)
    );
    let metres = bearing("time,px,py,pz,bearing_deg,sigma_deg\n1,10,20,30,90,1\n");
    assert!((metres.bearing_rad.to_degrees() - 90.0).abs() < 1e-9);
    assert_eq!(metres.platform_m, [10.0, 20.0, 30.0]);
}

#[test]
fn a_fix_in_degrees_has_the_variance_of_its_sigma() {
    let (latitude, longitude, height_m) = in_degrees([1_000.0, 2_000.0, 50.0]);
    let text = format!("timestamp,emitter,lat,lon,height_m,sigma_m\n9,7,{latitude},{longitude},{height_m},30\n");
    let Ok(EmitterMeasurement::Fix(fix)) = measurements(&text).remove(0) else {
        panic!("no fix");
    };
    assert!(is_near(&fix.position_m, &[1_000.0, 2_000.0, 50.0], 1e-4), "{fix:?}");
    assert_eq!((fix.covariance_m2, fix.emitter_id), ([900.0, 0.0, 900.0], 7));
}

#[test]
fn the_first_place_is_the_origin_unless_metres_come_first() {
    let text = "time,latitude,longitude,bearing_deg,sigma_deg\n1,91,4,90,1\n2,51,4,90,1\n3,51,4.1,90,1\n";
    let mut reader = EmitterRowReader::new(text.as_bytes(), 0).unwrap();
    let rows: Vec<_> = reader.by_ref().collect();
    assert!(rows[0].is_err() && rows[1].is_ok() && rows[2].is_ok());
    let Plane::FirstPlace(_, place, 3) = *reader.plane() else {
        panic!("{:?}", reader.plane());
    };
    assert!(is_near(
        &[place.latitude_deg(), place.longitude_deg()],
        &[51.0, 4.0],
        1e-9
    ));
    for (plane, text, words) in [
        (
            Plane::Metres,
            text,
            "column latitude: \"51\" is in degrees, rows before in metres; give --origin",
        ),
        (
            *reader.plane(),
            "time,px,py,pz,bearing_deg,sigma_deg\n1,1,2,3,90,1\n",
            "column px: \"1\" is in metres, rows before in degrees; give --origin",
        ),
    ] {
        let rows = EmitterRowReader::new(text.as_bytes(), 0).unwrap().placed_in(plane);
        let said: Vec<_> = rows.filter_map(|row| Some(row.err()?.to_string())).collect();
        assert!(said.iter().any(|said| said.contains(words)), "{said:?}");
    }
}

#[test]
fn rows_of_one_time_are_a_scan_and_a_file_is_a_sensor() {
    let text = "time,lat,lon\n1,51,-1\n1,51.1,-1\n2,51,-1\n";
    let mut reader = ScanRowReader::new(text.as_bytes(), 0).unwrap();
    reader.set_sensor(3);
    let found: Vec<_> = reader
        .map(|row| match row.unwrap() {
            ScanRow::Detection(detection) => (detection.sensor_id, detection.scan, detection.detection_id),
            ScanRow::Empty(empty) => panic!("{empty:?}"),
        })
        .collect();
    assert_eq!(found, [(3, 1, 1), (3, 1, 2), (3, 2, 3)]);
    let error = ScanRowReader::with_scans(text.as_bytes(), 0).unwrap_err();
    assert!(error.to_string().contains("column scan is missing"), "{error}");
}

#[test]
fn what_cannot_be_meant_is_refused_with_its_column() {
    for (header, row, words) in [
        ("lat,lon", "91,-1", "column lat: \"91\" gives no place"),
        (
            "lat,lon",
            "nan,-1",
            "column lat: \"nan\" states no position; leave the row out",
        ),
        (
            "lat,lon,sigma_m",
            "51,-1,0",
            "column sigma_m: \"0\" is no standard deviation",
        ),
        (
            "lat,lon,sensor",
            "51,-1,north",
            "column sensor: \"north\" is no number of a sensor",
        ),
        (
            "lat,lon,bearing_deg",
            "51,-1,400",
            "column bearing_deg: \"400\" is more than a full turn; write degrees",
        ),
        (
            "lat,lon,bearing_deg,range_m",
            "51,-1,40,-4",
            "column range_m: \"-4\" is negative",
        ),
        (
            "lat,lon,bearing_deg,bearing_sigma_deg",
            "51,-1,40,0",
            "must be greater than 0",
        ),
        ("lat,lon,icao24", "51,-1,zz", "column icao24: \"zz\" is not an address"),
    ] {
        let said = detections(&format!("time,{header}\n1,{row}\n")).remove(0).unwrap_err();
        assert!(said.starts_with("line 2, ") && said.contains(words), "{said}");
    }
    for (header, words) in [
        ("lat,lon", "column time is missing"),
        ("time,lat", "column longitude is missing"),
        ("time,lat,lon,x,y", "columns lat and x both state the position"),
        (
            "time,timestamp,lat,lon",
            "columns time and timestamp state one quantity",
        ),
        ("time,bearing_deg", "column px is missing"),
        (
            "time,bearing_deg,range_m,range_sigma_m,lat,lon",
            "column sigma_rad is missing",
        ),
    ] {
        let said = ScanRowReader::new(header.as_bytes(), 0).unwrap_err().to_string();
        assert!(said.contains(words), "{said}");
    }
}

proptest::proptest! {
    #[test]
    fn any_text_is_refused_or_read_and_each_row_once(
        header in "(time|bearing_deg|range_km|lat|lon|x|y|px|py|pz|sigma_m|fl|,){1,12}",
        rows in proptest::collection::vec("[0-9a-z.:,-]{0,40}", 0..8),
    ) {
        let text = format!("time,{header}\n{}\n", rows.join("\n"));
        if let Ok(reader) = ScanRowReader::new(text.as_bytes(), 0) {
            proptest::prop_assert!(reader.count() <= rows.len());
        }
        if let Ok(reader) = EmitterRowReader::new(text.as_bytes(), 0) {
            proptest::prop_assert!(reader.count() <= rows.len());
        }
    }
}
