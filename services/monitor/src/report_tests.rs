use std::collections::BTreeMap;

use messages::{Counter, Counters, LifeState, ProcessKind, Registration, registration_bits};

use super::*;
use crate::golden;
use observed::{ObservedProcess, ProcessState, RefusedInput, TrackCounts};
use telemetry::Summary;

use crate::report::{Hop, Losses, ProcessCounters, Restarts, SourceReport, SourceStageReport, StageReport, Verdict};
use crate::verdict;

const WIDTH: usize = 110;
const SUMMARY: Summary = Summary {
    count: 20_000,
    p50_ns: 41_200,
    p90_ns: 98_000,
    p99_ns: 412_000,
    p999_ns: 900_000,
    max_ns: 1_230_000,
    mean_ns: 50_000.0,
};

fn source(number: u16, name: &str, published: u64) -> SourceReport {
    SourceReport {
        number,
        name: name.to_owned(),
        sensor_of: None,
        adapter: Counters::default()
            .with(Counter::Records, published + 5)
            .with(Counter::RejectedJump, 3)
            .with(Counter::RejectedSpeed, 2)
            .with(Counter::Published, published),
        fusion: Counters::default()
            .with(Counter::Taken, published)
            .with(Counter::RejectedDuplicate, 11),
        recorder: Counters::default(),
        registration: Registration::default(),
        scan_period_s: None,
        states: published,
        joint_states: published / 2,
        stages: source_stages(SUMMARY, 0),
    }
}

fn source_stages(summary: Summary, deadline_misses: u64) -> Vec<(Stage, SourceStageReport)> {
    let report = SourceStageReport {
        summary,
        deadline_misses,
    };
    Stage::ALL.map(|stage| (stage, report)).to_vec()
}

fn process(kind: ProcessKind, name: &str) -> ObservedProcess {
    ObservedProcess {
        kind: Some(kind),
        name: name.to_owned(),
        state: ProcessState::Life(LifeState::Finished),
        restarts: 0,
        last_end: String::new(),
        note: String::new(),
        pid: None,
    }
}

fn judged(mut report: Report) -> Report {
    report.verdict = verdict::on(&report);
    report
}

/// A radar that is off by a few metres, as fusion has found out.
fn registered() -> Registration {
    Registration {
        comparisons: 900.0,
        offset_m: [-1.5, -6.8, 0.0],
        offset_sigma_m: [0.3, 0.3, 12.0],
        removed: registration_bits::EAST | registration_bits::NORTH,
        ..Registration::default()
    }
}

/// A demonstration that went well.
pub(crate) fn good() -> Report {
    let stage = |stage| {
        let report = StageReport {
            summary: SUMMARY,
            measured: true,
            deadline_us: (stage == Stage::TakenToFused).then_some(1000.0),
            ..StageReport::default()
        };
        (stage, report)
    };
    judged(Report {
        settings: RunSettings {
            deployment: "demo".to_owned(),
            instance: "demo".to_owned(),
            rule: "auto".to_owned(),
            order: "arrival",
            wait: "event",
            recorded_sources: 0,
            simulated_sources: 2,
            live_sources: 0,
            speed: None,
            latencies_measured: true,
            seed: Some(1),
            targets: Some(80),
            interval_s: 1.0,
            deadline_us: 1000.0,
            monitor_wait: "event",
            monitor_poll_ms: None,
        },
        begun_utc_ns: 1_700_000_000_000_000_000,
        duration_s: 20.04,
        recording_reached_utc_ns: None,
        verdict: Verdict::default(),
        sources: vec![
            SourceReport {
                registration: registered(),
                ..source(0, "radar-west", 1_234)
            },
            source(1, "ads-b", 20_345),
        ],
        losses: Losses {
            complete: true,
            hops: vec![
                Hop::new("radar-west", "fusion", 1_234, 1_234, 0),
                Hop::new("ads-b", "fusion", 20_345, 20_345, 0),
                Hop::new("fusion", "monitor", 21_000, 21_000, 0),
            ],
            ..Losses::default()
        },
        latency_remark: None,
        stages: Stage::ALL.map(stage).to_vec(),
        picture: TrackCounts {
            confirmed: 78,
            coasted: 2,
            tentative: 1,
            suspended: 4,
            live_max: 80,
            started: 85,
            ever_confirmed: 82,
            ended: 4,
            resumed: 9,
            merged: 3,
            split: 1,
            hand_overs: 12_345,
        },
        accuracy: Some(AccuracyReport {
            pictures: 10,
            targets: 79.9,
            held_once_share: 0.99,
            missed_share: 0.004,
            duplicates: 0.5,
            false_tracks: 0.1,
            identity_errors: 0,
            errors: 790,
            mean_m: 10.0,
            rms_m: 12.34,
            p95_m: 30.0,
            max_m: 210.0,
        }),
        restarts: Restarts::default(),
        alarms: Vec::new(),
        processes: vec![
            process(ProcessKind::Adapter, "radar-west"),
            process(ProcessKind::Adapter, "ads-b"),
            process(ProcessKind::Fusion, "fusion"),
            process(ProcessKind::Monitor, "monitor"),
        ],
        fusion: Counters::default()
            .with(Counter::Taken, 21_579)
            .with(Counter::Published, 21_000),
        others: Vec::new(),
        monitor: Counters::default().with(Counter::Taken, 21_000),
        network: vec![ProcessCounters {
            process: "adapter ads-b".to_owned(),
            counters: Counters::default().with(Counter::Datagrams, 4_321),
        }],
        refused: Vec::new(),
        health_rejected: 0,
    })
}

/// A recording during which nearly everything went wrong.
fn bad() -> Report {
    let mut report = good();
    report.settings.order = "time";
    report.settings.recorded_sources = 2;
    report.settings.simulated_sources = 0;
    report.settings.speed = Some("max".to_owned());
    report.settings.latencies_measured = false;
    (report.settings.seed, report.settings.targets) = (None, None);
    report.recording_reached_utc_ns = Some(1_462_917_600_000_000_000);
    report.accuracy = None;
    report.sources[0].fusion = Counters::default();
    report.losses = Losses {
        complete: true,
        reports_lost: 40,
        reports_unread: 1_239,
        hops: vec![
            Hop::new("radar-west", "fusion", 1_234, 0, 0),
            Hop::new("ads-b", "fusion", 20_345, 20_300, 40),
            Hop::new("fusion", "recorder", 21_000, 20_990, 10),
            Hop::new("fusion", "monitor", 21_000, 19_000, 2_000),
        ],
        monitor_missed: 2_000,
    };
    report.processes[0].state = ProcessState::Silent { for_ns: 3_200_000_000 };
    report.processes[2].restarts = 2;
    report.processes[2].last_end = "was killed by SIGKILL".to_owned();
    report.processes[2].note = "core 1 is shared".to_owned();
    report.restarts = Restarts {
        total: 2,
        by_process: BTreeMap::from([("fusion".to_owned(), 2)]),
    };
    report.fusion = report.fusion.with(Counter::DroppedTable, 7);
    let at_socket = report.network[0].counters;
    report.network[0].counters = at_socket
        .with(Counter::DatagramsDropped, 17)
        .with(Counter::DatagramsRejected, 1_000)
        .with(Counter::SendFailures, 2);
    report.health_rejected = 4;
    report.refused = vec![RefusedInput {
        of: "radar-west".to_owned(),
        text: "07:08:09: line 2, column px: \"\" is empty; write a number".to_owned(),
    }];
    judged(report)
}

/// Watched by a monitor that polls, with deadlines that are missed, and with everything counted that can be.
fn polled() -> Report {
    let mut report = good();
    report.settings.wait = "hybrid";
    (report.settings.monitor_wait, report.settings.monitor_poll_ms) = ("poll", Some(5.0));
    for (stage, figures) in &mut report.stages {
        match stage {
            Stage::FusedToReceived => *figures = StageReport::default(),
            Stage::TakenToFused => figures.deadline_misses = 3,
            Stage::EndToEnd => (figures.deadline_us, figures.deadline_misses) = (Some(400.0), 2_200),
            _ => {}
        }
    }
    report.sources[1].stages = source_stages(SUMMARY, 3);
    report.fusion = report
        .fusion
        .with(Counter::DeadlineMisses, 4)
        .with(Counter::OrdersObeyed, 1);
    let fusion = report.sources[0].fusion;
    report.sources[0].fusion = fusion
        .with(Counter::RejectedExtrapolated, 8)
        .with(Counter::DroppedQueue, 6)
        .with(Counter::RejectedOutOfOrder, 5)
        .with(Counter::CovariancesRepaired, 2);
    report.sources[1].recorder = Counters::default().with(Counter::RejectedSchema, 1);
    let adapter = report.sources[0].adapter;
    report.sources[0].adapter = adapter
        .with(Counter::BlocksRejected, 4)
        .with(Counter::BytesRejected, 180)
        .with(Counter::ServiceMessages, 7)
        .with(Counter::TracksEnded, 2);
    let others = [
        ("recorder", Counter::RowsWritten, 12_345),
        ("adapter ship", Counter::SentencesOther, 12),
        ("adapter ship", Counter::SentencesChecksum, 3),
        ("gateway picture", Counter::RejectedNoTrackNumber, 1),
    ];
    report.others = others
        .map(|(process, counter, count)| ProcessCounters {
            process: process.to_owned(),
            counters: Counters::default().with(counter, count),
        })
        .to_vec();
    report.monitor = report.monitor.with(Counter::RejectedOutOfOrder, 9);
    judged(report)
}

/// Nothing ever happened.
fn empty() -> Report {
    let mut report = good();
    for source in &mut report.sources {
        (source.adapter, source.fusion) = (Counters::default(), Counters::default());
        source.stages = source_stages(Summary::default(), 0);
    }
    report.losses.hops.clear();
    report.network[0].counters = Counters::default();
    for (_, figures) in &mut report.stages {
        figures.summary = Summary::default();
    }
    (report.picture, report.fusion) = (TrackCounts::default(), Counters::default());
    report.accuracy = Some(scoring::AccuracySums::default().report());
    for process in &mut report.processes {
        process.state = ProcessState::NotHeard;
    }
    judged(report)
}

#[test]
fn a_good_run() {
    golden::assert("report_good.txt", &good().text(WIDTH));
}

#[test]
fn a_bad_run() {
    golden::assert("report_bad.txt", &bad().text(WIDTH));
}

#[test]
fn a_run_watched_by_polling() {
    golden::assert("report_poll.txt", &polled().text(WIDTH));
}

#[test]
fn a_run_without_a_single_report() {
    golden::assert("report_empty.txt", &empty().text(WIDTH));
}

#[test]
fn what_is_allowed_of_a_live_run_is_not_of_a_recording() {
    let mut report = good();
    report.losses.reports_unread = 3;
    assert!(verdict::on(&report).fine);
    report.settings.simulated_sources = 0;
    assert!(!verdict::on(&report).fine);
}

#[test]
fn waiting_for_each_other_is_not_late() {
    let mut report = good();
    (report.settings.order, report.settings.speed) = ("time", Some("5".to_owned()));
    let text = report.text(WIDTH);
    assert!(text.contains("DEADLINES: none. Reports wait for each other"), "{text}");
}

#[test]
fn a_restarted_monitor_does_not_accuse_others_of_what_it_has_not_seen() {
    let mut report = good();
    report.losses.complete = false;
    report.losses.reports_unread = 15_000;
    report.processes[3].restarts = 1;
    let verdict = verdict::on(&report);
    assert_eq!(
        verdict.sentence,
        "Worth a look: monitor was restarted once, so this report speaks of the time since then only."
    );
    assert!(report.text(WIDTH).contains("The monitor was restarted"));
}

#[test]
fn poor_accuracy_and_missed_deadlines_are_worth_a_look() {
    let mut report = good();
    report.fusion = report.fusion.with(Counter::DeadlineMisses, 2_100);
    if let Some(accuracy) = &mut report.accuracy {
        (accuracy.held_once_share, accuracy.identity_errors) = (0.9, 2);
    }
    assert_eq!(
        verdict::on(&report).sentence,
        "Worth a look: 10.0 % of the states took longer through fusion than 1.00 ms; only 90.0 % of the targets in view \
         were held by exactly one system track; system tracks carried a wrong address twice."
    );
}

#[test]
fn a_sensor_of_a_tracker_is_no_source_of_fusion() {
    let mut report = good();
    report.sources.push(SourceReport {
        sensor_of: Some(0),
        fusion: Counters::default(),
        states: 0,
        ..source(2, "sea.radar", 178)
    });
    report.sources[2].adapter[Counter::Detections] = 178;
    let report = judged(report);
    let text = report.text(200);
    let row = text.lines().find(|line| line.starts_with("sea.radar")).unwrap();
    assert_eq!(
        row.split_whitespace().collect::<Vec<_>>(),
        ["sea.radar", "183", "5", "178", "-", "-"]
    );
    let latencies = text.split("LATENCY of").nth(1).unwrap();
    assert!(!latencies.contains("sea.radar"), "{latencies}");
    assert!(report.verdict.fine, "{}", report.verdict.sentence);
    // One that sends nothing is named.
    let mut silent = report;
    silent.sources[2].adapter = Counters::default();
    assert_eq!(
        judged(silent).verdict.sentence,
        "Worth a look: sea.radar delivered nothing."
    );
}

#[test]
fn every_report_has_every_member() {
    let members = |report: &Report| {
        let mut names = Vec::new();
        collect("", &serde_json::to_value(report).unwrap(), &mut names);
        names
    };
    let (good, empty) = (members(&good()), members(&empty()));
    // Hops are those that there are, and counters those that count something.
    let of_counters = |name: &str| {
        Counter::ALL
            .iter()
            .any(|counter| name.ends_with(&format!(".{}", counter.label())))
    };
    let always = |names: &[String]| -> Vec<String> {
        let kept = names
            .iter()
            .filter(|name| !name.starts_with(".losses.hops") && !of_counters(name));
        kept.cloned().collect()
    };
    assert_eq!(always(&good), always(&empty));
    let counted = |names: &[String]| names.iter().filter(|name| name.contains(".adapter.")).count();
    assert_eq!((counted(&good), counted(&empty)), (8, 0));
    for expected in [
        ".duration_s",
        ".settings.deployment",
        ".sources.0.name",
        ".sources.0.adapter.rejected_jump",
        ".sources.0.fusion.taken",
        ".sources.0.registration.gross_error",
        ".sources.0.registration.clock_offset_s",
        ".sources.0.joint_states",
        ".sources.0.stages.end_to_end.p50_ns",
        ".stages.ingest_to_publish.count",
        ".stages.fused_to_received.p999_ns",
        ".stages.age.max_ns",
        ".stages.fused_to_received.measured",
        ".stages.end_to_end.deadline_us",
        ".stages.end_to_end.deadline_misses",
        ".sources.0.stages.taken_to_fused.deadline_misses",
        ".settings.monitor_wait",
        ".monitor.taken",
        ".losses.reports_lost",
        ".losses.hops.0.unread",
        ".restarts.total",
        ".picture.hand_overs",
        ".accuracy.rms_m",
        ".verdict.fine",
        ".processes.0.state",
    ] {
        assert!(good.iter().any(|name| name == expected), "{expected}");
    }
}

fn collect(path: &str, value: &serde_json::Value, names: &mut Vec<String>) {
    match value {
        serde_json::Value::Object(members) => {
            for (name, member) in members {
                collect(&format!("{path}.{name}"), member, names);
            }
        }
        serde_json::Value::Array(items) => {
            for (index, item) in items.iter().enumerate() {
                collect(&format!("{path}.{index}"), item, names);
            }
        }
        _ => names.push(path.to_owned()),
    }
}
