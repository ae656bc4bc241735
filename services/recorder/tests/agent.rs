//! Tests of the recorder, driven turn by turn over the in-process transport.

use std::path::Path;

use bus::{Bus, InProcess, Mark, Publisher, Root, TopicHold};
use configuration::ConfigWith;
use messages::{Alarm, AlarmEvent, Counter, SensorTrack, SystemTrack};
use recorder::{Keys, RecorderAgent, Start};
use runtime::{Agent, HealthEntry, Now, Turn};

type Config = ConfigWith<Keys>;

const NOW: Now = Now { mono_ns: 1, utc_ns: 0 };

fn config() -> Config {
    config_with(&[])
}

fn config_with(overrides: &[String]) -> Config {
    let text = "name = \"t\"\n[frame]\nlatitude_deg = 0.0\nlongitude_deg = 0.0\n[time]\norder = \"time\"\ndate = \"2016-05-10\"\n\
                [[source]]\nname = \"a\"\n[source.recorded]\nfile = \"a.ast\"\n";
    Config::parse(Path::new("t.toml"), text, overrides).unwrap()
}

fn start<'a>(folder: &'a Path, run: &'a str) -> Start<'a> {
    Start {
        folder,
        run,
        version: "1",
        first_day_ns: 0,
    }
}

struct Bench {
    folder: tempfile::TempDir,
    bus: Bus<InProcess>,
    _held: Vec<TopicHold>,
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
            bus.hold(&messages::order_states()).unwrap(),
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
        let folder = self.folder.path().join("out");
        let config = config();
        RecorderAgent::new((&config, &config.parts.recorder), &self.bus, 1, &start(&folder, run))
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

    // The third recorder finds the gap recorded by the second: nothing is written twice.
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

mod all_topics {
    use std::fs::File;
    use std::path::PathBuf;

    use recording::Survey;

    use super::*;

    const TOPIC: &str = "sensor/a/tracks";

    /// Bench for recorders of all topics.
    fn bench() -> Bench {
        let mut bench = Bench::new();
        bench._held.push(bench.bus.hold(&messages::health()).unwrap());
        bench._held.push(bench.bus.hold(&messages::orders()).unwrap());
        bench._held.push(bench.bus.hold(&messages::frame_origin()).unwrap());
        bench._held.push(bench.bus.hold(&messages::restored()).unwrap());
        bench
    }

    fn recorder_of(bench: &Bench, folder: &Path, more: &[&str]) -> RecorderAgent<InProcess> {
        let overrides: Vec<String> = [&["recorder.format=[\"csv\", \"mcap\"]"], more]
            .concat()
            .iter()
            .map(|each| (*each).to_owned())
            .collect();
        let config = config_with(&overrides);
        RecorderAgent::new((&config, &config.parts.recorder), &bench.bus, 1, &start(folder, "run")).unwrap()
    }

    fn files(folder: &Path) -> Vec<PathBuf> {
        let files = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
        let mut files: Vec<_> = files
            .filter(|path| path.extension().is_some_and(|ending| ending == "mcap"))
            .collect();
        files.sort();
        files
    }

    fn survey(folder: &Path) -> Survey {
        let mut survey = Survey::default();
        for file in files(folder) {
            survey.add(&mut File::open(file).unwrap()).unwrap();
        }
        survey
    }

    fn at(mono_s: f64) -> Now {
        Now {
            mono_ns: (mono_s * 1e9) as i64,
            utc_ns: 0,
        }
    }

    fn counted(agent: &RecorderAgent<InProcess>, counter: Counter) -> u64 {
        let mut entries: Vec<HealthEntry> = Vec::new();
        agent.health(&mut entries);
        entries[0].counters[counter]
    }

    #[test]
    fn all_that_was_said_is_in_the_file() {
        let mut bench = bench();
        let out = bench.folder.path().join("out");
        let mut recorder = recorder_of(&bench, &out, &[]);
        bench.send(0..5, false);
        recorder.turn(at(1.0)).unwrap();
        bench.send(5..9, true);
        recorder.turn(at(2.5)).unwrap();
        recorder.close(at(2.6)).unwrap();
        let found = survey(&out);
        assert_eq!(
            (found.topics[TOPIC].samples, found.topics[TOPIC].tally.lost, found.torn),
            (9, 0, 0)
        );
        assert_eq!(found.topics["system/tracks"].samples, 9);
        assert!(found.topics.contains_key("health") && found.facts["configuration"].contains("a.ast"));
        let all: u64 = found.topics.values().map(|topic| topic.samples).sum();
        assert_eq!(counted(&recorder, Counter::RecordedSamples), all);
    }

    #[test]
    fn what_other_centres_are_told_is_recorded() {
        let mut bench = bench();
        let topic = messages::own_tracks();
        bench._held.push(bench.bus.hold(&topic).unwrap());
        let out = bench.folder.path().join("out");
        let mut recorder = recorder_of(&bench, &out, &["fusion.exchange=true"]);
        let mut own = bench.bus.publisher(&topic, 2).unwrap();
        let mark = Mark {
            progress_ns: i64::MIN,
            sent_ns: 1,
            end: false,
        };
        own.send(mark, 3, |_, _| SystemTrack::default()).unwrap();
        recorder.turn(at(1.0)).unwrap();
        recorder.close(at(1.1)).unwrap();
        assert_eq!(survey(&out).topics[topic.name.as_str()].samples, 3);
    }

    #[test]
    fn recorded_inputs_need_no_rows() {
        let mut bench = bench();
        let out = bench.folder.path().join("out");
        let mut recorder = recorder_of(&bench, &out, &["recorder.format=[\"mcap\"]"]);
        bench.send(0..5, false);
        assert!(matches!(recorder.turn(at(1.0)).unwrap(), Turn::Worked));
        bench.send(5..9, true);
        assert!(matches!(recorder.turn(at(1.1)).unwrap(), Turn::Worked));
        while !matches!(recorder.turn(at(1.2)).unwrap(), Turn::Finished) {}
        recorder.close(at(1.3)).unwrap();
        assert_eq!(survey(&out).topics[TOPIC].samples, 9);
        let mut entries: Vec<HealthEntry> = Vec::new();
        recorder.health(&mut entries);
        let taken: u64 = entries.iter().map(|entry| entry.counters[Counter::Taken]).sum();
        assert_eq!(taken, 18, "of the source and of the system tracks");
        assert!(!out.join("system_tracks.csv").exists());
    }

    #[test]
    fn without_rows_a_lost_sample_counts_once() {
        let mut bench = bench();
        let out = bench.folder.path().join("out");
        let mut recorder = recorder_of(&bench, &out, &["recorder.format=[\"mcap\"]"]);
        bench.send(0..1, false);
        recorder.turn(at(1.0)).unwrap();
        // The topic's queue holds 256 slices.
        (1..301).for_each(|number| bench.send(number..number + 1, false));
        while recorder.turn(at(1.0)).unwrap() == Turn::Worked {}
        assert_eq!(counted(&recorder, Counter::RecordedLost), 88, "44 of each topic");
        assert_eq!((lost(&recorder), missing(&recorder)), (0, 0));
    }

    #[test]
    fn a_killed_recorder_costs_what_was_not_flushed_and_the_next_one_counts_it() {
        for compression in ["zstd", "none"] {
            kill(&[&format!("recorder.compression={compression}")]);
        }
    }

    fn kill(settings: &[&str]) {
        let mut bench = bench();
        let (out, after) = (bench.folder.path().join("out"), bench.folder.path().join("after"));
        std::fs::create_dir(&after).unwrap();
        let mut first = recorder_of(&bench, &out, settings);
        bench.send(0..4, false);
        first.turn(at(10.0)).unwrap();
        bench.send(4..6, false);
        first.turn(at(11.5)).unwrap();
        bench.send(6..9, false);
        first.turn(at(11.6)).unwrap();
        // Remains of a killed recorder: its current file, and a few bytes of a chunk.
        let mut left = std::fs::read(&files(&out)[0]).unwrap();
        left.extend([6, 1, 0, 0]);
        std::fs::write(after.join("all_topics_000001.mcap"), left).unwrap();
        drop(first);
        std::fs::write(after.join("all_topics_000002.mcap"), [0x89, b'M']).unwrap();
        let mut second = recorder_of(&bench, &after, settings);
        bench.send(9..11, false);
        second.turn(at(13.0)).unwrap();
        assert_eq!(counted(&second, Counter::RecordedLost), 6, "3 of each topic");
        let mut entries: Vec<HealthEntry> = Vec::new();
        second.health(&mut entries);
        assert_eq!(entries[0].note, "a recorder ended or was killed before it had written");
        second.close(at(14.0)).unwrap();
        let found = survey(&after);
        assert_eq!(
            (found.topics[TOPIC].samples, found.topics[TOPIC].tally.lost, found.torn),
            (8, 3, 0)
        );
        assert_eq!(files(&after).len(), 2);
    }

    #[test]
    fn files_follow_each_other_and_the_oldest_make_room() {
        let mut bench = bench();
        let out = bench.folder.path().join("out");
        let mut recorder = recorder_of(
            &bench,
            &out,
            &[
                "recorder.segment_s=1",
                "recorder.keep_gb=0.001",
                "recorder.compression=none",
            ],
        );
        for turn in 0..40 {
            let first = 60 * turn;
            bench.send(first..first + 60, false);
            recorder.turn(at(turn as f64 + 0.5)).unwrap();
        }
        recorder.close(at(41.0)).unwrap();
        let (deleted, left) = (counted(&recorder, Counter::RecordingsDeleted), files(&out).len() as u64);
        assert!(deleted > 2 && left > 1, "{deleted} deleted, {left} left");
        let bytes: u64 = files(&out).iter().map(|path| path.metadata().unwrap().len()).sum();
        assert!(bytes < 1_200_000, "{bytes}");
        assert_eq!(survey(&out).topics[TOPIC].tally.lost, 0);
    }

    #[test]
    fn what_cannot_be_written_is_counted_and_it_goes_on_when_it_can() {
        let mut bench = bench();
        let out = bench.folder.path().join("out");
        let away = bench.folder.path().join("away");
        let mut recorder = recorder_of(&bench, &out, &["recorder.segment_s=1"]);
        bench.send(0..4, false);
        recorder.turn(at(1.0)).unwrap();
        recorder.turn(at(2.5)).unwrap();
        std::fs::rename(&out, &away).unwrap();
        bench.send(4..7, false);
        recorder.turn(at(2.6)).unwrap();
        bench.send(7..9, false);
        recorder.turn(at(3.0)).unwrap();
        // Five samples of each topic of data, and the recorder's own progress messages.
        let lost = counted(&recorder, Counter::RecordedLost);
        assert!(lost >= 10, "{lost}");
        assert_eq!(counted(&recorder, Counter::RecordingFailures), 1);
        std::fs::rename(&away, &out).unwrap();
        bench.send(9..10, false);
        recorder.turn(at(4.0)).unwrap();
        let error = recorder.close(at(4.5)).unwrap_err();
        assert!(error.to_string().contains(&format!("lacks {lost} samples")), "{error}");
        let topic = &survey(&out).topics[TOPIC];
        assert_eq!((topic.samples, topic.tally.lost), (5, 5));
    }

    #[test]
    fn a_table_that_fails_disturbs_no_other_file() {
        let mut bench = bench();
        let out = bench.folder.path().join("out");
        let table = out.join("sensor_tracks_a.csv");
        let mut recorder = recorder_of(&bench, &out, &[]);
        bench.send(0..4, false);
        recorder.turn(at(1.0)).unwrap();
        std::fs::remove_file(&table).unwrap();
        recorder.turn(at(2.1)).unwrap();
        bench.send(4..7, false);
        recorder.turn(at(2.2)).unwrap();
        let note = |recorder: &RecorderAgent<InProcess>| {
            let mut entries: Vec<HealthEntry> = Vec::new();
            recorder.health(&mut entries);
            entries[0].note.clone()
        };
        assert_eq!(note(&recorder), "its folder is gone");
        // A device that takes nothing.
        std::os::unix::fs::symlink("/dev/full", &table).unwrap();
        bench.send(7..9, false);
        recorder.turn(at(3.3)).unwrap();
        assert_eq!(note(&recorder), "its files cannot be written");
        std::fs::remove_file(&table).unwrap();
        bench.send(9..12, false);
        recorder.turn(at(4.5)).unwrap();
        assert_eq!(counted(&recorder, Counter::RecordedLost), 5);
        assert_eq!(counted(&recorder, Counter::RecordingFailures), 2);
        let error = recorder.close(at(4.6)).unwrap_err().to_string();
        assert_eq!(error, "tables could not be written 2 times; they lack 5 rows");
        assert_eq!(
            (bench.rows("sensor_tracks_a.csv"), bench.rows("system_tracks.csv")),
            (3, 12)
        );
        let topic = &survey(&out).topics[TOPIC];
        assert_eq!((topic.samples, topic.tally.lost), (12, 0));
    }

    #[test]
    fn a_table_that_cannot_be_made_at_the_start_is_tried_again_and_disturbs_no_other_file() {
        let mut bench = bench();
        let out = bench.folder.path().join("out");
        let table = out.join("sensor_tracks_a.csv");
        std::fs::create_dir_all(&out).unwrap();
        // Somebody's file, which is never replaced.
        std::fs::write(&table, "mine").unwrap();
        let mut recorder = recorder_of(&bench, &out, &[]);
        bench.send(0..4, false);
        recorder.turn(at(1.0)).unwrap();
        assert_eq!(std::fs::read_to_string(&table).unwrap(), "mine");
        assert_eq!(counted(&recorder, Counter::RecordedLost), 4);
        let failures = counted(&recorder, Counter::RecordingFailures);
        std::fs::remove_file(&table).unwrap();
        // Without a row, too.
        recorder.turn(at(2.1)).unwrap();
        assert_eq!(bench.rows("sensor_tracks_a.csv"), 0);
        bench.send(4..7, false);
        recorder.turn(at(2.2)).unwrap();
        assert_eq!(counted(&recorder, Counter::RecordedLost), 4);
        assert_eq!(counted(&recorder, Counter::RecordingFailures), failures);
        recorder.close(at(2.3)).unwrap_err();
        assert_eq!(
            (bench.rows("sensor_tracks_a.csv"), bench.rows("system_tracks.csv")),
            (3, 7)
        );
        assert_eq!(survey(&out).topics[TOPIC].samples, 7);
    }

    #[test]
    fn a_table_of_a_replay_that_cannot_be_continued_ends_the_recorder() {
        let bench = bench();
        let out = bench.folder.path().join("out");
        recorder_of(&bench, &out, &[]).close(at(1.0)).unwrap();
        let table = out.join("sensor_tracks_a.csv");
        std::fs::remove_file(&table).unwrap();
        std::fs::create_dir(&table).unwrap();
        let overrides = ["recorder.format=[\"csv\", \"mcap\"]".to_owned()];
        let config = config_with(&overrides);
        let error = RecorderAgent::new((&config, &config.parts.recorder), &bench.bus, 1, &start(&out, "run"));
        let error = error.unwrap_err().to_string();
        assert!(
            error.contains(&table.display().to_string()),
            "only it states the position: {error}"
        );
    }

    #[test]
    fn every_gap_ends_with_a_request_for_a_snapshot_once_files_can_be_written() {
        let mut bench = bench();
        let (out, away) = (bench.folder.path().join("out"), bench.folder.path().join("away"));
        let mut orders = bench.bus.subscriber(&messages::orders(), || 1).unwrap();
        let mut recorder = recorder_of(&bench, &out, &["recorder.segment_s=1", "recorder.format=[\"mcap\"]"]);
        let begin_s = Now::read().mono_ns as f64 / 1e9 + 1.0;
        let mut asked = || {
            let mut count = 0;
            orders.take(100, |_, orders| count += orders.len()).unwrap();
            count
        };
        let mut number = 0;
        let mut turn = |recorder: &mut RecorderAgent<InProcess>, second: f64| {
            bench.send(number..number + 1, false);
            number += 1;
            recorder.turn(at(begin_s + second)).unwrap();
        };
        turn(&mut recorder, 0.0);
        turn(&mut recorder, 1.1);
        assert_eq!(asked(), 0, "nothing is missing");
        for gap in 0..3 {
            let second = 5.0 + 100.0 * f64::from(gap);
            std::fs::rename(&out, &away).unwrap();
            for later in 0..4 {
                turn(&mut recorder, second + f64::from(later));
            }
            assert_eq!(asked(), 0, "what is asked for now cannot be written");
            std::fs::rename(&away, &out).unwrap();
            turn(&mut recorder, second + 4.1);
            turn(&mut recorder, second + 4.3);
            turn(&mut recorder, second + 4.4);
            assert_eq!(asked(), 1, "gap {gap}");
        }
        recorder.close(at(begin_s + 400.0)).unwrap_err();
    }

    #[test]
    fn a_queue_that_overran_ends_with_a_request_for_a_snapshot() {
        let mut bench = bench();
        let out = bench.folder.path().join("out");
        let mut orders = bench.bus.subscriber(&messages::orders(), || 1).unwrap();
        let mut recorder = recorder_of(&bench, &out, &["recorder.format=[\"mcap\"]"]);
        let begin_s = Now::read().mono_ns as f64 / 1e9 + 1.0;
        bench.send(0..1, false);
        recorder.turn(at(begin_s)).unwrap();
        (1..301).for_each(|number| bench.send(number..number + 1, false));
        while recorder.turn(at(begin_s + 0.1)).unwrap() == Turn::Worked {}
        let mut count = 0;
        orders.take(100, |_, orders| count += orders.len()).unwrap();
        assert_eq!(count, 1);
        let mut entries: Vec<HealthEntry> = Vec::new();
        recorder.health(&mut entries);
        assert_eq!(entries[0].note, "the recorder is too slow");
    }

    #[test]
    fn a_folder_is_a_bag_of_ros_2_also_without_an_end() {
        let mut bench = bench();
        let out = bench.folder.path().join("out");
        let bag = || -> serde_yaml::Value {
            let text = std::fs::read_to_string(out.join("metadata.yaml")).unwrap();
            serde_yaml::from_str::<serde_yaml::Value>(&text).unwrap()["rosbag2_bagfile_information"].clone()
        };
        let count = |bag: &serde_yaml::Value, topic: &str| {
            let topics = bag["topics_with_message_count"].as_sequence().unwrap();
            let found = topics
                .iter()
                .find(|each| each["topic_metadata"]["name"] == topic)
                .unwrap();
            assert_eq!(found["topic_metadata"]["serialization_format"], "cdr");
            assert_eq!(found["topic_metadata"]["offered_qos_profiles"], "");
            let schema = found["topic_metadata"]["type"].as_str().unwrap().to_owned();
            (schema, found["message_count"].as_u64().unwrap())
        };
        let mut first = recorder_of(&bench, &out, &[]);
        bench.send(0..4, false);
        first.turn(at(1.0)).unwrap();
        let begun = bag();
        assert_eq!(
            (&begun["version"], &begun["storage_identifier"]),
            (&5.into(), &"mcap".into())
        );
        assert_eq!(begun["relative_file_paths"][0], "all_topics_000001.mcap");
        assert_eq!(count(&begun, TOPIC), ("koseki/msg/SensorTrack".to_owned(), 0));
        first.turn(at(2.5)).unwrap();
        // Killed: the file has no summary, and its description is old.
        let left = std::fs::read(&files(&out)[0]).unwrap();
        drop(first);
        std::fs::write(&files(&out)[0], left).unwrap();
        let mut second = recorder_of(&bench, &out, &[]);
        assert_eq!(count(&bag(), TOPIC).1, 4);
        bench.send(4..9, false);
        second
            .turn(Now {
                utc_ns: 7_000,
                ..at(3.0)
            })
            .unwrap();
        second
            .close(Now {
                utc_ns: 9_000,
                ..at(4.0)
            })
            .unwrap();
        let ended = bag();
        assert_eq!(count(&ended, TOPIC).1, 9);
        assert_eq!(
            count(&ended, "sensor/a/tracks/slices"),
            ("koseki/msg/BatchHeader".to_owned(), 2)
        );
        let of_files = ended["files"].as_sequence().unwrap();
        let names: Vec<_> = of_files.iter().map(|file| file["path"].clone()).collect();
        assert_eq!(names, *ended["relative_file_paths"].as_sequence().unwrap());
        assert_eq!(names.len(), 2);
        let messages: u64 = of_files
            .iter()
            .map(|file| file["message_count"].as_u64().unwrap())
            .sum();
        assert_eq!(ended["message_count"].as_u64(), Some(messages));
        assert_eq!(
            of_files[1]["starting_time"]["nanoseconds_since_epoch"].as_u64(),
            Some(7_000)
        );
        assert_eq!(ended["duration"]["nanoseconds"].as_u64(), Some(9_000));
        assert!(!out.join(".metadata.yaml").exists());
        // A third recorder reads the counts of ended files in their summaries.
        drop(second);
        std::fs::remove_file(out.join("metadata.yaml")).unwrap();
        drop(recorder_of(&bench, &out, &[]));
        assert_eq!(bag()["message_count"].as_u64(), Some(messages));
    }
}
