//! The bench, as a user starts it: real processes, real shared memory, and no word about how fast they are.

use std::fs;

use rustix::process::Signal;
use serde_json::Value;

use crate::common::{Home, until};

/// Enough for every report to come and go, and little enough for any machine.
const SMALL: [&str; 12] = [
    "--targets",
    "20",
    "--sources",
    "2",
    "--rate",
    "500",
    "--seconds",
    "0.4",
    "--runs",
    "1",
    "--wait",
    "event",
];

/// The two cores that a measurement needs, as options; `None` where this process may use only one.
fn cores() -> Option<Vec<String>> {
    let cores = runtime::cores::available();
    if cores.len() < 2 {
        eprintln!("skipped: a measurement needs two cores, and this process may use {cores:?}");
        return None;
    }
    let option = |name: &str, core: usize| [name.to_owned(), core.to_string()];
    Some([option("--bench-core", cores[0]), option("--fusion-core", cores[1])].concat())
}

fn arguments<'a>(first: &[&'a str], cores: &'a [String]) -> Vec<&'a str> {
    [first, &SMALL]
        .concat()
        .into_iter()
        .chain(cores.iter().map(String::as_str))
        .collect()
}

#[test]
fn a_latency_measurement_accounts_for_every_report_and_leaves_nothing_behind() {
    let Some(cores) = cores() else { return };
    let home = Home::new();
    let options = arguments(&["bench", "latency"], &cores);
    let files = ["--json", "a.json", "--picture", "a.svg", "--percentiles", "histograms"];
    let bench = home.start(&[options, files.to_vec()].concat());
    let (instance, stdout) = (format!("bench-{}", bench.pid()), bench.stdout.clone());
    let (status, said) = bench.end();
    home.assert_nothing_is_left(&instance);

    let shown = stdout.lock().unwrap().clone();
    for word in [
        "relay (floor)",
        "pipeline",
        "machine alone",
        "in fusion",
        "Engine alone",
        "adds up",
    ] {
        assert!(shown.contains(word), "{word}: {shown}");
    }
    let report: Value = serde_json::from_str(&fs::read_to_string(home.path("a.json")).unwrap()).unwrap();
    for key in [
        "machine",
        "settings",
        "throughput_per_s",
        "engine_ns_per_update",
        "jitter",
    ] {
        assert!(report.get(key).is_some(), "{key}");
    }
    let number = |path: &str| {
        report
            .pointer(path)
            .and_then(Value::as_u64)
            .unwrap_or_else(|| panic!("{path}"))
    };
    let stages =
        ["publish_to_taken", "taken_to_fused", "fused_to_received", "end_to_end"].map(|key| format!("/stages/{key}"));
    for of in ["/floor".to_owned(), "/pipeline".to_owned()].iter().chain(&stages) {
        for key in ["count", "lost", "p50_ns", "p90_ns", "p99_ns", "p999_ns", "max_ns"] {
            number(&format!("{of}/{key}"));
        }
        let figures = ["p50_ns", "p99_ns", "max_ns"].map(|key| number(&format!("{of}/{key}")));
        assert!(figures[0] > 0 && figures.is_sorted(), "{of}: {figures:?}");
    }
    // 0.4 s at 500 a second. A busy machine may lose some; none may vanish.
    let account = |key: &str| number(&format!("/points/0/runs/0/account/{key}"));
    let expected = i32::from(account("unanswered") > 0);
    assert_eq!(status.code(), Some(expected), "{said}");
    assert_eq!(account("sent"), 200);
    assert_eq!(account("answers") - account("beyond_one") + account("unanswered"), 200);
    assert_eq!(account("sent_ever"), account("fusion/taken") + account("fusion/lost"));

    let picture = fs::read_to_string(home.path("a.svg")).unwrap();
    assert!(picture.contains("<svg") && picture.contains("bare relay"));
    for name in [
        "floor-500",
        "pipeline-500",
        "jitter-lateness-500",
        "stage-end_to_end-500",
        "engine",
    ] {
        assert!(home.path(&format!("histograms/{name}.hgrm")).exists(), "{name}");
    }

    // A file is comparable with itself, and not with one of other settings.
    let same = home.run(&["bench", "compare", "a.json", "a.json"]);
    assert_eq!(same.status.code(), Some(0), "{same:?}");
    let other = fs::read_to_string(home.path("a.json"))
        .unwrap()
        .replacen("\"targets\": 20", "\"targets\": 21", 1);
    fs::write(home.path("b.json"), other).unwrap();
    let refused = home.run(&["bench", "compare", "a.json", "b.json"]);
    let said = String::from_utf8_lossy(&refused.stderr);
    assert_eq!(refused.status.code(), Some(2), "{said}");
    assert!(said.contains("targets 20 -> 21") && said.contains("--force"), "{said}");
    assert_eq!(
        home.run(&["bench", "compare", "a.json", "b.json", "--force"])
            .status
            .code(),
        Some(0)
    );
}

#[test]
fn a_measurement_that_is_told_to_stop_stops_its_processes_and_clears_up() {
    let Some(cores) = cores() else { return };
    for signal in [Signal::INT, Signal::TERM] {
        let home = Home::new();
        let mut options = arguments(&["bench", "latency"], &cores);
        let place = options.iter().position(|option| *option == "--runs").unwrap();
        options[place + 1] = "1000";
        let bench = home.start(&options);
        let instance = format!("bench-{}", bench.pid());
        bench.until_said("run 1 of 1000");
        // `timeout` sends a signal to the process and to its group: the bench gets the signal again while it clears up.
        for _ in 0..100 {
            bench.signal(signal);
            std::thread::sleep(std::time::Duration::from_millis(2));
        }
        let (status, said) = bench.end();
        assert_eq!(status.code(), Some(1), "{said}");
        assert!(said.contains("stopped before the end"), "{said}");
        home.assert_nothing_is_left(&instance);
    }
}

#[test]
fn what_a_killed_measurement_leaves_is_removed_by_the_next() {
    let Some(cores) = cores() else { return };
    let home = Home::new();
    let options = arguments(&["bench", "latency"], &cores);
    let bench = home.start(&options);
    let instance = format!("bench-{}", bench.pid());
    bench.until_said("engine alone");
    bench.signal(Signal::KILL);
    bench.end();
    until("its processes have ended", || home.processes().is_empty());
    assert!(home.root(&instance).path().exists());
    let folders = || {
        let all = std::fs::read_dir(std::env::temp_dir()).unwrap().flatten();
        let prefix = format!("koseki-{instance}-");
        all.filter(|folder| folder.file_name().to_string_lossy().starts_with(&prefix))
            .count()
    };
    assert_eq!(folders(), 1);
    let next = home.run(&options);
    let said = String::from_utf8_lossy(&next.stderr);
    assert_eq!(next.status.code(), Some(0), "{said}");
    assert!(
        said.contains(&format!("remains of a killed bench in instance {instance}")),
        "{said}"
    );
    assert_eq!(folders(), 0);
    home.assert_nothing_is_left(&instance);
}

#[test]
fn every_measurement_has_help_with_examples() {
    let home = Home::new();
    for command in ["latency", "throughput", "engine", "watch", "compare"] {
        let output = home.run(&["bench", command, "--help"]);
        let text = String::from_utf8(output.stdout).unwrap();
        assert_eq!(output.status.code(), Some(0));
        assert!(
            text.contains("Examples:") && text.contains(&format!("koseki bench {command}")),
            "{text}"
        );
    }
}

#[test]
fn what_cannot_be_measured_is_refused_in_one_line() {
    let home = Home::new();
    let cases: [(&[&str], &[&str]); 6] = [
        (&[], &["there are latency, throughput, engine", "koseki bench --help"]),
        (&["latency", "--targets", "0"], &["--targets 0", "1 to 100000"]),
        (&["latency", "--batch", "65"], &["--batch 65", "1 to 64"]),
        (&["latency", "--rate", "0.5"], &["--rate 0.5", "between 1 and"]),
        (
            &["latency", "--json", "none/a.json"],
            &["--json none/a.json", "a folder that exists"],
        ),
        (&["compare", "none.json", "none.json"], &["none.json", "cannot be read"]),
    ];
    for (arguments, expected) in cases {
        let output = home.run(&[&["bench"], arguments].concat());
        let said = String::from_utf8(output.stderr).unwrap();
        let cores_refused = said.contains("need one each");
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert_eq!((said.lines().count(), output.stdout.len()), (1, 0), "{said}");
        for word in expected {
            assert!(cores_refused || said.contains(word), "{word}: {said}");
        }
    }
}

#[test]
fn the_engine_is_measured_without_shared_memory() {
    let home = Home::new();
    let core = runtime::cores::available()[0].to_string();
    let options = [
        "bench",
        "engine",
        "--targets",
        "50",
        "--seconds",
        "0.1",
        "--runs",
        "2",
        "--json",
        "e.json",
        "--core",
        &core,
    ];
    let output = home.run(&options);
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let report: Value = serde_json::from_str(&fs::read_to_string(home.path("e.json")).unwrap()).unwrap();
    assert!(report["engine_ns_per_update"].as_f64().unwrap() > 0.0);
    assert_eq!(
        report["engine"]["single"]["lost"], 0,
        "each report yields one confirmed state"
    );
    assert!(!home.path("koseki").exists(), "an instance was claimed");
}
