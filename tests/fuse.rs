//! `koseki fuse` and `koseki compare` as a user calls them: files in, files out, and what is refused.

use std::collections::BTreeSet;

use test_support::{MIDNIGHT_S, column, since_1970};

use crate::common::Folder;

const HEADER: &str = "time_s,sensor_id,sensor_track_id,x,y,z,vx,vy,vz,P00,P01,P02,P03,P04,P05,P11,P12,P13,P14,P15,\
                      P22,P23,P24,P25,P33,P34,P35,P44,P45,P55,state";
const VARIANCES: &str = "100,0,0,0,0,0,100,0,0,0,0,100,0,0,0,4,0,0,4,0,4";

/// Reports of one sensor: targets fly east at 100 m/s, 20 km apart; the last report is at or before 30 s.
fn sensor(id: u32, period_s: f64, phase_s: f64) -> String {
    let mut text = format!("{HEADER}\n");
    let mut time_s = phase_s;
    while time_s <= 30.0 {
        for target in 0..3 {
            let (x, y) = (100.0 * time_s, 20e3 * f64::from(target));
            text += &format!("{time_s},{id},{target},{x},{y},3000,100,0,0,{VARIANCES},confirmed\n");
        }
        time_s += period_s;
    }
    text
}

fn truth() -> String {
    let mut text = "time_s,target_id,x,y,z,vx,vy,vz\n".to_owned();
    for second in 0..=30 {
        for target in 0..3 {
            text += &format!("{second},{target},{},{},3000,100,0,0\n", 100 * second, 20_000 * target);
        }
    }
    text
}

/// Two sensors, 7 and 9, in a file each, and the truth.
fn two_sensors() -> Folder {
    let folder = Folder::new();
    folder.write("a.csv", sensor(7, 2.0, 0.25));
    folder.write("b.csv", sensor(9, 4.0, 1.5));
    folder.write("truth.csv", truth());
    folder
}

#[test]
fn fusing_gives_a_row_per_live_track_at_whole_multiples_to_the_end_of_the_data() {
    let folder = two_sensors();
    let found = folder.json("fuse --tracks a.csv b.csv --refresh 1 --out fused.csv --json");
    assert_eq!(found["rows_refused"], 0);
    let fused = folder.read("fused.csv");
    let header = fused.lines().next().unwrap();
    assert!(
        header.starts_with(
            "time_s,system_track_id,x,y,z,vx,vy,vz,state,sources,weights,selected,lambda,address,mode_3a,callsign,P00,"
        ),
        "{header}"
    );
    let times = column(&fused, "time_s");
    assert!(times.iter().all(|time| time.parse::<u32>().is_ok()), "{times:?}");
    // The last report is of 29.5 s.
    assert_eq!(times.last().unwrap(), "30");
    let states: BTreeSet<_> = column(&fused, "state").into_iter().collect();
    assert!(
        states
            .iter()
            .all(|state| ["confirmed", "coasted"].contains(&state.as_str()))
    );
    // No track twice at one time, and all three targets at the end.
    let ids = column(&fused, "system_track_id");
    let pairs: BTreeSet<_> = times.iter().zip(&ids).collect();
    assert_eq!(pairs.len(), times.len());
    assert_eq!(times.iter().filter(|time| *time == "30").count(), 3);
    // Sources have the ids of the files.
    assert_eq!(column(&fused, "sources").last().unwrap(), "7|9");
    let score = folder.json("score --truth truth.csv --tracks fused.csv --json");
    assert_eq!((&score["system_tracks"], &score["id_switches"]), (&3.into(), &0.into()));
    assert!(score["rmse_pos"].as_f64().unwrap() < 1.0, "{score}");
    assert!(score["nees_pos"].as_f64().unwrap() < 0.1, "the errors are 0: {score}");
}

#[test]
fn without_a_refresh_time_there_is_a_row_per_update() {
    let folder = two_sensors();
    let found = folder.json("fuse --tracks b.csv a.csv --out fused.csv --json");
    let fused = folder.read("fused.csv");
    assert_eq!(found["rows"], fused.lines().count() - 1);
    assert_eq!(found["reports"].as_u64(), Some(45 + 24));
    let times: BTreeSet<_> = column(&fused, "time_s").into_iter().collect();
    assert!(times.contains("0.25") && times.contains("29.5"), "{times:?}");
}

#[test]
fn the_same_files_give_the_same_bytes() {
    let folder = two_sensors();
    let mut both = sensor(7, 2.0, 0.25);
    both.push_str(sensor(9, 4.0, 1.5).split_once('\n').unwrap().1);
    let (header, rows) = both.split_once('\n').unwrap();
    let mut rows: Vec<&str> = rows.lines().collect();
    rows.sort_by(|one, other| {
        let time = |row: &str| row.split(',').next().unwrap().parse::<f64>().unwrap();
        time(one).total_cmp(&time(other))
    });
    folder.write("both.csv", format!("{header}\n{}\n", rows.join("\n")));
    folder.succeed("fuse --tracks a.csv b.csv --refresh 0.5 --out one.csv --explain why.csv");
    folder.succeed("fuse --tracks b.csv a.csv --refresh 0.5 --out two.csv --explain why_two.csv");
    folder.succeed("fuse --tracks both.csv --refresh 0.5 --out three.csv");
    assert_eq!(folder.read("one.csv"), folder.read("two.csv"));
    assert_eq!(folder.read("one.csv"), folder.read("three.csv"));
    assert_eq!(folder.read("why.csv"), folder.read("why_two.csv"));
    let decisions = column(&folder.read("why.csv"), "decision");
    assert_eq!(decisions.iter().filter(|word| *word == "started").count(), 3);
    assert_eq!(decisions.iter().filter(|word| *word == "joined").count(), 3);
}

#[test]
fn a_file_out_of_order_is_refused() {
    let folder = two_sensors();
    let good = folder.read("a.csv");
    let (header, rows) = good.split_once('\n').unwrap();
    // By target, as a data base gives them.
    let mut rows: Vec<&str> = rows.lines().collect();
    rows.sort_by_key(|row| row.split(',').nth(2).unwrap().to_owned());
    folder.write("unsorted.csv", format!("{header}\n{}\n", rows.join("\n")));
    for command in ["fuse --out x.csv", "smooth --out x.csv", "compare"] {
        let line = folder.refusal(&format!("{command} --tracks unsorted.csv"));
        for part in [
            " of 45 rows are out of order by time",
            "line 17, column time_s: 0.25 is before",
            "sort the rows",
        ] {
            assert!(line.contains(part), "{command}: {line}");
        }
    }
    assert!(!folder.path("x.csv").exists());
}

#[test]
fn times_of_the_day_that_begin_again_at_midnight_are_refused() {
    let row = |time_s: f64, more: &str| format!("{time_s},7,1,0,0,0,0,0,0,{VARIANCES},confirmed{more}\n");
    let times = (0..40).map(|place| (86_390.05 + 0.5 * f64::from(place)) % 86_400.0);
    let rows: String = times.clone().map(|time_s| row(time_s, "")).collect();
    let arrived: String = times
        .clone()
        .map(|time_s| row(time_s, &format!(",{}", time_s + 1.0)))
        .collect();
    let plots: String = times
        .zip(1..)
        .map(|(time_s, scan)| format!("{time_s},1,{scan},1,range_bearing,1000,0.5,,,15,0.006,,,0,0,0\n"))
        .collect();
    let folder = Folder::with(&[
        ("midnight.csv", format!("{HEADER}\n{rows}")),
        ("arrived.csv", format!("{HEADER},arrival_s\n{arrived}")),
        (
            "plots.csv",
            format!("time_s,sensor_id,scan,detection_id,kind,m0,m1,m2,m3,s0,s1,s2,s3,px,py,pz\n{plots}"),
        ),
    ]);
    for command in [
        "fuse --tracks midnight.csv",
        "fuse --tracks arrived.csv",
        "track --detections plots.csv",
    ] {
        let line = folder.refusal(&format!("{command} --out x.csv"));
        assert!(
            line.contains("line 22") && line.contains("add 86400 to the times of the next day"),
            "{line}"
        );
    }
    // Few rows behind midnight are left out, and counted with the remedy.
    let mut short: String = (0..2_000).map(|place| row(80_000.0 + f64::from(place), "")).collect();
    (0..5).for_each(|place| short += &row(f64::from(place), ""));
    folder.write("short.csv", format!("{HEADER}\n{short}"));
    let (_, said) = folder.succeed("fuse --tracks short.csv --out x.csv");
    assert!(
        said.contains("5 for order of time") && said.contains("add 86400"),
        "{said}"
    );
}

#[test]
fn a_table_of_which_the_engine_uses_nothing_is_a_failure() {
    let folder = two_sensors();
    let limits = "[[sensor]]\nid = 7\nposition_m = [50e3, 50e3]\nlimits = { range_m = 1000.0 }\n";
    let speeds = "[[sensor]]\nid = 7\nlimits = { speed_mps = 10.0 }\n";
    let table = folder.read("a.csv");
    let scaled = |factor: f64| -> String {
        let rows = table.lines().map(|line| {
            let mut values: Vec<String> = line.split(',').map(str::to_owned).collect();
            if let Ok(y) = values[4].parse::<f64>() {
                values[4] = (factor * (y + 1e3)).to_string();
            }
            values.join(",") + "\n"
        });
        rows.collect()
    };
    folder.write("near.toml", limits);
    folder.write("slow.toml", speeds);
    folder.write("centimetres.csv", scaled(5e3));
    folder.write("millimetres.csv", scaled(1e6));
    for (arguments, expected) in [
        ("a.csv --config near.toml", "line 2, columns x and y: 25, 0 is"),
        (
            "a.csv --config slow.toml",
            "line 2, columns vx and vy: 100, 0 is 100 m/s, beyond limits.speed_mps = 10",
        ),
        (
            "centimetres.csv",
            "line 2, columns x and y: 25, 5000000 is 5000 km from the origin of the frame, beyond 2000 km; check the unit",
        ),
        ("millimetres.csv", "line 2, column y: 1000000000 is beyond 1e8 m"),
    ] {
        let output = folder.run(&format!("fuse --tracks {arguments} --out x.csv"));
        let said = String::from_utf8_lossy(&output.stderr);
        let last = said.lines().last().unwrap_or_default();
        assert_eq!(output.status.code(), Some(1), "{arguments}: {said}");
        assert!(
            last.contains("no report was used") && last.contains(expected),
            "{arguments}: {said}"
        );
    }
}

#[test]
fn times_since_1970_give_the_same_picture() {
    let folder = two_sensors();
    folder.succeed("fuse --tracks a.csv b.csv --refresh 1 --out midnight.csv");
    for name in ["a", "b"] {
        let text = folder.read(&format!("{name}.csv"));
        folder.write(&format!("{name}70.csv"), since_1970(&text, &["time_s"]));
    }
    folder.succeed("fuse --tracks a70.csv b70.csv --refresh 1 --out since.csv");
    let times = |name: &str, less_s: i64| -> Vec<i64> {
        let times = column(&folder.read(name), "time_s").into_iter();
        times.map(|time_s| time_s.parse::<i64>().unwrap() - less_s).collect()
    };
    assert_eq!(times("since.csv", MIDNIGHT_S), times("midnight.csv", 0));
    for name in ["x", "y", "vx", "P00", "system_track_id", "state"] {
        let of = |file: &str| column(&folder.read(file), name);
        assert_eq!(of("since.csv"), of("midnight.csv"), "{name}");
    }
    let line = folder.refusal("fuse --tracks a70.csv b.csv --out x.csv");
    assert!(
        line.contains("b.csv: times count from a midnight, but those of a70.csv from 1970"),
        "{line}"
    );
    let both = folder.read("a.csv") + folder.read("a70.csv").split_once('\n').unwrap().1;
    folder.write("both.csv", both);
    let (_, said) = folder.succeed("fuse --tracks both.csv --out x.csv");
    assert!(
        said.contains("does not count from where the first row counts"),
        "{said}"
    );
}

#[test]
fn quotes_and_a_byte_order_mark_change_nothing() {
    let folder = two_sensors();
    folder.succeed("fuse --tracks a.csv --out plain.csv");
    let quoted: String = folder
        .read("a.csv")
        .lines()
        .map(|line| format!("\"{}\"\r\n", line.replace(',', "\",\"")))
        .collect();
    folder.write("quoted.csv", format!("\u{feff}{quoted}"));
    folder.succeed("fuse --tracks quoted.csv --out unquoted.csv");
    assert_eq!(folder.read("plain.csv"), folder.read("unquoted.csv"));
}

#[test]
fn a_hyphen_is_standard_output() {
    let folder = two_sensors();
    folder.succeed("fuse --tracks a.csv b.csv --refresh 1 --out file.csv");
    let (printed, said) = folder.succeed("fuse --tracks a.csv b.csv --refresh 1 --out -");
    assert_eq!(printed, folder.read("file.csv"));
    let rows = printed.lines().count() - 1;
    let expected = format!("standard output: {rows} rows");
    assert!(said.lines().any(|line| line.ends_with(&expected)), "{said}");
    assert!(!folder.path("-").exists());
    assert!(
        folder
            .refusal("fuse --tracks a.csv --out - --json")
            .contains("would mix on standard output")
    );
    assert!(
        folder
            .refusal("fuse --tracks a.csv --out - --explain -")
            .contains("name one file")
    );
    // Nobody reads on: that is no failure.
    let mut command = folder.command("fuse --tracks a.csv b.csv --out -");
    command
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::piped());
    let mut running = command.spawn().unwrap();
    drop(running.stdout.take());
    let output = running.wait_with_output().unwrap();
    assert!(output.status.success(), "{output:?}");
}

#[test]
fn rows_that_cannot_be_used_are_left_out_counted_and_named() {
    let folder = two_sensors();
    folder.succeed("fuse --tracks a.csv --refresh 1 --out good.csv");
    let good = folder.read("a.csv");
    let row = |time: &str, x: &str, state: &str| format!("{time},7,1,{x},0,0,0,0,0,{VARIANCES},{state}\n");
    let mut lines = good.lines();
    let mut text = format!("{}\n", lines.next().unwrap());
    for (place, line) in lines.enumerate() {
        text += &format!("{line}\n");
        match place {
            5 => text += &row("0.25", "0", "confirmed"),
            8 => text += &row("4.25", "NaN", "confirmed"),
            9 => text += &row("6.25", "5", "lost"),
            10 => text += "6.25,7\n",
            // Far beyond the rows after it: they are right, not this one.
            11 => text += &row("90000", "0", "confirmed"),
            _ => {}
        }
    }
    folder.write("bad.csv", &text);
    let found = folder.json("fuse --tracks bad.csv --refresh 1 --out fused.csv --json");
    assert_eq!(found["rows_refused"], 5);
    let refused = serde_json::json!({"column state": 1, "column x": 1, "number of values": 1, "order of time": 2});
    assert_eq!(found["refused"], refused);
    let first = found["first_refused"].to_string();
    for expected in [
        "bad.csv: line 8, column time_s: 0.25 is before 2.25",
        "column x: \\\"NaN\\\" is not finite",
        "column state: \\\"lost\\\" is no state",
        "2 values, but the header names",
        "90000 is far beyond the rows around it",
    ] {
        assert!(first.contains(expected), "{expected}: {first}");
    }
    assert_eq!(
        folder.read("good.csv"),
        folder.read("fused.csv"),
        "the others are fused as ever"
    );
    let (_, said) = folder.succeed("fuse --tracks bad.csv --out fused.csv");
    assert!(said.contains("left out: 5 rows") && said.contains("sensor 7"), "{said}");
}

#[test]
fn a_sensor_whose_times_run_away_lets_no_time_pass_for_the_others() {
    // One file of two sensors, written as they came: the second one's clock is wrong, always or now and then.
    let both = |offset_s: fn(usize) -> Option<f64>| {
        let mut text = format!("{HEADER}\n");
        for step in 0..300usize {
            let time_s = 0.1 * step as f64;
            for (id, time_s) in [
                (1, Some(time_s)),
                (2, offset_s(step).map(|offset_s| time_s + 0.01 + offset_s)),
            ] {
                let Some(time_s) = time_s else { continue };
                let target = step % 3;
                let x = if id == 1 { 100.0 * time_s } else { 80e3 };
                let y = 20e3 * target as f64;
                text += &format!("{time_s},{id},{target},{x},{y},3000,100,0,0,{VARIANCES},confirmed\n");
            }
        }
        text
    };
    let folder = Folder::new();
    folder.write("calm.csv", both(|_| None));
    let lies: [fn(usize) -> Option<f64>; 6] = [
        |_| Some(5.5),
        |_| Some(30.0),
        |_| Some(50.0),
        |_| Some(70.0),
        |step| Some(if step % 50 == 7 { 50.0 } else { 0.0 }),
        |step| Some(if step % 3 == 1 { 9e9 } else { 0.0 }),
    ];
    // The honest sensor's part of the picture, from where one sensor's word is believed to where the calm one ends.
    let honest = |file: &str| -> BTreeSet<String> {
        let out = format!("{file}.out");
        folder.succeed(&format!("fuse --tracks {file} --refresh 1 --out {out}"));
        let text = folder.read(&out);
        let (times, x, y) = (column(&text, "time_s"), column(&text, "x"), column(&text, "y"));
        let rows = times.iter().zip(x.iter().zip(&y));
        rows.filter(|(time_s, (x, _))| {
            (10.0..=29.0).contains(&time_s.parse::<f64>().unwrap()) && x.parse::<f64>().unwrap() < 40e3
        })
        .map(|(time_s, (x, y))| {
            let round = |text: &str| text.parse::<f64>().unwrap().round();
            format!("{time_s} {} {}", round(x), round(y))
        })
        .collect()
    };
    let calm = honest("calm.csv");
    assert!(calm.len() >= 60, "{}", calm.len());
    for (number, lie) in lies.into_iter().enumerate() {
        let file = format!("lie{number}.csv");
        folder.write(&file, both(lie));
        assert_eq!(honest(&file), calm, "lie {number}");
    }
}

#[test]
fn absurd_speeds_turn_nothing_into_what_is_no_number() {
    let Some(bytes) = test_support::recording("hostile/nan.csv") else {
        return;
    };
    let folder = Folder::new();
    folder.write("nan.csv", bytes);
    folder.succeed("fuse --tracks nan.csv --refresh 1 --out fused.csv");
    let fused = folder.read("fused.csv");
    assert!(!fused.contains("NaN") && !fused.contains("inf"));
    let (times, addresses) = (column(&fused, "time_s"), column(&fused, "address"));
    let last: BTreeSet<&str> = times
        .iter()
        .zip(&addresses)
        .filter(|(time_s, _)| **time_s == "29")
        .map(|(_, address)| address.as_ref())
        .collect();
    assert_eq!(
        last.iter().filter(|address| !address.is_empty()).count(),
        50,
        "every target of the honest source"
    );
}

#[test]
fn what_cannot_be_fused_is_refused_in_one_line_and_nothing_is_written() {
    let folder = two_sensors();
    folder.write("other.csv", "time_s,x\n1,2\n");
    folder.write("header.csv", format!("{HEADER}\n"));
    folder.write("useless.csv", format!("{HEADER}\n1,1,1\n"));
    folder.write("wrong.toml", "[fusion]\nspeed = 1\n");
    folder.write("twice.toml", "[[sensor]]\nid = 7\n[[sensor]]\nid = 7\n");
    folder.write(
        "range.toml",
        "[[sensor]]\nid = 7\n\n[sensor.accuracy]\nsigma_m = -1.0\n",
    );
    folder.write(
        "placeless.toml",
        "[[sensor]]\nid = 7\n[sensor.coverage]\nrange_m = 5e3\n",
    );
    folder.write("deployment.toml", "name = \"x\"\n");
    let before = folder.names();
    for (arguments, expected) in [
        ("--tracks gone.csv --out f.csv", "gone.csv: cannot be read"),
        (
            "--tracks other.csv --out f.csv",
            "other.csv: header: column sensor_id is missing",
        ),
        (
            "--tracks header.csv --out f.csv",
            "no row can be used: the files have a header only",
        ),
        (
            "--tracks useless.csv --out f.csv",
            "line 2: 3 values, but the header names",
        ),
        ("--tracks a.csv a.csv --out f.csv", "names a.csv twice"),
        ("--tracks a.csv --out a.csv", "--out a.csv is an input"),
        (
            "--tracks a.csv --out f.csv --explain a.csv",
            "--explain a.csv is an input",
        ),
        ("--tracks a.csv --out f.csv --explain f.csv", "name two"),
        (
            "--tracks a.csv --out f.csv --rule best",
            "there is no such rule; there are ",
        ),
        ("--tracks a.csv --out f.csv --refresh 0", "more than 0"),
        ("--tracks a.csv --out f.csv --refresh 7200", "between 0.001 and 3600"),
        ("--tracks a.csv", "--out <FILE>"),
        (
            "--tracks a.csv --config wrong.toml --out f.csv",
            "wrong.toml:2: fusion.speed: unknown key",
        ),
        (
            "--tracks a.csv --config twice.toml --out f.csv",
            "twice.toml:4: sensor[1].id: 7 is the id of an earlier",
        ),
        (
            "--tracks a.csv --config range.toml --out f.csv",
            "range.toml:5: sensor[0].accuracy.sigma_m: -1 is out of range",
        ),
        (
            "--tracks a.csv --config placeless.toml --out f.csv",
            "placeless.toml:4: sensor[0].coverage.range_m: depends",
        ),
        (
            "--tracks a.csv --config deployment.toml --out f.csv",
            "deployment.toml: frame: missing",
        ),
    ] {
        let line = folder.refusal(&format!("fuse {arguments}"));
        assert!(line.contains(expected), "{arguments}: {line}");
    }
    assert_eq!(folder.names(), before);
}

#[test]
fn a_configuration_says_what_is_known_better() {
    let folder = two_sensors();
    let config = "[fusion.rule]\nname = \"best-source\"\nreference_source = \"main\"\n\
                  [[sensor]]\nid = 9\nname = \"main\"\nperiod_s = 3.5\n[sensor.accuracy]\nsigma_m = 1.0\n\
                  [sensor.coverage]\npolygon_m = [[-9e4, -9e4], [9e4, -9e4], [0, 9e4]]\n";
    folder.write("sensors.toml", config);
    let found = folder.json("fuse --tracks a.csv b.csv --config sensors.toml --refresh 1 --out fused.csv --json");
    assert_eq!(found["rule"], "best-source");
    let sensors = found["sensors"].as_array().unwrap();
    let shown: Vec<_> = sensors
        .iter()
        .map(|sensor| (&sensor["name"], sensor["period_s"].as_f64()))
        .collect();
    assert_eq!(shown, [(&"7".into(), Some(2.0)), (&"main".into(), Some(3.5))]);
}

#[test]
fn a_comparison_has_a_row_per_rule_with_the_figures_of_fuse_and_score() {
    let folder = two_sensors();
    let rules: Vec<&str> = fusion::rules::REGISTRY.iter().map(|entry| entry.name()).collect();
    let found = folder.json("compare --tracks a.csv b.csv --truth truth.csv --json");
    let rows = found["rules"].as_array().unwrap();
    assert_eq!(
        rows.iter().map(|row| row["rule"].as_str().unwrap()).collect::<Vec<_>>(),
        rules
    );
    for row in rows {
        let rule = row["rule"].as_str().unwrap();
        folder.succeed(&format!(
            "fuse --tracks a.csv b.csv --rule {rule} --refresh 1 --out fused.csv"
        ));
        let score = folder.json("score --truth truth.csv --tracks fused.csv --json");
        for word in [
            "gospa",
            "completeness",
            "id_switches",
            "breaks",
            "spurious",
            "system_tracks",
        ] {
            let (one, other) = (row[word].as_f64().unwrap(), score[word].as_f64().unwrap());
            assert!((one - other).abs() < 0.01, "{rule}, {word}: {one} and {other}");
        }
    }
    let (table, _) = folder.succeed("compare --tracks a.csv b.csv --markdown");
    assert_eq!(table.lines().count(), 2 + rules.len());
    assert!(table.starts_with("| rule | confirmed_tracks | hand_overs | rows | coasted | us_per_report |\n| --- |"));
    let (table, _) = folder.succeed("compare --tracks a.csv b.csv --truth truth.csv");
    assert_eq!(table.lines().count(), 1 + rules.len());
    assert!(table.lines().next().unwrap().contains("nees_pos"), "{table}");
}

#[test]
fn a_picture_shows_the_tracks_over_the_reports_of_every_sensor() {
    let folder = Folder::new();
    folder.succeed("simulate --scenario demo --for 20 --out case1");
    let fuse = "fuse --tracks case1/sensor_tracks_1.csv case1/sensor_tracks_3.csv --refresh 1 --out fused.csv";
    folder.succeed(&format!("{fuse} --picture all.svg"));
    let all = folder.read("all.svg");
    for word in [
        "<svg",
        "east, km",
        "sensor 1",
        "sensor 3",
        "system track",
        "<circle",
        "<polyline",
    ] {
        assert!(all.contains(word), "{word}");
    }
    let text = folder.read("fused.csv");
    let number = text.lines().last().unwrap().split(',').nth(1).unwrap();
    folder.succeed(&format!("{fuse} --picture one.svg --track {number}"));
    let one = folder.read("one.svg");
    assert!(one.contains(&format!("System track {number}, its surroundings")) && one.len() < all.len());
    let line = folder.line_of(1, &format!("{fuse} --picture none.svg --track 99999"));
    assert!(line.contains("system track 99999 is never confirmed"), "{line}");
}
