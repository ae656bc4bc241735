//! `koseki fuse` with tables of named columns in degrees, as archives of receivers have them.

use std::collections::{BTreeMap, BTreeSet};
use std::io::Write as _;
use std::process::Stdio;

use test_support::{column, numbers, recordings};

use crate::common::Folder;

/// Two ships, 10 km apart, that go north at 10 knots for five minutes: a report of each in 10 s.
fn ships() -> String {
    let mut text = "BaseDateTime,MMSI,LAT,LON,SOG,COG,Heading,VesselName,Altitude\n".to_owned();
    for step in 0..30 {
        let latitude = 50.7 + 1852.0 / 360.0 * f64::from(step) * 10.0 / 111_240.0;
        for (mmsi, longitude, name) in [(235_070_762, -1.1, "SEA CLOUD"), (235_013_375, -0.96, "")] {
            let (minutes, seconds) = (step / 6, step % 6 * 10);
            text +=
                &format!("2016-01-12T13:{minutes:02}:{seconds:02},{mmsi},{latitude:.6},{longitude},10,0,511,{name},\n");
        }
    }
    text
}

/// Track numbers by MMSI or address, without those that state none.
fn tracks_of(fused: &str, identity: &str) -> BTreeMap<String, BTreeSet<String>> {
    let mut found: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    let states = column(fused, "state");
    let rows = column(fused, identity)
        .into_iter()
        .zip(column(fused, "system_track_id"));
    for ((name, number), state) in rows.zip(states) {
        if !name.is_empty() && ["confirmed", "coasted"].contains(&state.as_str()) {
            found.entry(name).or_default().insert(number);
        }
    }
    found
}

#[test]
fn a_table_in_degrees_needs_no_configuration() {
    let folder = Folder::with(&[("ships.csv", ships())]);
    let found = folder.json("fuse --tracks ships.csv --out fused.csv --json");
    assert_eq!((&found["rows_refused"], &found["reports"]), (&0.into(), &60.into()));
    assert_eq!(found["system_tracks"]["tracks_confirmed"], 2);
    assert_eq!(found["sensors"][0]["name"], "ships");
    let assumed = found["assumed"].to_string();
    for words in [
        "origin of the plane: latitude 50.700000, longitude -1.100000, the first position of ships.csv (line 2)",
        "all positions have a standard deviation of 30 m",
        "times without a zone are taken for UTC",
        "columns that are not used: Altitude, Heading",
        "column Altitude has no unit, so it is not used; name it altitude_m",
    ] {
        assert!(assumed.contains(words), "{assumed}");
    }
    let fused = folder.read("fused.csv");
    let tracks = tracks_of(&fused, "mmsi");
    assert_eq!(tracks.keys().collect::<Vec<_>>(), ["235013375", "235070762"]);
    assert!(tracks.values().all(|numbers| numbers.len() == 1));
    let [latitude, longitude] = ["latitude", "longitude"].map(|name| numbers(&fused, name));
    for (latitude, longitude) in latitude.iter().zip(&longitude) {
        let off = [(longitude + 1.1).abs(), (longitude + 0.96).abs()];
        assert!(
            (50.69..50.72).contains(latitude) && off[0].min(off[1]) < 1e-3,
            "{latitude} {longitude}"
        );
    }
    assert!(column(&fused, "utc")[0].starts_with("2016-01-12T13:00:00"));
    let (_, said) = folder.succeed("fuse --tracks ships.csv --out again.csv");
    assert!(
        said.contains("assumed: origin of the plane") && said.contains(": ships\n"),
        "{said}"
    );
    assert_eq!(folder.read("again.csv"), fused);
}

#[test]
fn what_is_given_replaces_what_is_assumed() {
    let folder = Folder::with(&[("ships.csv", ships())]);
    folder.write(
        "sensors.toml",
        "[[sensor]]\nid = 7\nname = \"ships\"\n[sensor.accuracy]\nsigma_m = 20.0\n",
    );
    let given = "--origin 50.7,-1.03 --sigma 15";
    let found = folder.json(&format!("fuse --tracks ships.csv {given} --out fused.csv --json"));
    let assumed = found["assumed"].to_string();
    assert!(
        !assumed.contains("origin") && !assumed.contains("deviation"),
        "{assumed}"
    );
    let fused = folder.read("fused.csv");
    let east = numbers(&fused, "x");
    assert!(east.iter().all(|east| (east.abs() - 4_930.0).abs() < 60.0), "{east:?}");
    let found = folder.json("fuse --tracks ships.csv --config sensors.toml --out named.csv --json");
    assert_eq!(found["sensors"][0]["sensor_id"], 7);
    assert_eq!(tracks_of(&folder.read("named.csv"), "mmsi").len(), 2);
}

#[test]
fn rows_without_use_are_counted_by_reason_with_an_example() {
    let bad = "2016-01-12T13:04:55,235070762,91,181,10,0,511,,\n2016-01-12T13:04:56,,50.7,-1.1,10,0,511,,\n\
               soon,235070762,50.7,-1.1,10,0,511,,\n2016-01-12T13:04:57,235070762,50.7\n";
    let folder = Folder::with(&[("ships.csv", ships() + bad)]);
    let found = folder.json("fuse --tracks ships.csv --out fused.csv --json");
    assert_eq!((&found["rows_refused"], &found["reports"]), (&4.into(), &60.into()));
    let reasons =
        serde_json::json!({ "column lat": 1, "column mmsi": 1, "column base_date_time": 1, "number of values": 1 });
    assert_eq!(found["refused"], reasons);
    let first = found["first_refused"].to_string();
    for words in [
        "ships.csv: line 62, column lat: \\\"91\\\" gives no place",
        "column mmsi: \\\"\\\" names no target",
    ] {
        assert!(first.contains(words), "{first}");
    }
}

#[test]
fn headers_that_contradict_themselves_or_other_files_are_refused() {
    let metres = "time_s,sensor_id,sensor_track_id,x,y,trace\n1,1,1,0,0,9\n";
    let folder = Folder::with(&[
        ("ships.csv", ships()),
        ("twice.csv", "time,timestamp,lat,lon\n1,1,50,1\n".to_owned()),
        ("empty.csv", "time,lat,lon,id\n".to_owned()),
        ("metres.csv", metres.to_owned()),
    ]);
    for (arguments, words) in [
        ("twice.csv", "header: columns time and timestamp state one quantity"),
        ("empty.csv", "no row has a time with a latitude and a longitude"),
        (
            "ships.csv metres.csv",
            "ships.csv has positions in degrees, metres.csv in metres; give --origin LAT,LON",
        ),
        ("metres.csv --origin 50,1", "--origin places tables in degrees"),
        ("metres.csv --sigma 5", "--sigma is for tables of named columns"),
    ] {
        let line = folder.refusal(&format!("fuse --tracks {arguments} --out x.csv"));
        assert!(line.contains(words), "{line}");
    }
}

#[test]
fn tables_in_metres_go_through_as_before() {
    let header = "time_s,sensor_id,sensor_track_id,x,y,z,vx,vy,vz,state,trace";
    let row = |step: i32| format!("{step},3,1,{},0,0,10,0,0,confirmed,200", 10 * step);
    let table = |header: &str, more: &str| {
        let rows = (0..20).map(|step| format!("{}{more}\n", row(step)));
        format!("{header}\n{}", rows.collect::<String>())
    };
    let folder = Folder::with(&[
        ("metres.csv", table(header, "")),
        (
            "more.csv",
            table(&format!("{header},latitude,longitude,speed,velocity"), ",50,1,1,2"),
        ),
    ]);
    let found = folder.json("fuse --tracks metres.csv --out fused.csv --json");
    assert_eq!((&found["reports"], found.get("assumed")), (&20.into(), None));
    folder.succeed("fuse --tracks more.csv --out more_fused.csv");
    let fused = folder.read("fused.csv");
    assert_eq!(folder.read("more_fused.csv"), fused);
    assert!(!fused.lines().next().unwrap().contains("latitude"));
}

#[test]
fn a_pipe_is_read_once() {
    let folder = Folder::with(&[("ships.csv", ships())]);
    folder.succeed("fuse --tracks ships.csv --out fused.csv");
    let mut command = folder.command("fuse --tracks /dev/stdin --out piped.csv");
    let mut child = command.stdin(Stdio::piped()).spawn().unwrap();
    child.stdin.take().unwrap().write_all(ships().as_bytes()).unwrap();
    assert!(child.wait().unwrap().success());
    assert_eq!(folder.read("piped.csv"), folder.read("fused.csv"));
}

#[test]
fn smoothing_and_comparison_read_the_same_tables() {
    let folder = Folder::with(&[("ships.csv", ships())]);
    folder.succeed("fuse --tracks ships.csv --refresh 10 --out fused.csv");
    let (_, said) = folder.succeed("smooth --tracks ships.csv --refresh 10 --fused fused.csv --out smoothed.csv");
    assert!(said.contains("assumed: origin of the plane"), "{said}");
    let [fused, smoothed] = ["fused.csv", "smoothed.csv"].map(|name| folder.read(name));
    assert_eq!(fused.lines().next(), smoothed.lines().next());
    assert_eq!(column(&fused, "utc"), column(&smoothed, "utc"));
    let (_, said) = folder.succeed("compare --tracks ships.csv --json");
    assert!(said.contains("assumed: origin of the plane"), "{said}");
}

/// Outcome of a public file.
#[derive(Debug, PartialEq)]
struct PublicFile {
    reports: u64,
    /// Targets with a confirmed track.
    confirmed: usize,
    /// Targets with more than one track number.
    divided: usize,
}

fn public(folder: &Folder, name: &str, identity: &str) -> Option<PublicFile> {
    let path = recordings(name)?.join(name);
    let found = folder.json(&format!("fuse --tracks {} --out public.csv --json", path.display()));
    assert_eq!(found["rows_refused"], 0);
    let tracks = tracks_of(&folder.read("public.csv"), identity);
    Some(PublicFile {
        reports: found["reports"].as_u64().unwrap(),
        confirmed: tracks.len(),
        divided: tracks.values().filter(|numbers| numbers.len() > 1).count(),
    })
}

#[test]
fn each_aircraft_and_ship_of_a_public_file_is_a_track() {
    let folder = Folder::new();
    if let Some(found) = public(&folder, "stonesoup/OpenSky_Plane_States.csv", "address") {
        // Of 84 aircraft, 83 have three reports and more.
        let expected = PublicFile {
            reports: 6052,
            confirmed: 83,
            divided: 0,
        };
        assert_eq!(found, expected);
    }
    if let Some(found) = public(&folder, "stonesoup/SolentAIS_20160112_130211.csv", "mmsi") {
        // Of 91 ships, 88 have three reports and more; three are silent for 22 to 38 minutes, and get new numbers.
        let expected = PublicFile {
            reports: 18_623,
            confirmed: 88,
            divided: 3,
        };
        assert_eq!(found, expected);
    }
}
