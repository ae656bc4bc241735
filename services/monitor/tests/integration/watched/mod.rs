//! A monitor over the in-process transport, with a clock that the test sets, and the processes that it watches.

use std::cell::Cell;
use std::io::Write;
use std::path::Path;
use std::rc::Rc;
use std::sync::{Arc, Mutex};

use bus::{Bus, InProcess, Mark, Publisher, Root, TopicHold};
use configuration::{BUILT_IN_DEMO, ConfigWith};
use messages::{Counter, Health, LifeState, ProcessKind, StageTimes, SystemTrack, TrackState};
use monitor::{Keys, MonitorAgent, PictureTarget, Screen, SimulatedTargets, VisibleAt};
use runtime::{Agent, HealthEntry, Now, Options, Speed, Turn};
use serde_json::Value;
pub(crate) use test_support::S;

/// Configuration of the demonstration with the keys of its monitor.
pub(crate) type Config = ConfigWith<Keys>;

/// Lets the demonstration have a recorder.
pub(crate) const RECORDER: &str = "recorder.enabled=true";

pub(crate) const UTC_NS: i64 = 1_700_000_000 * S;

/// Where the monitor's text goes.
#[derive(Clone, Default)]
pub(crate) struct Paper(Arc<Mutex<Vec<u8>>>);

impl Paper {
    fn text(&self) -> String {
        String::from_utf8(self.0.lock().unwrap().clone()).unwrap()
    }
}

impl Write for Paper {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.0.lock().unwrap().write(bytes)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

/// A monitor, and the processes that it watches.
pub(crate) struct Bench {
    pub(crate) monitor: MonitorAgent<InProcess>,
    pub(crate) clock: Rc<Cell<Now>>,
    pub(crate) paper: Paper,
    errors: Paper,
    config: Config,
    options: Options,
    pub(crate) bus: Bus<InProcess>,
    tracks: Publisher<InProcess, SystemTrack>,
    health: Publisher<InProcess, Health>,
    pub(crate) folder: tempfile::TempDir,
    _held: [TopicHold; 4],
}

/// As many targets as the demonstration has, at rest.
fn targets() -> SimulatedTargets {
    const COUNT: u32 = 80;
    let target = |id: u32| PictureTarget {
        id,
        position_m: [1e3 * f64::from(id), 0.0, 1e3],
        address: id + 1,
    };
    let seen = move |_, seen: &mut Vec<PictureTarget>| seen.extend((0..COUNT).map(target));
    SimulatedTargets {
        count: COUNT,
        visible: Some(VisibleAt(Box::new(seen))),
    }
}

impl Bench {
    /// Of the demonstration, changed by `overrides`.
    pub(crate) fn new(overrides: &[&str]) -> Self {
        Self::with(overrides, Speed::Factor(1.0), Path::new(BUILT_IN_DEMO))
    }

    pub(crate) fn with(overrides: &[&str], speed: Speed, config: &Path) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let overrides: Vec<String> = overrides.iter().map(|each| (*each).to_owned()).collect();
        let has_recorder = config != Path::new(BUILT_IN_DEMO) || overrides.iter().any(|each| each == RECORDER);
        let mut config = Config::read(config, &overrides).unwrap();
        // The monitor does not read the recorder's keys.
        config.deployment.services.recorder = has_recorder;
        let root = Root::in_base(folder.path(), "test").unwrap();
        let bus: Bus<InProcess> = Bus::open(&root, "test").unwrap();
        let held = [
            bus.hold(&messages::system_tracks()).unwrap(),
            bus.hold(&messages::health()).unwrap(),
            bus.hold(&messages::frame_origin()).unwrap(),
            bus.hold(&messages::alarms()).unwrap(),
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
        let (paper, errors) = (Paper::default(), Paper::default());
        let screen = Screen::new(Box::new(paper.clone()), false).with_errors(Box::new(errors.clone()));
        let reading = Rc::clone(&clock);
        let reads = Box::new(move || reading.get());
        let mut monitor = MonitorAgent::new(
            (&config, &config.parts.monitor),
            &options,
            "monitor",
            &bus,
            reads,
            screen,
        )
        .unwrap();
        if config.is_simulated() {
            monitor.compare_with(targets());
        }
        Self {
            monitor,
            clock,
            paper,
            errors,
            config,
            options,
            tracks: bus.publisher(&messages::system_tracks(), 100 * S as u64).unwrap(),
            health: bus.publisher(&messages::health(), 100 * S as u64).unwrap(),
            bus,
            folder,
            _held: held,
        }
    }

    /// A monitor that was started beside the first one.
    pub(crate) fn second_monitor(&self, name: &str) -> MonitorAgent<InProcess> {
        let reading = Rc::clone(&self.clock);
        let reads = Box::new(move || reading.get());
        let screen = Screen::new(Box::new(Paper::default()), false);
        MonitorAgent::new(
            (&self.config, &self.config.parts.monitor),
            &self.options,
            name,
            &self.bus,
            reads,
            screen,
        )
        .unwrap()
    }

    pub(crate) fn pass(&self, ns: i64) {
        let now = self.clock.get();
        self.clock.set(Now {
            mono_ns: now.mono_ns + ns,
            utc_ns: now.utc_ns + ns,
        });
    }

    pub(crate) fn turn(&mut self) -> Turn {
        self.monitor.turn(self.clock.get()).unwrap()
    }

    /// A turn at `now`; its outcome does not matter.
    pub(crate) fn monitor_turn(&mut self, now: Now) {
        let _ = self.monitor.turn(now).unwrap();
    }

    pub(crate) fn mark(&self) -> Mark {
        Mark {
            progress_ns: i64::MIN,
            sent_ns: self.clock.get().mono_ns,
            end: false,
        }
    }

    /// One process says how it is.
    pub(crate) fn say(&mut self, kind: ProcessKind, name: &str, source: u16, counters: &[(Counter, u64)]) {
        self.say_as(100 * S as u64, kind, name, source, counters);
    }

    pub(crate) fn say_as(
        &mut self,
        incarnation: u64,
        kind: ProcessKind,
        name: &str,
        source: u16,
        counters: &[(Counter, u64)],
    ) {
        let mut health = Health {
            said_ns: self.clock.get().mono_ns,
            incarnation,
            source,
            kind: kind as u8,
            life: LifeState::Finished as u8,
            ..Health::default()
        };
        for (counter, value) in counters {
            health.counters[*counter] = *value;
        }
        self.send_health(health.with_name(name));
    }

    pub(crate) fn send_health(&mut self, health: Health) {
        self.health.send(self.mark(), 1, |_, _| health).unwrap();
    }

    /// Fusion publishes these states.
    pub(crate) fn publish(&mut self, states: &[SystemTrack]) {
        self.tracks
            .send(self.mark(), states.len(), |index, _| states[index])
            .unwrap();
    }

    /// Fusion publishes `count` states that reports of `source` caused. Every stage took `unit_ns`.
    pub(crate) fn fuse(&mut self, source: u16, count: usize, unit_ns: i64) {
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

    pub(crate) fn close(&mut self) -> String {
        self.monitor.close(self.clock.get()).unwrap();
        self.text()
    }

    pub(crate) fn text(&self) -> String {
        self.paper.text()
    }

    /// Lines on standard error.
    pub(crate) fn errors(&self) -> String {
        self.errors.text()
    }

    /// The report's last sentence, without its line breaks.
    pub(crate) fn verdict(&self) -> String {
        let sentence = self.report()["verdict"]["sentence"].as_str().unwrap().to_owned();
        let text: Vec<&str> = sentence.split(' ').collect();
        let shown = self.text();
        let shown: Vec<&str> = shown.split_whitespace().collect();
        assert!(shown.ends_with(&text), "the text ends with the verdict");
        sentence
    }

    pub(crate) fn out(&self, name: &str) -> String {
        std::fs::read_to_string(self.folder.path().join("out").join(name)).unwrap()
    }

    pub(crate) fn report(&self) -> Value {
        serde_json::from_str(&self.out("report.json")).unwrap()
    }

    pub(crate) fn own_health(&self) -> HealthEntry {
        let mut entries = Vec::new();
        self.monitor.health(&mut entries);
        entries.remove(0)
    }
}

pub(crate) const RECORDED: &str = r#"name = "recorded"
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
