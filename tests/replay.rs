//! `koseki replay`: recordings of deployments whose processes were killed, fused again to the bit.
//!
//! The campaign is every kind of deployment for a minute, with ten kills of random children, and with two of the
//! recorder, three times each: `cargo test -p koseki --test integration replay_campaign -- --ignored --nocapture`, with
//! `--release` for the other build. `KOSEKI_SECONDS` and `KOSEKI_RUNS` say otherwise how long, and how often.

use std::fs::{self, File};
use std::io::{BufWriter, Cursor};
use std::path::Path;
use std::thread;
use std::time::Duration;

use ::recording::{Channel, Facts, Item, RecordingError, Writer};
use messages::layout::{ALL, Layout, Sample as _};
use messages::{BatchHeader, SystemTrack};
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use rustix::process::Signal;
use test_support::recordings;

use crate::common::home::{Home, kill, until};
use crate::common::repository;
use crate::kills::children;

const ALL_TOPICS: [&str; 4] = [
    "--set",
    "recorder.enabled=true",
    "--set",
    "recorder.format=[\"csv\", \"mcap\"]",
];

fn rows(home: &Home) -> usize {
    let file = home.path("out/latest/system_tracks.csv");
    fs::read_to_string(file).map_or(0, |text| text.lines().count())
}

/// Kills the process of this name, and waits until its deployment goes on.
fn kill_and_wait(home: &Home, name: &str) {
    let before = home.status_row(name);
    kill(before.pid, Signal::KILL);
    until("there is a successor", || home.status_row(name).pid != before.pid);
    let had = rows(home);
    until("there are new rows", || rows(home) > had + 100);
}

/// Words of a verification of a folder or file, after it has found no difference.
fn without_difference(home: &Home, recording: &str) -> String {
    let output = home.run(&["replay", recording, "--verify"]);
    let said = String::from_utf8(output.stdout).unwrap();
    assert!(
        output.status.success() && said.contains(", 0 differences\n"),
        "{said}{}",
        String::from_utf8_lossy(&output.stderr)
    );
    said
}

/// The same of all of the latest recording.
fn verified(home: &Home) {
    let said = without_difference(home, "out/latest");
    assert!(!said.contains("not verified"), "{said}");
}

/// The latest file of all topics.
fn latest_file(home: &Home) -> String {
    let files = fs::read_dir(home.path("out/latest")).unwrap();
    let names = files.map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let latest = names.filter(|name| name.ends_with(".mcap")).max().unwrap();
    format!("out/latest/{latest}")
}

#[test]
fn what_a_restarted_recorder_has_is_fused_again_from_an_image_on() {
    let home = Home::new();
    let demo = home.demo_with(&[&ALL_TOPICS[..], &["--out", "out"]].concat());
    until("there are rows", || rows(&home) > 100);
    for _ in 0..2 {
        kill_and_wait(&home, "recorder");
        until("there is an image", || {
            let output = home.run(&["recording", "info", &latest_file(&home)]);
            let said = String::from_utf8(output.stdout).unwrap();
            said.contains("system/restored") && number_after("system/restored", &said) > 0
        });
        let had = rows(&home);
        until("there are new rows", || rows(&home) > had + 100);
    }
    let (status, said) = demo.stop();
    assert!(status.success(), "{said}");
    let all = without_difference(&home, "out/latest");
    // The seconds without a recorder are missing, and what follows each up to the image; nothing else is.
    assert!(all.contains("not verified"), "{all}");
    let in_latest = without_difference(&home, &latest_file(&home));
    let states = |said: &str| number_before("track", said);
    assert!(states(&all) > states(&in_latest) + 100, "{all}{in_latest}");
}

#[test]
fn a_demonstration_with_kills_and_orders_is_fused_again_to_the_bit_and_a_difference_is_found() {
    let home = Home::new();
    let rain = ["--set", "source[0].accuracy.conditions={ rain = 9.0 }", "--out", "out"];
    let demo = home.demo_with(&[&ALL_TOPICS[..], &rain].concat());
    until("there are rows", || rows(&home) > 100);
    assert!(home.run(&["condition", "rain", "--instance", "demo"]).status.success());
    kill_and_wait(&home, "radar-west");
    kill_and_wait(&home, "fusion");
    kill_and_wait(&home, "ads-b");
    let (status, said) = demo.stop();
    assert!(status.success(), "{said}");
    verified(&home);

    let again = home.run(&["replay", "out/latest", "--out", "again.csv"]);
    assert!(again.status.success(), "{again:?}");
    let recorded = fs::read(home.path("out/latest/system_tracks.csv")).unwrap();
    assert!(fs::read(home.path("again.csv")).unwrap() == recorded);

    fs::create_dir(home.path("other")).unwrap();
    let files = fs::read_dir(home.path("out/latest"))
        .unwrap()
        .map(|entry| entry.unwrap().path());
    for path in files.filter(|path| path.extension().is_some_and(|ending| ending == "mcap")) {
        change(&path, &home.path("other").join(path.file_name().unwrap()));
    }
    let output = home.run(&["replay", "other", "--verify"]);
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(
        said.contains("1 track states differ") && said.contains("velocity_mps[1] differs"),
        "{said}"
    );
}

/// Copies a recording with one number of one state changed.
fn change(from: &Path, to: &Path) {
    let mut writer = None;
    let mut channels: Vec<(String, Channel)> = Vec::new();
    let mut slice: Option<(String, BatchHeader, Vec<u8>)> = None;
    let mut states = 0;
    let mut file = Cursor::new(fs::read(from).unwrap());
    let mut show = |item: Item<'_>| -> Result<(), RecordingError> {
        match item {
            Item::Damaged { bytes, reason } => panic!("{bytes:?}: {reason}"),
            Item::Facts(facts) => writer = Some(begin(to, &facts)),
            Item::Topic { name, schema, .. } => {
                let has_name = |layout: &&Layout| schema.ends_with(&format!("/{}", layout.name));
                let layout = ALL.iter().find(has_name).unwrap();
                channels.push((name.to_owned(), writer.as_mut().unwrap().channel(name, layout).unwrap()));
            }
            Item::Slice { topic, header, .. } => {
                if let Some((topic, header, octets)) = slice.take() {
                    let (_, channel) = channels.iter().find(|(name, _)| *name == topic).unwrap();
                    writer.as_mut().unwrap().slice(*channel, &header, &octets, 0, 0)?;
                }
                slice = Some((topic.to_owned(), header, Vec::new()));
            }
            Item::Sample { topic, octets } => {
                let (_, _, gathered) = slice.as_mut().unwrap();
                gathered.extend_from_slice(octets);
                if topic == "system/tracks" {
                    states += 1;
                }
                if topic == "system/tracks" && states == 50 {
                    let mut state = SystemTrack::of_octets(octets).unwrap();
                    state.velocity_mps[1] += 1e-12;
                    let first = gathered.len() - octets.len();
                    gathered[first..].copy_from_slice(SystemTrack::octets(&[state]));
                }
            }
        }
        Ok(())
    };
    ::recording::read(&mut file, &mut show).unwrap();
    writer.unwrap().finish().unwrap();
}

fn begin(to: &Path, facts: &Facts) -> Writer<BufWriter<File>> {
    Writer::begin(BufWriter::new(File::create(to).unwrap()), facts).unwrap()
}

const CROWD: &str = r#"name = "crowd"
[frame]
latitude_deg = 41.297063
longitude_deg = 2.078447
[scenario]
targets = 14000
[[source]]
name = "multilateration"
period_s = 4.0
[source.simulated]
kind = "multilateration"
[source.limits]
tracks = 20000
[source.covariance]
from = "report"
position_sigma_m = 5.0
[fusion.capacity]
system_tracks = 20000
sensor_tracks = 20000
[recorder]
format = ["csv", "mcap"]
"#;

#[test]
fn a_start_from_thousands_of_tracks_is_recorded_whole() {
    let home = Home::new();
    fs::write(home.path("crowd.toml"), CROWD).unwrap();
    let running = home.start(&["up", "crowd.toml", "--out", "out"]);
    until("most targets have tracks", || rows(&home) > 28_000);
    let before = home.status_row("fusion").pid;
    kill(before, Signal::KILL);
    until("there is a successor", || home.status_row("fusion").pid != before);
    let had = rows(&home);
    until("it goes on", || rows(&home) > had + 14_000);
    let (status, said) = running.stop();
    assert!(status.success(), "{said}");
    verified(&home);
}

#[test]
fn recordings_through_kills_are_fused_again_in_order_of_time() {
    recordings_through_kills("time");
}

#[test]
fn recordings_through_kills_are_fused_again_in_order_of_arrival() {
    recordings_through_kills("arrival");
}

fn recordings_through_kills(order: &str) {
    let Some(data) = recordings("lebl2016") else { return };
    let home = Home::new();
    let config = repository("config/barcelona.toml");
    let (config, data) = (config.to_str().unwrap(), data.to_str().unwrap());
    let order = format!("time.order=\"{order}\"");
    // So slow that the recording outlasts all kills on any machine.
    let up = [
        "up", config, "--data", data, "--speed", "100", "--out", "out", "--set", &order,
    ];
    let running = home.start(&[&up[..], &ALL_TOPICS].concat());
    until("there are rows", || rows(&home) > 1000);
    for name in ["fusion", "ads-b", "fusion"] {
        kill_and_wait(&home, name);
    }
    let (status, said) = running.stop();
    assert!(status.success(), "{said}");
    verified(&home);
}

const AGAIN: &str = r#"name = "again"
[frame]
latitude_deg = 41.297063
longitude_deg = 2.078447
[[source]]
name = "ads-b"
[source.external]
[[source]]
name = "multilateration"
[source.external]
[fusion.rule]
name = "best-source"
"#;

/// The number that stands after `word` in what was said.
fn number_after(word: &str, said: &str) -> u64 {
    let (_, rest) = said.split_once(word).unwrap();
    rest.split_whitespace().next().unwrap().parse().unwrap()
}

/// The number that stands before `word` in what was said.
fn number_before(word: &str, said: &str) -> u64 {
    let words: Vec<&str> = said.split([' ', '\n', ',']).filter(|word| !word.is_empty()).collect();
    let place = words.iter().position(|other| *other == word).unwrap();
    words[place - 1].parse().unwrap()
}

#[test]
fn recorded_traffic_is_fused_otherwise_and_goes_into_another_deployment() {
    let home = Home::new();
    let (status, said) = home
        .start(&[&["demo", "--for", "4", "--out", "out"], &ALL_TOPICS[..]].concat())
        .end();
    assert!(status.success(), "{said}");
    fs::write(home.path("again.toml"), AGAIN).unwrap();
    let replay = |more: &[&str]| {
        let output = home.run(&[&["replay", "out/latest"], more].concat());
        let said = String::from_utf8(output.stdout).unwrap();
        assert!(output.status.success() && !said.contains("missing"), "{more:?}: {said}");
        said
    };
    let reports = |more: &[&str]| number_before("reports", &replay(more));
    let all = reports(&[]);
    let two = reports(&["--config", "again.toml", "--out", "two.csv"]);
    let one = reports(&["--config", "again.toml", "--sources", "ads-b"]);
    assert!(all > two && two > one && one > 100, "{all}, {two}, {one}");
    let rows = fs::read_to_string(home.path("two.csv")).unwrap();
    assert!(rows.lines().count() > 100, "{rows}");
    let after = reports(&["--from", "2100-01-01T00:00:00Z", "--out", "none.csv"]);
    assert_eq!(after, all, "what is left out is what is written, not what is known");

    let again = home.start(&["up", "again.toml"]);
    again.until_said("instance again runs");
    let said = replay(&["--live", "--instance", "again", "--sources", "ads-b,multilateration"]);
    assert_eq!(number_before("reports", &said), two, "{said}");
    let rows = |file: &str| {
        let path = home.path("records/again/latest").join(file);
        fs::read_to_string(path).unwrap_or_default()
    };
    let taken = ["sensor_tracks_ads-b.csv", "sensor_tracks_multilateration.csv"];
    let count = || {
        taken
            .iter()
            .map(|file| rows(file).lines().skip(1).count() as u64)
            .sum::<u64>()
    };
    until("all of them are taken", || count() == two);
    until("tracks are confirmed", || {
        rows("system_tracks.csv").contains(",confirmed,")
    });
    let (status, said) = again.stop();
    assert!(status.success(), "{said}");
}

/// Value of an environment variable, if it is a number.
fn stated(variable: &str) -> Option<u64> {
    std::env::var(variable).ok()?.parse().ok()
}

#[test]
#[ignore = "takes half an hour: run it by its name"]
fn replay_campaign() {
    let length = Duration::from_secs(stated("KOSEKI_SECONDS").unwrap_or(60));
    let config = |name: &str| repository("config").join(name).to_str().unwrap().to_owned();
    let up = |name: &str, more: &[&str]| -> Vec<String> {
        let more = more.iter().map(|word| (*word).to_owned());
        ["up".to_owned(), config(name)].into_iter().chain(more).collect()
    };
    let mut deployments = vec![
        ("demo", up("demo.toml", &[])),
        ("coast", up("coast.toml", &[])),
        ("wide-area", up("wide-area.toml", &[])),
    ];
    if let Some(data) = recordings("lebl2016") {
        let data = ["--data", data.to_str().unwrap(), "--speed", "10"];
        deployments.push(("barcelona", up("barcelona.toml", &data)));
    }
    let mut random = ChaCha8Rng::seed_from_u64(18);
    for run in 1..=stated("KOSEKI_RUNS").unwrap_or(3) {
        for (name, up) in &deployments {
            for (victims, kills) in [("children", 10), ("the recorder", 2)] {
                let is_victim = |child: &str| (child == "recorder") == (kills == 2);
                let said = verified_after_kills(up, length, kills, &mut random, is_victim);
                println!(
                    "run {run}, {name}, {kills} kills of {victims}: {}",
                    said.trim().replace('\n', "; ")
                );
            }
        }
    }
}

/// Words of the verification of a deployment that ran so long while so many of its children were killed.
fn verified_after_kills(
    up: &[String],
    length: Duration,
    kills: u32,
    random: &mut ChaCha8Rng,
    is_victim: impl Fn(&str) -> bool,
) -> String {
    let home = Home::new();
    let up: Vec<&str> = up.iter().map(String::as_str).collect();
    let running = home.start(&[&up[..], &["--out", "out"], &ALL_TOPICS[..]].concat());
    until("there are rows", || rows(&home) > 10);
    for _ in 0..kills {
        thread::sleep(length / (kills + 1));
        let children = children(&running);
        let victims: Vec<u32> = children
            .iter()
            .filter(|(name, _)| is_victim(name))
            .map(|(_, pid)| *pid)
            .collect();
        if !victims.is_empty() {
            kill(victims[random.random_range(0..victims.len())], Signal::KILL);
        }
    }
    thread::sleep(length / (kills + 1));
    let (status, said) = running.stop();
    assert!(status.success(), "{said}");
    without_difference(&home, "out/latest")
}
