//! The recorder driven turn by turn over the in-process transport.

use std::path::Path;

use bus::{Bus, Held, InProcess, Mark, Publisher, Root};
use configuration::Config;
use messages::{Alarm, AlarmEvent, Counter, SensorTrack, SystemTrack};
use recorder::RecorderAgent;
use runtime::{Agent, HealthEntry, Now, Turn};

const NOW: Now = Now { mono_ns: 1, utc_ns: 0 };

fn config() -> Config {
    let text = "name = \"t\"\n[frame]\nlatitude_deg = 0.0\nlongitude_deg = 0.0\n[time]\norder = \"time\"\ndate = \"2016-05-10\"\n\
                [[source]]\nname = \"a\"\n[source.recorded]\nfile = \"a.ast\"\n";
    Config::parse(Path::new("t.toml"), text, &[]).unwrap()
}

struct Bench {
    folder: tempfile::TempDir,
    bus: Bus<InProcess>,
    _held: Vec<Held>,
    source: Publisher<InProcess, SensorTrack>,
    system: Publisher<InProcess, SystemTrack>,
}

impl Bench {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let bus: Bus<InProcess> = Bus::open(&Root::in_base(folder.path().join("b"), "t").unwrap(), "test").unwrap();
        let topic = messages::sensor_tracks("a");
        let held = vec![
            bus.hold(&topic).unwrap(),
            bus.hold(&messages::system_tracks()).unwrap(),
            bus.hold(&messages::alarms()).unwrap(),
            bus.hold(&messages::progress()).unwrap(),
        ];
        let (source, system) = (
            bus.publisher(&topic, 2).unwrap(),
            bus.publisher(&messages::system_tracks(), 2).unwrap(),
        );
        Self {
            folder,
            bus,
            _held: held,
            source,
            system,
        }
    }

    fn try_recorder(&self, run: &str) -> anyhow::Result<RecorderAgent<InProcess>> {
        RecorderAgent::new(&config(), &self.bus, 1, &self.folder.path().join("out"), 0, run)
    }

    fn recorder(&self, run: &str) -> RecorderAgent<InProcess> {
        self.try_recorder(run).unwrap()
    }

    /// Sends reports with the given numbers.
    fn send(&mut self, numbers: std::ops::Range<u64>, end: bool) {
        let mark = Mark {
            progress_ns: 0,
            sent_ns: 1,
            end,
        };
        let count = numbers.clone().count();
        self.source
            .send(mark, count, |index, _| SensorTrack {
                sequence: numbers.start + index as u64,
                ..SensorTrack::default()
            })
            .unwrap();
        self.system.send(mark, count, |_, _| SystemTrack::default()).unwrap();
    }

    fn rows(&self, file: &str) -> usize {
        std::fs::read_to_string(self.folder.path().join("out").join(file))
            .unwrap()
            .lines()
            .count()
            - 1
    }
}

fn counted(agent: &RecorderAgent<InProcess>, counter: Counter) -> u64 {
    let mut entries: Vec<HealthEntry> = Vec::new();
    agent.health(&mut entries);
    entries[1].counters[counter]
}

fn lost(agent: &RecorderAgent<InProcess>) -> u64 {
    counted(agent, Counter::Lost)
}

fn missing(agent: &RecorderAgent<InProcess>) -> u64 {
    counted(agent, Counter::MissingRows)
}

#[test]
fn it_writes_a_row_per_sample_and_finishes_when_all_topics_have_ended() {
    let mut bench = Bench::new();
    let mut recorder = bench.recorder("run");
    bench.send(0..5, false);
    assert_eq!(recorder.turn(NOW).unwrap(), Turn::Worked);
    bench.send(5..9, true);
    assert_eq!(recorder.turn(NOW).unwrap(), Turn::Worked);
    assert_eq!(recorder.turn(NOW).unwrap(), Turn::Finished);
    recorder.close(NOW).unwrap();
    assert_eq!(
        (bench.rows("sensor_tracks_a.csv"), bench.rows("system_tracks.csv")),
        (9, 9)
    );
}

#[test]
fn reports_that_come_twice_are_written_once() {
    let mut bench = Bench::new();
    let mut recorder = bench.recorder("run");
    bench.send(0..6, false);
    bench.send(2..8, false);
    recorder.close(NOW).unwrap();
    assert_eq!(bench.rows("sensor_tracks_a.csv"), 8);
    assert_eq!(lost(&recorder), 0);
}

#[test]
fn a_restarted_recorder_continues_its_run_and_counts_what_went_missing() {
    let mut bench = Bench::new();
    let mut first = bench.recorder("run");
    bench.send(0..4, false);
    first.close(NOW).unwrap();
    drop(first);
    let mut second = bench.recorder("run");
    bench.send(6..10, false);
    second.close(NOW).unwrap();
    assert_eq!(bench.rows("sensor_tracks_a.csv"), 8);
    assert_eq!(lost(&second), 2, "numbers 4 and 5 died with the first");

    drop(second);

    // What the second one knew of the gap, the third one knows, too: nothing is written twice.
    let mut third = bench.recorder("run");
    bench.send(8..12, false);
    third.close(NOW).unwrap();
    assert_eq!(
        (bench.rows("sensor_tracks_a.csv"), lost(&third), missing(&third)),
        (10, 0, 2)
    );
    drop(third);

    let refused = bench.try_recorder("another run").unwrap_err().to_string();
    assert!(
        refused.contains("holds the recording of another run (run)"),
        "{refused}"
    );
    assert_eq!(bench.rows("sensor_tracks_a.csv"), 10, "and is left as it is");
}

#[test]
fn alarms_make_a_row_when_they_are_raised_and_when_they_are_cleared() {
    let bench = Bench::new();
    let mut recorder = bench.recorder("run");
    let mut alarms = bench.bus.publisher(&messages::alarms(), 2).unwrap();
    for event in [
        AlarmEvent::Raised,
        AlarmEvent::Standing,
        AlarmEvent::Standing,
        AlarmEvent::Cleared,
    ] {
        let mark = Mark {
            progress_ns: i64::MIN,
            sent_ns: 1,
            end: false,
        };
        let alarm = |_: usize, sequence: u64| Alarm {
            code: 1,
            event: event.code(),
            sequence,
            ..Alarm::default()
        };
        alarms.send(mark, 1, alarm).unwrap();
    }
    recorder.turn(NOW).unwrap();
    recorder.close(NOW).unwrap();
    assert_eq!(bench.rows("alarms.csv"), 2);
}
