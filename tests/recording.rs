//! The recording of all topics of a running deployment, through kills of the recorder.

use std::fs::File;
use std::path::Path;

use ::recording::{Survey, TopicSurvey};
use formats::rows::Utc;
use rustix::process::Signal;

use crate::common::home::{Home, kill, until};

const SETTINGS: [&str; 6] = [
    "--set",
    "recorder.enabled=true",
    "--set",
    "recorder.format=[\"csv\", \"mcap\"]",
    "--out",
    "out",
];

fn survey(folder: &Path) -> (Survey, usize) {
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut files: Vec<_> = entries
        .filter(|path| path.extension().is_some_and(|ending| ending == "mcap"))
        .collect();
    files.sort();
    let mut survey = Survey::default();
    for file in &files {
        survey.add(&mut File::open(file).unwrap()).unwrap();
    }
    (survey, files.len())
}

#[test]
fn all_topics_are_in_the_recording_as_many_as_rows() {
    let home = Home::new();
    let decisions = ["--set", "fusion.decisions=true"];
    let running = home.start(&[&["demo", "--for", "3"], &SETTINGS[..], &decisions].concat());
    let (status, said) = running.end();
    assert!(status.success(), "{said}");
    let folder = home.path("out/latest");
    assert!(!said.contains("has lost"), "{said}");
    let (survey, _) = survey(&folder);
    assert_eq!(survey.torn, 0);
    let mut all_rows = 0;
    for (name, topic) in &survey.topics {
        let file = match name.split('/').collect::<Vec<_>>()[..] {
            ["sensor", source, "tracks"] => format!("sensor_tracks_{source}.csv"),
            ["system", "tracks"] => "system_tracks.csv".to_owned(),
            ["system", "decisions"] => "decisions.csv".to_owned(),
            _ => continue,
        };
        let rows = std::fs::read_to_string(folder.join(file)).unwrap().lines().count() - 1;
        all_rows += rows;
        assert_eq!((topic.samples, topic.tally.lost), (rows as u64, 0), "{name}");
    }
    assert!(all_rows > 100, "{all_rows}");
    assert!(survey.topics["health"].samples > 50);
    let order = &survey.topics["system/order"];
    assert!(order.samples > 100 && order.tally.lost == 0, "{order:?}");
    let decisions = std::fs::read_to_string(folder.join("decisions.csv")).unwrap();
    assert!(
        decisions.contains(",started,") && decisions.contains(",confirmed,"),
        "{decisions}"
    );
    let said = succeed(&home, &["recording", "info", "out/latest"]);
    assert!(
        said.contains("system/tracks ") && said.contains(env!("CARGO_PKG_VERSION")),
        "{said}"
    );

    succeed(
        &home,
        &[
            "recording",
            "export",
            "out/latest",
            "--csv",
            "again",
            "--asterix",
            "tracks.ast",
        ],
    );
    let tables = std::fs::read_dir(home.path("again")).unwrap();
    let mut compared = 0;
    for table in tables.map(|entry| entry.unwrap().path()) {
        let name = table.file_name().unwrap();
        assert_eq!(
            std::fs::read(&table).unwrap(),
            std::fs::read(folder.join(name)).unwrap(),
            "{}",
            table.display()
        );
        compared += 1;
    }
    assert!(compared > 5, "{compared}");
    succeed(&home, &["decode", "tracks.ast", "--out", "tracks.jsonl"]);
    let records = std::fs::read_to_string(home.path("tracks.jsonl")).unwrap();
    let states = std::fs::read_to_string(folder.join("system_tracks.csv")).unwrap();
    let sent = states
        .lines()
        .filter(|row| row.contains(",confirmed,") || row.contains(",coasted,"));
    assert!(records.lines().count() >= sent.count() && records.contains("\"_c\":62"));
}

#[test]
fn a_recording_of_several_files_is_merged_and_cut() {
    let home = Home::new();
    // A file is as large as one flush makes it.
    let small = ["--set", "recorder.segment_mb=1", "--set", "recorder.flush_s=0.2"];
    let (status, said) = home
        .start(&[&["demo", "--for", "4"], &SETTINGS[..], &small].concat())
        .end();
    assert!(status.success(), "{said}");
    let (several, files) = survey(&home.path("out/latest"));
    assert!(files > 1, "{files}");
    std::fs::create_dir(home.path("one")).unwrap();
    succeed(&home, &["recording", "merge", "out/latest", "--out", "one/all.mcap"]);
    let counts = |survey: &Survey| {
        let topics = survey.topics.iter().filter(|(_, topic)| topic.slices > 0);
        let count = |(name, topic): (&String, &TopicSurvey)| (name.clone(), topic.samples, topic.tally.lost);
        topics.map(count).collect::<Vec<_>>()
    };
    assert_eq!(counts(&survey(&home.path("one")).0), counts(&several));
    let tracks = &several.topics["system/tracks"];
    let (first_ns, last_ns) = (tracks.first_ns.unwrap() as i64, tracks.last_ns.unwrap() as i64);
    let middle = Utc(first_ns + (last_ns - first_ns) / 2).to_string();
    std::fs::create_dir(home.path("halves")).unwrap();
    let cut = ["recording", "cut", "one/all.mcap", "--topics", "system/tracks", "--out"];
    succeed(&home, &[&cut[..], &["halves/1.mcap", "--to", &middle]].concat());
    succeed(&home, &[&cut[..], &["halves/2.mcap", "--from", &middle]].concat());
    let (halves, _) = survey(&home.path("halves"));
    assert_eq!(counts(&halves), [("system/tracks".to_owned(), tracks.samples, 0)]);
    let output = home.run(&["recording", "cut", "one/all.mcap", "--out", "one/all.mcap"]);
    assert_eq!(output.status.code(), Some(2));
}

fn succeed(home: &Home, arguments: &[&str]) -> String {
    let output = home.run(arguments);
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success(), "{arguments:?}: {said}");
    String::from_utf8(output.stdout).unwrap()
}

#[test]
fn a_killed_recorder_leaves_files_that_open() {
    let home = Home::new();
    let running = home.start(&[&["demo"], &SETTINGS[..]].concat());
    let folder = home.path("out/latest");
    for kills in 1..=3 {
        until("it has written", || {
            let latest = folder.join(format!("all_topics_{kills:06}.mcap"));
            std::fs::metadata(latest).is_ok_and(|file| file.len() > 100_000)
        });
        kill(home.status_row("recorder").pid, Signal::KILL);
    }
    until("the last one writes", || folder.join("all_topics_000004.mcap").exists());
    let (status, said) = running.stop();
    assert!(status.success(), "{said}");
    let (survey, files) = survey(&folder);
    assert_eq!((survey.torn, files), (0, 4), "the next recorder has put an end to each");
    let tracks = &survey.topics["system/tracks"];
    assert!(tracks.samples > 100 && tracks.tally.lost > 0, "{tracks:?}");
    home.assert_nothing_is_left("demo");
}
