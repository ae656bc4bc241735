//! Kills at random: children come back, and every sample that died with one is counted.
//!
//! A short form runs with all tests. The campaign itself takes three minutes, fewer kills as `KOSEKI_KILLS` says less;
//! it prints what it measured: `cargo test -p koseki --test integration two_hundred_kills -- --ignored --nocapture`.
//!
//! An *observer* reads the topics of all sources and the system tracks from beginning to end; now and then it falls
//! behind, so that something is lost. Beside its subscribers' own counters it keeps a tally that is independent of
//! them: samples that came, by publisher, against the number that the publisher's line in shared memory states. Kills
//! are tallied, too, against what the launcher says of them.

use std::collections::BTreeMap;
use std::fs;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use bus::{Bus, Payload, SharedMemory, Subscriber};
use messages::{Health, LifeState, ProcessKind, Topic};
use rand::RngExt as _;
use rand::SeedableRng as _;
use rand::seq::SliceRandom as _;
use rand_chacha::ChaCha8Rng;
use runtime::clock::mono_ns;
use rustix::process::{Pid, Signal, kill_process};

use crate::common::{Home, Running, until};

/// A child that has run for so long was well: it must be back within [`BACK`].
const WELL: Duration = Duration::from_secs(10);
const BACK: Duration = Duration::from_secs(2);
/// The observer looks for so long, then does not for so long: more comes then than a queue holds.
const LOOKS: Duration = Duration::from_secs(3);
const LOOKS_AWAY: Duration = Duration::from_secs(7);
const SOURCES: [&str; 5] = ["radar-west", "radar-east", "multilateration", "ads-b", "radar-south"];

#[test]
fn killed_children_come_back_and_what_died_with_them_is_counted() {
    campaign(15, Duration::ZERO, 1);
}

#[test]
fn a_start_right_after_a_kill_of_everything_succeeds() {
    starts(5, 3);
}

#[test]
#[ignore = "takes two minutes: run it by its name"]
fn two_hundred_starts_after_kills_of_everything() {
    let count = std::env::var("KOSEKI_KILLS").ok().and_then(|times| times.parse().ok());
    starts(count.unwrap_or(200), 4);
}

/// Kills all processes of a demonstration so often, at any moment of its start or later and in any order, and starts it
/// again while they die.
fn starts(count: usize, seed: u64) {
    let home = Home::new();
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut took = Vec::new();
    let mut running = home.demo();
    for _ in 0..count {
        if random.random_bool(0.5) {
            thread::sleep(Duration::from_millis(random.random_range(0..1000)));
        }
        let mut pids = home.pids();
        pids.shuffle(&mut random);
        for pid in pids {
            // One may have followed its launcher already.
            let _ = kill_process(Pid::from_raw(pid as i32).unwrap(), Signal::KILL);
        }
        let start = Instant::now();
        let next = home.start(&["demo"]);
        let killed = std::mem::replace(&mut running, next);
        if random.random_bool(0.7) {
            running.until_said("instance demo runs");
            took.push(start.elapsed());
        } else {
            // The next kill comes while it starts.
            thread::sleep(Duration::from_millis(random.random_range(0..300)));
            assert!(running.child.try_wait().unwrap().is_none(), "{}", running.said());
        }
        killed.end();
    }
    running.until_said("instance demo runs");
    let (status, said) = running.stop();
    assert_eq!(status.code(), Some(0), "{said}");
    home.assert_nothing_is_left("demo");
    took.sort();
    println!("{count} kills of everything: a start took at most {:?}", took.last());
}

#[test]
#[ignore = "takes three minutes: run it by its name"]
fn two_hundred_kills() {
    let count = std::env::var("KOSEKI_KILLS").ok().and_then(|times| times.parse().ok());
    let mut back = campaign(count.unwrap_or(200), WELL, 2);
    back.sort();
    let at = |share: f64| back[(share * (back.len() - 1) as f64) as usize].as_secs_f64();
    println!(
        "{} children that had run for {} s: back after {:.2} s in the median, 90 %: {:.2} s, at most {:.2} s",
        back.len(),
        WELL.as_secs(),
        at(0.5),
        at(0.9),
        at(1.0)
    );
    assert!(at(1.0) <= BACK.as_secs_f64());
}

/// Kills `count` children of a demonstration that have run for `aged`, one in four of their successors while it starts.
/// Returns how long those took to come back that were killed once.
fn campaign(count: usize, aged: Duration, seed: u64) -> Vec<Duration> {
    let home = Home::new();
    let out = home.path("out");
    let demo = home.demo_with(&[
        "--set",
        "scenario.targets=300",
        "--set",
        "recorder.enabled=true",
        "--out",
        out.to_str().unwrap(),
    ]);
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let is_over = Arc::new(AtomicBool::new(false));
    let observer = thread::spawn({
        let (root, is_over) = (home.root("demo"), Arc::clone(&is_over));
        move || Observer::new(Bus::open(&root, "observer").unwrap()).watch(&is_over)
    });

    let mut killed: BTreeMap<String, usize> = BTreeMap::new();
    let mut up_since: BTreeMap<String, Instant> = BTreeMap::new();
    let mut back = Vec::new();
    let mut kills = 0;
    while kills < count {
        let now = Instant::now();
        let children = children(&demo);
        let mut ready: Vec<&String> = children
            .keys()
            .filter(|name| now - *up_since.entry((*name).clone()).or_insert(now) >= aged)
            .collect();
        if ready.is_empty() {
            thread::sleep(Duration::from_millis(20));
            continue;
        }
        let name = ready.swap_remove(random.random_range(0..ready.len())).clone();
        let mut pid = children[&name];
        let also_starting = if random.random_ratio(1, 4) {
            random.random_range(1..=2)
        } else {
            0
        };
        let begun = Instant::now();
        for again in 0..=also_starting {
            if again > 0 {
                let dead = pid;
                until("its successor is started", || {
                    pid = self::children(&demo).get(&name).copied().unwrap_or(dead);
                    pid != dead
                });
                thread::sleep(Duration::from_millis(random.random_range(0..30)));
            }
            kill_process(Pid::from_raw(pid as i32).unwrap(), Signal::KILL).unwrap();
            kills += 1;
            *killed.entry(name.clone()).or_default() += 1;
        }
        demo.until_said(&format!("{name} restarted ({}), back after ", killed[&name]));
        if also_starting == 0 {
            back.push(begun.elapsed());
        }
        up_since.insert(name, Instant::now());
    }

    for (name, times) in &killed {
        let restarts = home.status_row(name).restarts;
        assert_eq!(restarts, times.to_string(), "{name}: {}", demo.said());
    }
    is_over.store(true, Ordering::Relaxed);
    let (status, said) = demo.stop();
    assert_eq!(status.code(), Some(0), "{said}");
    assert_eq!(
        said.matches(" was killed by SIGKILL; restarting").count(),
        kills,
        "{said}"
    );
    for words in ["stood still", "rebuilding", "the shared memory stays"] {
        assert!(!said.contains(words), "{said}");
    }
    let lost = observer.join().unwrap();
    println!(
        "{kills} kills, {} samples taken, {} lost and counted, {} of them after the last slice of a publisher",
        lost.taken, lost.lost, lost.lost_at_end
    );
    home.assert_nothing_is_left("demo");
    back
}

/// Process numbers of the launcher's children, by their names.
pub(crate) fn children(launcher: &Running) -> BTreeMap<String, u32> {
    let pid = launcher.pid();
    let pids = fs::read_to_string(format!("/proc/{pid}/task/{pid}/children")).unwrap();
    let named = pids.split_whitespace().filter_map(|pid| {
        let command = fs::read_to_string(format!("/proc/{pid}/cmdline")).ok()?;
        let name = command.split('\0').find_map(|word| word.strip_prefix("--name="))?;
        Some((name.to_owned(), pid.parse().ok()?))
    });
    named.collect()
}

/// A reader of everything that is published.
struct Observer {
    bus: Bus<SharedMemory>,
    health: Subscriber<SharedMemory, Health>,
    sources: Vec<Watched<messages::SensorTrack>>,
    system: Watched<messages::SystemTrack>,
}

#[derive(Clone, Copy, Debug, Default)]
struct Sum {
    taken: u64,
    lost: u64,
    lost_at_end: u64,
}

impl Observer {
    fn new(bus: Bus<SharedMemory>) -> Self {
        Self {
            health: bus.subscriber(&messages::health(), || mono_ns() as u64).unwrap(),
            sources: SOURCES
                .map(|name| Watched::new(&bus, messages::sensor_tracks(name)))
                .into(),
            system: Watched::new(&bus, messages::system_tracks()),
            bus,
        }
    }

    /// Reads until the launcher says that it is over. The subscribers' own losses are those of the tally.
    fn watch(mut self, is_over: &AtomicBool) -> Sum {
        let is_end = |said: &Health| {
            let launcher = said.kind() == Some(ProcessKind::Launcher) && said.name() == "launcher";
            launcher && said.life() == Some(LifeState::Finished)
        };
        let begun = Instant::now();
        let falls_behind = || begun.elapsed().as_millis() % (LOOKS + LOOKS_AWAY).as_millis() > LOOKS.as_millis();
        let mut ended = false;
        while !ended {
            thread::sleep(Duration::from_millis(5));
            if falls_behind() && !is_over.load(Ordering::Relaxed) {
                continue;
            }
            self.health
                .take(usize::MAX, |_, slice| ended |= slice.iter().any(is_end))
                .unwrap();
            for source in &mut self.sources {
                source.look(&self.bus);
            }
            self.system.look(&self.bus);
        }
        let sums = self.sources.iter().map(Watched::sum).chain([self.system.sum()]);
        sums.fold(Sum::default(), |all, one| Sum {
            taken: all.taken + one.taken,
            lost: all.lost + one.lost,
            lost_at_end: all.lost_at_end + one.lost_at_end,
        })
    }
}

/// A topic, and what has come of each of its publishers.
struct Watched<T: Payload> {
    topic: Topic<T>,
    joined_ns: u64,
    subscriber: Subscriber<SharedMemory, T>,
    publishers: BTreeMap<u64, Publisher>,
}

/// By its start time: a publisher of a watched topic.
#[derive(Clone, Copy, Debug, Default)]
struct Publisher {
    /// Number of the first sample that came.
    first: Option<u64>,
    taken: u64,
    /// Numbers that it has given to samples, as its line says.
    numbered: u64,
}

impl<T: Payload> Watched<T> {
    fn new(bus: &Bus<SharedMemory>, topic: Topic<T>) -> Self {
        let mut joined_ns = 0;
        let now_ns = || {
            joined_ns = mono_ns() as u64;
            joined_ns
        };
        Self {
            subscriber: bus.subscriber(&topic, now_ns).unwrap(),
            topic,
            joined_ns,
            publishers: BTreeMap::new(),
        }
    }

    fn look(&mut self, bus: &Bus<SharedMemory>) {
        let publishers = &mut self.publishers;
        let taken = self.subscriber.take(usize::MAX, |header, samples| {
            let publisher = publishers.entry(header.incarnation).or_default();
            publisher.first.get_or_insert(header.first_sequence);
            publisher.taken += samples.len() as u64;
        });
        taken.unwrap();
        // At the very end the keeper, gone before its last word is read, has taken the lines with it.
        for line in bus.publisher_lines(&self.topic).unwrap_or_default() {
            let numbered = &mut publishers.entry(line.incarnation).or_default().numbered;
            *numbered = line.next_sequence.max(*numbered);
        }
    }

    /// What came and what did not, as tallied here; which must be what the subscriber counted.
    fn sum(&self) -> Sum {
        let mut sum = Sum::default();
        for (incarnation, publisher) in &self.publishers {
            // Of one that was there before the observer, only what follows its first slice is expected.
            let is_older = *incarnation < self.joined_ns;
            let first = if is_older {
                publisher.first.unwrap_or(publisher.numbered)
            } else {
                0
            };
            sum.taken += publisher.taken;
            sum.lost += publisher.numbered - first - publisher.taken;
        }
        let (counted, name) = (self.subscriber.counts(), self.topic.name.as_str());
        sum.lost_at_end = counted.lost_at_end;
        let publishers = &self.publishers;
        assert_eq!(
            (sum.taken, sum.lost),
            (counted.taken, counted.lost),
            "{name}: {publishers:#?}"
        );
        sum
    }
}
