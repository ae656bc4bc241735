//! Hostile sources among honest ones: whatever they claim, they harm nobody outside their gates.

use estimation::SourceClock;
use messages::{Counter, SensorTrack, SystemTrack, TrackState, sensor_track_bits};
use proptest::prelude::*;
use std::collections::BTreeMap;

use super::{Harness, S, random, report, with_address};
use crate::Engine;
use crate::settings::{CoverageArea, Settings};
use crate::testing::test_settings;

const HONEST: u16 = 2;
const TARGETS: u32 = 12;
const NOW_NS: i64 = 1_700_000_000 * S;

/// What a hostile source does to the time of its reports.
#[derive(Clone, Copy, Debug)]
enum Lie {
    Ahead(f64),
    AheadNowAndThen(f64),
    AnyTime,
    Jumping,
    /// Sound times, and new tracks all the time.
    Flood,
}

fn settings() -> Settings {
    let mut settings = test_settings(usize::from(HONEST) + 1);
    settings.rule.name.0 = messages::FusionRule::Auto;
    settings.association.scan_wait = 0.05;
    settings.capacity.system_tracks = Some(100);
    settings.capacity.sensor_tracks = Some(300);
    settings
}

/// Half a minute in order of arrival: ten rounds a second, in which each honest source reports some of its targets,
/// late by some hundredths of a second, and the hostile one does `lie`, a hundred kilometres away. What is published of
/// the honest targets, by target, and all that was counted of the hostile source.
fn run(settings: &Settings, seed: u64, lie: Option<Lie>) -> (BTreeMap<u32, Vec<SystemTrack>>, u64) {
    let (mut noise, mut chance) = (random(seed), random(seed ^ 0xabcd_ef12));
    let mut engine = Engine::new(settings.clone()).unwrap();
    let mut clocks = vec![SourceClock::new(5.0); settings.sources.len()];
    let mut published = Vec::new();
    let mut take = |engine: &mut Engine, mut report: SensorTrack, now_ns: i64| {
        if !clocks[usize::from(report.source)].believes(report.time_of_measurement_ns, now_ns, Some(0.0)) {
            report.valid |= sensor_track_bits::WILD_CLOCK;
        }
        engine.take_at(&report, now_ns, &mut |track: &SystemTrack| published.push(*track));
    };
    for step in 0..300u32 {
        let now_ns = NOW_NS + i64::from(step) * S / 10;
        for source in 0..HONEST {
            for target in (0..TARGETS).filter(|target| (target + step).is_multiple_of(10)) {
                let seconds = 0.1 * f64::from(step) - 0.02 * (1.0 + f64::from(source));
                let place = [3e3 * f64::from(target) + 6.0 * noise(), 6.0 * noise()];
                let mut report = with_address(report(source, target, seconds, place, [30.0, 10.0]), 0x40_0000 + target);
                report.time_of_measurement_ns += NOW_NS;
                take(&mut engine, report, now_ns);
            }
        }
        // Who floods before the others are there gets what nobody claims yet.
        let Some(lie) = lie.filter(|_| step >= 20) else {
            continue;
        };
        for index in 0..20 {
            let number = if matches!(lie, Lie::Flood) {
                20 * step + index
            } else {
                index
            };
            let mut report = report(
                HONEST,
                number,
                0.1 * f64::from(step),
                [-1e5 - 1e3 * f64::from(number % 500), 0.0],
                [0.0; 2],
            );
            let ahead_s = match lie {
                Lie::Ahead(seconds) => seconds,
                Lie::AheadNowAndThen(seconds) if chance() > 0.48 => seconds,
                Lie::Jumping => 4.5 * f64::from(step % 3) - 4.5,
                Lie::AheadNowAndThen(_) | Lie::Flood | Lie::AnyTime => 0.0,
            };
            report.time_of_measurement_ns = match lie {
                Lie::AnyTime => (2.0 * chance() * i64::MAX as f64) as i64,
                _ => now_ns + (ahead_s * S as f64) as i64,
            };
            take(&mut engine, report, now_ns);
        }
    }
    let hostile = engine.counts().source(HONEST).unwrap();
    let counted = hostile[Counter::RejectedClock] + hostile[Counter::RejectedInvalid] + hostile[Counter::DroppedTable];
    let mut by_target: BTreeMap<u32, Vec<SystemTrack>> = BTreeMap::new();
    for track in published {
        if let Some(address) = track.identity.address() {
            by_target.entry(address - 0x40_0000).or_default().push(track);
        }
    }
    (by_target, counted)
}

fn lies() -> impl Strategy<Value = Lie> {
    prop_oneof![
        prop::sample::select(vec![5.5, 30.0, 50.0, 70.0, -30.0, 1e6]).prop_map(Lie::Ahead),
        (5.5..100.0f64).prop_map(Lie::AheadNowAndThen),
        Just(Lie::AnyTime),
        Just(Lie::Jumping),
        Just(Lie::Flood),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    #[test]
    fn an_honest_target_keeps_its_life_its_number_and_its_place(seed in any::<u64>(), lie in lies()) {
        let (calm, _) = run(&settings(), seed, None);
        let (beside, counted) = run(&settings(), seed, Some(lie));
        prop_assert!(counted > 0, "what is kept out is counted");
        prop_assert_eq!(calm.len(), TARGETS as usize);
        for (target, calm) in &calm {
            let beside = &beside[target];
            prop_assert_eq!(calm.len(), beside.len());
            for (one, other) in calm.iter().zip(beside) {
                prop_assert_eq!(one.state, other.state);
                prop_assert_eq!(beside[0].track_number, other.track_number);
                let apart = |axis: usize| {
                    let sigma_m = one.covariance.get(axis, axis).sqrt();
                    (one.position_m[axis] - other.position_m[axis]).abs() / sigma_m
                };
                prop_assert!(apart(0).max(apart(1)) < 0.1, "{} {}", apart(0), apart(1));
            }
            prop_assert!(calm.iter().any(|track| track.state == TrackState::Confirmed as u8));
        }
    }

    #[test]
    fn where_nothing_is_learned_of_the_sources_not_one_bit_changes(seed in any::<u64>(), lie in lies()) {
        let mut settings = settings();
        settings.registration.enabled = false;
        for source in &mut settings.sources {
            source.coverage = Some(CoverageArea::none());
        }
        let state = |track: &SystemTrack| {
            (track.state, format!("{:?} {:?} {:?}", track.position_m, track.velocity_mps, track.covariance))
        };
        let states = |lie| -> Vec<_> {
            let (by_target, _) = run(&settings, seed, lie);
            by_target.into_values().map(|tracks| tracks.iter().map(state).collect::<Vec<_>>()).collect()
        };
        prop_assert_eq!(states(None), states(Some(lie)));
    }

    /// No loop over time is longer than there are tracks and steps, and nothing overflows.
    #[test]
    fn any_time_at_all_is_worked_off_at_once(
        times in prop::collection::vec((any::<i64>(), any::<i64>(), 0u16..3), 1..60),
        refresh in prop::option::of(Just(settings::Seconds::of(100.0))),
        delay in prop::sample::select(vec![0.0, 2.0]),
    ) {
        let mut settings = settings();
        settings.refresh_s = refresh;
        settings.refresh_delay_s = settings::Seconds::of(delay);
        let mut engine = Engine::new(settings).unwrap();
        let mut published = 0u64;
        let mut count = |_: &SystemTrack| published += 1;
        for (number, (time_ns, now_ns, source)) in times.iter().enumerate() {
            let mut report = report(*source, number as u32, 0.0, [1e3 * number as f64, 0.0], [0.0; 2]);
            report.time_of_measurement_ns = *time_ns;
            engine.take_at(&report, *now_ns, &mut count);
            engine.take(&report, &mut count);
            engine.advance(*now_ns, &mut count);
        }
        engine.advance(i64::MAX, &mut count);
        prop_assert!(published < 1_000_000, "{}", published);
    }
}

#[test]
fn a_report_that_is_older_than_any_track_becomes_starts_none() {
    let mut harness = Harness::new(test_settings(2));
    for second in 0..60 {
        let east_m = 100.0 * f64::from(second);
        harness.take(&report(0, 1, f64::from(second), [east_m, 0.0], [100.0, 0.0]));
    }
    // Brought to the present over so long a time, it would fit any target.
    assert!(harness.take(&report(1, 7, -1000.0, [5e3, 3e3], [0.0; 2])).is_none());
    assert_eq!(harness.count(Counter::RejectedClock), 1);
    assert_eq!(harness.engine.tracks.sensors.find(1, 7), None);
}
