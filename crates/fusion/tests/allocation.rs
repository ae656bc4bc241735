//! After its construction the engine allocates nothing, whatever it is given (PL-4).

use std::sync::atomic::AtomicU64;

use assert_no_alloc::{AllocDisabler, assert_no_alloc};
use fusion::rules;
use fusion::settings::{
    Accuracy, AssociationSettings, Capacity, DropOut, HandOverSettings, RuleSettings, Settings, SourceSettings,
};
use fusion::{Engine, Merger};
use messages::{Covariance, Identity, SensorTrack, SystemTrack, TrackState, sensor_track_bits};
use test_support::S;

#[global_allocator]
static ALLOCATOR: AllocDisabler = AllocDisabler;

fn settings() -> Settings {
    let source = |name: &str| SourceSettings {
        learns_period: name == "c",
        is_self_reported: name == "c",
        ..SourceSettings::of(name, 1.0, Accuracy::constant(10.0))
    };
    Settings {
        capacity: Capacity {
            system_tracks: Some(60),
            sensor_tracks: Some(200),
            stored_reports: 5,
            ..Capacity::default()
        },
        association: AssociationSettings {
            target_extent_m: 30.0,
            ..AssociationSettings::default()
        },
        ..Settings::of(["a", "b", "c"].map(source).to_vec())
    }
}

/// One report of an endless traffic that joins, splits, merges, renumbers, ends, falls silent and comes back, overflows
/// the tables and lies.
fn report(step: u64) -> SensorTrack {
    let mut noise = step.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
    let mut random = || {
        noise ^= noise << 13;
        noise ^= noise >> 7;
        noise ^= noise << 17;
        (noise >> 11) as f64 / (1u64 << 53) as f64
    };
    let (source, target) = ((random() * 3.0) as u16, (random() * 90.0) as u32);
    let second = step / 100;
    // A quarter of the targets is silent for half a minute, in turn; others report instead.
    let is_silent = (u64::from(target) + second / 31).is_multiple_of(4);
    let target = if is_silent { (target + 1) % 90 } else { target };
    let mut report = SensorTrack {
        time_of_measurement_ns: step as i64 * S / 100,
        source,
        track_number: target + 1000 * (second / 23) as u32,
        valid: sensor_track_bits::VELOCITY,
        position_m: [
            700.0 * f64::from(target % 9) + 60.0 * random(),
            700.0 * f64::from(target / 9),
            0.0,
        ],
        velocity_mps: [20.0 * random(), 0.0, 0.0],
        covariance: Covariance::diagonal([10.0, 10.0, 100.0], [3.0; 3]),
        state: if random() < 0.02 {
            TrackState::Terminated as u8
        } else {
            TrackState::Confirmed as u8
        },
        ..SensorTrack::default()
    };
    if source == 1 {
        report.identity = Identity::default().with_address(target % 40);
    }
    if source > 0 {
        // Codes that few have or many, that change and are garbled; call signs of every kind.
        let code = (target % 50 + (step / 5_000) as u32 % 3) as u16 ^ u16::from(random() < 0.05);
        let callsign = [b'A' + (random() * 26.0) as u8, b' ', 0, b'1', b' ', b' ', b' ', b' '];
        report.identity = report.identity.with_mode_3a(code).with_callsign(callsign);
    }
    if source == 2 && target % 7 == 0 {
        report.identity = report.identity.with_address(target % 40);
        report.position_m[1] += 20e3;
    }
    if random() < 0.1 {
        report.covariance.set(0, 1, 130.0);
    }
    if random() < 0.01 {
        report.position_m[0] = f64::NAN;
    }
    report
}

#[test]
fn the_engine_and_the_merger_allocate_nothing_once_built() {
    let mut engine = Engine::new(settings()).unwrap();
    let words = engine.checkpoint_layout().len();
    let memory: Vec<AtomicU64> = (0..words).map(|_| AtomicU64::new(0)).collect();
    engine.keep_checkpoint(Box::new(memory));
    let mut merger = Merger::new(3, 256);
    let mut published = 0u64;
    let mut sequences = [0u64; 3];
    assert_no_alloc(|| {
        for step in 0..200_000 {
            let mut report = report(step);
            let source = usize::from(report.source);
            report.sequence = sequences[source];
            sequences[source] += 1;
            merger.push(source, &report);
            for source in 0..3 {
                merger.set_watermark(source, report.time_of_measurement_ns);
            }
            while let Some(report) = merger.pop() {
                engine.take(&report, &mut |_: &SystemTrack| published += 1);
                engine.keep_learned(2);
            }
        }
        engine.advance(i64::MAX, &mut |_: &SystemTrack| published += 1);
    });
    assert!(published > 15_000, "{published}");
    let counts = engine.counts();
    for counter in [
        messages::Counter::DroppedTable,
        messages::Counter::TracksMerged,
        messages::Counter::RejectedInvalid,
        messages::Counter::NumbersResumed,
    ] {
        assert!(counts.get(counter) > 0, "the traffic was meant to cause {counter:?}");
    }
}

/// `cargo test --release -p fusion --test allocation -- --ignored`
#[test]
#[ignore = "ten million updates: some ten seconds in a release build, minutes in others; `.ci/campaign endurance` runs it"]
fn ten_million_updates_allocate_nothing() {
    let settings = Settings {
        rule: RuleSettings::default(),
        ..settings()
    };
    let mut engine = Engine::new(settings).unwrap();
    let mut published = 0u64;
    assert_no_alloc(|| {
        for step in 0..10_000_000 {
            engine.take(&report(step), &mut |_: &SystemTrack| published += 1);
        }
    });
    assert!(published > 500_000, "{published}");
}

#[test]
fn no_rule_allocates_anything_at_reports_or_at_uniform_times() {
    for (index, rule) in rules::REGISTRY.iter().enumerate() {
        for refresh_ns in [None, Some(S / 2)] {
            let settings = Settings {
                rule: RuleSettings {
                    name: fusion::settings::RuleName(rule.code),
                    hand_over: HandOverSettings {
                        ramp: vec![0.3, 0.6],
                        by_traces: index % 2 == 1,
                        drop_out: DropOut::Blend,
                        ..HandOverSettings::default()
                    },
                    ..RuleSettings::default()
                },
                refresh_s: refresh_ns.map(settings::Seconds::of_ns),
                refresh_delay_s: settings::Seconds::of_ns(S),
                ..settings()
            };
            let mut engine = Engine::new(settings).unwrap();
            let mut published = 0u64;
            assert_no_alloc(|| {
                for step in 0..20_000 {
                    engine.take(&report(step), &mut |_: &SystemTrack| published += 1);
                }
                engine.advance(i64::MAX, &mut |_: &SystemTrack| published += 1);
            });
            assert!(published > 2_000, "{}: {published}", rule.name());
            let repaired = engine.counts().get(messages::Counter::CovariancesRepaired);
            assert!(repaired > 0, "the traffic was meant to need repairs");
        }
    }
}
