//! The picture goes on when fusion is killed: tracks keep their numbers, and no number is given twice. With a fusion
//! that stands by, it goes on at once.
//!
//! A short form runs with all tests. The campaigns print what they measured; they take long, since each end comes more
//! than ten seconds after the one before:
//! `cargo test -p koseki --test integration hundred_times -- --ignored --nocapture`.
//!
//! An independent subscriber keeps the tally: who carries which number, by the addresses of the simulated aircraft.

use std::collections::{BTreeMap, BTreeSet};
use std::thread;
use std::time::{Duration, Instant};

use bus::{Bus, SharedMemory, Subscriber};
use messages::{SystemTrack, TrackState};
use rand::RngExt as _;
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use runtime::clock::mono_ns;
use rustix::process::Signal;

use crate::common::{Home, kill, until};

/// Time after a kill within which every target must be shown again.
const SHOWN_AGAIN: Duration = Duration::from_secs(8);

#[test]
fn a_killed_fusion_comes_back_with_the_same_tracks_under_the_same_numbers() {
    let gaps = ended(Signal::KILL, 3, Duration::from_millis(2500), 1, &[]);
    println!("gaps: {gaps:?}");
}

#[test]
#[ignore = "takes forty minutes: run it by its name"]
fn fusion_is_killed_two_hundred_times() {
    let gaps = ended(Signal::KILL, 200, WELL, 2, &[]);
    report(&gaps);
    assert!(gaps[gaps.len() / 2] < Duration::from_secs(1), "{gaps:?}");
}

#[test]
fn the_fusion_that_stands_by_takes_over_with_the_same_tracks_under_the_same_numbers() {
    let gaps = ended(Signal::KILL, 3, Duration::from_millis(3500), 3, &STANDBY);
    println!("gaps: {gaps:?}");
}

#[test]
#[ignore = "takes forty minutes: run it by its name"]
fn the_leader_is_killed_two_hundred_times() {
    let gaps = ended(Signal::KILL, 200, WELL, 4, &STANDBY);
    report(&gaps);
    assert!(gaps[gaps.len() / 2] < Duration::from_millis(150), "{gaps:?}");
}

#[test]
fn a_leader_that_is_stopped_is_replaced_and_never_speaks_again() {
    let gaps = ended(Signal::STOP, 2, Duration::from_millis(3500), 5, &STANDBY);
    println!("gaps: {gaps:?}");
}

#[test]
#[ignore = "takes ten minutes: run it by its name"]
fn the_leader_is_stopped_fifty_times() {
    let gaps = ended(Signal::STOP, 50, WELL, 6, &STANDBY);
    report(&gaps);
    assert!(gaps[gaps.len() / 2] < Duration::from_millis(150), "{gaps:?}");
}

/// A process that has run for so long is started again at once when it dies.
const WELL: Duration = Duration::from_secs(11);
const STANDBY: [&str; 2] = ["--set", "fusion.standby=true"];

fn report(gaps: &[Duration]) {
    let at = |share: f64| gaps[(share * (gaps.len() - 1) as f64) as usize].as_secs_f64();
    println!(
        "{} times: the next state came after {:.3} s in the median, 90 %: {:.3} s, at most {:.3} s",
        gaps.len(),
        at(0.5),
        at(0.9),
        at(1.0)
    );
}

/// Ends the fusion of a demonstration by `signal` so often, with such pauses; in rising order, how long no state came.
fn ended(signal: Signal, times: usize, pause: Duration, seed: u64, arguments: &[&str]) -> Vec<Duration> {
    let home = Home::new();
    let demo = home.demo_with(arguments);
    let mut watcher = Watcher::new(&Bus::open(&home.root("demo"), "watcher").unwrap());
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    until("most targets are shown", || {
        watcher.look();
        watcher.carriers.len() > 30
    });
    let mut gaps = Vec::new();
    for _ in 0..times {
        let pause = pause + Duration::from_millis(random.random_range(0..500));
        watcher.watch(pause);
        let before = watcher.carriers.clone();
        let (epoch, live) = (watcher.epoch, watcher.live.clone());
        let leader = home.status_row("fusion").pid;
        kill(leader, signal);
        let begun = Instant::now();
        until("another fusion speaks", || {
            watcher.look();
            watcher.epoch > epoch
        });
        gaps.push(begun.elapsed());
        watcher.shown.clear();
        let again = |watcher: &Watcher| before.keys().filter(|who| watcher.shown.contains(*who)).count();
        while again(&watcher) < before.len() && begun.elapsed() < SHOWN_AGAIN {
            watcher.look();
            thread::sleep(Duration::from_millis(5));
        }
        let renumbered: Vec<_> = before
            .iter()
            .filter(|(who, number)| watcher.carriers.get(*who).is_some_and(|now| now != *number))
            .collect();
        assert!(renumbered.is_empty(), "{renumbered:?}\n{}", demo.said());
        let forgotten: Vec<_> = live.iter().filter(|number| !watcher.heard.contains(*number)).collect();
        assert!(
            forgotten.len() <= live.len() / 20,
            "neither gone on with nor ended: {forgotten:?} of {}",
            live.len()
        );
    }
    assert_eq!(watcher.reused, BTreeSet::new(), "{}", demo.said());
    assert_eq!(watcher.fenced_after, 0, "an older fusion spoke after a newer one");
    drop(watcher);
    let (status, said) = demo.stop();
    assert_eq!(status.code(), Some(0), "{said}");
    home.assert_nothing_is_left("demo");
    gaps.sort();
    gaps
}

/// A subscriber that keeps the tally.
struct Watcher {
    subscriber: Subscriber<SharedMemory, SystemTrack>,
    epoch: u64,
    /// When the present epoch first spoke, monotonic, nanoseconds.
    began_ns: i64,
    /// States of older epochs that were sent after that.
    fenced_after: u64,
    /// Number under which each address was shown last, while that track lives.
    carriers: BTreeMap<u32, u32>,
    /// Addresses shown since this was emptied.
    shown: BTreeSet<u32>,
    /// Confirmed tracks that have not ended.
    live: BTreeSet<u32>,
    /// Numbers that the present epoch has said something of.
    heard: BTreeSet<u32>,
    /// Address that a number was first shown with.
    first: BTreeMap<u32, u32>,
    /// Numbers of ended tracks.
    ended: BTreeSet<u32>,
    /// Numbers that came again after their end, or with another address.
    reused: BTreeSet<u32>,
}

impl Watcher {
    fn new(bus: &Bus<SharedMemory>) -> Self {
        Self {
            subscriber: bus.subscriber(&messages::system_tracks(), || mono_ns() as u64).unwrap(),
            epoch: 0,
            began_ns: 0,
            fenced_after: 0,
            carriers: BTreeMap::new(),
            shown: BTreeSet::new(),
            live: BTreeSet::new(),
            heard: BTreeSet::new(),
            first: BTreeMap::new(),
            ended: BTreeSet::new(),
            reused: BTreeSet::new(),
        }
    }

    fn watch(&mut self, time: Duration) {
        let begun = Instant::now();
        while begun.elapsed() < time {
            self.look();
            thread::sleep(Duration::from_millis(5));
        }
    }

    fn look(&mut self) {
        let mut came = Vec::new();
        self.subscriber
            .take(usize::MAX, |header, tracks| {
                came.extend(tracks.iter().map(|track| (header.epoch, *track)));
            })
            .unwrap();
        for (epoch, track) in came {
            self.take(epoch, &track);
        }
    }

    fn take(&mut self, epoch: u64, track: &SystemTrack) {
        if epoch < self.epoch {
            self.fenced_after += u64::from(track.stages.fused_ns > self.began_ns);
            return;
        }
        if epoch > self.epoch {
            (self.epoch, self.began_ns) = (epoch, track.stages.fused_ns);
            self.heard.clear();
        }
        let number = track.track_number;
        self.heard.insert(number);
        if track.state == TrackState::Terminated as u8 {
            self.live.remove(&number);
            self.carriers.retain(|_, carried| *carried != number);
            self.ended.insert(number);
            return;
        }
        if self.ended.contains(&number) {
            self.reused.insert(number);
        }
        if track.state == TrackState::Tentative as u8 {
            return;
        }
        self.live.insert(number);
        if let Some(address) = track.identity.unique_number() {
            if *self.first.entry(number).or_insert(address) != address {
                self.reused.insert(number);
            }
            self.carriers.insert(address, number);
            self.shown.insert(address);
        }
    }
}
