//! The monitor as an agent, turn by turn, over the in-process transport and with a clock that the test sets.

use std::cell::Cell;
use std::io::Write;
use std::path::Path;
use std::rc::Rc;
use std::sync::{Arc, Mutex};

use bus::{Bus, Held, InProcess, Mark, Publisher, Root};
use messages::{Counter, Health, LifeState, NO_SOURCE, ProcessKind, StageTimes, SystemTrack, TrackState};
use monitor::{MonitorAgent, Screen};
use runtime::config::BUILT_IN_DEMO;
use runtime::{Agent, Config, HealthEntry, Now, Options, Speed, Turn};
use serde_json::Value;

const S: i64 = 1_000_000_000;
const UTC_NS: i64 = 1_700_000_000 * S;

/// Where the monitor's text goes.
#[derive(Clone, Default)]
struct Paper(Arc<Mutex<Vec<u8>>>);

impl Write for Paper {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.0.lock().unwrap().write(bytes)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

/// A monitor, and the processes that it watches.
struct Bench {
    monitor: MonitorAgent<InProcess>,
    clock: Rc<Cell<Now>>,
    paper: Paper,
    bus: Bus<InProcess>,
    tracks: Publisher<InProcess, SystemTrack>,
    health: Publisher<InProcess, Health>,
    folder: tempfile::TempDir,
    _held: [Held; 2],
}

impl Bench {
    /// Of the demonstration, changed by `overrides`.
    fn new(overrides: &[&str]) -> Self {
        Self::with(overrides, Speed::Factor(1.0), Path::new(BUILT_IN_DEMO))
    }

    fn with(overrides: &[&str], speed: Speed, config: &Path) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let overrides: Vec<String> = overrides.iter().map(|each| (*each).to_owned()).collect();
        let config = Config::read(config, &overrides).unwrap();
        let root = Root::in_base(folder.path(), "test").unwrap();
        let bus: Bus<InProcess> = Bus::open(&root, "test").unwrap();
        let held = [
            bus.hold(&messages::system_tracks()).unwrap(),
            bus.hold(&messages::health()).unwrap(),
        ];
        let options = Options {
            overrides: Vec::new(),
            instance: "test".to_owned(),
            data: folder.path().into(),
            out: folder.path().join("out"),
            speed,
            seed: 1,
            scenario_start_ns: UTC_NS,
            launcher: None,
        };
        let clock = Rc::new(Cell::new(Now {
            mono_ns: 100 * S,
            utc_ns: UTC_NS,
        }));
        let (paper, reading) = (Paper::default(), Rc::clone(&clock));
        let screen = Screen::new(Box::new(paper.clone()), false);
        let reads = Box::new(move || reading.get());
        let monitor = MonitorAgent::new(&config, &options, "monitor", &bus, reads, screen).unwrap();
        Self {
            monitor,
            clock,
            paper,
            tracks: bus.publisher(&messages::system_tracks(), 100 * S as u64).unwrap(),
            health: bus.publisher(&messages::health(), 100 * S as u64).unwrap(),
            bus,
            folder,
            _held: held,
        }
    }

    fn pass(&self, ns: i64) {
        let now = self.clock.get();
        self.clock.set(Now {
            mono_ns: now.mono_ns + ns,
            utc_ns: now.utc_ns + ns,
        });
    }

    fn turn(&mut self) -> Turn {
        self.monitor.turn(self.clock.get()).unwrap()
    }

    fn mark(&self) -> Mark {
        Mark {
            progress_ns: i64::MIN,
            sent_ns: self.clock.get().mono_ns,
            end: false,
        }
    }

    /// One process says how it is.
    fn say(&mut self, kind: ProcessKind, name: &str, source: u16, counters: &[(Counter, u64)]) {
        self.say_as(100 * S as u64, kind, name, source, counters);
    }

    fn say_as(&mut self, incarnation: u64, kind: ProcessKind, name: &str, source: u16, counters: &[(Counter, u64)]) {
        let mut health = Health {
            said_ns: self.clock.get().mono_ns,
            incarnation,
            source,
            kind: kind as u8,
            life: LifeState::Finished as u8,
            ..Health::default()
        };
        for (counter, value) in counters {
            health.counters[*counter as usize] = *value;
        }
        self.send_health(health.with_name(name));
    }

    fn send_health(&mut self, health: Health) {
        self.health.send(self.mark(), 1, |_, _| health).unwrap();
    }

    /// Fusion publishes `count` states that reports of `source` caused. Every stage took `unit_ns`.
    fn fuse(&mut self, source: u16, count: usize, unit_ns: i64) {
        let now = self.clock.get();
        let state = |index: usize, sequence: u64| SystemTrack {
            sequence,
            trigger_source: source,
            track_number: index as u32 + 1,
            state: TrackState::Confirmed as u8,
            reference_time_ns: now.utc_ns,
            time_of_measurement_ns: now.utc_ns - 100 * unit_ns,
            stages: StageTimes {
                ingested_ns: now.mono_ns - 4 * unit_ns,
                published_ns: now.mono_ns - 3 * unit_ns,
                taken_ns: now.mono_ns - 2 * unit_ns,
                fused_ns: now.mono_ns - unit_ns,
            },
            ..SystemTrack::default()
        };
        self.tracks.send(self.mark(), count, state).unwrap();
    }

    fn close(&mut self) -> String {
        self.monitor.close(self.clock.get()).unwrap();
        self.text()
    }

    fn text(&self) -> String {
        String::from_utf8(self.paper.0.lock().unwrap().clone()).unwrap()
    }

    /// The report's last sentence, without its line breaks.
    fn verdict(&self) -> String {
        let sentence = self.report()["verdict"]["sentence"].as_str().unwrap().to_owned();
        let text: Vec<&str> = sentence.split(' ').collect();
        let shown = self.text();
        let shown: Vec<&str> = shown.split_whitespace().collect();
        assert!(shown.ends_with(&text), "the text ends with the verdict");
        sentence
    }

    fn out(&self, name: &str) -> String {
        std::fs::read_to_string(self.folder.path().join("out").join(name)).unwrap()
    }

    fn report(&self) -> Value {
        serde_json::from_str(&self.out("report.json")).unwrap()
    }

    fn own_health(&self) -> HealthEntry {
        let mut entries = Vec::new();
        self.monitor.health(&mut entries);
        entries.remove(0)
    }
}

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
    assert!(text.contains(Counter::RejectedJump.sentence()), "{text}");
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
    assert_eq!(own.counters[Counter::Taken as usize], 2 * depth as u64);
    assert_eq!(own.counters[Counter::Lost as usize], 6);
    bench.close();
    let report = bench.report();
    assert_eq!(report["losses"]["monitor_missed"], 6);
    assert_eq!(report["losses"]["reports_lost"], 0);
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
    assert_eq!(bench.own_health().counters[Counter::Invalid as usize], 2);
    bench.close();
    let report = bench.report();
    assert_eq!(report["health_ignored"], 2);
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
    assert!(lines[0].starts_with("22:13:21  1 s | 200 reports/s | "), "{text}");
    // 150 reports in the 1.5 s between fusion's own words.
    assert!(lines[1].starts_with("22:13:22  2 s | 100 reports/s | "), "{text}");
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
    assert_eq!(report["sources"].as_array().unwrap().len(), 4);
    assert_eq!(report["duration_s"], 1.0);
    let log = bench.out("latency.hlog");
    assert_eq!(log.matches("Tag=end_to_end,").count(), 2, "{log}");
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
fn readers_that_have_gone_do_not_end_it() {
    struct Gone;
    impl Write for Gone {
        fn write(&mut self, _: &[u8]) -> std::io::Result<usize> {
            Err(std::io::ErrorKind::BrokenPipe.into())
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
    let clock = Rc::clone(&bench.clock);
    let screen = Screen::new(Box::new(Gone), true);
    let reads = Box::new(move || clock.get());
    let mut second = MonitorAgent::new(&config, &options, "second", &bench.bus, reads, screen).unwrap();
    bench.pass(2 * S);
    second.turn(bench.clock.get()).unwrap();
    second.close(bench.clock.get()).unwrap();
}

const RECORDED: &str = r#"name = "recorded"
[frame]
latitude_deg = 41.3
longitude_deg = 2.1
[time]
order = "time"
date = "2016-05-10"
[[source]]
name = "radar"
period_s = 1.0
[source.recorded]
file = "radar.ast"
editions = { "10" = "1.1" }
[fusion.capacity]
system_tracks = 10
sensor_tracks = 100
[monitor]
files = true
"#;
