//! Keys of the monitor, and mistakes in them.

use std::path::Path;
use std::time::Duration;

use configuration::ConfigWith;
use deployment::ReportOrder;

use crate::settings::{Keys, MonitorWait};

type Config = ConfigWith<Keys>;

const SITE: &str = include_str!("../../../config/barcelona.toml");

fn refused(text: &str) -> String {
    let read = Config::parse(Path::new("test.toml"), text, &[]);
    read.unwrap_err().to_string()
}

/// The configuration with other lines under `[monitor]`, and the number of the first of them.
fn with_monitor(lines: &str) -> (String, usize) {
    let old = "interval_s = 1.0\nfiles = true";
    let at = SITE.find(old).expect("the lines are there");
    (SITE.replacen(old, lines, 1), SITE[..at].matches('\n').count() + 1)
}

#[test]
fn a_monitor_polls_where_fusion_spins_unless_told_otherwise() {
    let wait = |overrides: &[&str]| {
        let overrides: Vec<String> = overrides.iter().map(|each| (*each).to_owned()).collect();
        let config = Config::parse(Path::new("test.toml"), SITE, &overrides).unwrap();
        config.parts.monitor.waiting(&config.fusion)
    };
    let every = |ms| MonitorWait::Poll {
        pause: Duration::from_millis(ms),
    };
    assert_eq!(wait(&["fusion.wait=event"]), MonitorWait::Event);
    assert_eq!(wait(&["fusion.wait=spin"]), every(5));
    assert_eq!(wait(&["fusion.wait=hybrid", "monitor.poll_ms=20"]), every(20));
    assert_eq!(wait(&["fusion.wait=spin", "monitor.wait=event"]), MonitorWait::Event);
    assert_eq!(wait(&["fusion.wait=event", "monitor.wait=poll"]), every(5));
}

#[test]
fn deadlines_are_those_given_and_fusion_has_its_own() {
    use telemetry::Stage;
    let (text, _) = with_monitor("[monitor.deadline_us]\nend_to_end = 2500.0\nage = 5e6");
    let config = Config::parse(Path::new("test.toml"), &text, &[]).unwrap();
    let deadlines = config.parts.monitor.configured_deadlines(&config.fusion);
    let of = |stage| deadlines.get(stage);
    assert_eq!(of(Stage::EndToEnd), Some(2_500_000));
    assert_eq!(of(Stage::Age), Some(5_000_000_000));
    assert_eq!(of(Stage::TakenToFused), Some(config.fusion.deadline_ns() as u64));
    assert_eq!(of(Stage::PublishToTaken), None);
    assert_eq!(config.order, ReportOrder::Time);
    assert_eq!(
        config.parts.monitor.deadlines(&config).get(Stage::EndToEnd),
        None,
        "none is late"
    );
    let (text, _) = with_monitor("[monitor.deadline_us]\ntaken_to_fused = 70.0");
    let config = Config::parse(Path::new("test.toml"), &text, &[]).unwrap();
    assert_eq!(
        config
            .parts
            .monitor
            .configured_deadlines(&config.fusion)
            .get(Stage::TakenToFused),
        Some(70_000)
    );
}

#[test]
fn mistakes_in_the_monitors_keys_are_named() {
    let cases = [
        (
            "wait = \"spin\"",
            "monitor.wait: \"spin\" is not known; there are: event, poll",
        ),
        (
            "pol_ms = 5",
            "monitor.pol_ms: unknown key; there are: interval_s, files, wait, poll_ms",
        ),
        ("poll_ms = 0", "monitor.poll_ms: 0 is out of range"),
        ("poll_ms = 101.0", "must lie between 0.5 and 100"),
        ("interval_s = 0.0", "monitor.interval_s: 0 is out of range"),
        (
            "deadline_us = { fusion = 3 }",
            "monitor.deadline_us.fusion: unknown key",
        ),
        (
            "deadline_us = { age = -1.0 }",
            "monitor.deadline_us.age: -1 is out of range",
        ),
        ("deadline_us = { age = 1e12 }", "must lie between 0.1 and 600000000"),
        (
            "deadline_us = { fused_to_received = 9.0 }\nwait = \"poll\"",
            "set monitor.wait = \"event\", or leave it out",
        ),
        ("prometheus = \"localhost\"", "as in \"127.0.0.1:9464\""),
        ("prometheus = \"0.0.0.0:9464\"", "set prometheus_public = true"),
        ("prometheus = \"[::]:9464\"", "reached from other machines"),
        ("prometheus_hosts = [\"a:80\"]", "write it without a port"),
    ];
    for (lines, expected) in cases {
        let (text, line) = with_monitor(lines);
        let message = refused(&text);
        assert!(message.contains(expected), "{lines}: {message}");
        assert!(
            message.starts_with(&format!("test.toml:{line}: ")),
            "line {line}: {message}"
        );
        assert_eq!(message.lines().count(), 1, "one line: {message}");
    }
}

#[test]
fn metrics_are_served_to_this_machine_unless_made_public() {
    let metrics = |lines: &str| {
        let (text, _) = with_monitor(lines);
        let config = Config::parse(Path::new("test.toml"), &text, &[]).unwrap();
        config.parts.monitor.metrics().map(|address| address.to_string())
    };
    assert_eq!(metrics(""), None);
    assert_eq!(
        metrics("prometheus = \"127.0.0.1:9464\"").as_deref(),
        Some("127.0.0.1:9464")
    );
    assert_eq!(metrics("prometheus = \"[::1]:0\"").as_deref(), Some("[::1]:0"));
    let public = metrics("prometheus = \"192.0.2.1:80\"\nprometheus_public = true");
    assert_eq!(public.as_deref(), Some("192.0.2.1:80"));
}
