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
//! Arguments: subscribers that read, subscribers that do not, sources, reports in a slice; or `engine`, the number of
//! sources, and the number of targets if it is another, for the engine without loop and bus. Each source is external
//! and observes each target with noise of its own. The bench never waits. The mode `event` makes the loop look fully at
//! all sources each 200 ms of the bench's time, as often per report as the mode `spin` at some 100,000 reports a
//! second. Functions of their own take the reports, so that each group can be counted alone: `steady_turn` and
//! `steady_update` those from report 31 of each sensor track on, `young_update` the reports 7 to 12.

use std::path::Path;
use std::time::{Duration, Instant};

use bus::{Bus, InProcess, Mark, Publisher, Root, Subscriber};
use configuration::Config;
use fusion::Engine;
use fusion_service::FusionAgent;
use messages::{Covariance, SensorTrack, SystemTrack, TrackState, sensor_track_bits};
use runtime::housekeeping::Queues;
use runtime::{Agent, Now};
use test_support::S;

const START_NS: i64 = 16_931 * 86_400 * S;
/// Targets, each observed by each source once a second.
const TARGETS: u64 = 128;
/// Reports of a sensor track while it counts as young, and from which on it counts as steady.
const YOUNG: std::ops::Range<u64> = 6..12;
const STEADY: std::ops::Range<u64> = 30..40;
/// Standard deviation of the sources' noise, metres.
const SIGMA_M: f64 = 10.0;

fn config(sources: usize) -> Config {
    let source = |number: usize| {
        format!(
            "[[source]]\nname = \"{}\"\nperiod_s = 1.0\n[source.external]\n",
            name(number)
        )
    };
    let text = format!(
        "name = \"t\"\n[frame]\nlatitude_deg = 0.0\nlongitude_deg = 0.0\n[time]\norder = \"arrival\"\n\
         date = \"2016-05-10\"\n{}[recorder]\nenabled = false\n[fusion]\nwait = \"event\"\n",
        (0..sources).map(source).collect::<String>()
    );
    Config::parse(Path::new("bench.toml"), &text, &[]).expect("a configuration")
}

fn name(source: usize) -> String {
    format!("source{source}")
}

/// Noise of one coordinate of a report, metres: the sum of four uniform numbers, the same in each run.
fn noise_m(source: u64, target: u64, scan: u64, axis: u64) -> f64 {
    let mut word = source << 48 ^ target << 32 ^ scan << 8 ^ axis;
    let mut sum = 0.0;
    for _ in 0..4 {
        // The finaliser of splitmix64.
        word = word.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (word ^ word >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ mixed >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        sum += (mixed >> 11) as f64 / (1u64 << 53) as f64 - 0.5;
    }
    sum * SIGMA_M * 3.0_f64.sqrt()
}

fn report(source: u64, target: u64, scan: u64, time_ns: i64) -> SensorTrack {
    let second = (time_ns - START_NS) as f64 / S as f64;
    let noise = |axis: u64| noise_m(source, target, scan, axis);
    SensorTrack {
        time_of_measurement_ns: time_ns,
        track_number: target as u32,
        valid: sensor_track_bits::VELOCITY,
        position_m: [
            2000.0 * (target % 16) as f64 + noise(0),
            2000.0 * (target / 16) as f64 + 10.0 * second + noise(1),
            0.0,
        ],
        velocity_mps: [0.1 * noise(2), 10.0 + 0.1 * noise(3), 0.0],
        covariance: Covariance::diagonal([SIGMA_M, SIGMA_M, 100.0], [1.0; 3]),
        state: TrackState::Confirmed as u8,
        ..SensorTrack::default()
    }
}

/// Sends slices of reports, one source after the other, and lets fusion work each off. Returns the steady reports, and
/// how long their turns took.
fn drive(reading: usize, stopped: usize, sources: usize, slice: u64) -> (u64, Duration) {
    let folder = tempfile::tempdir().expect("a folder");
    let bus: Bus<InProcess> =
        Bus::open_for_few(&Root::in_base(folder.path(), "t").expect("a root"), "bench").expect("a bus");
    let topics: Vec<_> = (0..sources)
        .map(|number| messages::sensor_tracks(&name(number)))
        .collect();
    let mut held: Vec<_> = topics.iter().map(|topic| bus.hold(topic).expect("a topic")).collect();
    held.push(bus.hold(&messages::system_tracks()).expect("a topic"));
    held.push(bus.hold(&messages::progress()).expect("a topic"));
    let speed = runtime::Speed::Factor(1.0);
    let config = config(sources);
    let mut agent = FusionAgent::new(&config, &config.engine, speed, &bus, 1, Queues::new(None)).expect("an agent");
    let publisher = |topic| bus.publisher(topic, 2).expect("a publisher");
    let mut publishers: Vec<Publisher<InProcess, SensorTrack>> = topics.iter().map(publisher).collect();
    let subscriber = |_| bus.subscriber(&messages::system_tracks(), || 1).expect("a subscriber");
    let mut readers: Vec<Subscriber<InProcess, SystemTrack>> = (0..reading).map(subscriber).collect();
    let _stopped: Vec<Subscriber<InProcess, SystemTrack>> = (0..stopped).map(subscriber).collect();
    let (mut reports, mut spent) = (0, Duration::ZERO);
    let turns = TARGETS / slice * sources as u64;
    for scan in 0..STEADY.end {
        for turn in 0..turns {
            let (first, source) = (turn / sources as u64 * slice, turn % sources as u64);
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
            let sent = publishers[source as usize].send(mark, slice as usize, |index, sequence| SensorTrack {
                sequence,
                ..report(source, first + index as u64, scan, time_ns)
            });
            sent.expect("a send");
            let began = Instant::now();
            if STEADY.contains(&scan) {
                steady_turn(&mut agent, now);
                spent += began.elapsed();
                reports += slice;
            } else {
                agent.turn(now).expect("a turn");
            }
            for reader in &mut readers {
                reader.take(usize::MAX, |_, _| ()).expect("a look");
            }
        }
    }
    (reports, spent)
}

/// The same reports, for the engine alone.
fn drive_engine(sources: usize, targets: u64) -> (u64, Duration) {
    let mut engine = Engine::new(config(sources).engine).expect("an engine");
    let (mut reports, mut spent) = (0, Duration::ZERO);
    let turns = targets * sources as u64;
    for scan in 0..STEADY.end {
        for turn in 0..turns {
            let (target, source) = (turn / sources as u64, turn % sources as u64);
            let time_ns = START_NS + scan as i64 * S + turn as i64 * (S / turns as i64);
            let report = SensorTrack {
                source: source as u16,
                sequence: scan * targets + target,
                ..report(source, target, scan, time_ns)
            };
            let began = Instant::now();
            if YOUNG.contains(&scan) {
                young_update(&mut engine, &report, time_ns);
            } else if STEADY.contains(&scan) {
                steady_update(&mut engine, &report, time_ns);
                spent += began.elapsed();
                reports += 1;
            } else {
                engine.take_at(&report, time_ns, &mut |_: &SystemTrack| ());
            }
        }
    }
    (reports, spent)
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
    let numbers: Vec<usize> = std::env::args().skip(1).filter_map(|word| word.parse().ok()).collect();
    if std::env::args().any(|word| word == "engine") {
        let (sources, targets) = (numbers[0], numbers.get(1).map_or(TARGETS, |targets| *targets as u64));
        let (reports, spent) = drive_engine(sources, targets);
        let each_ns = spent.as_nanos() as f64 / reports as f64;
        println!("engine, {sources} sources, {targets} targets: {reports} steady reports, {each_ns:.0} ns each");
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
        let (reports, spent) = drive(reading, stopped, sources, slice as u64);
        println!(
            "{reading} subscribers that read, {stopped} that do not, {sources} sources, slices of {slice}: {reports} \
             steady reports, {:.0} ns each",
            spent.as_nanos() as f64 / reports as f64
        );
    }
}
