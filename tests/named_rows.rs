//! `koseki track`, `locate` and `score` with tables of named columns: the same targets in metres and in degrees.

use std::fmt::Write as _;

use frames::{Geodetic, SystemFrame};
use test_support::{Random, column, numbers};

use crate::common::Folder;

const ORIGIN: &str = "50.7,-1.03";

fn frame() -> SystemFrame {
    SystemFrame::at(Geodetic::from_degrees(50.7, -1.03, 0.0).unwrap())
}

/// Latitude, longitude and height of a place in metres, as cells of a row.
fn degrees(position_m: [f64; 3]) -> String {
    let place = frame().to_geodetic(position_m);
    format!(
        "{:.11},{:.11},{:.6}",
        place.latitude_deg(),
        place.longitude_deg(),
        place.height_m()
    )
}

/// Whether two tables have the same values in these columns.
fn assert_same(one: &str, other: &str, names: &[&str], within: f64) {
    for name in names {
        let [one, other] = [one, other].map(|table| numbers(table, name));
        assert_eq!(one.len(), other.len(), "{name}");
        let far = one
            .iter()
            .zip(&other)
            .find(|(one, other)| (*one - *other).abs() > within);
        assert!(far.is_none() && !one.is_empty(), "{name}: {far:?}");
    }
}

/// Places of `--out` in degrees are those in metres.
fn assert_placed(table: &str) {
    let places = numbers(table, "x")
        .into_iter()
        .zip(numbers(table, "y"))
        .zip(numbers(table, "z"));
    let found = numbers(table, "latitude").into_iter().zip(numbers(table, "longitude"));
    for (((x, y), z), (latitude, longitude)) in places.zip(found) {
        let place = frame().to_geodetic([x, y, z]);
        assert!((place.latitude_deg() - latitude).abs() < 1e-6 && (place.longitude_deg() - longitude).abs() < 1e-6);
    }
}

#[test]
fn detections_in_degrees_give_the_tracks_of_those_in_metres() {
    let mut metres = "time_s,sensor_id,scan,detection_id,kind,m0,m1,m2,m3,s0,s1,s2,s3,px,py,pz,address\n".to_owned();
    let mut named = "BaseDateTime,LAT,LON,altitude (m),sigma_m,icao24,remark\n".to_owned();
    let mut random = Random::new(7);
    for step in 0..40 {
        for (id, start) in [(1, [2_000.0, -9_000.0]), (2, [-4_000.0, 3_000.0])] {
            let time = f64::from(step);
            let mut error = || random.between(-20.0, 20.0);
            let [x, y] = [start[0] + 120.0 * time + error(), start[1] + 80.0 * time + error()];
            let address = format!("3C658{id}");
            writeln!(
                metres,
                "{step},1,{scan},{id},position3,{x},{y},900,,20,20,30,,0,0,0,{address}",
                scan = step + 1
            )
            .unwrap();
            writeln!(named, "00:00:{step:02},{},20,{address},-", degrees([x, y, 900.0])).unwrap();
        }
    }
    let folder = Folder::with(&[("metres.csv", metres), ("named.csv", named)]);
    folder.succeed("track --detections metres.csv --out metres_tracks.csv");
    let found = folder.json(&format!(
        "track --detections named.csv --origin {ORIGIN} --out named_tracks.csv --json"
    ));
    assert_eq!(
        (&found["detections"], &found["rows_refused"], &found["tracks"]),
        (&80.into(), &0.into(), &2.into())
    );
    let [metres, named] = ["metres_tracks.csv", "named_tracks.csv"].map(|name| folder.read(name));
    assert_same(
        &metres,
        &named,
        &["time_s", "x", "y", "z", "vx", "vy", "P00", "sensor_track_id"],
        2e-3,
    );
    assert_eq!(column(&metres, "address"), column(&named, "address"));
    assert_placed(&named);
    assert!(!metres.lines().next().unwrap().contains("latitude"));
    let (_, said) = folder.succeed("track --detections named.csv --out own_origin.csv");
    assert!(said.contains("assumed: origin of the plane: latitude 50.6"), "{said}");
}

#[test]
fn bearings_in_degrees_give_the_fixes_of_those_in_radians() {
    let mut metres = "time_s,emitter_id,bearing_rad,sigma_rad,px,py,pz\n".to_owned();
    let mut named = "Time,Latitude,Longitude,height_m,bearing_deg,sigma_deg,emitter\n".to_owned();
    let mut random = Random::new(5);
    for step in 0..300 {
        let time = 2.0 * f64::from(step);
        let from = [6e3 * (time / 50.0).sin(), 6e3 * (time / 50.0).cos(), 3_000.0];
        let bearing = f64::atan2(1e3 - from[0], 500.0 - from[1]) + random.between(-0.03, 0.03);
        writeln!(metres, "{time},4,{bearing:.12},0.02,{},{},3000", from[0], from[1]).unwrap();
        // From true north at the aircraft.
        let [_, north, _] = frame().axes(from);
        let of_place = (bearing - north[0].atan2(north[1])).to_degrees();
        let sigma = 0.02_f64.to_degrees();
        writeln!(named, "{time},{},{of_place:.12},{sigma:.12},4", degrees(from)).unwrap();
    }
    let folder = Folder::with(&[("metres.csv", metres), ("named.csv", named)]);
    folder.succeed("locate --bearings metres.csv --out metres_fixes.csv");
    let found = folder.json(&format!(
        "locate --bearings named.csv --origin {ORIGIN} --out named_fixes.csv --json"
    ));
    assert_eq!((&found["bearings"], &found["rows_refused"]), (&300.into(), &0.into()));
    let [metres, named] = ["metres_fixes.csv", "named_fixes.csv"].map(|name| folder.read(name));
    assert_same(&metres, &named, &["time_s", "emitter_id", "x", "y"], 0.1);
    assert_placed(&named);
    let (_, said) = folder.succeed("locate --bearings named.csv --out own_origin.csv");
    assert!(said.contains("assumed: origin of the plane: latitude 50.75"), "{said}");
}

#[test]
fn a_truth_in_degrees_gives_the_figures_of_one_in_metres() {
    let (mut metres, mut named) = (
        "time_s,target_id,x,y,z,vx,vy,vz\n".to_owned(),
        "timestamp,lat,lon,height_m,sog_knots,cog,mmsi\n".to_owned(),
    );
    let mut tracks = "time_s,system_track_id,x,y,z,vx,vy,vz\n".to_owned();
    let knot = 1852.0 / 3600.0;
    for step in 0..60 {
        let y = 10.0 * knot * f64::from(step);
        writeln!(metres, "{step},235070762,100,{y},0,0,{},0", 10.0 * knot).unwrap();
        writeln!(named, "00:00:{step:02},{},10,0,235070762", degrees([100.0, y, 0.0])).unwrap();
        writeln!(tracks, "{step},1,103,{},0,0.1,{},0", y + 4.0, 10.0 * knot).unwrap();
    }
    let folder = Folder::with(&[("metres.csv", metres), ("named.csv", named), ("tracks.csv", tracks)]);
    let score = |truth: &str| {
        folder.json(&format!(
            "score --truth {truth} --tracks tracks.csv --origin {ORIGIN} --json"
        ))
    };
    let (metres, named) = (score("metres.csv"), score("named.csv"));
    for figure in ["gospa", "ospa"] {
        let [one, other] = [&metres, &named].map(|figures| figures[figure].as_f64().unwrap());
        assert!((one - other).abs() < 1e-3 && one > 1.0, "{figure}: {one} {other}");
    }
}

#[test]
fn faults_of_named_tables_name_file_column_value_and_remedy() {
    let folder = Folder::with(&[
        ("bare.csv", "time,lat,lon\n1,50.7,-1\n2,50.7,-1\n"),
        ("bad.csv", "time,lat,lon,sigma_m\n1,95,-1,5\n"),
        ("metres.csv", "time,x,y,sigma_m\n1,5,6,5\n"),
        ("unitless.csv", "time,lat,lon,bearing\n1,50.7,-1,5\n"),
    ]);
    for (arguments, words) in [
        (
            "track --detections bare.csv",
            "bare.csv: no detection of sensor 1 states standard deviations",
        ),
        (
            "track --detections bad.csv",
            "bad.csv: no row can be used: bad.csv: line 2, column lat: \"95\" gives no place",
        ),
        (
            "locate --bearings unitless.csv",
            "unitless.csv: header: column bearing_rad is missing",
        ),
    ] {
        let line = folder.refusal(&format!("{arguments} --out x.csv"));
        assert!(line.contains(words), "{line}");
    }
    let found = folder.json("track --detections metres.csv bad.csv --out x.csv --json");
    assert_eq!(found["refused"]["column lat"], 1);
}
