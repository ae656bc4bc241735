//! Fusion driven turn by turn over the in-process transport.

use std::path::Path;
use std::sync::Arc;

use bus::{Bus, InProcess, Mark, Publisher, Root, Subscriber, TopicHold};
use configuration::Config;
use fusion_service::FusionAgent;
use messages::{
    BatchHeader, Counter, Covariance, Decision, DecisionKind, FusionRule, NO_SOURCE, Order, OrderKind, SensorTrack,
    SystemTrack, TrackState, sensor_track_bits,
};
use runtime::clock::mono_ns;
use runtime::housekeeping::Queues;
use runtime::{Agent, HealthEntry, Now, Speed, Turn};
use test_support::S;

const DAY: i64 = 16_931 * 86_400 * S;

fn config(order: &str, more: &str) -> Config {
    let source = |name: &str| {
        // Live sources are those of other processes here; "replay" is order `arrival` with recordings.
        let input = match order {
            "arrival" => "[source.external]\n".to_owned(),
            _ => format!("[source.recorded]\nfile = \"{name}.ast\"\n"),
        };
        format!("[[source]]\nname = \"{name}\"\n{input}[source.accuracy]\nconditions = {{ rain = 9.0 }}\n")
    };
    let order = if order == "replay" { "arrival" } else { order };
    let head = format!(
        "name = \"t\"\n[frame]\nlatitude_deg = 0.0\nlongitude_deg = 0.0\n[time]\norder = \"{order}\"\ndate = \"2016-05-10\"\n"
    );
    let text = format!(
        "{head}{}{}[recorder]\nenabled = false\n{more}",
        source("a"),
        source("b")
    );
    Config::parse(Path::new("t.toml"), &text, &[]).unwrap()
}

/// A new sensor track is placed at once, without waiting for the rest of its scan.
const AT_ONCE: &str = "[fusion.association]\nscan_wait = 0.0\n";

struct Bench {
    _folder: tempfile::TempDir,
    _held: Vec<TopicHold>,
    agent: FusionAgent<InProcess>,
    sources: [Publisher<InProcess, SensorTrack>; 2],
    queues: Arc<Queues>,
    now: Now,
    system: Subscriber<InProcess, SystemTrack>,
    received: Vec<SystemTrack>,
    /// Progress marks of the slices received.
    marks: Vec<i64>,
    ended: bool,
}

impl Bench {
    fn new(config: &Config) -> Self {
        Self::at_speed(config, Speed::Factor(1.0))
    }

    fn at_speed(config: &Config, speed: Speed) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let bus: Bus<InProcess> = Bus::open(&Root::in_base(folder.path(), "t").unwrap(), "test").unwrap();
        let topics = ["a", "b"].map(messages::sensor_tracks);
        let mut held: Vec<TopicHold> = topics.iter().map(|topic| bus.hold(topic).unwrap()).collect();
        held.push(bus.hold(&messages::system_tracks()).unwrap());
        held.push(bus.hold(&messages::progress()).unwrap());
        let system = bus.subscriber(&messages::system_tracks(), || 1).unwrap();
        let queues = Queues::new(config.decision_use());
        let agent = FusionAgent::new(config, &config.engine, speed, &bus, 1, Arc::clone(&queues)).unwrap();
        let sources = topics.map(|topic| bus.publisher(&topic, 2).unwrap());
        Self {
            _folder: folder,
            _held: held,
            agent,
            sources,
            queues,
            now: Now {
                mono_ns: 1,
                utc_ns: DAY,
            },
            system,
            received: Vec::new(),
            marks: Vec::new(),
            ended: false,
        }
    }

    fn send(&mut self, source: usize, reports: &[SensorTrack], progress_ns: i64, end: bool) {
        let mark = Mark {
            progress_ns,
            sent_ns: self.now.mono_ns,
            end,
        };
        self.sources[source]
            .send(mark, reports.len(), |index, _| reports[index])
            .unwrap();
    }

    fn turn(&mut self) -> Turn {
        let turn = self.agent.turn(self.now).unwrap();
        let (received, marks, ended) = (&mut self.received, &mut self.marks, &mut self.ended);
        self.system
            .take(usize::MAX, |header, tracks| {
                received.extend_from_slice(tracks);
                marks.push(header.progress_ns);
                *ended |= header.flags & BatchHeader::END != 0;
            })
            .unwrap();
        turn
    }

    /// Lets so much time pass on both clocks.
    fn pass(&mut self, seconds: f64) {
        let passed_ns = (seconds * S as f64) as i64;
        self.now.mono_ns += passed_ns;
        self.now.utc_ns += passed_ns;
    }

    /// Time since the day began.
    fn seconds(&self) -> f64 {
        (self.now.utc_ns - DAY) as f64 / S as f64
    }

    fn settle(&mut self) {
        for _ in 0..100 {
            if self.turn() != Turn::Worked {
                return;
            }
        }
        panic!("never idle");
    }

    fn counter(&self, counter: Counter) -> u64 {
        let mut entries: Vec<HealthEntry> = Vec::new();
        self.agent.health(&mut entries);
        entries[0].counters[counter]
    }
}

fn report(number: u32, sequence: u64, time_s: f64, x: f64) -> SensorTrack {
    SensorTrack {
        time_of_measurement_ns: DAY + (time_s * S as f64) as i64,
        sequence,
        track_number: number,
        // A topic is its source, so what a report says of it must not matter.
        source: 77,
        valid: sensor_track_bits::VELOCITY,
        position_m: [x, 0.0, 0.0],
        covariance: Covariance::diagonal([10.0, 10.0, 100.0], [2.0; 3]),
        state: TrackState::Confirmed as u8,
        ..SensorTrack::default()
    }
}

fn essence(tracks: &[SystemTrack]) -> Vec<(i64, u32, u16, [f64; 3])> {
    tracks
        .iter()
        .map(|t| (t.reference_time_ns, t.track_number, t.trigger_source, t.position_m))
        .collect()
}

#[test]
fn by_time_the_result_does_not_depend_on_who_comes_first() {
    let a: Vec<_> = (0..30).map(|step| report(1, step, step as f64, 0.0)).collect();
    let b: Vec<_> = (0..30).map(|step| report(1, step, step as f64 + 0.4, 8.0)).collect();
    let run = |first: usize| {
        let mut bench = Bench::new(&config("time", ""));
        let mut parts = [(0, &a), (1, &b)];
        parts.rotate_left(first);
        for (source, reports) in parts {
            bench.send(source, reports, i64::MAX, true);
            bench.settle();
        }
        assert_eq!(bench.turn(), Turn::Finished);
        assert!(bench.ended);
        bench.received
    };
    let (forwards, backwards) = (run(0), run(1));
    assert_eq!(essence(&forwards), essence(&backwards));
    assert_eq!(forwards.len(), 63, "60 reports, one coasting, one suspension, one end");
    assert!(forwards.windows(2).all(|pair| pair[0].sequence + 1 == pair[1].sequence));
}

#[test]
fn by_time_a_report_waits_for_the_slower_source() {
    let mut bench = Bench::new(&config("time", AT_ONCE));
    bench.send(0, &[report(1, 0, 5.0, 0.0)], DAY + 6 * S, false);
    bench.settle();
    assert!(bench.received.is_empty(), "source b may still be at 3 s");
    bench.send(1, &[], DAY + 5 * S, false);
    bench.settle();
    assert_eq!(bench.received.len(), 1);
    assert_eq!(bench.received[0].trigger_source, 0);
}

#[test]
fn a_repeated_report_is_not_fused_twice() {
    let mut bench = Bench::new(&config("time", ""));
    let reports: Vec<_> = (0..10).map(|step| report(1, step, step as f64, 0.0)).collect();
    bench.send(1, &[], i64::MAX, true);
    bench.send(0, &reports[..6], DAY + 6 * S, false);
    bench.settle();
    bench.send(0, &reports[3..], i64::MAX, true);
    bench.settle();
    assert_eq!(
        bench.received.iter().filter(|track| track.trigger_source == 0).count(),
        10
    );
}

#[test]
fn states_say_who_made_them_when_by_which_rule_and_of_which_sensor() {
    let mut bench = Bench::new(&config("arrival", AT_ONCE));
    bench.send(1, &[report(1, 0, 0.0, 3.0)], i64::MIN, false);
    bench.turn();
    let track = bench.received[0];
    assert_eq!(
        (track.epoch, track.origin),
        (1, 0),
        "the incarnation; no number of the deployment"
    );
    assert_eq!(FusionRule::from_code(track.rule), Some(FusionRule::Auto));
    assert_eq!(track.contributions()[0].sensor_uid, messages::sensor_uid("b"));
}

#[test]
fn on_arrival_a_report_is_fused_at_once_and_stamped() {
    let mut bench = Bench::new(&config("arrival", AT_ONCE));
    bench.send(1, &[report(1, 0, 0.0, 3.0)], i64::MIN, false);
    bench.turn();
    let track = bench.received[0];
    assert_eq!((track.trigger_source, track.position_m), (1, [3.0, 0.0, 0.0]));
    assert!(track.stages.taken_ns > 0 && track.stages.fused_ns >= track.stages.taken_ns);
}

#[test]
fn the_wait_for_a_scan_counts_against_no_deadline() {
    // Of 0.1 µs: every answer is late.
    let mut bench = Bench::new(&config("arrival", "[fusion]\ndeadline_us = 0.1\n"));
    bench.now.mono_ns = mono_ns();
    bench.send(0, &[report(1, 0, 0.0, 0.0)], i64::MIN, false);
    bench.turn();
    assert!(bench.received.is_empty(), "its scan may bring others");
    bench.pass(0.5);
    bench.turn();
    let held = bench.received[0];
    let from_taken_ns = bench.now.mono_ns - held.stages.taken_ns;
    assert_eq!(i64::from(held.held_us), from_taken_ns / 1000);
    assert_eq!(bench.counter(Counter::DeadlineMisses), 0);
    bench.send(0, &[report(1, 1, 0.5, 0.0)], i64::MIN, false);
    bench.turn();
    assert_eq!(bench.received[1].held_us, 0);
    assert_eq!(bench.counter(Counter::DeadlineMisses), 1);
}

#[test]
fn on_arrival_full_looks_find_the_slices_of_a_publisher_that_gives_no_hint() {
    let mut bench = Bench::new(&config("arrival", AT_ONCE));
    bench.settle();
    bench.sources[0].pretend_foreign();
    for sequence in 0..3 {
        bench.send(0, &[report(1, sequence, 0.1 * sequence as f64, 0.0)], i64::MIN, false);
    }
    assert_ne!(bench.turn(), Turn::Worked, "nothing is known of them");
    bench.pass(0.3);
    bench.settle();
    assert_eq!(bench.received.len(), 3, "all that the full look had before it");
    // Other sources give hints, and need no full look.
    bench.send(1, &[report(1, 0, 0.3, 0.0)], i64::MIN, false);
    assert_eq!(bench.turn(), Turn::Worked);
}

#[test]
fn a_flood_of_one_source_does_not_keep_the_other_waiting() {
    let mut bench = Bench::new(&config("arrival", AT_ONCE));
    for slice in 0..50u64 {
        let flood: Vec<_> = (0..64)
            .map(|index| report(index, 64 * slice + u64::from(index), 0.0, 1e4))
            .collect();
        bench.send(0, &flood, i64::MIN, false);
    }
    bench.send(1, &[report(1, 0, 0.0, 0.0)], i64::MIN, false);
    bench.turn();
    let of_other = bench.received.iter().position(|track| track.trigger_source == 1);
    assert!(
        of_other.is_some_and(|place| place <= 2),
        "{of_other:?}: after a report or two of the flood"
    );
    assert!(bench.received.len() < 50 * 64, "and a turn is bounded");

    // While a slice of the flood is being worked off, another report comes.
    bench.received.clear();
    bench.send(1, &[report(1, 1, 1.0, 0.0)], i64::MIN, false);
    bench.turn();
    let of_other = bench.received.iter().position(|track| track.trigger_source == 1);
    assert!(of_other.is_some_and(|place| place <= 2), "{of_other:?}");
}

#[test]
fn a_slice_is_not_said_to_be_worked_off_before_it_is() {
    let mut bench = Bench::new(&config("arrival", AT_ONCE));
    let reports: Vec<_> = (0..40)
        .map(|number| report(number, 0, 0.0, 1e4 * f64::from(number)))
        .collect();
    bench.send(0, &reports, DAY + S, false);
    bench.settle();
    let (last, before) = bench.marks.split_last().unwrap();
    assert!(
        !before.is_empty() && before.iter().all(|mark| *mark == i64::MIN),
        "{before:?}"
    );
    assert_eq!(*last, DAY + S);
}

#[test]
fn slices_without_reports_keep_nobody_waiting() {
    let mut bench = Bench::new(&config("arrival", AT_ONCE));
    for _ in 0..200 {
        bench.send(0, &[], DAY, false);
    }
    bench.send(0, &[report(1, 0, 0.0, 0.0)], DAY, false);
    bench.send(1, &[report(1, 0, 0.0, 9e4)], DAY, false);
    bench.turn();
    assert_eq!(
        bench.received.len(),
        1,
        "of the other source: the empty slices are not passed over all at once"
    );
    for _ in 0..30 {
        bench.agent.wait(std::time::Duration::ZERO).unwrap();
        bench.turn();
    }
    assert_eq!(bench.received.len(), 2);
}

#[test]
fn what_overflows_is_counted_exactly() {
    let mut bench = Bench::new(&config("arrival", ""));
    let depth = messages::sensor_tracks("a").capacity.depth as u64;
    for step in 0..depth + 40 {
        bench.send(0, &[report(1, step, step as f64, 0.0)], i64::MIN, false);
    }
    bench.settle();
    assert_eq!(bench.counter(Counter::Lost), 40);
    assert_eq!(bench.counter(Counter::Taken), depth);
}

#[test]
fn decisions_wait_for_whoever_publishes_them() {
    let mut bench = Bench::new(&config("arrival", &format!("[fusion]\ndecisions = true\n{AT_ONCE}")));
    for step in 0..20 {
        for source in 0..2 {
            bench.send(source, &[report(1, step, step as f64, 0.0)], i64::MIN, false);
        }
        bench.settle();
        bench.pass(1.0);
    }
    bench.pass(200.0);
    bench.settle();
    let queue = bench.queues.decisions.as_ref().unwrap();
    let decided: Vec<Decision> = std::iter::from_fn(|| queue.pop()).collect();
    let kinds: Vec<DecisionKind> = decided.iter().map(|decision| decision.kind().unwrap()).collect();
    let place = |kind| kinds.iter().position(|one| *one == kind);
    let expected = [
        DecisionKind::Started,
        DecisionKind::Joined,
        DecisionKind::Confirmed,
        DecisionKind::Coasted,
        DecisionKind::Suspended,
        DecisionKind::Ended,
    ];
    let places = expected.map(place);
    assert!(places.is_sorted() && places[0].is_some(), "{kinds:?}");
    let number = bench.received[0].track_number;
    assert!(
        decided.iter().all(|decision| decision.system_track == number),
        "{decided:?}"
    );
    assert_eq!(bench.counter(Counter::DecisionsDropped), 0);
}

#[test]
fn decisions_that_nobody_takes_are_counted() {
    let mut bench = Bench::new(&config("arrival", &format!("[fusion]\ndecisions = true\n{AT_ONCE}")));
    let room = bench.queues.decisions.as_ref().unwrap().capacity() as u64;
    let starts = room + 30;
    for first in (0..starts).step_by(50) {
        let reports: Vec<_> = (first..starts.min(first + 50))
            .map(|number| report(number as u32, number, bench.seconds(), 3000.0 * (number % 50) as f64))
            .collect();
        bench.send(0, &reports, i64::MIN, false);
        bench.settle();
        bench.pass(100.0);
    }
    assert!(bench.counter(Counter::DecisionsDropped) >= 30);
    assert!(bench.queues.decisions.as_ref().unwrap().is_full());
}

#[test]
fn a_condition_ordered_while_running_changes_the_accuracy_values() {
    let value = |ordered: Option<&str>| {
        let mut bench = Bench::new(&config("arrival", "[fusion.rule]\nname = \"best-source\"\n"));
        if let Some(name) = ordered {
            let order = Order {
                token: 1,
                sent_ns: bench.now.utc_ns,
                ..Order::new(OrderKind::Condition).with_name(name).unwrap()
            };
            bench.queues.orders.push(order).unwrap();
        }
        for step in 0..3 {
            bench.send(
                0,
                &[report(1, step, step as f64, 5.0 * (step % 2) as f64)],
                i64::MIN,
                false,
            );
            bench.settle();
            bench.pass(1.0);
        }
        bench.settle();
        bench.received.last().unwrap().contributions()[0].accuracy
    };
    let clear = value(None);
    assert!(clear > 0.0);
    assert!((value(Some("rain")) / clear - 9.0).abs() < 1e-9);
    assert!(
        (value(Some("fog")) / clear - 1.0).abs() < 1e-9,
        "a condition that nobody names"
    );
}

/// A minute of an honest source and one whose times are `claimed` of the true ones, ten reports a second each, a target
/// each second; everything that was published, and counted of the second source.
fn beside(claimed: impl Fn(i64) -> i64) -> (Vec<SystemTrack>, Bench) {
    let mut bench = Bench::new(&config("arrival", AT_ONCE));
    for step in 0..600u64 {
        let number = (step % 10) as u32;
        let (second, place) = (0.1 * step as f64, 5e3 * f64::from(number));
        bench.send(0, &[report(number, step, second - 0.05, place)], i64::MIN, false);
        let mut other = report(number, step, 0.0, -1e5 - place);
        other.time_of_measurement_ns = claimed(bench.now.utc_ns);
        bench.send(1, &[other], i64::MIN, false);
        bench.settle();
        bench.pass(0.1);
    }
    (std::mem::take(&mut bench.received), bench)
}

fn of_first(tracks: &[SystemTrack]) -> Vec<String> {
    let first = tracks.iter().filter(|track| track.position_m[0] > -5e4);
    first
        .map(|track| {
            // Neither the times of processing nor the evidence that the silence of the other source gives.
            let stages = messages::StageTimes::default();
            format!(
                "{:?}",
                SystemTrack {
                    stages,
                    sequence: 0,
                    track_number: 0,
                    existence: 0.0,
                    ..*track
                }
            )
        })
        .collect()
}

#[test]
fn a_wild_clock_harms_nobody_else_and_is_shown() {
    let (honest, _) = beside(|now_ns| now_ns - S / 20);
    assert_eq!(of_first(&honest).len(), 600);
    for offset_s in [5.5, 30.0, 50.0, 70.0, -30.0, 31e6] {
        let (tracks, bench) = beside(|now_ns| now_ns + (offset_s * S as f64) as i64);
        assert_eq!(of_first(&tracks), of_first(&honest), "{offset_s} s");
        assert!(tracks.iter().all(|track| track.trigger_source != 1), "{offset_s} s");
        assert_eq!(bench.counter(Counter::RejectedClock), 600, "{offset_s} s");
        let mut entries = Vec::new();
        bench.agent.health(&mut entries);
        let shown = entries[2].registration;
        assert!(
            (shown.clock_offset_s - offset_s).abs() < 1e-3 && shown.clock_offset_sigma_s > 0.0,
            "{shown:?}"
        );
        assert!(entries[1].registration.clock_offset_s.abs() < 0.1);
    }
    // One report in fifty, and any number that there is.
    for wild in [
        |now_ns: i64| now_ns + 50 * S,
        |now_ns: i64| now_ns.wrapping_mul(0x1e37_79b9_7f4a_7c15),
    ] {
        let (tracks, bench) = beside(|now_ns| {
            if now_ns / (S / 10) % 50 == 7 {
                wild(now_ns)
            } else {
                now_ns - S / 20
            }
        });
        assert_eq!(of_first(&tracks), of_first(&honest));
        assert!(bench.counter(Counter::RejectedClock) + bench.counter(Counter::RejectedInvalid) >= 12);
        assert_eq!(tracks.iter().filter(|track| track.trigger_source == 1).count(), 588);
    }
}

#[test]
fn an_offset_that_all_sources_share_is_the_hosts_and_disturbs_no_track() {
    for (first_s, then_s) in [
        (6.0, 6.0),
        (-5.5, -5.5),
        (3600.0, 3600.0),
        (0.0, 7.0),
        (0.0, -7.0),
        (4.0, -3600.0),
    ] {
        let mut bench = Bench::new(&config("arrival", AT_ONCE));
        for step in 0..600u64 {
            let number = (step % 10) as u32;
            let off_s = if step < 300 { first_s } else { then_s };
            let second = 0.1 * step as f64 - 0.05 + off_s;
            for source in 0..2 {
                let mut report = report(number, step, second, 5e3 * f64::from(number));
                report.position_m[1] += 1e5 * source as f64;
                bench.send(source, &[report], i64::MIN, false);
            }
            bench.settle();
            bench.pass(0.1);
        }
        let tracks = std::mem::take(&mut bench.received);
        let ended = tracks
            .iter()
            .filter(|track| track.state == TrackState::Terminated as u8);
        assert_eq!(ended.count(), 0, "{first_s} {then_s}");
        let numbers: std::collections::BTreeSet<u32> = tracks.iter().map(|track| track.track_number).collect();
        assert_eq!(numbers.len(), 20, "{first_s} {then_s}");
        // In the sources' time, a second after a change at the latest but for the reports that showed it.
        let of_second = |second: i64| {
            let time_ns = DAY + second * S + (then_s * S as f64) as i64;
            let within = time_ns..time_ns + S;
            tracks
                .iter()
                .filter(|track| within.contains(&track.reference_time_ns))
                .count()
        };
        assert_eq!((of_second(45), of_second(58)), (20, 20), "{first_s} {then_s}");
        let mut entries = Vec::new();
        bench.agent.health(&mut entries);
        let host_s = entries[0].registration.clock_offset_s;
        let expected_s = if then_s.abs() > 5.0 { then_s } else { 0.0 };
        assert!((host_s - expected_s).abs() <= 0.6, "{host_s}");
    }
}

#[test]
fn five_thousand_targets_that_are_late_together_are_all_shown() {
    const TARGETS: u64 = 5_000;
    const PER_STEP: u64 = 125;
    let capacity = "[fusion.capacity]\nsystem_tracks = 6000\nsensor_tracks = 12000\n";
    for (first_s, then_s) in [(-6.0, -6.0), (-3600.0, -3600.0), (0.0, -7.0)] {
        let mut bench = Bench::new(&config("arrival", &format!("{AT_ONCE}{capacity}")));
        for step in 0..800u64 {
            let off_s = if step < 400 { first_s } else { then_s };
            let second = 0.1 * step as f64 - 0.05 + off_s;
            for source in 0..2 {
                let seen = |place| {
                    let number = (PER_STEP * step + place) % TARGETS;
                    let mut report = report(
                        number as u32,
                        PER_STEP * step + place,
                        second,
                        2e3 * (number % 70) as f64,
                    );
                    report.position_m[1] = 2e3 * (number / 70) as f64;
                    report
                };
                for slice in (0..PER_STEP).map(seen).collect::<Vec<_>>().chunks(64) {
                    bench.send(source, slice, i64::MIN, false);
                }
            }
            bench.settle();
            bench.pass(0.1);
            if step < 760 {
                bench.received.clear();
            }
        }
        let shown = bench.received.iter().filter(|track| {
            let age_ns = bench.now.utc_ns + (then_s * S as f64) as i64 - track.reference_time_ns;
            track.state == TrackState::Confirmed as u8 && (0..5 * S).contains(&age_ns)
        });
        let numbers: std::collections::BTreeSet<u32> = shown.map(|track| track.track_number).collect();
        assert_eq!(numbers.len() as u64, TARGETS, "{first_s} {then_s}");
    }
}

#[test]
fn a_step_of_the_machines_clock_is_no_step_of_the_picture() {
    let states = |set_s: i64| {
        let mut bench = Bench::new(&config("arrival", AT_ONCE));
        for step in 0..400u64 {
            let number = (step % 10) as u32;
            let second = 0.1 * step as f64 - 0.05;
            bench.send(
                0,
                &[report(number, step, second, 5e3 * f64::from(number))],
                i64::MIN,
                false,
            );
            bench.settle();
            bench.pass(0.1);
            if step == 200 {
                bench.now.utc_ns += set_s * S;
            }
        }
        let mut entries = Vec::new();
        bench.agent.health(&mut entries);
        let states = bench
            .received
            .iter()
            .map(|track| (track.track_number, track.reference_time_ns));
        (states.collect::<Vec<_>>(), entries[0].registration.clock_offset_s)
    };
    let (undisturbed, host_s) = states(0);
    assert_eq!((undisturbed.len(), host_s), (400, 0.0));
    for set_s in [7, -7, 3600, -86_400] {
        let (disturbed, host_s) = states(set_s);
        assert_eq!(disturbed, undisturbed, "{set_s} s");
        assert!(
            (host_s + set_s as f64).abs() < 0.01,
            "the machine is ahead by {set_s} s: {host_s}"
        );
    }
}

#[test]
fn a_source_is_back_when_its_clock_is_sound_again() {
    let bad_from = DAY + 10 * S;
    let (tracks, _) = beside(|now_ns| {
        now_ns - S / 20
            + if (bad_from..bad_from + 20 * S).contains(&now_ns) {
                40 * S
            } else {
                0
            }
    });
    let times: Vec<i64> = tracks
        .iter()
        .filter(|track| track.trigger_source == 1)
        .map(|track| track.reference_time_ns)
        .collect();
    let in_second = |second: i64| times.iter().filter(|time_ns| (*time_ns - DAY) / S == second).count();
    assert_eq!((in_second(5), in_second(20)), (10, 0));
    assert!(in_second(31) < 10, "not at the first sound report");
    assert_eq!(in_second(45), 10);
}

#[test]
fn a_replay_on_arrival_is_judged_by_the_clock_that_it_has() {
    let live_until = |bench: &mut Bench, mark: bool| {
        for step in 0..300u64 {
            let second = 0.1 * step as f64;
            let mark_ns = if mark {
                DAY + (second * S as f64) as i64
            } else {
                i64::MIN
            };
            bench.send(0, &[report(1, step, second, 0.0)], mark_ns, false);
            // The other recording began an hour later, and runs as evenly; one of its times is 50 s ahead.
            let wild = if step == 150 { 50.0 } else { 0.0 };
            bench.send(1, &[report(1, step, 3600.0 + second + wild, 1e5)], mark_ns, false);
            bench.settle();
            bench.pass(0.01);
        }
        bench
            .received
            .iter()
            .filter(|track| track.state == TrackState::Terminated as u8)
            .count()
    };
    // Ten seconds of the recording a second.
    let mut paced = Bench::at_speed(&config("replay", AT_ONCE), Speed::Factor(10.0));
    assert_eq!(live_until(&mut paced, false), 0);
    assert_eq!(paced.counter(Counter::RejectedClock), 1);
    // Faster than any clock: time passes to where the slowest says that it has got.
    let mut free = Bench::at_speed(&config("replay", AT_ONCE), Speed::Max);
    assert_eq!(live_until(&mut free, true), 0);
    assert_eq!(free.counter(Counter::RejectedClock), 0);
    free.send(0, &[], i64::MAX, true);
    free.send(1, &[], DAY + 60 * S, false);
    free.settle();
    assert_eq!(
        free.received.last().map(|track| track.state),
        Some(TrackState::Suspended as u8),
        "one is silent"
    );
}

#[test]
fn by_time_one_source_that_runs_away_holds_up_nobody_and_ends_nothing() {
    let honest: Vec<_> = (0..60).map(|step| report(1, step, step as f64, 0.0)).collect();
    let run = |ahead: &[f64]| {
        let mut bench = Bench::new(&config("time", ""));
        for step in 0..60 {
            bench.send(0, &honest[step..=step], DAY + step as i64 * S, step == 59);
            let seconds = step as f64 + ahead[step % ahead.len()];
            let other = report(7, step as u64, seconds, 1e5);
            bench.send(1, &[other], other.time_of_measurement_ns.saturating_add(S), step == 59);
            bench.settle();
        }
        bench.settle();
        assert_eq!(bench.turn(), Turn::Finished);
        bench
            .received
            .retain(|track| track.position_m[0] < 5e4 && track.trigger_source != NO_SOURCE);
        bench.received
    };
    let calm = run(&[0.5]);
    assert_eq!(calm.len(), 60);
    for ahead in [&[30.0][..], &[70.0], &[0.5, 0.5, 50.0], &[3e9]] {
        let tracks = run(ahead);
        assert_eq!(tracks.len(), 60, "{ahead:?}");
        assert!(
            tracks.iter().all(|track| track.track_number == tracks[0].track_number),
            "{ahead:?}"
        );
    }
}
