//! `koseki torture` judges a deployment, and can be judged itself: by its exit codes, its records, and by defects.
//!
//! The command plants defects in records itself (`--self-test`). Those that are caused in a live deployment, by a hand
//! of which the command knows nothing, are a campaign of some five minutes:
//! `cargo test --manifest-path lab/Cargo.toml caused_from_outside -- --ignored --nocapture --test-threads 1`.

use std::fs;
use std::os::unix::fs::FileExt as _;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use rustix::process::{Pid, Signal, kill_process};
use serde_json::Value;

use crate::common::{Home, Running, until};

/// Longest that a run may take, on whatever machine.
const PATIENCE: Duration = Duration::from_secs(400);

fn json(home: &Home) -> Value {
    serde_json::from_str(&home.read("result.json")).unwrap()
}

/// Starts a run that writes its result.
fn start(home: &Home, arguments: &[&str]) -> Running {
    let result = home.path("result.json");
    let mut command = home.command(&["torture", "--json", result.to_str().unwrap()]);
    home.start_command(command.args(arguments).env("TMPDIR", home.path("")))
}

fn code(home: &Home, arguments: &[&str]) -> (Option<i32>, String) {
    let output = home.run(&[&["torture"], arguments].concat());
    let said = [output.stdout, output.stderr].concat();
    (output.status.code(), String::from_utf8(said).unwrap())
}

#[test]
fn the_judge_finds_each_defect_that_the_command_plants() {
    let (code, said) = code(&Home::new(), &["--self-test"]);
    assert_eq!(code, Some(0), "{said}");
    assert_eq!(
        (said.matches("found   ").count(), said.matches("missed").count()),
        (43, 0),
        "{said}"
    );
}

#[test]
fn a_run_is_recorded_and_judged_again() {
    let home = Home::new();
    let record = home.path("events.jsonl");
    let record = record.to_str().unwrap();
    let faults = ["--only", "flood-of-orders", "--minutes", "0.15"];
    let (status, said) = start(&home, &[&faults[..], &["--record", record]].concat()).end();
    assert_eq!(status.code(), Some(0), "{said}\n{}", home.read("result.json"));
    let result = json(&home);
    assert_eq!(result["outcome"], "sound", "{result}");
    assert!(!result["faults"].as_array().unwrap().is_empty(), "{result}");
    let seconds = |key: &str| result["figures"]["picture"][key].as_u64().unwrap();
    assert!(seconds("seconds") > 2 && seconds("targets_s") > 100, "{result}");
    assert_eq!(
        (seconds("missing_s"), seconds("double_s"), seconds("ghosts_s")),
        (0, 0, 0)
    );

    assert_eq!(code(&home, &["--judge", record]).0, Some(0));
    let events = home.read("events.jsonl");
    let half = events.len() / 2 + events[events.len() / 2..].find('\n').unwrap();
    let number = events[half..].split("\"number\":").nth(1).unwrap();
    let number = format!("\"number\":{},", number.split(',').next().unwrap());
    let other = events[half..].replace(&number, "\"number\":4000000000,");
    home.write("events.jsonl", format!("{}{other}", &events[..half]));
    let (verdict, said) = code(&home, &["--judge", record]);
    assert_eq!(verdict, Some(1), "{said}");
    home.write("events.jsonl", &events[..half - 10]);
    let (refused, said) = code(&home, &["--judge", record]);
    assert!(refused == Some(2) && said.contains("events.jsonl, line "), "{said}");
}

#[test]
fn an_interrupted_run_has_a_result_and_no_verdict() {
    let home = Home::new();
    let run = start(&home, &["--only", "none", "--minutes", "9"]);
    until("it looks on", || run.stdout.lock().unwrap().contains("limits: "));
    run.signal(Signal::INT);
    let (status, said) = run.end();
    assert_eq!(status.code(), Some(3), "{said}");
    assert_eq!(json(&home)["outcome"], "interrupted");
    assert_eq!(json(&home)["failure"], "interrupted");
}

#[test]
fn a_failure_of_the_command_is_no_verdict() {
    let home = Home::new();
    let result = home.path("result.json");
    let mut command = home.command(&["torture", "--json", result.to_str().unwrap()]);
    let (status, said) = home.start_command(command.env("TMPDIR", home.path("nowhere"))).end();
    assert_eq!(status.code(), Some(3), "{said}");
    assert!(said.contains("no verdict: making a folder"), "{said}");
    assert_eq!(json(&home)["outcome"], "failed");
    assert_eq!(code(&home, &["--only", "nothing-of-the-kind"]).0, Some(2));
    assert_eq!(code(&home, &["--minutes", "many"]).0, Some(2));
}

/// A deployment under torture, seen from outside.
struct Outside<'a> {
    home: &'a Home,
    torture: u32,
}

impl Outside<'_> {
    fn children(pid: u32) -> Vec<(u32, String)> {
        let pids = fs::read_to_string(format!("/proc/{pid}/task/{pid}/children")).unwrap_or_default();
        let named = pids.split_whitespace().filter_map(|pid| {
            let command = fs::read_to_string(format!("/proc/{pid}/cmdline")).ok()?;
            Some((pid.parse().ok()?, command.replace('\0', " ")))
        });
        named.collect()
    }

    fn launcher(&self) -> Option<u32> {
        let children = Self::children(self.torture);
        children
            .iter()
            .find(|(_, command)| command.contains(" up "))
            .map(|(pid, _)| *pid)
    }

    fn fusions(&self) -> Vec<u32> {
        let children = self.launcher().map(Self::children).unwrap_or_default();
        let is_fusion = |(pid, command): (u32, String)| command.contains(" fusion ").then_some(pid);
        children.into_iter().filter_map(is_fusion).collect()
    }

    /// The link to fusion's checkpoint.
    fn link(&self) -> Option<PathBuf> {
        let folders = fs::read_dir(self.home.path("")).unwrap().flatten();
        let mut links = folders.map(|folder| folder.path().join("koseki/torture.checkpoint"));
        links.find(|link| link.is_symlink())
    }

    /// The checkpoint itself, perhaps in a file system of the command's own.
    fn checkpoint(&self) -> Option<fs::File> {
        let place = fs::read_link(self.link()?).ok()?;
        let place = format!("/proc/{}/root{}", self.torture, place.display());
        fs::File::options().read(true).write(true).open(place).ok()
    }

    fn signal(pid: u32, signal: Signal) {
        // The process may have ended.
        let _ = kill_process(Pid::from_raw(pid as i32).unwrap(), signal);
    }
}

/// Runs a deployment on which a hand from outside does `damage` again and again, after a few faults and until the time
/// that it is given is over; `true` as argument the last time.
fn caused_from_outside(
    arguments: &[&str],
    finding: &str,
    for_s: u64,
    damage: impl Fn(&Outside<'_>, bool) + Send + Sync,
) {
    let home = Home::new();
    let run = start(&home, arguments);
    // By then, targets are shown.
    let faults = || run.stdout.lock().unwrap().matches("back after").count();
    until("a few faults are over", || faults() >= 3);
    let is_over = Arc::new(AtomicBool::new(false));
    let outside = Outside {
        home: &home,
        torture: run.pid(),
    };
    let begun = Instant::now();
    let mut run = run;
    thread::scope(|scope| {
        let is_over = Arc::clone(&is_over);
        let hand = Arc::clone(&is_over);
        scope.spawn(move || {
            while begun.elapsed() < Duration::from_secs(for_s) && !hand.load(Ordering::Relaxed) {
                damage(&outside, false);
                thread::sleep(Duration::from_millis(20));
            }
            damage(&outside, true);
        });
        while run.child.try_wait().unwrap().is_none() && begun.elapsed() < PATIENCE {
            thread::sleep(Duration::from_millis(50));
        }
        is_over.store(true, Ordering::Relaxed);
    });
    let (status, said) = run.end();
    println!("{finding}: {said}");
    let result = json(&home);
    assert_eq!(
        (status.code(), &result["outcome"]),
        (Some(1), &"faulty".into()),
        "{said}"
    );
    let findings = result["findings"].as_array().unwrap();
    assert!(findings.iter().any(|found| found["finding"] == finding), "{said}");
}

const KILLS: [&str; 6] = ["--only", "kill-fusion", "--minutes", "0.8", "--seed", "78"];
const HARMLESS: [&str; 4] = ["--only", "flood-of-orders", "--minutes", "1"];
/// Time for which a process is held: longer than any limit.
const HELD_S: u64 = 40;
const ALWAYS_S: u64 = 3600;

#[test]
#[ignore = "takes a minute; `.ci/campaign torture` runs it"]
fn a_checkpoint_whose_header_is_overwritten_is_a_defect_caused_from_outside() {
    caused_from_outside(&KILLS, "renumbered", ALWAYS_S, |outside, _| {
        if let Some(checkpoint) = outside.checkpoint() {
            let _ = checkpoint.write_at(&[0xa5; 64], 0);
        }
    });
}

#[test]
#[ignore = "takes a minute; `.ci/campaign torture` runs it"]
fn a_checkpoint_whose_link_is_removed_is_a_defect_caused_from_outside() {
    caused_from_outside(&KILLS, "renumbered", ALWAYS_S, |outside, _| {
        if let Some(link) = outside.link() {
            let _ = fs::remove_file(link);
        }
    });
}

#[test]
#[ignore = "takes a minute; `.ci/campaign torture` runs it"]
fn a_checkpoint_of_which_every_second_page_is_spoilt_is_a_defect_caused_from_outside() {
    caused_from_outside(&KILLS, "renumbered", ALWAYS_S, |outside, _| {
        if let Some(checkpoint) = outside.checkpoint() {
            let length = checkpoint.metadata().map_or(0, |found| found.len());
            for page in (8192..length).step_by(8192) {
                let _ = checkpoint.write_at(&[0xa5; 4096], page);
            }
        }
    });
}

#[test]
#[ignore = "takes a minute; `.ci/campaign torture` runs it"]
fn a_fusion_that_is_held_for_too_long_is_a_defect_caused_from_outside() {
    caused_from_outside(&HARMLESS, "missing", HELD_S, |outside, last| {
        for pid in outside.fusions() {
            Outside::signal(pid, if last { Signal::CONT } else { Signal::STOP });
        }
    });
}

#[test]
#[ignore = "takes a minute; `.ci/campaign torture` runs it"]
fn a_fusion_that_nobody_starts_again_is_a_defect_caused_from_outside() {
    caused_from_outside(&HARMLESS, "missing", HELD_S, |outside, last| {
        let Some(launcher) = outside.launcher() else { return };
        Outside::signal(launcher, if last { Signal::CONT } else { Signal::STOP });
        for pid in outside.fusions().into_iter().filter(|_| !last) {
            Outside::signal(pid, Signal::KILL);
        }
    });
}
