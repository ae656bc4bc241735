//! `koseki smooth` as a user calls it: on files with their fused output, on a recording, and what is refused.

use test_support::{column, numbers};

use crate::common::{Folder, Home};

/// A world of eight targets, seen by three radars for a minute and a half, and what `koseki fuse` makes of it.
fn fused() -> Folder {
    let folder = Folder::new();
    folder.write("world.toml", include_str!("golden/world.toml"));
    folder.succeed("simulate --scenario world.toml --seed 4 --for 90 --out w");
    folder.succeed(&format!("fuse {TRACKS} --refresh 1 --out fused.csv"));
    folder
}

const TRACKS: &str = "--tracks w/sensor_tracks_1.csv w/sensor_tracks_2.csv w/sensor_tracks_3.csv";

#[test]
fn smoothed_tracks_are_the_fused_ones_with_half_of_the_errors() {
    let folder = fused();
    let found = folder.json(&format!(
        "smooth {TRACKS} --refresh 1 --fused fused.csv --out smoothed.csv --asterix smoothed.ast --origin 41.3,2.1 --sac 7 \
         --sic 9 --json"
    ));
    let (fused, smoothed) = (folder.read("fused.csv"), folder.read("smoothed.csv"));
    assert_eq!(found["rows"], smoothed.lines().count() - 1);
    assert_eq!(found["rows_unmeasured"], 0);
    for same in [
        "time_s",
        "system_track_id",
        "state",
        "sources",
        "weights",
        "address",
        "report_times_s",
    ] {
        assert_eq!(column(&fused, same), column(&smoothed, same), "{same}");
    }
    let score = |file: &str| folder.json(&format!("score --truth w/truth.csv --tracks {file} --json"));
    let (before, after) = (score("fused.csv"), score("smoothed.csv"));
    let figure = |score: &serde_json::Value, name: &str| score[name].as_f64().unwrap();
    assert!(
        figure(&after, "rmse_pos") < 0.6 * figure(&before, "rmse_pos"),
        "{before} {after}"
    );
    assert!(
        figure(&after, "rmse_vel") < 0.5 * figure(&before, "rmse_vel"),
        "{before} {after}"
    );
    assert!((0.3..2.0).contains(&figure(&after, "nees_pos")), "{after}");
    // What the command expects of itself.
    let sigma = &found["sigma"];
    let expected = figure(&sigma["smoothed"], "position_m") / figure(&sigma["fused"], "position_m");
    assert!((0.2..0.7).contains(&expected), "{found}");

    // CAT062 has the same tracks at the same times.
    folder.succeed("decode smoothed.ast --out smoothed.jsonl");
    let records: Vec<serde_json::Value> = folder
        .read("smoothed.jsonl")
        .lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect();
    assert_eq!(found["records"], records.len());
    let times = numbers(&smoothed, "time_s");
    assert_eq!(records.len(), times.len());
    let xs = numbers(&smoothed, "x");
    for (record, (time_s, x)) in records.iter().zip(times.into_iter().zip(xs)) {
        assert_eq!(
            (&record["_c"], &record["010"]["SAC"], &record["010"]["SIC"]),
            (&62.into(), &7.into(), &9.into())
        );
        assert!((record["070"].as_f64().unwrap() - time_s).abs() < 0.01, "{record}");
        assert!((record["100"]["X"].as_f64().unwrap() - x).abs() < 0.3, "{record}");
    }
    // The same files give the same bytes, without the fused output as well.
    folder.succeed(&format!("smooth {TRACKS} --refresh 1 --out again.csv"));
    assert_eq!(folder.read("again.csv"), smoothed);
}

#[test]
fn an_output_of_other_options_is_refused_with_its_line_and_nothing_is_written() {
    let folder = fused();
    let fused = folder.read("fused.csv");
    let mut lines: Vec<String> = fused.lines().map(str::to_owned).collect();
    lines[40].replace_range(..1, "x");
    folder.write("changed.csv", lines.join("\n") + "\n");
    let line = folder.refusal(&format!("smooth {TRACKS} --refresh 1 --fused changed.csv --out s.csv"));
    assert!(
        line.contains("changed.csv: line 41 ") && line.contains("--refresh"),
        "{line}"
    );
    folder.write("longer.csv", format!("{fused}{}\n", lines[1]));
    let line = folder.refusal(&format!("smooth {TRACKS} --refresh 1 --fused longer.csv --out s.csv"));
    assert!(line.contains("beyond the last row"), "{line}");
    let line = folder.refusal(&format!("smooth {TRACKS} --refresh 2 --fused fused.csv --out s.csv"));
    assert!(line.contains("fused.csv: line "), "{line}");
    assert!(!folder.names().contains("s.csv"));
}

#[test]
fn what_cannot_be_smoothed_is_refused_in_one_line() {
    let folder = Folder::new();
    folder.write("t.csv", "time_s\n");
    for (arguments, expected) in [
        ("smooth --out s.csv", "--tracks"),
        ("smooth nowhere --tracks t.csv --out s.csv", "cannot be used with"),
        ("smooth nowhere --out s.csv", "nowhere"),
        ("smooth --tracks t.csv --out s.csv", "t.csv"),
        ("smooth --tracks t.csv --out t.csv", "is an input"),
        ("smooth --tracks t.csv --out s.csv --asterix s.csv", "name one file"),
        ("smooth --tracks t.csv --out s.csv --origin 41,2", "--asterix"),
        (
            "smooth --tracks t.csv --out s.csv --asterix s.ast --origin 91,2",
            "latitude 91",
        ),
        (
            "smooth --tracks t.csv --out s.csv --asterix s.ast --origin here",
            "41.297,2.078",
        ),
        ("smooth --tracks t.csv --out s.csv --rule none", "none"),
    ] {
        let line = folder.refusal(arguments);
        assert!(line.contains(expected), "{arguments}: {line}");
        assert!(!folder.names().contains("s.csv"), "{arguments}");
    }
    folder.write("world.toml", include_str!("golden/world.toml"));
    folder.succeed("simulate --scenario world.toml --seed 4 --for 10 --out w");
    let line = folder.refusal(&format!("smooth {TRACKS} --out s.csv --asterix s.ast"));
    assert!(line.contains("--origin") && line.contains("--config"), "{line}");
}

#[test]
fn a_recording_is_smoothed_at_the_times_of_its_states() {
    let home = Home::new();
    let settings = [
        "--set",
        "recorder.enabled=true",
        "--set",
        "recorder.format=[\"csv\", \"mcap\"]",
    ];
    let (status, said) = home
        .start(&[&["demo", "--for", "6", "--out", "out"], &settings[..]].concat())
        .end();
    assert!(status.success(), "{said}");
    let output = home.run(&[
        "smooth",
        "out/latest",
        "--out",
        "smoothed.csv",
        "--asterix",
        "smoothed.ast",
        "--json",
    ]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let found: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let (live, smoothed) = (home.read("out/latest/system_tracks.csv"), home.read("smoothed.csv"));
    assert_eq!(found["rows"], smoothed.lines().count() - 1);
    assert!(
        found["rows"].as_u64().unwrap() > 300 && found["measurements"].as_u64().unwrap() > 300,
        "{found}"
    );
    for same in ["time_s", "system_track_id", "state", "utc", "sources"] {
        assert_eq!(column(&live, same), column(&smoothed, same), "{same}");
    }
    // Positions on the Earth follow the smoothed ones.
    assert_ne!(column(&live, "latitude"), column(&smoothed, "latitude"));
    let sigma = &found["sigma"];
    let [before, after] = ["fused", "smoothed"].map(|which| sigma[which]["position_m"].as_f64().unwrap());
    assert!(after < before, "{found}");
    let decoded = home.run(&["decode", "smoothed.ast", "--out", "smoothed.jsonl"]);
    assert!(decoded.status.success());
    assert_eq!(found["records"], home.read("smoothed.jsonl").lines().count());
}
