//! Cost of a live report in the loop of fusion: receiving, the engine, the event log, publishing, with so many
//! subscribers that read and so many that do not.
//!
//! Time varies with the machine, counted instructions do not. `.ci/cost` counts with valgrind, and compares with the
//! table in the repository. By hand:
//!
//! ```text
//! cargo bench -p fusion-service --bench subscribers --no-run        # prints the path
//! valgrind --tool=callgrind --toggle-collect='*steady_turn*' --callgrind-out-file=/dev/null PATH 0 0 4 1
//! ```
//!
//! Arguments: subscribers that read, subscribers that do not, sources, reports in a slice, and `checkpoint` to write
//! one; or `engine`, the number of sources, and the number of targets if it is another, for the engine without loop
//! and bus; or `memory` and the same numbers, for the octets that the engine has allocated. With `turning` the targets
//! turn and change height, with `tracked` the sources are trackers with full covariances (`traffic`). Each source is
//! external and observes each target with noise of its own. The bench never waits. The mode `event` makes the loop
//! look fully at all sources each 200 ms of the bench's time, as often per report as the mode `spin` at some 100,000
//! reports a second. Functions of their own take the reports, so that each group can be counted alone: `steady_turn`
//! and `steady_update` those from report 31 of each sensor track on, `young_update` the reports 7 to 12.
//!
//! On a core of its own, fusion finds its code in the caches as its last turn has left it. Here, sending runs on the
//! same core, and evicts that code. A second fusion therefore takes the same slice between sending and the counted
//! turn, and is not counted: it is in the place of the last turn. Its tables compete for the caches, too: data misses
//! of turns are those of 256 targets. While a report runs through more code than the cache holds, misses of
//! instructions are the same with and without (984 and 985). For the engine alone, eight reports are made together,
//! and the first of them is not counted.

use std::alloc::{GlobalAlloc, Layout, System};
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};
use std::time::{Duration, Instant};

use bus::{Bus, InProcess, Mark, Publisher, Root, Subscriber, TopicHold};
use configuration::Config;
use fusion::Engine;
use fusion_service::FusionAgent;
use messages::{SensorTrack, SystemTrack};
use runtime::housekeeping::Queues;
use runtime::{Agent, Now};
use test_support::S;

use traffic::{Kind, START_NS, Traffic};

mod traffic;

/// Targets, each observed by each source once a second.
const TARGETS: u64 = 128;
/// Reports of a sensor track while it counts as young, and from which on it counts as steady.
const YOUNG: std::ops::Range<u64> = 6..12;
const STEADY: std::ops::Range<u64> = 30..40;
/// Reports made before the engine takes them; the first is not counted.
const TOGETHER: u64 = 8;

/// The system's allocator, with the octets in use.
struct CountingAllocator;

static OCTETS: AtomicUsize = AtomicUsize::new(0);

#[global_allocator]
static ALLOCATOR: CountingAllocator = CountingAllocator;

// SAFETY: the system's allocator does all the work.
unsafe impl GlobalAlloc for CountingAllocator {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        OCTETS.fetch_add(layout.size(), Relaxed);
        // SAFETY: the caller keeps the contract of this function, which is the same.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, block: *mut u8, layout: Layout) {
        OCTETS.fetch_sub(layout.size(), Relaxed);
        // SAFETY: as above; `block` comes from `System`.
        unsafe { System.dealloc(block, layout) }
    }
}

/// Configuration of so many sources, with room for `systems` targets, or for as many as is usual.
fn config(sources: usize, systems: Option<u64>) -> Config {
    let source = |number: usize| {
        format!(
            "[[source]]\nname = \"{}\"\nperiod_s = 1.0\n[source.external]\n",
            name(number)
        )
    };
    let capacity = |systems: u64| {
        format!(
            "[fusion.capacity]\nsystem_tracks = {systems}\nsensor_tracks = {}\n",
            systems * sources as u64
        )
    };
    let text = format!(
        "name = \"t\"\n[frame]\nlatitude_deg = 0.0\nlongitude_deg = 0.0\n[time]\norder = \"arrival\"\n\
         date = \"2016-05-10\"\n{}[recorder]\nenabled = false\n[fusion]\nwait = \"event\"\n{}",
        (0..sources).map(source).collect::<String>(),
        systems.map(capacity).unwrap_or_default()
    );
    Config::parse(Path::new("bench.toml"), &text, &[]).expect("a configuration")
}

fn name(source: usize) -> String {
    format!("source{source}")
}

/// What [`drive`] is to measure.
#[derive(Clone, Copy, Debug)]
struct Case {
    reading: usize,
    stopped: usize,
    sources: usize,
    slice: u64,
    keeps_checkpoint: bool,
}

/// Reports that were counted, and how long the steady ones took.
#[derive(Debug, Default)]
struct Counted {
    reports: u64,
    young_reports: u64,
    spent: Duration,
}

impl Counted {
    fn each_ns(&self) -> f64 {
        self.spent.as_nanos() as f64 / self.reports as f64
    }
}

/// A fusion in process, and the publishers of its sources.
struct Site {
    agent: FusionAgent<InProcess>,
    publishers: Vec<Publisher<InProcess, SensorTrack>>,
    bus: Bus<InProcess>,
    _held: Vec<TopicHold>,
    _folder: tempfile::TempDir,
}

impl Site {
    fn new(case: Case) -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let bus = Bus::open_for_few(&Root::in_base(folder.path(), "t").expect("a root"), "bench").expect("a bus");
        let topics: Vec<_> = (0..case.sources)
            .map(|number| messages::sensor_tracks(&name(number)))
            .collect();
        let mut held: Vec<_> = topics.iter().map(|topic| bus.hold(topic).expect("a topic")).collect();
        held.push(bus.hold(&messages::system_tracks()).expect("a topic"));
        held.push(bus.hold(&messages::progress()).expect("a topic"));
        let publisher = |topic| bus.publisher(topic, 2).expect("a publisher");
        Self {
            agent: agent(case, &bus),
            publishers: topics.iter().map(publisher).collect(),
            bus,
            _held: held,
            _folder: folder,
        }
    }
}

impl Drop for Site {
    /// The checkpoint outlives its process.
    fn drop(&mut self) {
        self.bus.root().remove_outlasting();
    }
}

/// Sends slices of reports, one source after the other, and lets fusion work each off.
fn drive(case: Case) -> Counted {
    let (mut before, mut site) = (Site::new(case), Site::new(case));
    let subscriber = |_| {
        let reader = site.bus.subscriber(&messages::system_tracks(), || 1);
        reader.expect("a subscriber")
    };
    let mut readers: Vec<Subscriber<InProcess, SystemTrack>> = (0..case.reading).map(subscriber).collect();
    let _stopped: Vec<Subscriber<InProcess, SystemTrack>> = (0..case.stopped).map(subscriber).collect();
    let mut counted = Counted::default();
    let mut traffic = Traffic::new(Kind::Level, case.sources, TARGETS);
    let (slice, sources) = (case.slice, case.sources as u64);
    let turns = TARGETS / slice * sources;
    for scan in 0..STEADY.end {
        for turn in 0..turns {
            let (first, source) = (turn / sources * slice, turn % sources);
            let time_ns = START_NS + scan as i64 * S + turn as i64 * (S / turns as i64);
            let now = Now {
                mono_ns: time_ns - START_NS + 1,
                utc_ns: time_ns,
            };
            let mark = Mark {
                progress_ns: i64::MIN,
                sent_ns: now.mono_ns,
                end: false,
            };
            for publishers in [&mut before.publishers, &mut site.publishers] {
                let sent = publishers[source as usize].send(mark, slice as usize, |index, sequence| SensorTrack {
                    sequence,
                    ..traffic.report(source, first + index as u64, scan, time_ns)
                });
                sent.expect("a send");
            }
            before.agent.turn(now).expect("a turn");
            let began = Instant::now();
            if STEADY.contains(&scan) {
                steady_turn(&mut site.agent, now);
                counted.spent += began.elapsed();
                counted.reports += slice;
            } else {
                site.agent.turn(now).expect("a turn");
            }
            for reader in &mut readers {
                reader.take(usize::MAX, |_, _| ()).expect("a look");
            }
        }
    }
    counted
}

/// Fusion of a case.
fn agent(case: Case, bus: &Bus<InProcess>) -> FusionAgent<InProcess> {
    let config = config(case.sources, None);
    let (speed, queues) = (runtime::Speed::Factor(1.0), Queues::new(None));
    if !case.keeps_checkpoint {
        return FusionAgent::new(&config, &config.engine, speed, bus, 1, queues).expect("an agent");
    }
    let now = Now {
        mono_ns: 1,
        utc_ns: START_NS,
    };
    FusionAgent::resumed(&config, &config.engine, speed, bus, 1, queues, now).expect("an agent")
}

/// Passes the same reports, or those of another kind, to the engine alone.
fn drive_engine(engine: &mut Engine, kind: Kind, sources: usize, targets: u64) -> Counted {
    let mut counted = Counted::default();
    let mut traffic = Traffic::new(kind, sources, targets);
    let turns = targets * sources as u64;
    for scan in 0..STEADY.end {
        for first in (0..turns).step_by(TOGETHER as usize) {
            let made = std::array::from_fn::<SensorTrack, { TOGETHER as usize }, _>(|index| {
                let turn = first + index as u64;
                let (target, source) = (turn / sources as u64, turn % sources as u64);
                let time_ns = START_NS + scan as i64 * S + turn as i64 * (S / turns as i64);
                SensorTrack {
                    source: source as u16,
                    sequence: scan * targets + target,
                    ..traffic.report(source, target, scan, time_ns)
                }
            });
            for (index, report) in made.iter().enumerate() {
                let began = Instant::now();
                let time_ns = report.time_of_measurement_ns;
                match index {
                    1.. if YOUNG.contains(&scan) => {
                        young_update(engine, report, time_ns);
                        counted.young_reports += 1;
                    }
                    1.. if STEADY.contains(&scan) => {
                        steady_update(engine, report, time_ns);
                        counted.spent += began.elapsed();
                        counted.reports += 1;
                    }
                    _ => engine.take_at(report, time_ns, &mut |_: &SystemTrack| ()),
                }
            }
        }
    }
    counted
}

/// Counted by its name.
#[inline(never)]
fn young_update(engine: &mut Engine, report: &SensorTrack, now_ns: i64) {
    engine.take_at(report, now_ns, &mut |track: &SystemTrack| {
        std::hint::black_box(track);
    });
}

/// Counted by its name.
#[inline(never)]
fn steady_update(engine: &mut Engine, report: &SensorTrack, now_ns: i64) {
    engine.take_at(report, now_ns, &mut |track: &SystemTrack| {
        std::hint::black_box(track);
    });
}

/// Counted by its name.
#[inline(never)]
fn steady_turn(agent: &mut impl Agent, now: Now) {
    agent.turn(now).expect("a turn");
}

fn main() {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let numbers: Vec<usize> = words.iter().filter_map(|word| word.parse().ok()).collect();
    let named = |name: &str| words.iter().any(|word| word == name);
    if named("engine") || named("memory") {
        let (sources, targets) = (numbers[0], numbers.get(1).map_or(TARGETS, |targets| *targets as u64));
        assert!(
            (sources as u64 * targets).is_multiple_of(TOGETHER),
            "whole groups of {TOGETHER}"
        );
        let config = config(sources, named("memory").then_some(targets));
        let before = OCTETS.load(Relaxed);
        let mut engine = Engine::new(config.engine.clone()).expect("an engine");
        let counted = drive_engine(&mut engine, Kind::among(&words), sources, targets);
        let octets = (OCTETS.load(Relaxed) - before) as f64 / targets as f64;
        println!(
            "engine, {sources} sources, {targets} targets: {} young reports, {} steady reports, {:.0} ns each, \
             {octets:.0} octets a target",
            counted.young_reports,
            counted.reports,
            counted.each_ns()
        );
        return;
    }
    let cases = match numbers[..] {
        [reading, stopped] => vec![[reading, stopped, 1, 1]],
        [reading, stopped, sources, slice] => vec![[reading, stopped, sources, slice]],
        _ => vec![
            [0, 0, 1, 1],
            [0, 0, 4, 1],
            [0, 0, 4, 64],
            [1, 0, 1, 1],
            [1, 1, 1, 1],
            [10, 0, 1, 1],
            [11, 0, 1, 1],
        ],
    };
    for [reading, stopped, sources, slice] in cases {
        let counted = drive(Case {
            reading,
            stopped,
            sources,
            slice: slice as u64,
            keeps_checkpoint: named("checkpoint"),
        });
        println!(
            "{reading} subscribers that read, {stopped} that do not, {sources} sources, slices of {slice}: {} steady \
             reports, {:.0} ns each",
            counted.reports,
            counted.each_ns()
        );
    }
}
