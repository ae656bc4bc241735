//! The recording of all topics of a running deployment, through kills of the recorder.

use std::fs::File;
use std::path::Path;

use ::recording::Survey;
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
    let output = home.run(&["recording", "info", "out/latest"]);
    let said = String::from_utf8(output.stdout).unwrap();
    assert!(output.status.success() && said.contains("system/tracks "), "{said}");
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
