//! Alerts on targets: live through a kill of their process, and of files.

use std::collections::BTreeMap;

use rustix::process::Signal;
use serde_json::Value;
use test_support::column;

use crate::common::{Folder, Home, kill, repository, until};

/// Limits within which the demonstration always has pairs.
const WIDE: &str = "alert=[{kind=\"conflict\", distance_nm=30.0, vertical_ft=5000.0}]";

/// Alerts in force by number: their targets, and the time at which they were raised.
fn in_force(home: &Home) -> BTreeMap<u64, (Value, i64)> {
    let output = home.run(&["tap", "system/alerts", "--instance", "demo", "--count", "40"]);
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let text = String::from_utf8(output.stdout).unwrap();
    let alerts = text.lines().map(|line| serde_json::from_str::<Value>(line).unwrap());
    let alerts = alerts.filter(|alert| alert["event"] != "cleared");
    let entry = |alert: Value| {
        assert!(
            alert["kind"] == "conflict" && alert["text"].as_str().unwrap().contains(" and "),
            "{alert}"
        );
        (
            alert["number"].as_u64().unwrap(),
            (alert["tracks"].clone(), alert["raised_ns"].as_i64().unwrap()),
        )
    };
    alerts.map(entry).collect()
}

#[test]
fn alerts_in_force_outlast_their_process() {
    let home = Home::new();
    let demo = home.demo_with(&["--set", WIDE, "--set", "recorder.enabled=true", "--out", "out"]);
    let before = in_force(&home);
    assert!(!before.is_empty());
    kill(home.status_row("alerts").pid, Signal::KILL);
    demo.until_said("alerts was killed by SIGKILL");
    until("the successor runs", || home.status_row("alerts").state == "running");
    let after = in_force(&home);
    let kept = before
        .iter()
        .filter(|(number, alert)| after.get(*number) == Some(*alert))
        .count();
    assert!(kept > 0, "before: {before:?}, after: {after:?}");
    let (status, said) = demo.stop();
    assert_eq!(status.code(), Some(0), "{said}");
    // Each alert is raised once in the table, also by two processes.
    let table = std::fs::read_to_string(home.path("out/latest/alerts.csv")).unwrap();
    let mut raised: Vec<String> = Vec::new();
    for (event, number) in column(&table, "event").into_iter().zip(column(&table, "alert")) {
        if event == "raised" {
            assert!(!raised.contains(&number), "{number} is raised twice");
            raised.push(number);
        }
    }
    assert!(!raised.is_empty());
    home.assert_nothing_is_left("demo");
}

#[test]
fn files_give_the_same_alerts_again_and_need_rules() {
    let folder = Folder::new();
    let demo = std::fs::read_to_string(repository("config/demo.toml")).unwrap();
    folder.write("plain.toml", &demo);
    let zone = "[[area]]\nname = \"zone\"\ncircle = { latitude_deg = 41.3, longitude_deg = 2.08, radius_nm = 20 }\n\
                [[alert]]\nkind = \"enter\"\nareas = [\"zone\"]\n[[alert]]\nkind = \"conflict\"\n";
    folder.write("site.toml", format!("{demo}\n{zone}"));
    folder.succeed("simulate --scenario plain.toml --seed 2 --for 60 --out world");
    let fuse = "fuse --tracks world/sensor_tracks_1.csv world/sensor_tracks_4.csv --out fused.csv --refresh 1";
    let found = folder.json(&format!("{fuse} --config site.toml --alerts one.csv --json"));
    let table = folder.read("one.csv");
    let raised = column(&table, "event")
        .iter()
        .filter(|event| *event == "raised")
        .count();
    assert_eq!(found["alerts_raised"], raised);
    let kinds = column(&table, "kind");
    assert!(
        ["enter", "conflict"]
            .iter()
            .all(|kind| kinds.iter().any(|found| found == kind)),
        "{kinds:?}"
    );
    folder.succeed(&format!("{fuse} --config site.toml --alerts other.csv"));
    assert_eq!(table, folder.read("other.csv"));

    let line = folder.refusal(&format!("{fuse} --config plain.toml --alerts one.csv"));
    assert!(
        line.contains("--alerts: there are no rules; give a deployment with [[alert]]"),
        "{line}"
    );
    folder.write(
        "lost.toml",
        format!("{demo}\n[[area]]\nname = \"z\"\nfile = \"none.geojson\"\n"),
    );
    let line = folder.refusal("check lost.toml");
    assert!(
        line.contains("lost.toml: area[0]: none.geojson: cannot be read"),
        "{line}"
    );
    folder.write(
        "wrong.toml",
        format!("{demo}\n[[alert]]\nkind = \"enter\"\nareas = [\"zone\"]\n"),
    );
    let line = folder.refusal("check wrong.toml");
    assert!(line.contains("alert[0].areas: \"zone\" is not known"), "{line}");
    let (summary, _) = folder.succeed("check site.toml");
    assert!(summary.contains("zone: no floor to no ceiling"), "{summary}");
}
