//! What a subscriber costs fusion: its loop in this process, with so many subscribers that read and so many that do
//! not.
//!
//! Time varies with the machine, counted instructions do not. With valgrind installed:
//!
//! ```text
//! cargo bench -p fusion-service --bench subscribers --no-run        # prints the path
//! valgrind --tool=callgrind --toggle-collect='*one_turn*' --callgrind-out-file=/dev/null PATH 10 0
//! ```
//!
//! Divide what it collected by the number of reports that the bench prints.

use std::path::Path;
use std::time::Instant;

use bus::{Bus, InProcess, Mark, Publisher, Root, Subscriber};
use configuration::Config;
use fusion_service::FusionAgent;
use messages::{Covariance, SensorTrack, SystemTrack, TrackState, sensor_track_bits};
use runtime::housekeeping::Queues;
use runtime::{Agent, Now};
use test_support::S;

const START_NS: i64 = 16_931 * 86_400 * S;
const TARGETS: u64 = 1000;
const REPORTS: u64 = 30_000;

fn config() -> Config {
    let text = "name = \"t\"\n[frame]\nlatitude_deg = 0.0\nlongitude_deg = 0.0\n[time]\norder = \"arrival\"\n\
                date = \"2016-05-10\"\n[[source]]\nname = \"a\"\n[source.recorded]\nfile = \"a.ast\"\n[recorder]\n\
                enabled = false\n[fusion]\nwait = \"spin\"\n";
    Config::parse(Path::new("bench.toml"), text, &[]).expect("a configuration")
}

fn report(number: u64, time_ns: i64) -> SensorTrack {
    let second = (time_ns - START_NS) as f64 / S as f64;
    SensorTrack {
        time_of_measurement_ns: time_ns,
        track_number: number as u32,
        valid: sensor_track_bits::VELOCITY,
        position_m: [
            2000.0 * (number % 40) as f64,
            2000.0 * (number / 40) as f64 + 10.0 * second,
            0.0,
        ],
        velocity_mps: [0.0, 10.0, 0.0],
        covariance: Covariance::diagonal([10.0, 10.0, 100.0], [2.0; 3]),
        state: TrackState::Confirmed as u8,
        ..SensorTrack::default()
    }
}

/// Sends one report after the other, each target once a second, and lets fusion work each off; how long its turns took.
fn drive(reading: usize, stopped: usize) -> std::time::Duration {
    let folder = tempfile::tempdir().expect("a folder");
    let bus: Bus<InProcess> =
        Bus::open_for_few(&Root::in_base(folder.path(), "t").expect("a root"), "bench").expect("a bus");
    let topic = messages::sensor_tracks("a");
    let _held = [
        bus.hold(&topic).expect("a topic"),
        bus.hold(&messages::system_tracks()).expect("a topic"),
        bus.hold(&messages::progress()).expect("a topic"),
    ];
    let mut agent = FusionAgent::new(&config(), runtime::Speed::Max, &bus, 1, Queues::new(false)).expect("an agent");
    let mut source: Publisher<InProcess, SensorTrack> = bus.publisher(&topic, 2).expect("a publisher");
    let subscriber = |_| bus.subscriber(&messages::system_tracks(), || 1).expect("a subscriber");
    let mut readers: Vec<Subscriber<InProcess, SystemTrack>> = (0..reading).map(subscriber).collect();
    let _stopped: Vec<Subscriber<InProcess, SystemTrack>> = (0..stopped).map(subscriber).collect();
    let mut spent = std::time::Duration::ZERO;
    for sent in 0..REPORTS {
        let (round, number) = (sent / TARGETS, sent % TARGETS);
        let time_ns = START_NS + round as i64 * S + number as i64 * (S / TARGETS as i64);
        let mark = Mark {
            progress_ns: time_ns,
            sent_ns: sent as i64,
            end: false,
        };
        source.send(mark, 1, |_, _| report(number, time_ns)).expect("a send");
        let now = Now {
            mono_ns: sent as i64,
            utc_ns: time_ns,
        };
        let began = Instant::now();
        one_turn(&mut agent, now);
        spent += began.elapsed();
        for reader in &mut readers {
            reader.take(usize::MAX, |_, _| ()).expect("a look");
        }
    }
    spent
}

/// What is counted; by itself, so that it can be named.
#[inline(never)]
fn one_turn(agent: &mut impl Agent, now: Now) {
    agent.turn(now).expect("a turn");
}

fn main() {
    let numbers: Vec<usize> = std::env::args().skip(1).filter_map(|word| word.parse().ok()).collect();
    let cases = match numbers[..] {
        [reading, stopped] => vec![(reading, stopped)],
        _ => vec![(0, 0), (1, 0), (1, 1), (10, 0), (11, 0)],
    };
    for (reading, stopped) in cases {
        let spent = drive(reading, stopped);
        println!(
            "{reading} subscribers that read, {stopped} that do not: {REPORTS} reports, {:.0} ns each",
            spent.as_nanos() as f64 / REPORTS as f64
        );
    }
}
