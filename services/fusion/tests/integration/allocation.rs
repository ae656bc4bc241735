//! Once it runs, the loop allocates nothing: taking slices, fusing, publishing, waiting, counting (PL-4).
//!
//! One exception, which is not ours: iceoryx2 0.10 keeps the state of a loaned slice in one small block, taken when the
//! slice is loaned and given back before its send returns. The next slice is loaned after each send. So the numbers are
//! exact: as many blocks are given back as are taken, one for each slice published, and a second one where the slice
//! loaned ahead has another length than the batch.

#[path = "../../../../crates/bus/tests/integration/common/heap.rs"]
mod heap;

use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use bus::{Bus, InProcess, Mark, Publisher, Root, TopicHold};
use configuration::Config;
use fusion_service::{FusionAgent, SmoothingQueue, SmoothingWorker};
use heap::{Counting, SMALL_BYTES, heap_use};
use messages::{Counter, Covariance, Order, OrderKind, SensorTrack, SystemTrack, TrackState, sensor_track_bits};
use runtime::housekeeping::Queues;
use runtime::{Agent, HealthEntry, Now, Speed};
use test_support::S;

#[global_allocator]
static ALLOCATOR: Counting = Counting;

const START_NS: i64 = 16_931 * 86_400 * S;
const TARGETS: u32 = 300;
const SLICE: u64 = 48;
const SLICES: u64 = 3000;

fn config(wait: &str) -> Config {
    let source = |name: &str| format!("[[source]]\nname = \"{name}\"\n[source.external]\n");
    let text = format!(
        "name = \"t\"\n[frame]\nlatitude_deg = 0.0\nlongitude_deg = 0.0\n[time]\norder = \"arrival\"\ndate = \"2016-05-10\"\n\
         {}{}{}[recorder]\nenabled = false\n[fusion]\nwait = \"{wait}\"\ndecisions = true\n[fusion.capacity]\nsystem_tracks = 250\nkept_measurements = 5000\n",
        source("a"),
        source("b"),
        source("c")
    );
    Config::parse(Path::new("t.toml"), &text, &[]).unwrap()
}

fn report(number: u32, second: f64) -> SensorTrack {
    SensorTrack {
        time_of_measurement_ns: START_NS + (second * S as f64) as i64,
        track_number: number,
        valid: sensor_track_bits::VELOCITY,
        position_m: [
            2000.0 * f64::from(number % 20),
            2000.0 * f64::from(number / 20) + 10.0 * second,
            0.0,
        ],
        velocity_mps: [0.0, 10.0, 0.0],
        covariance: Covariance::diagonal([10.0, 10.0, 100.0], [2.0; 3]),
        state: TrackState::Confirmed as u8,
        ..SensorTrack::default()
    }
}

/// An order of each kind in turn, some of them about the two tracks that were published last.
fn order(step: u64, [track, other_track]: [u32; 2]) -> Order {
    let order = |kind: OrderKind| Order {
        token: 1 + step,
        sent_ns: START_NS + step as i64 * S / 20,
        ..Order::new(kind)
    };
    let source = 1;
    match step / 100 % 8 {
        0 => order(OrderKind::Condition).with_name("normal").unwrap_or_default(),
        1 => Order {
            value: 0.5,
            ..order(OrderKind::Eta)
        },
        2 => Order {
            source,
            value: 2.0,
            ..order(OrderKind::Adjustment)
        },
        3 => Order {
            source,
            ..order(OrderKind::Out)
        },
        4 => Order {
            source,
            ..order(OrderKind::In)
        },
        5 => Order {
            track,
            ..order(OrderKind::Drop)
        },
        6 => Order {
            track,
            other_track,
            ..order(OrderKind::Join)
        },
        _ => Order {
            track,
            ..order(OrderKind::Renumber)
        },
    }
}

#[test]
fn the_loop_allocates_nothing() {
    for wait in ["spin", "event"] {
        let folder = tempfile::tempdir().unwrap();
        let bus: Bus<InProcess> = Bus::open(&Root::in_base(folder.path(), "t").unwrap(), "test").unwrap();
        let topics = ["a", "b", "c"].map(messages::sensor_tracks);
        let mut held: Vec<TopicHold> = topics.iter().map(|topic| bus.hold(topic).unwrap()).collect();
        held.push(bus.hold(&messages::system_tracks()).unwrap());
        held.push(bus.hold(&messages::progress()).unwrap());
        held.push(bus.hold(&messages::smoothed_tracks()).unwrap());
        let queues = Queues::new(Some(deployment::DecisionUse::Record));
        let config = config(wait);
        let agent = FusionAgent::new(&config, &config.engine, Speed::Max, &bus, 1, Arc::clone(&queues)).unwrap();
        // The second time the loop passes on what it emits to the smoothing thread, too.
        let smoothing = (wait == "event").then(|| SmoothingQueue::new(250));
        let mut agent = agent.with_smoothing(smoothing.clone());
        let mut worker = smoothing.map(|queue| SmoothingWorker::new(queue, S, &bus, 1));
        let mut sources: Vec<Publisher<InProcess, SensorTrack>> =
            topics.iter().map(|topic| bus.publisher(topic, 2).unwrap()).collect();
        let mut reader = bus.subscriber(&messages::system_tracks(), || 1).unwrap();
        let mut entries: Vec<HealthEntry> = Vec::with_capacity(1 + sources.len());

        let (mut published, mut latest) = (0, [0; 2]);
        for step in 0..SLICES {
            // Slices of three sources, each all of its targets in turn; one of them in bursts.
            let source = (step % 3) as usize;
            let slices = if source == 0 && step.is_multiple_of(5) { 6 } else { 1 };
            for _ in 0..slices {
                // The third source is late now and then.
                let is_late = source == 2 && step / 300 % 4 == 2;
                let late_s = if is_late { 0.2 * (step % 20) as f64 } else { 0.0 };
                let second = step as f64 * 0.05 - late_s;
                let mark = Mark {
                    progress_ns: i64::MIN,
                    sent_ns: step as i64 * S / 20,
                    end: false,
                };
                let number = |index: usize| ((step / 3 * SLICE) as u32 + index as u32) % TARGETS;
                sources[source]
                    .send(mark, SLICE as usize, |index, _| report(number(index), second))
                    .unwrap();
            }
            if step.is_multiple_of(100) {
                queues.orders.push(order(step, latest)).unwrap();
            }
            let now = Now {
                mono_ns: step as i64 * S / 20,
                utc_ns: START_NS + step as i64 * S / 20,
            };
            let slices = reader.counts().slices;
            let used = heap_use(|| {
                for _ in 0..4 {
                    agent.turn(now).expect("a turn");
                }
                agent.wait(Duration::from_micros(20)).expect("a wait");
                entries.clear();
                agent.health(&mut entries);
            });
            while queues.order_states.pop().is_some() {}
            // Smoothing itself takes long: a part is enough.
            if let Some(worker) = worker.as_mut().filter(|_| step < SLICES / 10) {
                worker.turn().expect("smoothed states");
            }
            let taken = reader.take(usize::MAX, |_, tracks: &[SystemTrack]| {
                published += tracks.len();
                let shown = tracks.iter().filter(|track| track.state == TrackState::Confirmed as u8);
                shown.for_each(|track| latest = [track.track_number, latest[0]]);
            });
            taken.unwrap();
            let slices = reader.counts().slices - slices;
            // Ports that meet for the first time may allocate.
            if step >= 10 {
                let taken = slices..=2 * slices;
                assert!(
                    taken.contains(&used.taken),
                    "step {step}, {wait}: {} of {slices}",
                    used.taken
                );
                assert_eq!(used.taken, used.given_back, "step {step}, {wait}");
                assert!(used.largest_bytes <= SMALL_BYTES);
            }
        }
        let taken = entries[0].counters[Counter::Taken];
        assert!(
            taken > SLICES * SLICE && published > 100_000,
            "{taken} taken, {published} published"
        );
        assert!(
            entries[0].counters[Counter::DroppedTable] > 0,
            "a full table is part of it"
        );
        let dropped = entries[0].counters[Counter::SmoothingDropped];
        assert_eq!(dropped > 0, wait == "event", "nobody takes the rest");
        for late in [Counter::LateUsed, Counter::LateUnkept] {
            assert!(entries[0].counters[late] > 0, "{}", late.label());
        }
        let obeyed = entries[0].counters[Counter::OrdersObeyed];
        assert!(obeyed > 20, "{obeyed} of 30 orders, too");
    }
}
