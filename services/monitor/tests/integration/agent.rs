//! The monitor as an agent, turn by turn, over the in-process transport and with a clock that the test sets.

use std::io::Write;
use std::path::Path;
use std::rc::Rc;

use crate::watched::{Bench, Config, RECORDED, S, UTC_NS};
use bus::{Bus, InProcess, WaitMode, Waiter};
use configuration::BUILT_IN_DEMO;
use hdrhistogram::Histogram;
use hdrhistogram::serialization::Deserializer;
use hdrhistogram::serialization::interval_log::{IntervalLogIterator, LogEntry};
use messages::{Counter, Health, LifeState, NO_SOURCE, ProcessKind, SystemTrack};
use monitor::{MonitorAgent, Screen};
use runtime::{Agent, Options, Speed, Turn};
use serde_json::Value;

#[test]
fn stages_are_those_of_the_messages() {
    let mut bench = Bench::new(&["monitor.files=true"]);
    bench.fuse(0, 100, 1_000);
    bench.fuse(3, 200, 1_000);
    bench.turn();
    bench.close();
    let report = bench.report();
    for (stage, expected_ns) in [
        ("ingest_to_publish", 1_000),
        ("publish_to_taken", 1_000),
        ("taken_to_fused", 1_000),
        ("fused_to_received", 1_000),
        ("end_to_end", 4_000),
        ("age", 100_000),
    ] {
        let figures = &report["stages"][stage];
        assert_eq!(figures["count"], 300, "{stage}");
        for figure in ["p50_ns", "p90_ns", "p99_ns", "p999_ns", "max_ns"] {
            let value = figures[figure].as_u64().unwrap();
            assert!(
                value.abs_diff(expected_ns) * 1000 <= expected_ns,
                "{stage} {figure} {value}"
            );
        }
    }
    assert_eq!(report["sources"][0]["stages"]["end_to_end"]["count"], 100);
    assert_eq!(report["sources"][3]["stages"]["end_to_end"]["count"], 200);
    assert_eq!(report["sources"][1]["stages"]["end_to_end"]["count"], 0);
}

#[test]
fn each_slice_is_stamped_when_it_is_taken() {
    let mut bench = Bench::new(&["monitor.files=true"]);
    bench.fuse(0, 1, 1_000);
    // The clock that stamps goes on after the turn's own time was read.
    let turn_began = bench.clock.get();
    bench.pass(5_000_000);
    bench.monitor.turn(turn_began).unwrap();
    bench.close();
    let received = bench.report()["stages"]["fused_to_received"]["p50_ns"]
        .as_u64()
        .unwrap();
    assert!(received.abs_diff(5_001_000) <= 5_001, "{received}");
}

#[test]
fn arrivals_are_accounted_for_hop_by_hop() {
    let mut bench = Bench::new(&["monitor.files=true", "recorder.enabled=true"]);
    let (adapter, fusion, recorder) = (ProcessKind::Adapter, ProcessKind::Fusion, ProcessKind::Recorder);
    let rejected = (Counter::RejectedJump, 4);
    bench.say(adapter, "radar-west", NO_SOURCE, &[(Counter::Published, 100), rejected]);
    bench.say(adapter, "ads-b", NO_SOURCE, &[(Counter::Published, 500)]);
    bench.say(fusion, "fusion", 0, &[(Counter::Taken, 100)]);
    bench.say(fusion, "fusion", 3, &[(Counter::Taken, 450), (Counter::Lost, 30)]);
    bench.say(fusion, "fusion", NO_SOURCE, &[(Counter::Published, 70)]);
    bench.say(
        recorder,
        "recorder",
        NO_SOURCE,
        &[(Counter::Taken, 60), (Counter::Lost, 10)],
    );
    bench.fuse(0, 70, 1_000);
    bench.turn();
    let text = bench.close();
    let report = bench.report();
    let hop = |from: &str, to: &str| {
        let hops = report["losses"]["hops"].as_array().unwrap();
        let hop = hops.iter().find(|hop| hop["from"] == from && hop["to"] == to).unwrap();
        ["published", "taken", "lost", "unread"].map(|key| hop[key].as_u64().unwrap())
    };
    assert_eq!(hop("radar-west", "fusion"), [100, 100, 0, 0]);
    assert_eq!(hop("ads-b", "fusion"), [500, 450, 30, 20]);
    assert_eq!(hop("fusion", "recorder"), [70, 60, 10, 0]);
    assert_eq!(hop("fusion", "monitor"), [70, 70, 0, 0]);
    assert_eq!(
        (&report["losses"]["reports_lost"], &report["losses"]["reports_unread"]),
        (&30.into(), &20.into())
    );
    assert_eq!(report["sources"][0]["adapter"]["rejected_jump"], 4);
    assert_eq!(report["verdict"]["fine"], false);
    let verdict = bench.verdict();
    assert!(verdict.contains("30 reports did not reach fusion"), "{verdict}");
    assert!(verdict.contains("the recorder missed 10 samples"), "{verdict}");
    let listed = text.matches(Counter::RejectedJump.sentence()).count();
    assert_eq!(listed, 1, "for the source, not for its adapter again: {text}");
}

#[test]
fn what_only_the_monitor_missed_is_kept_apart() {
    let mut bench = Bench::new(&["monitor.files=true"]);
    let depth = messages::system_tracks().capacity.depth;
    for _ in 0..depth + 3 {
        bench.fuse(0, 2, 1_000);
    }
    while bench.turn() == Turn::Worked {}
    let own = bench.own_health();
    assert_eq!(own.counters[Counter::Taken], 2 * depth as u64);
    assert_eq!(own.counters[Counter::Lost], 6);
    bench.close();
    let report = bench.report();
    assert_eq!(report["losses"]["monitor_missed"], 6);
    assert_eq!(report["losses"]["reports_lost"], 0);
}

#[test]
fn states_of_a_fusion_that_has_been_replaced_are_rejected_and_counted() {
    let mut bench = Bench::new(&[]);
    let fusion = |epoch: u64| {
        let publisher = bench.bus.publisher(&messages::system_tracks(), epoch).unwrap();
        publisher.with_epoch(epoch)
    };
    let mut fusions = [fusion(1), fusion(2)];
    for speaks in [0, 1, 0] {
        let state = |_, sequence| SystemTrack {
            sequence,
            ..SystemTrack::default()
        };
        fusions[speaks].send(bench.mark(), 2, state).unwrap();
        while bench.turn() == Turn::Worked {}
    }
    let counted = [Counter::Taken, Counter::RejectedEpoch, Counter::Lost];
    let counters = bench.own_health().counters;
    assert_eq!(counted.map(|counter| counters[counter]), [4, 2, 0]);
}

#[test]
fn restarts_are_seen_in_new_incarnations_and_in_the_launchers_words() {
    let mut bench = Bench::new(&["monitor.files=true"]);
    let fusion = ProcessKind::Fusion;
    bench.say(fusion, "fusion", 0, &[(Counter::Taken, 100)]);
    bench.turn();
    bench.say_as(101 * S as u64, fusion, "fusion", 0, &[(Counter::Taken, 20)]);
    let of_child = Health {
        kind: ProcessKind::Launcher as u8,
        life: LifeState::Running as u8,
        restarts: 2,
        source: 1,
        said_ns: bench.clock.get().mono_ns,
        ..Health::default()
    };
    bench.send_health(of_child.with_name("radar-east").with_note("was killed by SIGKILL"));
    bench.turn();
    bench.close();
    let report = bench.report();
    let expected = serde_json::json!({
        "total": 3, "by_process": { "adapter radar-east": 2, "fusion": 1 }
    });
    assert_eq!(report["restarts"], expected);
    assert_eq!(
        report["sources"][0]["fusion"]["taken"], 120,
        "counted on across the restart"
    );
    let verdict = bench.verdict();
    let expected = "adapter radar-east was restarted twice (the last time because it was killed by SIGKILL)";
    assert!(verdict.contains(expected), "{verdict}");
}

#[test]
fn health_that_cannot_be_understood_is_ignored_and_counted() {
    let mut bench = Bench::new(&["monitor.files=true"]);
    let odd = Health {
        kind: 200,
        ..Health::default()
    };
    bench.send_health(odd.with_name("fusion"));
    bench.say(ProcessKind::Fusion, "fusion", 99, &[(Counter::Taken, 5)]);
    bench.turn();
    assert_eq!(bench.own_health().counters[Counter::RejectedInvalid], 2);
    bench.close();
    let report = bench.report();
    assert_eq!(report["health_rejected"], 2);
    let fusion = report["processes"]
        .as_array()
        .unwrap()
        .iter()
        .find(|process| process["kind"] == "fusion");
    assert_eq!(fusion.unwrap()["state"], "not heard from");
}

#[test]
fn a_line_is_shown_per_interval() {
    let mut bench = Bench::new(&[]);
    bench.pass(500_000_000);
    bench.say(ProcessKind::Fusion, "fusion", 0, &[(Counter::Taken, 100)]);
    bench.turn();
    assert_eq!(bench.text(), "");
    bench.pass(500_000_000);
    bench.turn();
    bench.pass(S);
    bench.say(ProcessKind::Fusion, "fusion", 0, &[(Counter::Taken, 250)]);
    bench.fuse(0, 150, 1_000);
    bench.turn();
    let text = bench.text();
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines.len(), 2, "{text}");
    assert!(
        lines[0].starts_with("22:13:21  test | 1 s | 200 reports/s | "),
        "{text}"
    );
    // 150 reports in the 1.5 s between fusion's own words.
    assert!(
        lines[1].starts_with("22:13:22  test | 2 s | 100 reports/s | "),
        "{text}"
    );
    assert!(lines[1].contains("end to end p50 4.00 µs"), "{text}");
}

#[test]
fn turns_end_no_later_than_the_interval() {
    let mut bench = Bench::new(&[]);
    bench.pass(960_000_000);
    let Turn::Idle(at_most) = bench.turn() else {
        panic!("nothing to do")
    };
    assert_eq!(at_most.as_millis(), 40);
}

#[test]
fn files_are_complete_without_a_single_report() {
    let mut bench = Bench::new(&["monitor.files=true"]);
    bench.pass(S);
    bench.turn();
    bench.close();
    let report = bench.report();
    assert_eq!(report["stages"]["end_to_end"]["count"], 0);
    assert_eq!(report["accuracy"]["pictures"], 0);
    assert_eq!(report["restarts"]["total"], 0);
    assert_eq!(report["sources"].as_array().unwrap().len(), 5);
    assert_eq!(report["duration_s"], 1.0);
    let log = bench.out("latency.hlog");
    assert_eq!(
        log.matches("Tag=end_to_end,").count(),
        1,
        "the first of two silent intervals: {log}"
    );
    for stage in ["ingest_to_publish", "end_to_end", "age"] {
        assert!(
            bench
                .out(&format!("latency_{stage}.hgrm"))
                .contains("Total count    =            0")
        );
    }
    assert!(bench.verdict().contains("fusion did not receive a single report"));
}

#[test]
fn the_log_names_sources() {
    let mut bench = Bench::new(&["monitor.files=true"]);
    bench.fuse(3, 10, 1_000);
    bench.pass(S);
    bench.turn();
    assert!(
        bench.out("latency.hlog").contains("Tag=end_to_end/ads-b,0.000,1.000,"),
        "on disk at once"
    );
}

#[test]
fn nothing_is_written_unless_configured() {
    let mut bench = Bench::new(&[]);
    bench.close();
    assert!(!bench.folder.path().join("out").exists());
}

#[test]
fn the_picture_is_compared_with_the_truth_once_a_second() {
    let mut bench = Bench::new(&["monitor.files=true"]);
    for _ in 0..125 {
        bench.pass(100_000_000);
        bench.fuse(0, 1, 1_000);
        bench.turn();
    }
    bench.close();
    let accuracy = &bench.report()["accuracy"];
    assert_eq!(accuracy["pictures"], 3, "after 10, 11 and 12 s");
    assert_eq!(accuracy["targets"], 80.0);
}

#[test]
fn recordings_as_fast_as_possible_have_no_latencies() {
    let config = tempfile::NamedTempFile::new().unwrap();
    std::fs::write(config.path(), RECORDED).unwrap();
    let mut bench = Bench::with(&[], Speed::Max, config.path());
    bench.fuse(0, 10, 1_000);
    bench.turn();
    let text = bench.close();
    let report = bench.report();
    assert_eq!(report["settings"]["latencies_measured"], false);
    assert_eq!(report["stages"]["end_to_end"]["count"], 0);
    assert_eq!(report["accuracy"], Value::Null);
    assert_eq!(
        report["losses"]["hops"].as_array().unwrap().last().unwrap()["taken"],
        10
    );
    assert!(text.contains("LATENCY: not measured"), "{text}");
}

#[test]
fn what_waits_by_intention_is_not_late() {
    let config = tempfile::NamedTempFile::new().unwrap();
    std::fs::write(config.path(), RECORDED).unwrap();
    for (order, late) in [("time", 0), ("arrival", 10)] {
        let order_key = format!("time.order=\"{order}\"");
        let mut bench = Bench::with(&[&order_key], Speed::Factor(5.0), config.path());
        bench.fuse(0, 10, 5_000_000);
        bench.pass(S);
        bench.turn();
        assert_eq!(bench.own_health().counters[Counter::StagesLate], late, "{order}");
    }
}

#[test]
fn the_end_of_the_others_is_waited_for() {
    let mut bench = Bench::new(&["monitor.files=true"]);
    let fusion = Health {
        kind: ProcessKind::Fusion as u8,
        life: LifeState::Running as u8,
        said_ns: bench.clock.get().mono_ns,
        ..Health::default()
    }
    .with_name("fusion");
    bench.send_health(fusion);
    bench.turn();
    // Its last words are on their way.
    bench.say(ProcessKind::Fusion, "fusion", NO_SOURCE, &[(Counter::Published, 7)]);
    bench.fuse(0, 7, 1_000);
    bench.close();
    let report = bench.report();
    assert_eq!(report["losses"]["hops"].as_array().unwrap().last().unwrap()["taken"], 7);
    assert_eq!(report["fusion"]["published"], 7);
}

#[test]
fn readers_that_have_gone_do_not_end_it_and_a_full_disk_is_said() {
    struct Gone(std::io::ErrorKind);
    impl Write for Gone {
        fn write(&mut self, _: &[u8]) -> std::io::Result<usize> {
            Err(self.0.into())
        }
        fn flush(&mut self) -> std::io::Result<()> {
            Ok(())
        }
    }
    let bench = Bench::new(&[]);
    let config = Config::read(Path::new(BUILT_IN_DEMO), &[]).unwrap();
    let options = Options {
        overrides: Vec::new(),
        instance: "test".to_owned(),
        data: "data".into(),
        out: "out".into(),
        speed: Speed::Factor(1.0),
        seed: 1,
        scenario_start_ns: UTC_NS,
        launcher: None,
    };
    use std::io::ErrorKind::{BrokenPipe, Other, StorageFull};
    for (error, terminal, said) in [
        (BrokenPipe, false, false),
        (Other, true, false),
        (StorageFull, false, true),
    ] {
        let clock = Rc::clone(&bench.clock);
        let screen = Screen::new(Box::new(Gone(error)), terminal);
        let reads = Box::new(move || clock.get());
        let mut second = MonitorAgent::new(
            (&config, &config.parts.monitor),
            &options,
            "second",
            &bench.bus,
            reads,
            screen,
        )
        .unwrap();
        bench.pass(2 * S);
        second.turn(bench.clock.get()).unwrap();
        assert_eq!(second.close(bench.clock.get()).is_err(), said, "{error}");
    }
}

/// How many listeners still find a place on the topic of system tracks.
fn free_listeners(bus: &Bus<InProcess>) -> usize {
    let topic = messages::system_tracks();
    let mut waiters: Vec<Waiter<InProcess>> = Vec::new();
    loop {
        let mut waiter = bus.waiter(WaitMode::Event);
        if waiter.watch(bus, &topic).is_err() {
            return waiters.len();
        }
        waiters.push(waiter);
    }
}

#[test]
fn a_monitor_that_polls_is_no_listener_of_fusion() {
    let places = messages::system_tracks().capacity.subscribers;
    assert_eq!(free_listeners(&Bench::new(&["monitor.wait=event"]).bus), places - 1);
    assert_eq!(free_listeners(&Bench::new(&["monitor.wait=poll"]).bus), places);
    assert_eq!(
        free_listeners(&Bench::new(&["fusion.wait=hybrid"]).bus),
        places,
        "the default where fusion spins"
    );
}

#[test]
fn a_monitor_that_polls_sleeps_between_its_looks_though_much_has_come() {
    let mut bench = Bench::new(&["monitor.wait=poll", "monitor.poll_ms=2.5"]);
    bench.fuse(0, 100, 1_000);
    let Turn::Idle(at_most) = bench.turn() else {
        panic!("all has been taken")
    };
    assert_eq!(at_most.as_micros(), 2_500);
    // What has come meanwhile does not end the pause: asked for a pause of nothing, it takes nothing.
    bench.fuse(0, 100, 1_000);
    bench.monitor.wait(std::time::Duration::ZERO).unwrap();
    assert_eq!(bench.own_health().counters[Counter::Taken], 100);
}

#[test]
fn the_pause_of_a_monitor_that_polls_is_not_measured() {
    let mut bench = Bench::new(&["monitor.wait=poll", "monitor.files=true"]);
    bench.fuse(0, 10, 1_000);
    bench.pass(4_000_000);
    bench.turn();
    let text = bench.close();
    let report = bench.report();
    let near = |stage: &str, expected_ns: u64| {
        let value = report["stages"][stage]["p50_ns"].as_u64().unwrap();
        assert!(value.abs_diff(expected_ns) * 1000 <= expected_ns, "{stage} {value}");
    };
    near("taken_to_fused", 1_000);
    near("end_to_end", 3_000);
    near("age", 99_000);
    let transport_out = &report["stages"]["fused_to_received"];
    assert_eq!(
        (&transport_out["measured"], &transport_out["count"]),
        (&false.into(), &0.into())
    );
    assert_eq!(report["settings"]["monitor_wait"], "poll");
    let remark = report["latency_remark"].as_str().unwrap();
    assert!(remark.starts_with("transport out is not measured"), "{remark}");
    assert_eq!(report["settings"]["monitor_poll_ms"], 5.0);
    assert!(
        text.contains("transport out is not measured: the monitor polls"),
        "{text}"
    );
    assert!(!bench.out("latency.hlog").contains("fused_to_received"));
    assert!(!bench.folder.path().join("out/latency_fused_to_received.hgrm").exists());
}

#[test]
fn missed_deadlines_are_counted_by_stage_and_source() {
    let mut bench = Bench::new(&[
        "monitor.files=true",
        "fusion.deadline_us=10",
        "monitor.deadline_us.end_to_end=30",
        "monitor.deadline_us.age=5000",
    ]);
    bench.fuse(0, 20, 1_000);
    bench.fuse(3, 10, 9_000);
    bench.fuse(3, 5, 11_000);
    bench.turn();
    bench.pass(S);
    bench.turn();
    let own = bench.own_health();
    assert_eq!(own.counters[Counter::DeadlineMisses], 5);
    assert_eq!(own.counters[Counter::StagesLate], 5 + 15);
    bench.close();
    let report = bench.report();
    let stage = |stage: &str| &report["stages"][stage];
    assert_eq!(
        (
            &stage("taken_to_fused")["deadline_us"],
            &stage("taken_to_fused")["deadline_misses"]
        ),
        (&10.0.into(), &5.into())
    );
    assert_eq!(
        (
            &stage("end_to_end")["deadline_us"],
            &stage("end_to_end")["deadline_misses"]
        ),
        (&30.0.into(), &15.into())
    );
    assert_eq!(
        (
            &stage("age")["deadline_misses"],
            &stage("publish_to_taken")["deadline_us"]
        ),
        (&0.into(), &Value::Null)
    );
    let of_source = |source: usize| &report["sources"][source]["stages"]["end_to_end"]["deadline_misses"];
    assert_eq!((of_source(0), of_source(3)), (&0.into(), &15.into()));
    let verdict = bench.verdict();
    assert!(
        verdict.contains("42.9 % of the states missed a deadline: end to end took longer than 30.0 µs"),
        "{verdict}"
    );
}

#[test]
fn what_each_source_missed_is_said_in_health_messages() {
    let mut bench = Bench::new(&["fusion.deadline_us=10"]);
    bench.fuse(3, 7, 20_000);
    bench.turn();
    bench.pass(S);
    bench.turn();
    let mut entries = Vec::new();
    bench.monitor.health(&mut entries);
    let of_source = entries.iter().find(|entry| entry.source == 3).unwrap();
    assert_eq!(of_source.counters[Counter::DeadlineMisses], 7);
    assert_eq!(entries.len(), 2);
}

/// The histogram of all intervals of one tag in a log.
fn logged(log: &str, tag: &str) -> Histogram<u64> {
    use base64::Engine as _;
    let mut sum = Histogram::new(3).unwrap();
    for entry in IntervalLogIterator::new(log.as_bytes()) {
        if let LogEntry::Interval(line) = entry.unwrap()
            && line.tag().unwrap().as_str() == tag
        {
            let encoded = line.encoded_histogram();
            let bytes = base64::engine::general_purpose::STANDARD.decode(encoded).unwrap();
            let interval: Histogram<u64> = Deserializer::new().deserialize(&mut bytes.as_slice()).unwrap();
            sum.add(interval).unwrap();
        }
    }
    sum
}

#[test]
fn files_hold_every_stage_and_source_and_agree_with_the_report() {
    let mut bench = Bench::new(&["monitor.files=true"]);
    for unit_ns in 1..=50 {
        bench.fuse(0, 2, 1_000 * unit_ns);
        bench.fuse(3, 3, 7_000 * unit_ns);
        bench.pass(100_000_000);
        bench.turn();
    }
    bench.close();
    let (log, report) = (bench.out("latency.hlog"), bench.report());
    let stages = [
        "ingest_to_publish",
        "publish_to_taken",
        "taken_to_fused",
        "fused_to_received",
        "end_to_end",
        "age",
    ];
    for stage in stages {
        let of_source = |index: usize| report["sources"][index]["stages"][stage].clone();
        for (tag, file, figures) in [
            (
                stage.to_owned(),
                format!("latency_{stage}.hgrm"),
                report["stages"][stage].clone(),
            ),
            (
                format!("{stage}/radar-west"),
                format!("latency_{stage}_radar-west.hgrm"),
                of_source(0),
            ),
            (
                format!("{stage}/ads-b"),
                format!("latency_{stage}_ads-b.hgrm"),
                of_source(3),
            ),
        ] {
            let histogram = logged(&log, &tag);
            assert_eq!(figures["count"], histogram.len(), "{tag}");
            assert_eq!(figures["p99_ns"], histogram.value_at_quantile(0.99), "{tag}");
            assert_eq!(figures["max_ns"], histogram.max(), "{tag}");
            let text = bench.out(&file);
            let last = text.lines().rfind(|line| line.contains(" 1.000000000000 ")).unwrap();
            let words: Vec<f64> = last.split_whitespace().map(|word| word.parse().unwrap()).collect();
            assert_eq!(words[0], (histogram.max() as f64).round() / 1e3, "{file}, microseconds");
            assert_eq!(words[2], histogram.len() as f64, "{file}");
        }
    }
    assert!(
        !bench.folder.path().join("out/latency_age_radar-east.hgrm").exists(),
        "it did not report"
    );
}
