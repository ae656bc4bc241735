//! The recording of all topics of a running deployment, through kills of the recorder.

use std::collections::BTreeMap;
use std::fs::File;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use ::recording::{Item, RecordingError, Survey, TopicSurvey};
use bus::{Bus, SharedMemory};
use formats::rows::Utc;
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use rustix::process::Signal;

use crate::common::{Home, kill, repository, until};

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

    let said = succeed(&home, &["recording", "info", "out/latest", "--json"]);
    let info: serde_json::Value = serde_json::from_str(&said).unwrap();
    assert_eq!(info["topics"]["health"]["samples"], survey.topics["health"].samples);
    assert!(info["configuration"].as_str().unwrap().contains("radar-west"));

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
            "--foxglove",
            "map.mcap",
        ],
    );
    check_pictures(&std::fs::read(home.path("map.mcap")).unwrap());
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

/// The recording of a deployment that runs is read as far as it is complete, and each command states in one line that
/// it has no end yet.
#[test]
fn a_recording_that_is_still_written_is_read() {
    let home = Home::new();
    let running = home.demo_with(&SETTINGS);
    let file = "out/latest/all_topics_000001.mcap";
    until("tracks are recorded", || {
        let survey = home.path(file).is_file().then(|| survey(&home.path("out/latest")).0);
        survey.is_some_and(|survey| {
            survey
                .topics
                .get("system/tracks")
                .is_some_and(|topic| topic.samples > 10)
        })
    });
    let commands: [&[&str]; 5] = [
        &["recording", "repair", file, "--out", "whole.mcap"],
        &["recording", "export", file, "--csv", "tables"],
        &["recording", "merge", "out/latest", "--out", "merged.mcap"],
        &["replay", file, "--out", "again.csv"],
        &["smooth", file, "--out", "smoothed.csv"],
    ];
    let unended = |command: &[&str]| {
        let output = home.run(command);
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(0), "{command:?}: {said}");
        said.lines().filter(|line| line.contains("has no end")).count()
    };
    for command in commands {
        assert_eq!(unended(command), 1, "{command:?}");
    }
    assert!(succeed(&home, &["recording", "info", file]).contains("without an end: 1"));
    // The copy is a file for every reader of MCAP, and has a summary.
    let copy = survey_of(&home.path("whole.mcap"));
    assert_eq!((copy.torn, copy.topics["system/tracks"].samples > 10), (0, true));
    assert_eq!(unended(&["replay", "whole.mcap"]), 0);
    let (status, said) = running.stop();
    assert!(status.success(), "{said}");
    assert_eq!(unended(&["replay", file]), 0);
    home.assert_nothing_is_left("demo");
}

fn survey_of(file: &Path) -> Survey {
    let mut survey = Survey::default();
    survey.add(&mut File::open(file).unwrap()).unwrap();
    survey
}

/// Pictures of the demonstration's aircraft: of each second one of places and one of a scene, with the same tracks.
fn check_pictures(file: &[u8]) {
    let mut tracks: BTreeMap<u64, [Vec<String>; 2]> = BTreeMap::new();
    for message in mcap::MessageStream::new(file).unwrap() {
        let message = message.unwrap();
        let schema = message.channel.schema.as_ref().unwrap().name.clone();
        let content: serde_json::Value = serde_json::from_slice(&message.data).unwrap();
        let of_second = tracks.entry(message.log_time).or_default();
        match schema.as_str() {
            "foxglove.LocationFixes" => {
                for fix in content["fixes"].as_array().unwrap() {
                    let [latitude, longitude] = ["latitude", "longitude"].map(|name| fix[name].as_f64().unwrap());
                    assert!(
                        (40.0..43.0).contains(&latitude) && (0.0..4.0).contains(&longitude),
                        "{fix}"
                    );
                    assert!(fix["position_covariance"][0].as_f64().unwrap() > 0.0);
                    of_second[0].push(fix["metadata"][0]["value"].as_str().unwrap().to_owned());
                }
            }
            "foxglove.SceneUpdate" => {
                let entities = content["entities"].as_array().unwrap().iter();
                of_second[1].extend(entities.map(|entity| entity["id"].as_str().unwrap().to_owned()));
            }
            other => panic!("{other}"),
        }
    }
    assert!(tracks.len() >= 3, "{}", tracks.len());
    assert!(tracks.values().all(|[places, scene]| places == scene));
    assert!(tracks.values().last().unwrap()[0].len() > 60);
}

#[test]
fn a_recording_of_several_files_is_merged_and_cut() {
    let home = Home::new();
    // A file is as large as one flush makes it; compressed, a few seconds fit one file.
    let small =
        ["segment_mb=1", "flush_s=0.2", "compression=none"].map(|key| ["--set".to_owned(), format!("recorder.{key}")]);
    let small: Vec<&str> = small.iter().flatten().map(String::as_str).collect();
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
    let output = home.run(&[
        "recording",
        "cut",
        "one/all.mcap",
        "--topics",
        "system/track",
        "--out",
        "none.mcap",
    ]);
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(
        output.status.code() == Some(2) && said.contains("no topic system/track; its topics: "),
        "{said}"
    );
    assert!(!home.path("none.mcap").exists());
    check_repair(&home, several.topics["system/tracks"].samples);
    check_damage_is_reported(&home);
}

/// Wrong bits in `one/all.mcap`, which has so many samples of system tracks, cost the chunks that they are in.
fn check_repair(home: &Home, states: u64) {
    const HEAD: usize = 9;
    let mut octets = std::fs::read(home.path("one/all.mcap")).unwrap();
    let (mut at, mut chunks) = (8, Vec::new());
    while at + HEAD < octets.len() {
        let end = at + HEAD + u64::from_le_bytes(octets[at + 1..at + HEAD].try_into().unwrap()) as usize;
        if octets[at] == 0x06 {
            chunks.push((at + end) / 2);
        }
        at = end;
    }
    // In the middle: the chunks before and behind it stay.
    octets[chunks[chunks.len() / 2]] ^= 1;
    std::fs::write(home.path("damaged.mcap"), octets).unwrap();
    let said = succeed(home, &["recording", "info", "damaged.mcap"]);
    assert!(said.contains("damaged parts: "), "{said}");
    let said = succeed(home, &["recording", "repair", "damaged.mcap", "--out", "repaired.mcap"]);
    assert!(said.contains("; damaged parts skipped: "), "{said}");
    let mut repaired = Survey::default();
    repaired
        .add(&mut File::open(home.path("repaired.mcap")).unwrap())
        .unwrap();
    let left = repaired.topics["system/tracks"].samples;
    assert!(
        (repaired.damaged, repaired.torn) == (0, 0) && (1..=states).contains(&left),
        "{left}"
    );
    for out in ["--out", "--csv", "--asterix", "--foxglove"] {
        let command = if out == "--out" { "cut" } else { "export" };
        let output = home.run(&["recording", command, "one/all.mcap", out, "one/all.mcap/o"]);
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(said.contains("one/all.mcap/o: cannot be written: "), "{said}");
    }
    let output = home.run(&["recording", "info", "out/latest/system_tracks.csv"]);
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(
        output.status.code() == Some(2) && said.contains("is no recording of all topics"),
        "{said}"
    );
}

/// A wrong bit in the length of an index costs no sample, but the recording is damaged. Of a recording with one chunk,
/// which is damaged, nothing can be copied.
fn check_damage_is_reported(home: &Home) {
    const HEAD: usize = 9;
    let whole = std::fs::read(home.path("one/all.mcap")).unwrap();
    let place_of = |wanted: u8| {
        let mut at = 8;
        while whole[at] != wanted {
            at += HEAD + u64::from_le_bytes(whole[at + 1..at + HEAD].try_into().unwrap()) as usize;
        }
        at
    };
    let mut octets = whole.clone();
    octets[place_of(0x07) + 2] ^= 4;
    std::fs::write(home.path("index.mcap"), octets).unwrap();
    assert!(succeed(home, &["replay", "one/all.mcap", "--verify"]).contains(", 0 differences\n"));
    let output = home.run(&["replay", "index.mcap", "--verify"]);
    let (given, said) = (
        String::from_utf8_lossy(&output.stdout),
        String::from_utf8_lossy(&output.stderr),
    );
    assert_eq!(output.status.code(), Some(1), "{given}{said}");
    assert!(
        given.contains(", 0 differences\n") && given.contains("damaged parts skipped: 1 ("),
        "{given}{said}"
    );
    // The first chunk, which is damaged, without an end.
    let mut octets = whole[..place_of(0x07)].to_vec();
    *octets.last_mut().unwrap() ^= 1;
    std::fs::write(home.path("nothing.mcap"), octets).unwrap();
    let output = home.run(&["recording", "repair", "nothing.mcap", "--out", "repaired_nothing.mcap"]);
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(
        output.status.code() == Some(2) && said.contains("nothing.mcap: no sample can be read"),
        "{said}"
    );
    assert!(!home.path("repaired_nothing.mcap").exists());
}

/// A full disk costs samples of the recording, and nothing else. Needs a namespace of its own for a small disk.
#[test]
fn a_full_disk_costs_samples_which_are_counted_and_the_recording_goes_on() {
    const DISK: &str = "mkdir disk && mount -t tmpfs -o size=3m tmpfs disk && head -c 2500000 /dev/zero > disk/other";
    let home = Home::new();
    let can = home.command(&[]);
    let executable = can.get_program().to_owned();
    let mut command = Command::new("unshare");
    command.args(["--map-root-user", "--mount", "sh", "-c"]);
    command.arg(format!("{DISK} && exec \"$0\" \"$@\""));
    command.arg(executable);
    command.args([
        "demo",
        "--set",
        "recorder.enabled=true",
        "--set",
        "recorder.format=[\"mcap\"]",
        // So that the disk is full soon.
        "--set",
        "recorder.compression=none",
        "--out",
        "disk/out",
    ]);
    command.envs(can.get_envs().filter_map(|(name, value)| Some((name, value?))));
    command.current_dir(home.path("."));
    command
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped());
    let probe = ["--map-root-user", "--mount", "mount", "-t", "tmpfs", "tmpfs", "/mnt"];
    if !Command::new("unshare")
        .args(probe)
        .status()
        .is_ok_and(|status| status.success())
    {
        eprintln!("not tried: this machine gives nobody a namespace");
        return;
    }
    let running = home.start_command(&mut command);
    running.until_said("cannot be written");
    let disk = Path::new("/proc").join(running.pid().to_string()).join("root");
    let disk = disk.join(home.path("disk").strip_prefix("/").unwrap());
    std::fs::remove_file(disk.join("other")).unwrap();
    let folder = disk.join("out/latest");
    until("it writes again", || {
        let files = std::fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path());
        let latest = files
            .filter(|path| path.extension().is_some_and(|ending| ending == "mcap"))
            .max();
        latest.is_some_and(|path| !path.ends_with("all_topics_000001.mcap") && path.metadata().unwrap().len() > 100_000)
    });
    let (survey, _) = survey(&folder);
    let tracks = &survey.topics["system/tracks"];
    assert!(tracks.samples > 0 && tracks.tally.lost > 0, "{tracks:?}");
    let (status, said) = running.stop();
    assert_eq!(said.matches("cannot be written (").count(), 1, "{said}");
    assert_eq!(status.code(), Some(1), "{said}");
    assert!(
        said.contains("could not be written") && said.contains("it lacks"),
        "{said}"
    );
}

/// Kills recorders at random moments: each file opens, and of each publisher as many samples are counted as lost as are
/// not in the files.
#[test]
#[ignore = "takes three minutes: run it by its name"]
fn two_hundred_kills_of_the_recorder() {
    let count = std::env::var("KOSEKI_KILLS").ok().and_then(|times| times.parse().ok());
    kill_recorders(count.unwrap_or(200));
}

#[test]
fn losses_are_counted_through_kills_of_the_recorder() {
    kill_recorders(5);
}

fn kill_recorders(kills: usize) {
    const ALL: [&str; 4] = ["--set", "recorder.format=[\"mcap\"]", "--set", "recorder.flush_s=0.1"];
    let home = Home::new();
    let demo = home.demo_with(&[&ALL[..], &["--set", "recorder.enabled=false"]].concat());
    let bus: Bus<SharedMemory> = Bus::open(&home.root("demo"), "test").unwrap();
    // Not the launcher's, which would wait longer and longer before the next one.
    let serve = [
        "recorder",
        "--config",
        "demo.toml",
        "--instance",
        "demo",
        "--out",
        "out",
        "--scenario-start",
        "0",
    ];
    std::fs::copy(repository("config/demo.toml"), home.path("demo.toml")).unwrap();
    let start = || {
        home.command(&[&serve[..], &ALL].concat())
            .stderr(Stdio::inherit())
            .spawn()
            .unwrap()
    };
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let file = |number: usize| home.path(&format!("out/all_topics_{number:06}.mcap"));
    for number in 1..=kills {
        let mut recorder = start();
        until("it has begun", || file(number).exists());
        std::thread::sleep(Duration::from_micros(random.random_range(0..400_000)));
        recorder.kill().unwrap();
        recorder.wait().unwrap();
        bus.remove_dead();
    }
    let mut last = start();
    until("the last one writes", || {
        std::fs::metadata(file(kills + 1)).is_ok_and(|file| file.len() > 40_000)
    });
    kill(last.id(), Signal::TERM);
    assert!(last.wait().unwrap().success());
    let (survey, files) = survey(&home.path("out"));
    // Of a recorder that was killed before it had said anything there is no file.
    assert!(survey.torn == 0 && files > 1 && files <= kills + 1, "{files}");
    let since_ns: u64 = survey.facts["since_ns"].parse().unwrap();
    let (mut all, mut counted) = (0, 0);
    for (name, (heard, published)) in heard(&home.path("out")) {
        // Of a publisher that was there before the recording, this begins with the first sample that came.
        let begin = |(incarnation, (first, _)): (&u64, &(u64, u64))| if *incarnation < since_ns { *first } else { 0 };
        let begins: u64 = published.iter().map(begin).sum();
        let missing = published.values().map(|(_, next)| next).sum::<u64>() - begins - heard;
        assert_eq!(survey.topics[&name].tally.lost, missing, "{name}");
        all += heard;
        counted += missing;
    }
    assert!(all > 0 && counted > 0, "{all} {counted}");
    println!("{kills} kills: {all} samples in {files} files that open, {counted} lost and counted");
    demo.stop();
}

/// Samples of each topic of data in the files, and the first and the next sequence number of each of its publishers.
type Heard = BTreeMap<String, (u64, BTreeMap<u64, (u64, u64)>)>;

fn heard(folder: &Path) -> Heard {
    let mut heard = Heard::new();
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut files: Vec<_> = entries
        .filter(|path| path.extension().is_some_and(|ending| ending == "mcap"))
        .collect();
    files.sort();
    for file in files {
        let mut publisher = 0;
        let visit = |item: Item<'_>| {
            match item {
                Item::Slice { topic, header, .. } if topic.contains("/tracks") => {
                    publisher = header.incarnation;
                    let (_, publishers) = heard.entry(topic.to_owned()).or_default();
                    let (_, next) = publishers.entry(publisher).or_insert((header.first_sequence, 0));
                    *next = header.first_sequence;
                }
                Item::Sample { topic, .. } if topic.contains("/tracks") => {
                    let (samples, publishers) = heard.get_mut(topic).unwrap();
                    *samples += 1;
                    publishers.get_mut(&publisher).unwrap().1 += 1;
                }
                _ => {}
            }
            Ok::<_, RecordingError>(())
        };
        ::recording::read(&mut File::open(file).unwrap(), visit).unwrap();
    }
    heard
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
            std::fs::metadata(latest).is_ok_and(|file| file.len() > 40_000)
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
