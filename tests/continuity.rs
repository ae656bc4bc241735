//! The picture goes on when fusion is killed: tracks keep their numbers, and no number is given twice. With a fusion
//! that stands by, it goes on at once.
//!
//! A few ends are tested always. For a campaign, some forty minutes a test, which prints what it measured:
//! `KOSEKI_KILLS=200 cargo test -p koseki --test integration continuity -- --nocapture`.
//!
//! An independent subscriber keeps the tally: who carries which number, by the addresses of the simulated aircraft.

use std::thread;
use std::time::{Duration, Instant};

use bus::{Bus, SharedMemory, Subscriber};
use messages::SystemTrack;
use rand::RngExt as _;
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use runtime::clock::mono_ns;
use runtime::instance::leading_fusion;
use rustix::process::Signal;
use scoring::NumberTally;

use crate::common::{Home, kill, until};

/// A process that has run for so long is started again at once when it dies.
const WELL: Duration = Duration::from_secs(11);
const SOON: Duration = Duration::from_millis(3500);
/// Time after a kill within which every target must be shown again.
const SHOWN_AGAIN: Duration = Duration::from_secs(8);

#[test]
fn a_killed_fusion_comes_back_with_the_same_tracks_under_the_same_numbers() {
    campaign(Signal::KILL, 3, 1, &[], Duration::from_secs(1));
}

#[test]
fn the_fusion_that_stands_by_takes_over_with_the_same_tracks_under_the_same_numbers() {
    campaign(Signal::KILL, 3, 3, &STANDBY, Duration::from_millis(150));
}

#[test]
fn a_leader_that_is_stopped_is_replaced_and_never_speaks_again() {
    campaign(Signal::STOP, 2, 5, &STANDBY, Duration::from_millis(150));
}

#[test]
fn a_leader_that_stands_still_before_anybody_has_seen_it_is_replaced_too() {
    let home = Home::new();
    // Nobody else notices.
    let demo = home.demo_with(&[&STANDBY[..], &["--set", "launcher.watchdog_s=3600"]].concat());
    let leads = || leading_fusion(&home.root("demo"));
    until("one leads", || leads().is_some());
    until("one stands by", || home.status_row("standby").state == "running");
    let (leader, standby) = (leads().unwrap(), home.status_row("standby").pid);
    kill(leader, Signal::STOP);
    kill(standby, Signal::KILL);
    until("another leads", || leads().is_some_and(|now| now != leader));
    let (status, said) = demo.stop();
    assert_eq!(status.code(), Some(0), "{said}");
    home.assert_nothing_is_left("demo");
}

#[test]
fn a_fusion_that_dies_again_and_again_is_restarted_without_a_pause() {
    const TIMES: usize = 6;
    let home = Home::new();
    let demo = home.demo();
    for restart in 1..=TIMES {
        kill(home.status_row("fusion").pid, Signal::KILL);
        demo.until_said(&format!("fusion restarted ({restart}), back after "));
    }
    let (status, said) = demo.stop();
    assert_eq!(status.code(), Some(0), "{said}");
    let at_once = "fusion was killed by SIGKILL; restarting it in 0.0 s";
    assert_eq!(said.matches(at_once).count(), TIMES, "{said}");
    home.assert_nothing_is_left("demo");
}

#[test]
fn the_core_of_fusion_belongs_to_whoever_leads() {
    if runtime::cores::available().len() < 2 {
        println!("skipped: it takes two cores");
        return;
    }
    let home = Home::new();
    let cores = [
        "fusion.standby=true",
        "fusion.core=0",
        "fusion.standby_core=1",
        "fusion.required=true",
    ];
    let demo = home.demo_with(&cores.iter().flat_map(|each| ["--set", *each]).collect::<Vec<_>>());
    let runs_on = |pid: u32| {
        let status = std::fs::read_to_string(format!("/proc/{pid}/status")).unwrap_or_default();
        let cores = status.lines().find_map(|line| line.strip_prefix("Cpus_allowed_list:"));
        cores.map(|cores| cores.trim().to_owned())
    };
    let mut before = None;
    for round in 0..3 {
        let mut leader = 0;
        until("leader and standby run on their cores", || {
            // Where the leader dies before the other one is up, both start again, and either leads.
            let both = ["fusion", "standby"].map(|name| home.status_row(name).pid);
            leader = leading_fusion(&home.root("demo")).unwrap_or(0);
            let standby = both.into_iter().find(|pid| *pid != leader);
            Some(leader) != before
                && both.contains(&leader)
                && runs_on(leader).as_deref() == Some("0")
                && standby.and_then(runs_on).as_deref() == Some("1")
        });
        before = Some(leader);
        if round < 2 {
            kill(leader, Signal::KILL);
        }
    }
    let (status, said) = demo.stop();
    assert_eq!(status.code(), Some(0), "{said}");
    home.assert_nothing_is_left("demo");
}

#[test]
fn numbers_are_not_given_again_after_the_machines_death() {
    let home = Home::new();
    let folder = format!("checkpoint.folder=\"{}\"", home.path("disk").display());
    // Nothing is young enough to go on.
    let durable = [
        &folder,
        "checkpoint.durable=true",
        "checkpoint.copy_every_s=0.1",
        "checkpoint.max_age_s=0.1",
    ];
    let arguments: Vec<&str> = durable.iter().flat_map(|each| ["--set", *each]).collect();
    let demo = home.demo_with(&arguments);
    let live_in = |many: usize| {
        let mut watcher = Watcher::new(&Bus::open(&home.root("demo"), "watcher").unwrap());
        until("targets are shown", || {
            watcher.look();
            watcher.tally.carriers().len() > many
        });
        watcher.tally
    };
    let before = live_in(30);
    let copied = || std::fs::metadata(home.path("disk").join("demo.checkpoint")).and_then(|file| file.modified());
    let since = copied().unwrap();
    until("all of them are copied", || copied().unwrap() > since);
    // It cannot start any of them again.
    demo.signal(Signal::STOP);
    for pid in home.pids() {
        kill(pid, Signal::KILL);
    }
    demo.end();
    until("all are dead", || home.pids().is_empty());
    home.root("demo").remove_outlasting();
    let demo = home.demo_with(&arguments);
    let after = live_in(30);
    let last = before.live().iter().max().copied().unwrap();
    assert!(
        after.live().iter().all(|number| *number > last),
        "{:?} {:?}",
        before.live(),
        after.live()
    );
    let (status, said) = demo.stop();
    assert_eq!(status.code(), Some(0), "{said}");
    assert!(said.contains("copies in"), "{said}");
    home.assert_nothing_is_left("demo");
    let kept = std::fs::read_dir(home.path("disk")).unwrap().flatten();
    let kept: Vec<_> = kept.map(|entry| entry.file_name()).collect();
    assert!(
        kept.iter().all(|file| file.to_str().unwrap().ends_with(".end")),
        "an orderly end leaves its own files: {kept:?}"
    );
}

const STANDBY: [&str; 2] = ["--set", "fusion.standby=true"];

/// Ends fusion a few times, or as often as `KOSEKI_KILLS` says: then at long intervals, and with a limit to how long no
/// state came in the median.
fn campaign(signal: Signal, few: usize, seed: u64, arguments: &[&str], limit: Duration) {
    let often = std::env::var("KOSEKI_KILLS").ok().and_then(|times| times.parse().ok());
    let pause = if often.is_some() { WELL } else { SOON };
    let gaps = ended(signal, often.unwrap_or(few), pause, seed, arguments);
    let at = |share: f64| gaps[(share * (gaps.len() - 1) as f64) as usize].as_secs_f64();
    println!(
        "{} times: the next state came after {:.3} s in the median, 90 %: {:.3} s, at most {:.3} s",
        gaps.len(),
        at(0.5),
        at(0.9),
        at(1.0)
    );
    assert!(often.is_none() || gaps[gaps.len() / 2] < limit, "{gaps:?}");
}

/// Ends the fusion of a demonstration by `signal` so often, with such pauses; in rising order, how long no state came.
fn ended(signal: Signal, times: usize, pause: Duration, seed: u64, arguments: &[&str]) -> Vec<Duration> {
    let home = Home::new();
    let demo = home.demo_with(arguments);
    let mut watcher = Watcher::new(&Bus::open(&home.root("demo"), "watcher").unwrap());
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    until("most targets are shown", || {
        watcher.look();
        watcher.tally.carriers().len() > 30
    });
    let mut gaps = Vec::new();
    for _ in 0..times {
        watcher.watch(pause + Duration::from_millis(random.random_range(0..500)));
        let before = watcher.tally.clone();
        let leads = leading_fusion(&home.root("demo"));
        kill(leads.unwrap_or_else(|| home.status_row("fusion").pid), signal);
        let begun = Instant::now();
        until("another fusion speaks", || {
            watcher.look();
            watcher.tally.epoch() > before.epoch()
        });
        gaps.push(begun.elapsed());
        watcher.tally.begin();
        let addresses: Vec<u32> = before.carriers().keys().copied().collect();
        while begun.elapsed() < SHOWN_AGAIN && !addresses.iter().all(|who| watcher.tally.shown(*who)) {
            watcher.watch(Duration::from_millis(5));
        }
        let renumbered = watcher.tally.renumbered(&before);
        assert!(renumbered.is_empty(), "{renumbered:?}\n{}", demo.said());
        let forgotten = watcher.tally.forgotten(&before);
        assert!(
            forgotten.len() <= before.live().len() / 20,
            "neither gone on with nor ended: {forgotten:?} of {}",
            before.live().len()
        );
    }
    assert!(watcher.tally.reused().is_empty(), "{:?}", watcher.tally.reused());
    assert_eq!(watcher.tally.late(), 0, "an older fusion spoke after a newer one");
    drop(watcher);
    let (status, said) = demo.stop();
    assert_eq!(status.code(), Some(0), "{said}");
    home.assert_nothing_is_left("demo");
    gaps.sort();
    gaps
}

/// A subscriber that keeps the tally.
pub(crate) struct Watcher {
    subscriber: Subscriber<SharedMemory, SystemTrack>,
    pub(crate) tally: NumberTally,
}

impl Watcher {
    pub(crate) fn new(bus: &Bus<SharedMemory>) -> Self {
        let topic = messages::system_tracks();
        Self {
            subscriber: bus.subscriber(&topic, || mono_ns() as u64).unwrap().of_all_epochs(),
            tally: NumberTally::default(),
        }
    }

    fn watch(&mut self, time: Duration) {
        let begun = Instant::now();
        while begun.elapsed() < time {
            self.look();
            thread::sleep(Duration::from_millis(5));
        }
    }

    pub(crate) fn look(&mut self) {
        let tally = &mut self.tally;
        let taken = self.subscriber.take(usize::MAX, |header, tracks| {
            tracks.iter().for_each(|track| tally.take(header.epoch, track));
        });
        taken.unwrap();
    }
}
