//! `koseki track` with a wide-area sensor beside it: who targets are, groups, pictures, cues, explanations, and bad
//! input (WA).

use std::fmt::Write as _;

use test_support::{column, numbers};

use crate::common::Folder;

const DETECTIONS: &str = "time_s,sensor_id,scan,detection_id,kind,m0,m1,m2,m3,s0,s1,s2,s3,px,py,pz,truth_id";
const COUNTS: &str = "time_s,arrival_s,x,y,z,vx,vy,vz,count,route";
const BEARINGS: &str = "time_s,emitter_id,bearing_rad,sigma_rad,px,py,pz,heading_rad,frequency_hz,pulse_interval_s";
/// What is known of the sensor and of the two kinds of boats.
const CONFIG: &str = "[[sensor]]\nid = 1\nclutter_density = 1e-6\n[initiation]\nspeed_sigma_mps = 20.0\n\
    [motion]\nprocess_noise_m2ps3 = [1.0, 1.0]\nmanoeuvres = { enabled = false }\n[confirmation]\ndetections_min = 3\n\
    [[wide_area.type]]\nname = \"patrol 7\"\nemissions = [{ frequency_hz = [9.3e9, 9.5e9], pulse_interval_s = [5e-4, 2e-3] }]\n\
    [[wide_area.type]]\nname = \"ferry\"\nemissions = [{ frequency_hz = [2.9e9, 3.1e9] }]\n\
    [[wide_area.prior]]\ncircle = { centre_m = [-50e3, 0], radius_m = 9e3 }\ntypes = { \"patrol 7\" = 0.6 }\n";
/// Metres per second, to the east.
const SPEED: f64 = 15.0;

/// A scan a second in which two boats side by side are seen as one, save every fifth one that shows both.
fn boats(seconds: i32) -> String {
    let mut text = format!("{DETECTIONS}\n");
    for second in 0..seconds {
        let east = SPEED * f64::from(second);
        let off = 4.0 * f64::from((second * 7) % 5 - 2);
        let seen = match second % 5 {
            3 => vec![[east + 3.0, 40.0], [east - 4.0, -40.0]],
            _ => vec![[east + off, -off]],
        };
        for (number, [x, y]) in seen.into_iter().enumerate() {
            writeln!(text, "{second},1,{second},{number},position2,{x},{y},,,10,10,,,0,0,0,").unwrap();
        }
    }
    text
}

/// So many targets, counted every five seconds and known three seconds later.
fn counts(seconds: i32, targets: u32, route: &str) -> String {
    let mut text = format!("{COUNTS}\n");
    for second in (5..seconds).step_by(5) {
        let (east, arrival) = (SPEED * f64::from(second) + 300.0, second + 3);
        writeln!(text, "{second},{arrival},{east},-200,0,{SPEED},0,0,{targets},{route}").unwrap();
    }
    text
}

/// Emissions heard from the place (-3000, -4000), in the direction of the boats.
fn heard(times_s: &[f64], frequency_hz: &str) -> String {
    let mut text = format!("{BEARINGS}\n");
    for time_s in times_s {
        let bearing = (SPEED * time_s + 3000.0).atan2(4000.0);
        writeln!(text, "{time_s},,{bearing},0.02,-3000,-4000,0,,{frequency_hz},1e-3").unwrap();
    }
    text
}

#[test]
fn who_targets_are_goes_from_emissions_and_counts_through_files_to_fused_tracks() {
    let folder = Folder::new();
    folder.write("plots.csv", boats(40));
    folder.write("counts.csv", counts(40, 3, "-52000|0|-9000|0"));
    folder.write("heard.csv", heard(&[12.5, 14.25, 90.0], "9.41e9"));
    folder.write(
        "track.toml",
        format!("{CONFIG}[wide_area]\ngroups = {{ probability_min = 0.5 }}\n"),
    );
    let said = folder.json(
        "track --detections plots.csv --config track.toml --wide-area counts.csv --emissions heard.csv --out tracks.csv --json",
    );
    let emissions = &said["emissions"];
    assert_eq!(
        (
            &emissions["taken"],
            &emissions["after_last_scan"],
            &emissions["rows_refused"]
        ),
        (&2.into(), &1.into(), &0.into()),
        "{said}"
    );
    let tracks = folder.read("tracks.csv");
    let [kinds, members, types] = ["kind", "members", "type"].map(|name| column(&tracks, name));
    let last = kinds.len() - 1;
    assert_eq!(
        (kinds[last].as_str(), members[last].as_str(), types[last].as_str()),
        ("group", "3", "patrol 7")
    );
    let confidence = column(&tracks, "type_confidence")[last].parse::<f64>().unwrap();
    assert!(confidence > 0.8 && confidence < 1.0, "{confidence}");
    assert_eq!(types[0], "", "before anything was heard");
    // Fusion carries them on, and comparing and scoring are not disturbed by them.
    folder.succeed("fuse --tracks tracks.csv --out fused.csv");
    let fused = folder.read("fused.csv");
    let last = column(&fused, "kind").len() - 1;
    assert_eq!(column(&fused, "kind")[last], "group");
    assert_eq!(column(&fused, "members")[last], "3");
    assert_eq!(column(&fused, "type")[last], "patrol 7");
    assert_eq!(
        column(&fused, "type_confidence")[last].parse::<f64>().unwrap(),
        confidence
    );
    folder.write("truth.csv", truth(40));
    folder.succeed("score --truth truth.csv --tracks tracks.csv");
    folder.succeed("score --truth truth.csv --tracks fused.csv");
    // Without the counts there is neither a group nor an origin, and not a track moves because of what was heard.
    let plain = folder.json("track --detections plots.csv --config track.toml --out plain.csv --json");
    assert!(plain["emissions"].is_null() && plain["wide_area"].is_null(), "{plain}");
    folder.succeed("track --detections plots.csv --config track.toml --emissions heard.csv --out heard_tracks.csv");
    let [plain, heard] = ["plain.csv", "heard_tracks.csv"].map(|name| folder.read(name));
    for name in [
        "time_s",
        "sensor_track_id",
        "x",
        "y",
        "P00",
        "state",
        "hypotheses",
        "reliability",
    ] {
        assert_eq!(column(&plain, name), column(&heard, name), "{name}");
    }
    assert!(column(&plain, "kind").iter().all(String::is_empty));
    assert!(column(&plain, "type").iter().all(String::is_empty));
}

fn truth(seconds: i32) -> String {
    let mut text = "time_s,target_id,x,y,z,vx,vy,vz\n".to_owned();
    for second in 0..seconds {
        let east = SPEED * f64::from(second);
        writeln!(
            text,
            "{second},1,{east},40,0,{SPEED},0,0\n{second},2,{east},-40,0,{SPEED},0,0"
        )
        .unwrap();
    }
    text
}

#[test]
fn pictures_come_at_even_times_whatever_the_sensors_do() {
    let folder = Folder::new();
    // Scans at uneven times, with a pause of eight seconds in between.
    let mut rows = format!("{DETECTIONS}\n");
    let mut time_s = 0.3;
    for scan in 0..60 {
        time_s += if scan == 30 {
            8.0
        } else {
            0.7 + 0.25 * f64::from(scan % 3)
        };
        let (x, shown) = (SPEED * time_s, format!("{time_s:.3}"));
        writeln!(rows, "{shown},1,{scan},0,position2,{x},0,,,10,10,,,0,0,0,").unwrap();
    }
    folder.write("plots.csv", &rows);
    folder.write("track.toml", CONFIG);
    folder.succeed("track --detections plots.csv --config track.toml --out scans.csv");
    let said = folder.json("track --detections plots.csv --config track.toml --period 2 --out tracks.csv --json");
    let tracks = folder.read("tracks.csv");
    let times = numbers(&tracks, "time_s");
    assert_eq!(said["rows"], times.len());
    let first = times[0];
    let expected: Vec<f64> = (0..times.len()).map(|nth| first + 2.0 * nth as f64).collect();
    assert_eq!(
        times, expected,
        "one row of the one track at each even time, the pause included"
    );
    let last = numbers(&folder.read("scans.csv"), "time_s").pop().unwrap();
    assert!(
        first % 2.0 == 0.0 && first < 8.0 && last - times[times.len() - 1] < 2.0,
        "{first} {last}"
    );
    // Where the target is then, and not where it was seen last.
    for (time_s, x) in times.iter().zip(numbers(&tracks, "x")).skip(3) {
        assert!((x - SPEED * time_s).abs() < 15.0, "{time_s} {x}");
    }
    for period in ["0", "-1", "never", "4000"] {
        let output = folder.run(&format!(
            "track --detections plots.csv --period {period} --out refused.csv"
        ));
        assert_eq!(output.status.code(), Some(2), "{output:?}");
    }
    assert!(!folder.path("refused.csv").exists());
}

#[test]
fn cues_say_where_each_sensor_should_look_next() {
    let folder = Folder::new();
    // Sensor 1 looks every second, sensor 2 every four; only the first one sees the boat again and again.
    let mut rows = format!("{DETECTIONS}\n");
    for second in 0..30 {
        let x = SPEED * f64::from(second);
        writeln!(rows, "{second},1,{second},0,position2,{x},0,,,10,10,,,0,0,0,").unwrap();
        if second % 4 == 0 {
            let (scan, time_s) = (second / 4, f64::from(second) + 0.5);
            writeln!(rows, "{time_s},2,{scan},0,position2,90000,90000,,,30,30,,,0,0,0,").unwrap();
        }
    }
    folder.write("plots.csv", &rows);
    let second_sensor =
        "[[sensor]]\nid = 2\nclutter_density = 1e-9\nfield_of_view = { range_m = [0, 10], position_m = [9e4, 9e4] }\n";
    folder.write("track.toml", format!("{second_sensor}{CONFIG}"));
    let said = folder.json("track --detections plots.csv --config track.toml --cues cues.csv --out tracks.csv --json");
    let cues = folder.read("cues.csv");
    let [made, times, x, longer, shorter, angle] =
        ["made_s", "time_s", "x", "longer_m", "shorter_m", "orientation_rad"].map(|name| numbers(&cues, name));
    let sensors = column(&cues, "sensor_id");
    assert_eq!(said["cues"], made.len());
    let boat: Vec<usize> = (0..made.len())
        .filter(|row| x[*row] < 50e3 && made[*row] > 10.0)
        .collect();
    assert!(boat.iter().any(|row| sensors[*row] == "1") && boat.iter().any(|row| sensors[*row] == "2"));
    for row in boat {
        // The next look is a period after the last one, and the boat is in the ellipse then.
        let ahead = times[row] - made[row];
        assert!(
            ahead > 0.0 && ahead <= if sensors[row] == "1" { 1.0 } else { 4.0 },
            "{ahead}"
        );
        assert!((x[row] - SPEED * times[row]).abs() < longer[row], "row {row}");
        assert!(shorter[row] <= longer[row] && (0.0..std::f64::consts::PI).contains(&angle[row]));
        // What sensor 2 measures is coarser, so it must look farther around.
        let least = if sensors[row] == "1" { 30.0 } else { 90.0 };
        assert!(shorter[row] > least, "{} {}", sensors[row], shorter[row]);
    }
    let output = folder.run("track --detections plots.csv --cues same.csv --out same.csv");
    let line = String::from_utf8(output.stderr).unwrap();
    assert!(
        output.status.code() == Some(2) && line.contains("--out and --cues name one file"),
        "{line}"
    );
}

#[test]
fn what_a_count_did_is_explained() {
    let folder = Folder::new();
    // Both boats leave at 30 s, which the wide-area sensor reports.
    let elsewhere = |second: i32| format!("{second},1,{second},0,position2,9e4,9e4,,,10,10,,,0,0,0,\n");
    let silent: String = (30..45).map(elsewhere).collect();
    folder.write("plots.csv", format!("{}{silent}", boats(30)));
    folder.write("counts.csv", format!("{}30,32,450,0,0,0,0,0,0,\n", counts(28, 2, "")));
    // Without the rule for targets that part, which would confirm the second boat in the same scan.
    let chosen = "[splitting]\nreliability_min = \"off\"\n\
                  [wide_area]\ngroups = { probability_min = 0.3 }\ndeletion = { existence_min = 0.95, silent_s = 30 }\n\
                  correction = { share = 0.75 }\nvalid_s = 6\n";
    folder.write("track.toml", format!("{CONFIG}{chosen}"));
    let call = "track --detections plots.csv --config track.toml --wide-area counts.csv";
    let said = folder.json(&format!("{call} --explain why.csv --out tracks.csv --json"));
    folder.succeed(&format!("{call} --out unexplained.csv"));
    assert!(
        folder.read("tracks.csv") == folder.read("unexplained.csv"),
        "an observer changes nothing"
    );
    let why = folder.read("why.csv");
    let [events, probabilities, values, limits, times] =
        ["event", "probability", "value", "limit", "time_s"].map(|name| column(&why, name));
    let rows = |event: &str| {
        (0..events.len())
            .filter(|row| events[*row] == event)
            .collect::<Vec<_>>()
    };
    let number = |values: &[String], row: usize| values[row].parse::<f64>().unwrap();
    // The share of the hypotheses with two tracks was raised to what is configured, or to what held until the next
    // report.
    let corrected = rows("corrected");
    assert!(!corrected.is_empty() && !rows("corrected_children").is_empty(), "{why}");
    for row in corrected.iter().chain(&rows("corrected_children")) {
        assert!(number(&probabilities, *row) > number(&values, *row), "{why}");
        assert_eq!(number(&limits, *row), 2.0);
    }
    let due = corrected
        .iter()
        .filter(|row| (number(&probabilities, **row) - 0.75).abs() < 1e-6);
    assert!(due.count() > 0, "{why}");
    let early = rows("confirmed_early");
    assert_eq!(said["wide_area"]["confirmations"], early.len());
    assert!(!early.is_empty(), "{said}");
    for row in early {
        assert!(
            number(&values, row) >= number(&limits, row) && number(&limits, row) < 0.99,
            "{why}"
        );
    }
    let groups = rows("group");
    let in_tracks = column(&folder.read("tracks.csv"), "kind");
    assert_eq!(groups.len(), in_tracks.iter().filter(|kind| *kind == "group").count());
    assert!(!groups.is_empty(), "{why}");
    for row in groups {
        assert_eq!((number(&values, row), number(&limits, row)), (2.0, 0.3));
        assert!(number(&probabilities, row) >= 0.3);
    }
    let absent: Vec<usize> = rows("absent_missed_too_often");
    assert!(
        !absent.is_empty() && absent.iter().all(|row| number(&times, *row) >= 32.0),
        "{why}"
    );
    assert!(
        said["wide_area"]["deletions"].as_u64() >= Some(absent.len() as u64),
        "{said}"
    );
}

#[test]
fn bad_reports_and_emissions_are_counted_and_explained_and_change_no_track() {
    let folder = Folder::new();
    folder.write("plots.csv", boats(40));
    folder.write("track.toml", CONFIG);
    folder.succeed("track --detections plots.csv --config track.toml --out plain.csv");
    // More targets than can be, no number, no place on Earth, no number of a place or speed, arrival
    // before the observation, later than allowed, and no count at all.
    let bad = [
        "10,12,150,0,0,15,0,0,10000,",
        "10,12,150,0,0,15,0,0,two,",
        "10,12,9e12,0,0,15,0,0,2,",
        "10,12,150,-9e7,0,15,0,0,2,",
        "10,12,nan,0,0,15,0,0,2,",
        "10,12,150,0,0,inf,0,0,2,",
        "12,10,150,0,0,15,0,0,2,",
        "10,300,150,0,0,15,0,0,2,",
        "-200,10,150,0,0,15,0,0,2,",
        "10,12,150,0,0,15,0,0,,",
        "10,12,150,0,0,15,0,0,2,1e12|0",
        "10,12,150,0",
        // Nothing is wrong with none, and there is nothing that it could correct.
        "10,12,150,0,0,15,0,0,0,",
    ];
    folder.write("counts.csv", format!("{COUNTS}\n{}\n", bad.join("\n")));
    let heard = [
        "12,,0.9,0,-3000,-4000,0,,9.4e9,1e-3",
        "12,,0.9,0.02,-3000,-4000,0,,-9.4e9,1e-3",
        "12,,0.9,0.02,-3000,-4000,0,,9.4e9,nan",
        "12,,0.9,0.02,-3000,-4000,0,,,1e-3",
        "12,,99,0.02,-3000,-4000,0,,9.4e9,1e-3",
        "12,,0.9,0.02,9e12,-4000,0,,9.4e9,1e-3",
    ];
    folder.write("heard.csv", format!("{BEARINGS}\n{}\n", heard.join("\n")));
    let said = folder.json(
        "track --detections plots.csv --config track.toml --wide-area counts.csv --emissions heard.csv --out tracks.csv --json",
    );
    assert!(folder.read("tracks.csv") == folder.read("plain.csv"), "{said}");
    let wide_area = &said["wide_area"];
    assert_eq!(wide_area["rows_refused"], 5, "{said}");
    let refused = wide_area["refused"].as_object().unwrap();
    let sum: u64 = refused.values().filter_map(serde_json::Value::as_u64).sum();
    // What arrives after the last scan is not even given.
    assert_eq!(
        (sum, &wide_area["after_last_scan"], &wide_area["reports"]),
        (6, &1.into(), &1.into()),
        "{said}"
    );
    for expected in [
        "10000 targets",
        "must be numbers",
        "before it was observed",
        "s after the observation",
    ] {
        assert!(
            refused.keys().any(|reason| reason.contains(expected)),
            "{expected}: {said}"
        );
    }
    let emissions = &said["emissions"];
    assert_eq!(
        (&emissions["rows_refused"], &emissions["taken"]),
        (&5.into(), &0.into()),
        "{said}"
    );
    assert!(
        emissions["refused"]
            .as_object()
            .unwrap()
            .keys()
            .any(|reason| reason.contains("must be numbers")),
        "{said}"
    );
    let (_, text) = folder.succeed(
        "track --detections plots.csv --config track.toml --wide-area counts.csv --emissions heard.csv --out tracks.csv",
    );
    for expected in [
        "counts.csv: line 3, column count: \"two\" is no whole number",
        "refused: 1 wide-area reports: 10000 targets in one report; at most 256 can be used",
        "wide area: 1 reports came after the last scan",
        "heard.csv: line 5: no frequency to identify a type",
        "refused: 1 emissions: bearing and place must be numbers",
    ] {
        assert!(text.contains(expected), "{expected}\n{text}");
    }
}

#[test]
fn what_makes_no_sense_is_refused_before_anything_is_written() {
    let folder = Folder::new();
    folder.write("plots.csv", boats(10));
    folder.write("heard.csv", heard(&[5.0], "9.4e9"));
    folder.write(
        "track.toml",
        "[[wide_area.prior]]\ncircle = { centre_m = [0, 0], radius_m = 10 }\nformations = { 10000 = 0.5 }\n",
    );
    for (arguments, expected) in [
        (
            "--emissions heard.csv",
            "heard.csv: emissions identify types of targets, but no type is configured",
        ),
        (
            "--emissions plots.csv",
            "plots.csv: header: column emitter_id is missing",
        ),
        (
            "--config track.toml",
            "track.toml:3: wide_area.prior[0].formations.10000: \"10000\" is no number of members; it must lie between 1 and 256",
        ),
        ("--emissions heard.csv --cues heard.csv", "--cues heard.csv is an input"),
    ] {
        let output = folder.run(&format!("track --detections plots.csv {arguments} --out tracks.csv"));
        let line = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.code() == Some(2) && line.contains(expected), "{line}");
        assert_eq!(folder.names().len(), 3, "{:?}", folder.names());
    }
}
