//! `koseki track` as a user calls it: files of detections in, tracks out, and what is refused.

use std::fmt::Write as _;
use std::fs;

use serde_json::Value;
use test_support::{Random, column};

use crate::common::Folder;

const HEADER: &str = "time_s,sensor_id,scan,detection_id,kind,m0,m1,m2,m3,s0,s1,s2,s3,px,py,pz,truth_id";

fn position(time_s: f64, scan: usize, number: usize, [east, north]: [f64; 2]) -> String {
    format!("{time_s},1,{scan},{number},position2,{east:.3},{north:.3},,,50,50,,,0,0,0,")
}

/// Two targets that fly past each other, a false detection or two per scan of 4 s, and a miss now and then.
fn scene(scans: usize) -> Vec<String> {
    let (mut random, mut rows) = (Random::new(1), Vec::new());
    for scan in 0..scans {
        let time_s = 4.0 * scan as f64;
        let mut off = || 100.0 * (random.unit() + random.unit() - 1.0);
        let mut places = vec![
            [-8000.0 + 150.0 * time_s + off(), 500.0 + off()],
            [8000.0 - 150.0 * time_s + off(), -500.0 + off()],
        ];
        if scan % 7 == 5 {
            places.remove(scan % 2);
        }
        for _ in 0..1 + scan % 2 {
            places.push([20e3 * (random.unit() - 0.5), 20e3 * (random.unit() - 0.5)]);
        }
        for (number, place) in places.into_iter().enumerate() {
            rows.push(position(time_s, scan, number, place));
        }
    }
    rows
}

/// A table of detections.
fn table(rows: &[String]) -> String {
    format!("{HEADER}\n{}\n", rows.join("\n"))
}

/// The table of the scene of so many scans.
pub(crate) fn scene_of(scans: usize) -> String {
    table(&scene(scans))
}

fn write(folder: &Folder, name: &str, rows: &[String]) {
    folder.write(name, table(rows));
}

/// What `koseki track` says of files that it takes.
fn track(folder: &Folder, arguments: &str) -> Value {
    folder.json(&format!("track {arguments} --json"))
}

/// The one line with which `koseki track` refuses a call; nothing is written then.
fn refusal(folder: &Folder, arguments: &str) -> String {
    let line = folder.refusal(&format!("track {arguments}"));
    assert!(!folder.path("tracks.csv").exists(), "{line}");
    line
}

#[test]
fn two_targets_that_pass_each_other_have_a_track_each() {
    let folder = Folder::new();
    write(&folder, "plots.csv", &scene(28));
    let said = track(&folder, "--detections plots.csv --out tracks.csv");
    assert_eq!(
        (&said["scans"], &said["tracks"], &said["live_tracks"]),
        (&28.into(), &2.into(), &2.into())
    );
    let tracks = folder.read("tracks.csv");
    let header = tracks.lines().next().unwrap();
    assert!(
        header.starts_with("time_s,sensor_id,sensor_track_id,x,y,z,vx,vy,vz,P00,P01,"),
        "{header}"
    );
    assert!(
        header.ends_with(",hypotheses,reliability") && header.contains(",P55,state,"),
        "{header}"
    );
    assert_eq!(said["rows"], tracks.lines().count() - 1);
    for (name, allowed) in [
        ("sensor_id", &["0"][..]),
        ("state", &["confirmed", "coasted"]),
        ("height_valid", &["0"]),
    ] {
        assert!(
            column(&tracks, name)
                .iter()
                .all(|value| allowed.contains(&value.as_str())),
            "{name}"
        );
    }
    // One row per track and scan, and who flies east goes on flying east.
    let speeds = column(&tracks, "vx")
        .into_iter()
        .zip(column(&tracks, "sensor_track_id"));
    let late: Vec<_> = speeds.skip(10).collect();
    let east = &late.iter().find(|(vx, _)| vx.parse::<f64>().unwrap() > 0.0).unwrap().1;
    assert!(
        late.iter()
            .all(|(vx, number)| (vx.parse::<f64>().unwrap() > 0.0) == (number == east))
    );
    let share = said["false_share"].as_f64().unwrap();
    assert!((0.3..0.6).contains(&share), "{share}");
}

#[test]
fn neither_the_order_of_rows_nor_their_number_of_files_matters() {
    let folder = Folder::new();
    let mut rows = scene(20);
    write(&folder, "plots.csv", &rows);
    track(&folder, "--detections plots.csv --out tracks.csv");
    let expected = folder.read("tracks.csv");
    let mut random = Random::new(7);
    for place in (1..rows.len()).rev() {
        rows.swap(place, (random.unit() * place as f64) as usize);
    }
    let (one, other) = rows.split_at(17);
    write(&folder, "one.csv", one);
    write(&folder, "other.csv", other);
    track(&folder, "--detections one.csv other.csv --out again.csv");
    assert!(folder.read("again.csv") == expected);
}

#[test]
fn a_configuration_is_heard_and_sensors_of_all_kinds_meet_in_one_track() {
    let folder = Folder::new();
    let mut rows = Vec::new();
    for scan in 0..12 {
        let at = |time_s: f64| (time_s, 1000.0 + 20.0 * time_s, 2000.0f64);
        let (time_s, east, north) = at(f64::from(scan));
        rows.push(format!("{time_s},3,{scan},0,position2,{east},{north},,,,,,,0,0,0,"));
        let (time_s, east, north) = at(f64::from(scan) + 0.5);
        let bearing = east.atan2(north);
        rows.push(format!("{time_s},8,{scan},0,bearing,{bearing},,,,0.001,,,,0,0,0,"));
        let (time_s, east, north) = at(f64::from(scan) + 0.75);
        let (range, bearing) = (east.hypot(north), east.atan2(north));
        let rate = 20.0 * east / range;
        rows.push(format!(
            "{time_s},9,{scan},0,range_bearing,{range},{bearing},,{rate},10,0.001,,1,0,0,0,"
        ));
    }
    write(&folder, "all.csv", &rows);
    let line = refusal(&folder, "--detections all.csv --out tracks.csv");
    assert!(
        line.contains("all.csv: no detection of sensor 3 states standard deviations"),
        "{line}"
    );
    assert!(line.contains("[[sensor]] with id = 3"), "{line}");
    let known = |id: u32, more: &str| format!("[[sensor]]\nid = {id}\nclutter_density = 1e-8\n{more}");
    let sensors = known(3, "sigmas = [10, 10]\n") + &known(9, "[confirmation]\ndetections_min = 4\n");
    folder.write("sensors.toml", &sensors);
    let said = track(&folder, "--detections all.csv --config sensors.toml --out tracks.csv");
    assert_eq!((&said["tracks"], &said["scans"]), (&1.into(), &36.into()));
    let first = column(&folder.read("tracks.csv"), "time_s")[0].parse::<f64>().unwrap();
    assert!(first >= 1.0, "four detections: {first}");
    folder.write("wrong.toml", "[confirmation]\ndetection_min = 4\n");
    let _ = fs::remove_file(folder.path("tracks.csv"));
    let line = refusal(&folder, "--detections all.csv --config wrong.toml --out tracks.csv");
    assert!(
        line.contains("wrong.toml:2: confirmation.detection_min: unknown key"),
        "{line}"
    );
}

#[test]
fn bad_rows_are_left_out_and_counted_with_their_place() {
    let folder = Folder::new();
    let mut rows = scene(10);
    for bad in [
        "8,1,2,9,position2,nan,1,,,50,50,,,0,0,0,",
        "8,1,2,9,plot,1,1,,,50,50,,,0,0,0,",
        "8,1,2,9,position2,1,1,1,,50,50,,,0,0,0,",
        "8,1,2,9,position2,1,1,,,0,50,,,0,0,0,",
        "8,1,2,9,position2,1,1",
        "soon,1,2,9,position2,1,1,,,50,50,,,0,0,0,",
        "1e9,1,2,9,position2,1,1,,,50,50,,,0,0,0,",
        "8,1,2,9,bearing,270,,,,0.1,,,,0,0,0,",
    ] {
        rows.push(bad.to_owned());
    }
    write(&folder, "plots.csv", &rows);
    let said = track(&folder, "--detections plots.csv --out tracks.csv");
    assert_eq!((&said["rows_refused"], &said["tracks"]), (&8.into(), &2.into()));
    let first = said["first_refused"][0].as_str().unwrap();
    let line = rows.len() - 8 + 2;
    assert!(
        first.contains(&format!("plots.csv: line {line}, column m0")) && first.contains("NaN") || first.contains("nan"),
        "{first}"
    );
    let text = String::from_utf8(folder.run("track --detections plots.csv --out tracks.csv").stderr).unwrap();
    for expected in ["left out: 8 rows", "2 confirmed", "time per scan: median", "28 scans"] {
        assert!(text.contains(expected) || expected == "28 scans", "{expected}: {text}");
    }
}

#[test]
fn files_that_are_none_are_refused_in_one_line() {
    let folder = Folder::new();
    folder.write("empty.csv", "");
    folder.write("header.csv", format!("{HEADER}\n"));
    folder.write(
        "tracks_of_another.csv",
        "time_s,sensor_id,sensor_track_id,x,y\n1,1,1,1,1\n",
    );
    write(&folder, "wrong.csv", &["1,1,1,1,plot,1,1,,,5,5,,,0,0,0,".to_owned()]);
    write(&folder, "good.csv", &scene(3));
    for (arguments, expected) in [
        ("--detections gone.csv --out tracks.csv", "gone.csv: cannot be read"),
        ("--detections . --out tracks.csv", "is a folder"),
        ("--detections empty.csv --out tracks.csv", "column time_s is missing"),
        (
            "--detections tracks_of_another.csv --out tracks.csv",
            "column scan is missing",
        ),
        ("--detections header.csv --out tracks.csv", "header only"),
        (
            "--detections wrong.csv --out tracks.csv",
            "line 2, column kind: \"plot\" is no kind",
        ),
        (
            "--detections good.csv good.csv --out tracks.csv",
            "names good.csv twice",
        ),
        ("--detections good.csv --out good.csv", "--out good.csv is an input"),
        (
            "--detections good.csv --config gone.toml --out tracks.csv",
            "gone.toml: cannot be read",
        ),
        (
            "--detections good.csv --out tracks.csv --explain tracks.csv",
            "name two",
        ),
        ("--out tracks.csv", "--detections"),
        ("--detections good.csv", "--out"),
    ] {
        let line = refusal(&folder, arguments);
        assert!(
            line.starts_with("koseki: ") && line.contains(expected),
            "{arguments}: {line}"
        );
    }
}

#[test]
fn hostile_scans_are_bounded_and_counted() {
    let folder = Folder::new();
    // Two tracks, then 10,000 detections in a gate, all of them the same in the next scan, and none for minutes.
    let mut rows = scene(8);
    let before = rows.len() as u64;
    let mut random = Random::new(3);
    for number in 0..10_000 {
        let place = [-3250.0 + 100.0 * random.unit(), 450.0 + 100.0 * random.unit()];
        rows.push(position(32.0, 8, number, place));
    }
    rows.extend((0..10_000).map(|number| position(36.0, 9, number, [-2600.0, 500.0])));
    rows.push(position(436.0, 109, 0, [0.0, 0.0]));
    // A scan number that is greater at an earlier time, and times a day apart.
    rows.push(position(2.0, 110, 0, [0.0, 0.0]));
    rows.push(position(90_000.0, 110, 1, [0.0, 0.0]));
    write(&folder, "plots.csv", &rows);
    let said = track(&folder, "--detections plots.csv --out tracks.csv");
    let refused = &said["refused_by_tracker"];
    assert!(refused["unmade_comparisons"].as_u64().unwrap() > 1000, "{said}");
    assert!(refused["unusable_detections"].as_u64().unwrap() >= 1, "{said}");
    let unusable = refused["unusable_detections"].as_u64().unwrap();
    assert_eq!(said["detections"].as_u64().unwrap() + unusable, before + 20_003);
    assert_eq!(said["sensors"][0]["silent_scans"], 99);
    assert!(said["tracks"].as_u64().unwrap() >= 2, "{said}");
}

#[test]
fn its_help_teaches() {
    let output = Folder::new().run("track --help");
    let text = String::from_utf8(output.stdout).unwrap();
    for expected in [
        "Examples:",
        "range_bearing_elevation",
        "[[sensor]]",
        "detection_probability",
        "docs/tracking.md",
    ] {
        assert!(text.contains(expected), "{expected}");
    }
}

#[test]
fn decisions_are_explained() {
    let folder = Folder::new();
    write(&folder, "plots.csv", &scene(12));
    track(&folder, "--detections plots.csv --out tracks.csv --explain why.csv");
    let with = folder.read("tracks.csv");
    track(&folder, "--detections plots.csv --out without.csv");
    assert!(with == folder.read("without.csv"), "an observer changes nothing");
    let why = folder.read("why.csv");
    let (events, probabilities) = (column(&why, "event"), column(&why, "probability"));
    let count = |word: &str| events.iter().filter(|event| *event == word).count();
    assert_eq!((count("scan"), count("confirmed")), (12, 2), "{why}");
    assert!(
        count("ended") > 0 && count("started") > 2 && count("cluster") > 12,
        "{why}"
    );
    // The reliabilities of a cluster's hypotheses sum to 1.
    let clusters = column(&why, "cluster");
    let mut sums = std::collections::BTreeMap::new();
    for row in (0..events.len()).filter(|row| events[*row] == "hypothesis") {
        let scan = events[..row].iter().filter(|event| *event == "scan").count();
        *sums.entry((scan, &clusters[row])).or_insert(0.0) += probabilities[row].parse::<f64>().unwrap();
    }
    assert!(
        sums.len() > 12 && sums.values().all(|sum| (sum - 1.0f64).abs() < 1e-4),
        "{sums:?}"
    );
    let confirmed: Vec<String> = column(&with, "sensor_track_id");
    let numbers = column(&why, "sensor_track_id");
    for row in (0..events.len()).filter(|row| events[*row] == "confirmed") {
        assert!(confirmed.contains(&numbers[row]), "{why}");
    }
}

#[test]
fn a_recording_of_the_ferry_is_read_as_it_is() {
    let folder = Folder::new();
    let mut json = Vec::new();
    for scan in 0..20 {
        let time = 1_600_000_000.5 + f64::from(scan);
        let (north, east) = (30.0 + 2.0 * f64::from(scan), 40.0);
        json.push(format!(
            r#"{{"sensorID": 2, "ownshipPosition": [-10, 20], "time": {time}, "measurement": [{north}, {east}]}}"#
        ));
    }
    folder.write("ferry.json", format!("[{}]", json.join(",\n")));
    let line = refusal(&folder, "--detections ferry.json --out tracks.csv");
    assert!(
        line.contains("no detection of sensor 2 states standard deviations"),
        "{line}"
    );
    let near = "[initiation]\nspeed_sigma_mps = 5.0\n";
    folder.write(
        "ferry.toml",
        format!("[[sensor]]\nid = 2\nsigmas = [3.0, 3.0]\nclutter_density = 1e-6\n{near}"),
    );
    let said = track(&folder, "--detections ferry.json --config ferry.toml --out tracks.csv");
    assert_eq!((&said["tracks"], &said["scans"]), (&1.into(), &20.into()));
    let tracks = folder.read("tracks.csv");
    let last = |name: &str| column(&tracks, name).last().unwrap().parse::<f64>().unwrap();
    assert!(
        (last("x") - 60.0).abs() < 1.0 && (last("y") - 58.0).abs() < 1.0,
        "{tracks}"
    );
    // 2020-09-13, 12:26:40.5 and 19 s.
    assert!((last("time_s") - 44_819.5).abs() < 1e-3, "{tracks}");
    folder.write("broken.json", "[{\"sensorID\": 9}]");
    let _ = fs::remove_file(folder.path("tracks.csv"));
    let line = refusal(&folder, "--detections broken.json --config ferry.toml --out tracks.csv");
    assert!(line.contains("broken.json: detections: missing field"), "{line}");
}

/// Two targets side by side, of which every fifth scan shows both; a report of two every eight seconds.
fn side_by_side() -> (Vec<String>, String) {
    let (mut random, mut rows) = (Random::new(3), Vec::new());
    let mut reports = "time_s,arrival_s,x,y,z,vx,vy,vz,count,route\n".to_owned();
    for scan in 0..60 {
        let (time_s, mut off) = (2.0 * scan as f64, || 60.0 * (random.unit() + random.unit() - 1.0));
        let north = 20e3 - 150.0 * time_s;
        let easts: &[f64] = if scan % 5 == 3 { &[-100.0, 100.0] } else { &[0.0] };
        for (number, east) in easts.iter().enumerate() {
            rows.push(position(time_s, scan, number, [east + off(), north + off()]));
        }
        let clutter = [20e3 + 150.0 * off(), 30e3 + 150.0 * off()];
        rows.push(position(time_s, scan, 9, clutter));
        if scan % 4 == 0 {
            writeln!(
                reports,
                "{time_s},{},300,{},0,0,-150,0,2,0|90000",
                time_s + 8.0,
                north - 500.0
            )
            .unwrap();
        }
    }
    (rows, reports)
}

#[test]
fn a_wide_area_count_is_used_without_a_detection_more() {
    let folder = Folder::new();
    let (rows, reports) = side_by_side();
    write(&folder, "plots.csv", &rows);
    let bad = "10,5,0,0,0,0,0,0,2,\n10,12,0,0,0,0,0,0,10000,\n10,12,0,0,0,0,0,0,two,\n10,12,9e9,0,0,0,0,0,2,\n";
    folder.write("counts.csv", format!("{reports}{bad}"));
    folder.write("silent.csv", "time_s,arrival_s,x,y,z,vx,vy,vz,count\n");
    let without = track(&folder, "--detections plots.csv --out without.csv");
    assert!(without["wide_area"].is_null());
    let silent = track(
        &folder,
        "--detections plots.csv --wide-area silent.csv --out silent_tracks.csv",
    );
    assert_eq!(silent["wide_area"]["reports"], 0);
    let same = folder.read("without.csv") == folder.read("silent_tracks.csv");
    assert!(same, "no report changes nothing");
    let with = track(&folder, "--detections plots.csv --wide-area counts.csv --out with.csv");
    assert_eq!(with["detections"], without["detections"]);
    let support = &with["wide_area"];
    assert_eq!(support["rows_refused"], 1, "{with}");
    assert_eq!(support["reports"], 14, "{with}");
    assert!(support["corrections"].as_u64() > Some(0), "{with}");
    let refused = support["refused"].as_object().unwrap().values();
    assert_eq!(refused.filter_map(Value::as_u64).sum::<u64>(), 3, "{with}");
    let line = refusal(&folder, "--detections plots.csv --wide-area plots.csv --out tracks.csv");
    assert!(line.contains("arrival_s"), "{line}");
    let line = refusal(
        &folder,
        "--detections plots.csv --wide-area counts.csv --out counts.csv",
    );
    assert!(line.contains("counts.csv is an input"), "{line}");
}

#[test]
fn scans_without_detections_are_rows_before_the_first_detection_and_after_the_last() {
    let folder = Folder::new();
    let rows = scene(30);
    let empty = |scan: usize| format!("{},1,{scan},,none,,,,,,,,,,,,", 4.0 * scan as f64);
    let ends = |rows: &[String]| {
        write(&folder, "d.csv", rows);
        let said = track(&folder, "--detections d.csv --out t.csv");
        let of_sensor = &said["sensors"][0];
        let scans = ["scans", "silent_scans"].map(|name| of_sensor[name].as_u64().unwrap());
        let times = column(&folder.read("t.csv"), "time_s");
        let last_s = times
            .iter()
            .map(|time| time.parse::<f64>().unwrap())
            .fold(0.0, f64::max);
        (
            scans,
            last_s,
            said["live_tracks"].as_u64().unwrap(),
            said["rows_refused"].as_u64(),
        )
    };
    let (scans, last_s, live, _) = ends(&rows);
    assert_eq!((scans, last_s, live), ([30, 0], 116.0, 2));
    // Twice the same scan, and one that has detections, are no further scans.
    let after: Vec<String> = (29..50).chain([35]).map(empty).collect();
    let (scans, last_s, live, refused) = ends(&[rows.clone(), after].concat());
    assert_eq!((scans, live, refused), ([50, 20], 0, Some(0)));
    assert!(last_s > 120.0 && last_s < 160.0, "the tracks coast and end: {last_s}");
    // Before the first detection they are scans, too: a sensor that has not seen a target yet was looking.
    let late = rows
        .iter()
        .filter(|row| row.split(',').nth(2).unwrap().parse::<usize>().unwrap() >= 10);
    let late: Vec<String> = (0..10).map(empty).chain(late.cloned()).collect();
    assert_eq!(ends(&late).0, [30, 10]);
    // A row of this kind with a value is refused with its place.
    let bad = [rows, vec!["120,1,30,0,none,5,,,,,,,,,,,".to_owned()]].concat();
    write(&folder, "d.csv", &bad);
    let said = track(&folder, "--detections d.csv --out t.csv");
    let first = said["first_refused"][0].as_str().unwrap();
    assert!(
        first.contains("column m0") && first.contains("leave it empty"),
        "{first}"
    );
}
