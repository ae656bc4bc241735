//! `koseki tap`: what a deployment publishes, as lines of text.

use std::convert::Infallible;
use std::io::{BufRead as _, BufReader};
use std::os::unix::fs::PermissionsExt as _;
use std::os::unix::net::UnixStream;

use formats::recording::RecordingBytes;
use rustix::process::Signal;

use crate::common::{Home, until};

#[test]
fn states_are_lines_of_json_or_csv() {
    let home = Home::new();
    let demo = home.demo();
    let tapped = |arguments: &[&str]| {
        let output = home.run(&[&["tap", "--instance", "demo", "--count", "20"], arguments].concat());
        assert_eq!(output.status.code(), Some(0), "{output:?}");
        String::from_utf8(output.stdout).unwrap()
    };
    let json = tapped(&[]);
    assert_eq!(json.lines().count(), 20);
    for line in json.lines() {
        let state: serde_json::Value = serde_json::from_str(line).unwrap();
        assert!(
            state["track_number"].is_u64() && state["position_m"][0].is_f64(),
            "{line}"
        );
        let contributions = state["contributions"].as_array().unwrap();
        assert!(contributions.len() as u64 <= state["contribution_count"].as_u64().unwrap());
        assert!(state["state"].is_string() && state["latitude"].is_f64(), "{line}");
        for contribution in contributions {
            assert!(contribution["source"].is_string(), "{line}");
        }
    }
    for line in tapped(&["--raw"]).lines() {
        let state: serde_json::Value = serde_json::from_str(line).unwrap();
        assert!(state["state"].is_u64() && state["latitude"].is_null(), "{line}");
    }
    let only = home.run(&["tap", "--topic", "system/tracks", "--csv", "--count", "20"]);
    let table = String::from_utf8(only.stdout).unwrap();
    assert_eq!(table.lines().count(), 21, "the only instance that runs");
    let table = tapped(&["--format", "csv"]);
    let mut reader = csv::Reader::from_reader(table.as_bytes());
    assert!(reader.headers().unwrap().iter().any(|name| name == "stages.fused_ns"));
    assert_eq!(reader.records().map(Result::unwrap).count(), 20);
    demo.stop();
    home.assert_nothing_is_left("demo");
}

#[test]
fn the_schema_of_a_topic_needs_no_instance() {
    let home = Home::new();
    let schema = |arguments: &[&str]| -> serde_json::Value {
        let output = home.run(&[&["tap", "--schema"], arguments].concat());
        assert_eq!(output.status.code(), Some(0), "{output:?}");
        serde_json::from_slice(&output.stdout).unwrap()
    };
    let named = schema(&[]);
    assert_eq!(named["title"], "SystemTrack");
    assert_eq!(
        named["properties"]["latitude"]["type"],
        serde_json::json!(["number", "null"])
    );
    let raw = schema(&["--raw"]);
    assert!(raw["properties"]["latitude"].is_null() && raw["properties"]["state"]["type"] == "integer");
    assert_eq!(schema(&["system/alarms"])["title"], "Alarm");
}

#[test]
fn states_are_blocks_of_cat062() {
    let home = Home::new();
    let demo = home.demo();
    let arguments = [
        "tap",
        "--instance",
        "demo",
        "--format",
        "cat062",
        "--sac",
        "7",
        "--sic",
        "9",
        "--count",
        "300",
    ];
    // What it writes is no text.
    let tapped = home.command(&arguments).output().unwrap();
    assert_eq!(tapped.status.code(), Some(0), "{tapped:?}");
    let recording = RecordingBytes::new(&tapped.stdout);
    let survey = recording.survey();
    assert_eq!(survey.categories.keys().collect::<Vec<_>>(), [&62]);
    assert_eq!(survey.categories[&62].blocks_refused, 0);
    assert!(survey.categories[&62].records > 100);
    let Ok(()) = recording.for_each(&survey, |found| {
        assert_eq!(found.record.sender(), Some((7, 9)));
        Ok::<(), Infallible>(())
    });
    let refused = home.run(&["tap", "health", "--instance", "demo", "--format", "cat062"]);
    assert_eq!(refused.status.code(), Some(2), "{refused:?}");
    demo.stop();
    home.assert_nothing_is_left("demo");
}

#[test]
fn a_unix_socket_serves_whom_its_mode_lets_until_the_deployment_ends() {
    let home = Home::new();
    let demo = home.demo();
    let socket = home.path("tracks.sock");
    let text = socket.to_str().unwrap();
    let tap = home.start(&["tap", "--instance", "demo", "--unix", text, "--mode", "620"]);
    until("the socket is there", || {
        socket
            .metadata()
            .is_ok_and(|found| found.permissions().mode() & 0o777 == 0o620)
    });
    let mut readers = [(); 2].map(|()| BufReader::new(UnixStream::connect(&socket).unwrap()).lines());
    for reader in &mut readers {
        let line = reader.next().unwrap().unwrap();
        assert!(line.starts_with("{\"reference_time_ns\":"), "{line}");
    }
    demo.signal(Signal::TERM);
    let (status, said) = tap.end();
    assert_eq!(status.code(), Some(0), "{said}");
    assert!(!socket.exists());
    demo.end();
    home.assert_nothing_is_left("demo");
}

#[test]
fn what_is_no_topic_or_does_not_run_is_said() {
    let home = Home::new();
    let refused = home.run(&["tap", "nonsense", "--instance", "demo"]);
    assert_eq!(refused.status.code(), Some(2));
    for option in ["--tcp", "--serve"] {
        let refused = home.run(&["tap", "--instance", "demo", option, "0.0.0.0:0"]);
        let said = String::from_utf8(refused.stderr).unwrap();
        assert_eq!(refused.status.code(), Some(2), "{said}");
        assert!(
            said.contains("can be reached from other machines") && said.contains("--remote"),
            "{said}"
        );
    }
    let refused = home.run(&["tap", "--instance", "demo", "--tcp", "0.0.0.0:0", "--remote"]);
    let said = String::from_utf8(refused.stderr).unwrap();
    assert!(said.contains("no instance demo runs"), "{said}");
    let refused = home.run(&["tap", "--instance", "demo"]);
    let said = String::from_utf8(refused.stderr).unwrap();
    assert!(said.contains("no instance demo runs"), "{said}");
}
