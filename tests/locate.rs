//! `koseki locate` as a user calls it: bearings in, fixes out, and what is refused.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use serde_json::Value;
use test_support::Random;

use crate::common::Folder;

const HEADER: &str = "time_s,emitter_id,bearing_rad,sigma_rad,px,py,pz,heading_rad";

/// Two emitters, 4 still and 9 drifting, seen from an aircraft that circles: a bearing of each every 2 s for `seconds`.
fn flight(seconds: u32) -> String {
    let mut text = format!("{HEADER}\n");
    let mut random = Random::new(12345);
    let mut error = || random.between(-0.03, 0.03);
    for step in 0..seconds / 2 {
        let time = 2.0 * f64::from(step);
        let angle = time / 50.0;
        let (px, py) = (6e3 * angle.sin(), 6e3 * angle.cos());
        for (id, east, north) in [(4, 1e3, 500.0), (9, -1e3 + 4.0 * time, 200.0)] {
            let bearing = f64::atan2(east - px, north - py) + error();
            let heading = (angle + std::f64::consts::FRAC_PI_2) % std::f64::consts::TAU;
            writeln!(text, "{time},{id},{bearing:.9},0.02,{px:.3},{py:.3},3000,{heading:.6}").unwrap();
        }
    }
    text
}

/// Rows of a table as maps from column to value.
fn rows(text: &str) -> Vec<BTreeMap<String, String>> {
    let mut lines = text.lines();
    let header: Vec<_> = lines.next().unwrap().split(',').collect();
    lines
        .map(|line| {
            let values: Vec<_> = line.split(',').collect();
            assert_eq!(values.len(), header.len(), "{line}");
            header
                .iter()
                .map(|name| (*name).to_owned())
                .zip(values.into_iter().map(str::to_owned))
                .collect()
        })
        .collect()
}

fn number(row: &BTreeMap<String, String>, column: &str) -> f64 {
    row[column].parse().unwrap()
}

#[test]
fn emitters_are_located_and_every_decision_has_a_row() {
    let folder = Folder::new();
    folder.write("flight.csv", flight(1_200));
    let arguments =
        "locate --bearings flight.csv --out fixes.csv --explain why.csv --picture four.svg --emitter 4 --json";
    let (stdout, stderr) = folder.succeed(arguments);
    assert!(stderr.is_empty(), "{stderr}");
    let summary: Value = serde_json::from_str(&stdout).unwrap();
    assert_eq!(
        (summary["emitters_with_fix"].as_u64(), summary["bearings"].as_u64()),
        (Some(2), Some(1_200))
    );
    assert_eq!(
        summary["emitters_by_model"],
        serde_json::json!({"fixed": 1, "straight": 1})
    );
    let fixes = rows(&folder.read("fixes.csv"));
    assert_eq!(fixes.len() as u64, summary["rows"].as_u64().unwrap());
    for (id, [x, y, vx]) in [("4", [1e3, 500.0, 0.0]), ("9", [-1e3 + 4.0 * 1_198.0, 200.0, 4.0])] {
        let last = fixes.iter().rfind(|row| row["emitter_id"] == id).unwrap();
        assert_eq!(
            (last["time_s"].as_str(), last["stage"].as_str(), last["agreed"].as_str()),
            ("1198", "steered", "1")
        );
        let off = (number(last, "x") - x).hypot(number(last, "y") - y);
        assert!(off < 60.0, "emitter {id} is off by {off} m");
        assert!((number(last, "vx") - vx).abs() < 1.0);
        let trace = number(last, "Pxx") + number(last, "Pyy");
        assert!((trace - number(last, "variance_m2")).abs() < 0.01);
    }
    let decisions = rows(&folder.read("why.csv"));
    for (decision, subject) in [
        ("emitter_started", ""),
        ("model_leads", "fixed"),
        ("model_leads", "straight"),
        ("selection", "steered"),
    ] {
        assert!(
            decisions
                .iter()
                .any(|row| row["decision"] == decision && row["subject"] == subject),
            "{decision} {subject}"
        );
    }
    let picture = folder.read("four.svg");
    assert!(
        picture.contains("<svg") && picture.contains("Emitter 4"),
        "{picture:.200}"
    );
    // The same file and options give the same bytes.
    let before = folder.read("fixes.csv");
    folder.succeed(arguments);
    assert_eq!(folder.read("fixes.csv"), before);
}

#[test]
fn filter_and_selection_are_taken_from_the_command_line_or_the_configuration() {
    let folder = Folder::new();
    folder.write("flight.csv", flight(1_200));
    folder.write(
        "settings.toml",
        "[locating.motion]\nfilter = \"straight\"\n[locating.selection]\nselect = \"interval\"\ninterval_s = 60.0\n",
    );
    let (_, stderr) = folder.succeed("locate --bearings flight.csv --config settings.toml --out fixes.csv");
    assert!(stderr.contains("filter straight, select interval"), "{stderr}");
    let fixes = rows(&folder.read("fixes.csv"));
    assert!(
        fixes
            .iter()
            .all(|row| ["straight", "manoeuvring"].contains(&row["motion"].as_str()))
    );
    let selected = fixes
        .iter()
        .filter(|row| row["selected"] == "1" && row["emitter_id"] == "9")
        .count();
    assert!((10..=20).contains(&selected), "{selected}");
    let (_, stderr) = folder
        .succeed("locate --bearings flight.csv --config settings.toml --select none --filter fixed --out fixes.csv");
    assert!(stderr.contains("filter fixed, select none"), "{stderr}");
    for row in rows(&folder.read("fixes.csv")) {
        assert_eq!(
            (&row["x"], &row["y"], row["stage"].as_str()),
            (&row["raw_x"], &row["raw_y"], "passing")
        );
    }
}

#[test]
fn unusable_rows_are_left_out_and_said() {
    let folder = Folder::new();
    let mut text = flight(600);
    text.push_str("700,4,270,0.02,0,0,0,0\n");
    text.push_str("5,4,1,0.02,0,0,0,0\n");
    text.push_str("701,4,1,0,0,0,0,0\n");
    folder.write("flight.csv", &text);
    let (_, stderr) = folder.succeed("locate --bearings flight.csv --out fixes.csv");
    assert!(stderr.contains("left out: 3 rows"), "{stderr}");
    assert!(
        stderr.contains("flight.csv: line 602, column bearing_rad: \"270\" is more than a full turn"),
        "{stderr}"
    );
    assert!(
        stderr.contains("flight.csv: line 603: is older than the emitter's last bearing; sort"),
        "{stderr}"
    );
}

#[test]
fn what_makes_no_sense_is_refused_and_leaves_nothing() {
    let folder = Folder::new();
    folder.write("flight.csv", flight(20));
    folder.write("empty.csv", format!("{HEADER}\n"));
    folder.write("short.csv", "time_s,emitter_id,bearing_rad,px,py,pz\n1,1,1,0,0,0\n");
    folder.write("bad.toml", "[locating.selection]\ninterval_s = -1.0\n");
    let before = folder.names();
    for (arguments, expected) in [
        (
            "--bearings flight.csv --filter still --out f.csv",
            "--filter still: there are auto, fixed, straight",
        ),
        (
            "--bearings flight.csv --select all --out f.csv",
            "--select all: there are auto, none, interval",
        ),
        (
            "--bearings flight.csv --out flight.csv",
            "--out flight.csv is an input; name another file",
        ),
        (
            "--bearings flight.csv --out f.csv --explain f.csv",
            "--out and --explain name one file; name two",
        ),
        ("--bearings no.csv --out f.csv", "no.csv: cannot be read"),
        (
            "--bearings empty.csv --out f.csv",
            "empty.csv: no row can be used: the file has a header only",
        ),
        (
            "--bearings short.csv --out f.csv",
            "short.csv: header: column sigma_rad is missing",
        ),
        (
            "--bearings flight.csv --config bad.toml --out f.csv",
            "bad.toml:2: locating.selection.interval_s: -1 is out of range; it must be greater than 0",
        ),
    ] {
        let line = folder.refusal(&format!("locate {arguments}"));
        assert!(line.contains(expected), "{line}");
    }
    assert_eq!(folder.names(), before);
}

/// A dropped emitter has a fix with its first bearing; what cannot be meant is refused in one line.
#[test]
fn a_dropped_emitter_is_located_from_its_first_bearing_on() {
    let folder = Folder::new();
    folder.write("flight.csv", flight(20));
    let arguments = "locate --bearings flight.csv --dropped 4:0:1000,500:20 --out fixes.csv";
    folder.succeed(arguments);
    let fixes = rows(&folder.read("fixes.csv"));
    let first = &fixes[0];
    assert_eq!((first["time_s"].as_str(), first["emitter_id"].as_str()), ("0", "4"));
    assert!(
        (number(first, "x") - 1e3).hypot(number(first, "y") - 500.0) < 60.0,
        "{first:?}"
    );
    // The same by a file.
    let text = "[[dropped]]\nemitter_id = 4\ntime_s = 0\nposition_m = [1000, 500]\nsigma_m = 20\n";
    folder.write("drop.toml", text);
    folder.succeed("locate --bearings flight.csv --config drop.toml --out again.csv");
    let without_config = |name: &str| rows(&folder.read(name))[0]["x"].clone();
    assert_eq!(without_config("again.csv"), without_config("fixes.csv"));
    for (dropped, expected) in [
        ("4:0", "it must be ID:TIME_S:EAST,NORTH"),
        ("four:0:1,2", "four is no number of an emitter"),
        ("4:90000:1,2", "time_s: 90000 is out of range"),
        ("4:0:1,2:0", "sigma_m: 0 is out of range; it must be greater than 0"),
    ] {
        let output = folder.run(&format!(
            "locate --bearings flight.csv --dropped {dropped} --out out.csv"
        ));
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(said.contains(expected), "{said}");
    }
}
