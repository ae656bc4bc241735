//! What a kill preserves, a planned stop preserves, too: no number is given twice, and the same targets keep theirs.
//!
//! A simulated world begins anew with each start, unless its begin is given: then its targets fly on meanwhile.

use std::fs;
use std::path::PathBuf;

use bus::Bus;
use runtime::Now;
use rustix::process::Signal;
use scoring::NumberTally;

use crate::common::{Home, Running, repository, until};
use crate::continuity::Watcher;

/// The first number that no numbering from 1 reaches within a day.
const ANEW: u32 = 1 << 31;
const SHOWN: usize = 30;

/// Watches until most targets are shown; `before` is the tally of earlier starts.
fn watched(home: &Home, before: NumberTally) -> NumberTally {
    watched_until(home, before, |tally| tally.shown_count() > SHOWN)
}

/// Watches a picture of another epoch than `before` until it holds enough.
fn watched_until(home: &Home, before: NumberTally, is_enough: impl Fn(&NumberTally) -> bool) -> NumberTally {
    let mut watcher = Watcher::new(&Bus::open(&home.root("demo"), "watcher").unwrap());
    watcher.tally = before;
    watcher.tally.begin();
    let mut epoch = watcher.tally.epoch();
    until("most targets are shown", || {
        watcher.look();
        if watcher.tally.epoch() > epoch {
            epoch = u64::MAX;
            watcher.tally.begin();
        }
        epoch == u64::MAX && is_enough(&watcher.tally)
    });
    watcher.tally
}

fn stop(home: &Home, running: Running, signal: Signal) -> String {
    running.signal(signal);
    let (status, said) = running.end();
    assert_eq!(status.code(), Some(0), "{said}");
    home.assert_nothing_is_left("demo");
    said
}

/// Files of the last end in `folder`.
fn end_files(folder: &PathBuf) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder)
        .into_iter()
        .flatten()
        .flatten()
        .map(|entry| entry.path());
    entries
        .filter(|path| path.extension().is_some_and(|end| end == "end"))
        .collect()
}

#[test]
fn a_new_world_gets_no_number_of_the_last_one() {
    let home = Home::new();
    let disk = home.path("disk");
    let folder = format!("checkpoint.folder=\"{}\"", disk.display());
    let durable = ["--set", &folder, "--set", "checkpoint.durable=true"];
    let start = |seed| home.demo_with(&[&["--seed", seed], &durable[..]].concat());

    let demo = start("71");
    let first = watched(&home, NumberTally::default());
    stop(&home, demo, Signal::TERM);
    let checkpoint = home.base().join("demo.checkpoint.end");
    let size = fs::metadata(&checkpoint).unwrap().len() as usize;
    assert!(
        size <= 2048 * first.live().len(),
        "{size} bytes for {} tracks",
        first.live().len()
    );
    assert!(disk.join("demo.checkpoint.end").exists());
    let status = home.status();
    assert!(status.contains(&checkpoint.display().to_string()), "{status}");

    let demo = start("72");
    let second = watched(&home, first);
    assert!(second.reused().is_empty(), "{:?}", second.reused());
    assert!(
        end_files(&home.base()).is_empty() && end_files(&disk).is_empty(),
        "a later death must not find them"
    );
    stop(&home, demo, Signal::INT);

    for file in [end_files(&home.base()), end_files(&disk)].concat() {
        fs::remove_file(file).unwrap();
    }
    let demo = start("73");
    let third = watched(&home, second);
    assert!(third.reused().is_empty(), "{:?}", third.reused());
    assert!(third.live().iter().any(|number| *number >= ANEW), "{:?}", third.live());
    stop(&home, demo, Signal::TERM);
}

#[test]
fn copies_that_cannot_be_written_are_an_alarm_until_they_can() {
    let home = Home::new();
    let disk = home.path("disk");
    let folder = format!("checkpoint.folder=\"{}\"", disk.display());
    let every = "checkpoint.copy_every_s=0.2";
    let demo = home.demo_with(&["--set", &folder, "--set", "checkpoint.durable=true", "--set", every]);
    // Nobody, root included, can write into a file as a folder.
    until("the folder is a file", || {
        let _ = fs::remove_dir_all(&disk);
        fs::write(&disk, "").is_ok()
    });
    let stands = || {
        home.status()
            .contains("  alarm, major: The memory for a start after a loss of power is not written")
    };
    until("the alarm is raised", stands);
    fs::remove_file(&disk).unwrap();
    fs::create_dir(&disk).unwrap();
    until("the alarm is cleared", || !stands());
    stop(&home, demo, Signal::TERM);
}

#[test]
fn the_same_targets_keep_their_numbers_over_a_planned_stop() {
    let home = Home::new();
    let begin = Now::read().utc_ns.to_string();
    let config = repository("config/demo.toml").display().to_string();
    let start = |more: &[&str]| {
        let up = ["up", &config, "--instance", "demo", "--scenario-start", &begin];
        // A slow machine takes longer than the default to start again.
        let up = home.start(&[&up[..], &["--set", "checkpoint.max_age_s=600"], more].concat());
        up.until_said("instance demo runs");
        up
    };
    let up = start(&[]);
    let first = watched(&home, NumberTally::default());
    let said = stop(&home, up, Signal::TERM);
    assert!(said.contains("the next start goes on from"), "{said}");

    let up = start(&[]);
    // Most targets go on, however long the second start takes.
    let carriers = first.carriers();
    let second = watched_until(&home, first.clone(), |tally| {
        2 * carriers.keys().filter(|address| tally.shown(**address)).count() > carriers.len()
    });
    assert!(up.said().contains("going on from"), "{}", up.said());
    assert_eq!(second.renumbered(&first), []);
    assert!(second.reused().is_empty(), "{:?}", second.reused());
    stop(&home, up, Signal::INT);

    let damaged = home.base().join("demo.checkpoint.end");
    let mut octets = fs::read(&damaged).unwrap();
    let middle = octets.len() / 2;
    octets[middle] ^= 1;
    fs::write(&damaged, octets).unwrap();
    let up = start(&[]);
    let anew = watched(&home, NumberTally::default());
    assert!(anew.live().iter().all(|number| *number >= ANEW), "{:?}", anew.live());
    assert!(up.said().contains("cannot be used"), "{}", up.said());
    stop(&home, up, Signal::TERM);

    let up = start(&["--fresh"]);
    let fresh = watched(&home, NumberTally::default());
    let last = anew.live().last().unwrap();
    assert!(fresh.live().iter().all(|number| number > last), "{:?}", fresh.live());
    stop(&home, up, Signal::TERM);
}
