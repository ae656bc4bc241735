//! `koseki locate` with arrival times and ready-made fixes, as a user calls it.

use std::fmt::Write as _;

use serde_json::Value;
use test_support::Random;

use crate::common::Folder;

const C: f64 = 299_792_458.0;
const HEADER: &str = "time_s,emitter_id,kind,receiver,t_s,sigma_s,px,py,pz,receiver_2,px_2,py_2,pz_2,tdoa_s,reference_x,\
                      reference_y,reference_z";
const RECEIVERS: [(&str, [f64; 2]); 4] = [
    ("south-west", [-10e3, -10e3]),
    ("south-east", [10e3, -10e3]),
    ("north-east", [10e3, 10e3]),
    ("north-west", [-10e3, 10e3]),
];
const EMITTER: [f64; 2] = [3e3, -4e3];
const REFERENCE: [f64; 2] = [-1e3, 500.0];

fn distance(one: [f64; 2], other: [f64; 2]) -> f64 {
    (one[0] - other[0]).hypot(one[1] - other[1])
}

/// Arrival times of an emitter and of a reference emitter, each second, by clocks that are off by up to 10 µs.
fn times(seconds: u32) -> String {
    let mut text = format!("{HEADER}\n");
    let mut random = Random::new(7);
    for second in 0..seconds {
        for (id, place, after_s) in [(9, REFERENCE, 0.0), (4, EMITTER, 0.5)] {
            let time_s = f64::from(second) + after_s;
            for (number, (name, at)) in RECEIVERS.into_iter().enumerate() {
                let clock_s = 1e-5 * (number as f64 - 1.0) + 1e-9 * f64::from(second);
                let t_s = time_s + distance(at, place) / C + clock_s + random.between(-8e-8, 8e-8);
                let known = if id == 9 {
                    format!("{},{},0", place[0], place[1])
                } else {
                    ",,".to_owned()
                };
                writeln!(
                    text,
                    "{time_s},{id},toa,{name},{t_s:.12},4.7e-8,{},{},0,,,,,,{known}",
                    at[0], at[1]
                )
                .unwrap();
            }
        }
    }
    text
}

/// Differences of arrival times from the first receiver, each second.
fn differences(seconds: u32) -> String {
    let mut text = format!("{HEADER}\n");
    let mut random = Random::new(8);
    for second in 0..seconds {
        for (name, at) in &RECEIVERS[1..] {
            let (first, from) = RECEIVERS[0];
            let tdoa_s = (distance(from, EMITTER) - distance(*at, EMITTER)) / C + random.between(-1.1e-7, 1.1e-7);
            let places = format!("{},{},0,{name},{},{},0", from[0], from[1], at[0], at[1]);
            writeln!(text, "{second},4,tdoa,{first},,6.7e-8,{places},{tdoa_s:.12},,,").unwrap();
        }
    }
    text
}

/// Distance of the last fix from the emitter, and its model.
fn last(folder: &Folder, file: &str) -> (f64, String) {
    let text = folder.read(file);
    let row: Vec<_> = text.lines().last().expect("a fix").split(',').collect();
    let [x, y] = [11, 12].map(|column| row[column].parse().expect("a number"));
    (distance([x, y], EMITTER), row[18].to_owned())
}

#[test]
fn times_by_clocks_that_a_reference_emitter_shows_locate() {
    let folder = Folder::new();
    folder.write("times.csv", times(60));
    let arguments = "locate --bearings times.csv --out fixes.csv --json";
    let (stdout, _) = folder.succeed(arguments);
    let summary: Value = serde_json::from_str(&stdout).unwrap();
    assert_eq!(
        ["arrivals", "references", "emitters", "bearings"].map(|key| summary[key].as_u64().unwrap()),
        [480, 60, 1, 0]
    );
    // The clocks are known from the third reference on.
    assert_eq!(summary["refused"], serde_json::json!({"unknown clocks": 2}));
    let (off_m, motion) = last(&folder, "fixes.csv");
    assert!(off_m < 15.0 && motion == "fixed", "{off_m} m off, {motion}");
    let before = folder.read("fixes.csv");
    folder.succeed(arguments);
    assert_eq!(folder.read("fixes.csv"), before);
}

#[test]
fn differences_locate_alone_and_with_bearings() {
    let folder = Folder::new();
    folder.write("differences.csv", differences(20));
    folder.succeed("locate --bearings differences.csv --out fixes.csv");
    let (off_m, _) = last(&folder, "fixes.csv");
    assert!(off_m < 30.0, "{off_m} m off");
    // One pair, and bearings from one place: neither locates alone.
    let mut text = format!("{HEADER},bearing_rad,sigma_rad\n");
    for (second, row) in differences(20).lines().skip(1).step_by(3).enumerate() {
        let bearing = f64::atan2(EMITTER[0] + 20e3, EMITTER[1]);
        writeln!(
            text,
            "{second},4,bearing,,,,-20000,0,0,,,,,,,,,{bearing},0.005\n{row},,"
        )
        .unwrap();
    }
    folder.write("mixed.csv", text);
    let (_, stderr) = folder.succeed("locate --bearings mixed.csv --out fixes.csv");
    assert!(
        stderr.contains("20 bearings, 20 arrivals of 1 emitters; 1 with a fix"),
        "{stderr}"
    );
    let (off_m, _) = last(&folder, "fixes.csv");
    assert!(off_m < 60.0, "{off_m} m off");
}

/// The example of the specification: the fifth fix has a variance above the threshold.
#[test]
fn fixes_alone_are_selected_as_they_are() {
    let folder = Folder::new();
    folder.write(
        "fixes.csv",
        "time_s,emitter_id,x,y,z,variance_m2\n10,1,0,0,0,90\n20,1,10,0,0,90\n30,1,20,2,0,90\n40,1,30,3,0,90\n\
         50,1,70,70,0,200\n60,1,0,0,0,200\n",
    );
    folder.write(
        "settings.toml",
        "[locating.selection]\nselect = \"interval\"\ninterval_s = 10.0\nposition_sigma_max_m = 10.0\n",
    );
    let (_, stderr) = folder.succeed("locate --fixes fixes.csv --config settings.toml --out out.csv");
    assert!(
        stderr.contains("6 fixes of 1 emitters") && stderr.contains("filter none"),
        "{stderr}"
    );
    let output = |text: &str| -> Vec<(String, String)> {
        let rows = text.lines().skip(1).map(|line| line.split(',').collect::<Vec<_>>());
        rows.map(|row| (row[2].to_owned(), row[3].to_owned())).collect()
    };
    let expected = [(0, 0), (10, 0), (20, 0), (30, 2), (40, 5), (50, 8)];
    let expected = expected.map(|(x, y)| (format!("{x}.000"), format!("{y}.000")));
    assert_eq!(output(&folder.read("out.csv")), expected);
    // A filter makes one position of them, and so do fixes beside bearings.
    folder.succeed("locate --fixes fixes.csv --filter fixed --out out.csv");
    assert!(!folder.read("out.csv").contains(",given,"));
}

#[test]
fn fixes_and_bearings_are_joined_in_the_order_of_time() {
    let folder = Folder::new();
    let mut fixes = "time_s,emitter_id,x,y,z,Pxx,Pxy,Pyy\n".to_owned();
    let mut bearings = "time_s,emitter_id,bearing_rad,sigma_rad,px,py,pz\n".to_owned();
    for second in 0..10 {
        writeln!(fixes, "{second},4,3400,-4000,0,250000,0,100").unwrap();
        writeln!(bearings, "{}.5,4,{},0.001,3000,6000,0", second, std::f64::consts::PI).unwrap();
    }
    folder.write("fixes.csv", fixes);
    folder.write("bearings.csv", bearings);
    let (_, stderr) = folder.succeed("locate --bearings bearings.csv --fixes fixes.csv --out out.csv");
    assert!(stderr.contains("10 bearings, 10 fixes of 1 emitters"), "{stderr}");
    let (off_m, _) = last(&folder, "out.csv");
    assert!(off_m < 5.0, "the bearings' east, the fixes' north: {off_m} m off");
}

#[test]
fn what_cannot_be_meant_is_refused_with_a_remedy() {
    let folder = Folder::new();
    let mut text = differences(5);
    text.push_str("6,4,toa,a,6.1,1e-8,0,0,0,,,,,,,,\n7,4,adoa,a,6.1,1e-8,0,0,0,,,,,,,,\n");
    text.push_str("8,4,tdoa,a,,1e-8,0,0,0,b,100,0,0,1e-3,,,\n");
    folder.write("rows.csv", text);
    folder.write("fixes.csv", "time_s,emitter_id,x,y,z,variance_m2\n1,1,0,0,0,90\n");
    let (_, stderr) = folder.succeed("locate --bearings rows.csv --out out.csv");
    for expected in [
        "rows.csv: line 18, column kind: \"adoa\" is no kind of measurement; there are bearing, toa and tdoa",
        "rows.csv: line 19: an arrival before is the only one of its transmission; give the arrivals",
        "rows.csv: line 19: is farther off than the receivers are apart; check the clocks, the units",
    ] {
        assert!(stderr.contains(expected), "{expected}\n{stderr}");
    }
    for (arguments, expected) in [
        ("locate --out f.csv", "--bearings"),
        (
            "locate --bearings fixes.csv --out f.csv",
            "fixes.csv: has fixes; name it with --fixes",
        ),
        (
            "locate --fixes rows.csv --out f.csv",
            "rows.csv: has no fixes, which need the columns x, y, z",
        ),
        (
            "locate --fixes fixes.csv --out fixes.csv",
            "--out fixes.csv is an input",
        ),
    ] {
        let line = folder.refusal(arguments);
        assert!(line.contains(expected), "{line}");
    }
}
