//! `koseki bearings` as a user starts it: snapshots of antennas in, bearings out, and from these the emitters' places.

use std::f64::consts::{FRAC_PI_2, TAU};
use std::fmt::Write as _;

use locating::music::{AntennaArray, ElementPosition, SimulatedArray, SimulatedWaves};

use crate::common::Folder;

const FREQUENCY_HZ: f64 = 1e9;
const SNAPSHOTS: usize = 60;
/// Two emitters: east and north of the system's origin, metres.
const EMITTERS_M: [[f64; 2]; 2] = [[2_500.0, 2_000.0], [-3_500.0, -2_500.0]];

/// Five antennas on a circle of 12 cm, less than half a wavelength apart, the first one forward.
fn circle() -> (AntennaArray, String) {
    let mut text = "frequency_max_hz = 1.1e9\n".to_owned();
    for antenna in 0..5 {
        let (sin, cos) = (TAU * f64::from(antenna) / 5.0).sin_cos();
        let (right_m, forward_m) = (0.12 * sin, 0.12 * cos);
        writeln!(text, "[[antenna]]\nright_m = {right_m}\nforward_m = {forward_m}").unwrap();
    }
    (AntennaArray::circle(5, 0.12).unwrap(), text)
}

/// What an array hears of some emitters on an aircraft that flies a circle of 6 km: a measurement every 5 s.
fn flight(array: &AntennaArray, emitters_m: &[[f64; 2]], measurements: u64) -> String {
    let names: Vec<String> = (1..=array.len())
        .map(|antenna| format!(",re_{antenna},im_{antenna}"))
        .collect();
    let mut text = format!("time_s,px,py,pz,heading_rad,frequency_hz{}\n", names.concat());
    let mut samples = Vec::new();
    for number in 0..measurements {
        let time_s = 5.0 * number as f64;
        let angle = time_s / 50.0;
        let (east, north) = (6e3 * angle.sin(), 6e3 * angle.cos());
        let heading = (angle + FRAC_PI_2) % TAU;
        let bearings: Vec<f64> = emitters_m
            .iter()
            .map(|[x, y]| f64::atan2(x - east, y - north) - heading)
            .collect();
        let waves = SimulatedWaves::independent(&bearings, 15.0, FREQUENCY_HZ, SNAPSHOTS);
        SimulatedArray::new(array, waves, 7).unwrap().run(number, &mut samples);
        for snapshot in samples.chunks(array.len()) {
            write!(text, "{time_s},{east:.3},{north:.3},3000,{heading:.9},{FREQUENCY_HZ}").unwrap();
            for sample in snapshot {
                write!(text, ",{:.6},{:.6}", sample.re, sample.im).unwrap();
            }
            text.push('\n');
        }
    }
    text
}

/// Size of an angle, radians, at most half a turn.
fn turn(angle_rad: f64) -> f64 {
    (angle_rad - TAU * (angle_rad / TAU).round()).abs()
}

/// Values of some columns of a table, row by row.
fn columns<const N: usize>(text: &str, names: [&str; N]) -> Vec<[f64; N]> {
    let mut lines = text.lines();
    let header: Vec<&str> = lines.next().unwrap().split(',').collect();
    let places = names.map(|name| header.iter().position(|found| *found == name).unwrap());
    let row = |line: &str| {
        let values: Vec<&str> = line.split(',').collect();
        places.map(|place| values[place].parse().unwrap())
    };
    lines.map(row).collect()
}

#[test]
fn emitters_are_located_from_snapshots_of_an_array() {
    let (array, described) = circle();
    let folder = Folder::with(&[
        ("array.toml", described),
        ("flight.csv", flight(&array, &EMITTERS_M, 120)),
    ]);
    let summary = folder.json("bearings --snapshots flight.csv --array array.toml --out bearings.csv --json");
    assert_eq!(
        (summary["measurements"].as_u64(), summary["snapshots"].as_u64()),
        (Some(120), Some(7_200))
    );
    assert_eq!(
        (summary["ambiguous"].as_u64(), summary["rows_refused"].as_u64()),
        (Some(0), Some(0))
    );
    let rows = columns(&folder.read("bearings.csv"), ["bearing_rad", "sigma_rad", "px", "py"]);
    assert_eq!(summary["rows"].as_u64(), Some(rows.len() as u64));
    assert!(
        (200..=240).contains(&rows.len()),
        "two for nearly every measurement: {}",
        rows.len()
    );
    let mut apart = 0;
    for [bearing_rad, sigma_rad, px, py] in &rows {
        let [first, second] = EMITTERS_M.map(|[x, y]| f64::atan2(x - px, y - py));
        // Nearer to each other than half a beam, two may be one.
        if turn(first - second) > 0.6 {
            let off = turn(bearing_rad - first).min(turn(bearing_rad - second));
            assert!(off < 6.0 * sigma_rad, "{bearing_rad} is {off} off, sigma {sigma_rad}");
            apart += 1;
        }
    }
    assert!(apart >= 100, "{apart}");

    folder.succeed("locate --bearings bearings.csv --filter fixed --out fixes.csv");
    let fixes = columns(&folder.read("fixes.csv"), ["time_s", "x", "y"]);
    for [x, y] in EMITTERS_M {
        let off = fixes
            .iter()
            .filter(|[time_s, ..]| *time_s > 500.0)
            .map(|fix| (fix[1] - x).hypot(fix[2] - y));
        let nearest = off.fold(f64::INFINITY, f64::min);
        assert!(nearest < 60.0, "{x}, {y}: the nearest fix is {nearest} m off");
    }
}

#[test]
fn a_line_of_antennas_needs_to_be_told_its_side() {
    // Along the fuselage, from front to rear; described by what looks to the right of the aircraft.
    let antennas = (0..4).map(|antenna| 0.14 * f64::from(antenna));
    let mut described = "frequency_max_hz = 1.1e9\nforward_deg = 90\ntransmitters = 1\n".to_owned();
    for along_m in antennas.clone() {
        writeln!(described, "[[antenna]]\nright_m = {along_m}\nforward_m = 0").unwrap();
    }
    let positions = antennas.map(|along_m| ElementPosition {
        right_m: 0.0,
        forward_m: -along_m,
    });
    let array = AntennaArray::new(&positions.collect::<Vec<_>>()).unwrap();
    // The middle of the circle is to the right of the aircraft all the time.
    let folder = Folder::with(&[
        ("line.toml", described.clone()),
        ("side.toml", format!("sector_deg = [-90, 90]\n{described}")),
        ("flight.csv", flight(&array, &[[0.0, 0.0]], 40)),
    ]);
    let both = folder.json("bearings --snapshots flight.csv --array line.toml --out both.csv --json");
    assert_eq!((both["rows"].as_u64(), both["ambiguous"].as_u64()), (Some(0), Some(80)));
    let right = folder.json("bearings --snapshots flight.csv --array side.toml --out right.csv --json");
    assert_eq!(
        (right["rows"].as_u64(), right["outside_sector"].as_u64()),
        (Some(40), Some(40))
    );
    for [bearing_rad, px, py] in columns(&folder.read("right.csv"), ["bearing_rad", "px", "py"]) {
        let off = bearing_rad - f64::atan2(-px, -py);
        assert!(
            (off - TAU * (off / TAU).round()).abs() < 0.1,
            "{bearing_rad} at {px}, {py}"
        );
    }
}

#[test]
fn what_cannot_be_used_is_named_with_file_line_value_and_remedy() {
    let (array, described) = circle();
    let heard = flight(&array, &EMITTERS_M[..1], 2);
    let folder = Folder::with(&[("array.toml", &described), ("flight.csv", &heard)]);
    let refused = |array: &str, snapshots: &str| {
        folder.write("wrong.toml", array);
        folder.write("wrong.csv", snapshots);
        folder.refusal("bearings --snapshots wrong.csv --array wrong.toml --out out.csv")
    };
    for (array, expected) in [
        (
            described.replace("frequency_max_hz", "frequency_hz"),
            "wrong.toml: line 1: frequency_hz",
        ),
        (
            described.replace("1.1e9", "-1"),
            "wrong.toml: line 1: frequency_max_hz: -1",
        ),
        (
            described.replace("[[antenna]]\nright_m = 0\n", "[[antenna]]\n"),
            "antenna[0].right_m",
        ),
        ("frequency_max_hz = 1e9\n".to_owned(), "antenna"),
        (
            "frequency_max_hz = 1e9\n[[antenna]]\nright_m = 0\nforward_m = 0\n".to_owned(),
            "wrong.toml: an array of 1 antennas measures no bearing: two at least are needed",
        ),
        (described.replace("1.1e9", "1e15"), "are its positions in metres?"),
    ] {
        let said = refused(&array, &heard);
        assert!(said.contains(expected), "{said}");
    }
    let said = refused(&described, &heard.replace(",re_5", ",re_6"));
    assert!(said.contains("wrong.csv: header: column re_5 is missing"), "{said}");
    let said = refused(&described, heard.lines().next().unwrap());
    assert!(
        said.contains("wrong.csv: nothing was measured: the file has a header only"),
        "{said}"
    );
    let said = folder.refusal("bearings --snapshots flight.csv --array array.toml --out flight.csv");
    assert!(said.contains("--out flight.csv is an input"), "{said}");

    // Single rows and measurements that cannot be used are left out.
    let lines: Vec<&str> = heard.lines().collect();
    let (first, second) = (lines[1], lines[1 + SNAPSHOTS]);
    let (_, rest) = first.split_once(',').unwrap();
    let odd = format!("{}\n{first}\nnow,{rest}\n10,{rest}\n", lines.join("\n"));
    assert!(second.starts_with("5,"));
    folder.write("odd.csv", odd);
    let summary = folder.json("bearings --snapshots odd.csv --array array.toml --out odd-bearings.csv --json");
    assert_eq!(summary["measurements"].as_u64(), Some(2));
    assert_eq!(
        summary["refused"],
        serde_json::json!({"order of time": 1, "column time_s": 1, "a measurement that cannot be made": 1})
    );
}
