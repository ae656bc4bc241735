//! What cannot be is refused or repaired, and counted; nobody else notices.

use messages::{Counter, Covariance, SensorTrack, SystemTrack, TrackState, sensor_track_bits};
use proptest::prelude::*;
use test_support::S;

use super::{Harness, random, report, with_address};
use crate::testing::test_settings;

#[test]
fn bad_reports_are_counted_and_change_nothing() {
    let mut settings = test_settings(1);
    (settings.sources[0].limits.range_m, settings.sources[0].limits.speed_mps) = (4e5, 700.0);
    let mut harness = Harness::new(settings);
    harness.take(&report(0, 1, 1.0, [0.0, 0.0], [0.0, 0.0]));
    let good = report(0, 1, 2.0, [0.0, 0.0], [0.0, 0.0]);
    let mut bad = [good; 10];
    bad[0].position_m[1] = f64::NAN;
    bad[1].covariance.set(0, 0, -1.0);
    bad[2].state = 9;
    bad[3].source = 5;
    bad[4].position_m[0] = 1e12;
    bad[5].covariance.set(1, 1, 1e300);
    bad[6].velocity_mps[0] = 701.0;
    bad[7].position_m[1] = -4.1e5;
    bad[8].time_of_measurement_ns = i64::MAX;
    bad[9].time_of_measurement_ns = i64::MIN;
    for report in &bad {
        assert_eq!(harness.take(report), None);
    }
    assert_eq!(harness.count(Counter::RejectedInvalid), 8);
    assert_eq!(harness.count(Counter::RejectedTooFast), 1);
    assert_eq!(harness.count(Counter::RejectedTooFar), 1);
    assert_eq!(harness.take(&report(0, 1, 0.5, [0.0, 0.0], [0.0, 0.0])), None);
    assert_eq!(harness.count(Counter::RejectedOutOfOrder), 1);
}

/// What is published of the tracks that start in the west, while `disturb` does its worst in the east.
fn picture_of_the_west(disturb: impl Fn(&mut Harness, u32)) -> (String, Harness) {
    let mut settings = test_settings(2);
    settings.rule.name.0 = messages::FusionRule::Auto;
    let mut harness = Harness::new(settings);
    for step in 0..40 {
        let time_s = 0.5 * f64::from(step);
        for source in 0..2 {
            let noise = 3.0 * f64::from((step * 7 + u32::from(source) * 3) % 5) - 6.0;
            let place = [-2e4 + noise, 0.0];
            harness.take(&report(
                source,
                1,
                time_s + 0.1 * f64::from(source),
                place,
                [50.0, 10.0],
            ));
        }
        disturb(&mut harness, step);
    }
    let west = |track: &&SystemTrack| track.position_m[0] < 0.0;
    let picture = harness
        .published
        .iter()
        .filter(west)
        .map(|track| format!("{:?} {:?} {:?}", track.position_m, track.velocity_mps, track.covariance))
        .collect();
    (picture, harness)
}

#[test]
fn bad_input_does_not_change_other_targets_by_one_bit() {
    let east = |step: u32, offset_s: f64| report(0, 9, 0.5 * f64::from(step) + 0.3 + offset_s, [2e4, 0.0], [0.0, 0.0]);
    let (calm, _) = picture_of_the_west(|harness, step| {
        harness.take(&east(step, 0.0));
    });
    assert!(!calm.is_empty());
    type Disturbance<'a> = (&'a str, Counter, Box<dyn Fn(&mut Harness, u32) + 'a>);
    let disturbances: [Disturbance<'_>; 5] = [
        (
            "not a number",
            Counter::RejectedInvalid,
            Box::new(|harness, step| {
                harness.take(&east(step, 0.0));
                let mut bad = east(step, 0.05);
                bad.position_m[1] = f64::NAN;
                harness.take(&bad);
            }),
        ),
        (
            "time backwards",
            Counter::RejectedOutOfOrder,
            Box::new(|harness, step| {
                harness.take(&east(step, 0.0));
                harness.take(&east(step, -0.2));
            }),
        ),
        (
            "repeated",
            Counter::RejectedOutOfOrder,
            Box::new(|harness, step| {
                harness.take(&east(step, 0.0));
                harness.take(&east(step, 0.0));
            }),
        ),
        (
            "not positive definite",
            Counter::CovariancesRepaired,
            Box::new(|harness, step| {
                let mut bad = east(step, 0.0);
                bad.covariance.set(0, 1, 500.0);
                harness.take(&bad);
            }),
        ),
        (
            "another target's address",
            Counter::IdentityConflicts,
            Box::new(|harness, step| {
                harness.take(&with_address(east(step, 0.0), 0x123));
                harness.take(&with_address(
                    report(0, 8, 0.5 * f64::from(step) + 0.3, [4e4, 0.0], [0.0, 0.0]),
                    0x123,
                ));
            }),
        ),
    ];
    for (what, counter, disturb) in disturbances {
        let (picture, harness) = picture_of_the_west(disturb);
        assert_eq!(picture, calm, "{what}");
        assert!(harness.count(counter) > 0, "{what} is counted");
    }
}

#[test]
fn ten_times_more_tracks_than_there_is_room_for_are_counted_and_the_others_stay() {
    let (calm, _) = picture_of_the_west(|_, _| {});
    let (full, harness) = picture_of_the_west(|harness, step| {
        for number in 0..50 {
            let number = 100 + 50 * step + number;
            harness.take(&report(
                0,
                number,
                0.5 * f64::from(step) + 0.3,
                [1e4 + 1e3 * f64::from(number), 0.0],
                [0.0, 0.0],
            ));
        }
    });
    assert!(harness.count(Counter::DroppedTable) > 0);
    assert_eq!(full, calm);
}

#[test]
fn a_covariance_that_knows_too_much_is_repaired() {
    let mut harness = Harness::new(test_settings(1));
    let mut report = report(0, 1, 1.0, [0.0; 2], [0.0; 2]);
    report.covariance = Covariance::diagonal([1e-100, 10.0, 0.0], [2.0, 2.0, 1e-9]);
    let track = harness.take(&report).unwrap();
    assert_eq!(harness.count(Counter::CovariancesRepaired), 1);
    assert!(track.covariance.get(0, 0) >= 1e-6, "{:?}", track.covariance);
}

/// A source that makes up new tracks all the time, 10,000 of them in all, in tables for a hundred system tracks.
fn flood(harness: &mut Harness, step: u32) {
    for number in 0..50 {
        let number = 100 + 50 * step + number;
        let place = [1e5 + 3e3 * f64::from(number), 0.0];
        harness.take(&report(1, number, 0.1 * f64::from(step) + 0.05, place, [0.0; 2]));
    }
}

fn small_tables() -> Harness {
    let mut settings = test_settings(2);
    settings.capacity.system_tracks = Some(100);
    settings.capacity.sensor_tracks = Some(200);
    settings.registration.enabled = false;
    Harness::new(settings)
}

/// Twenty seconds of fifty targets of source 0, each reported once a second, from step `from` of two hundred on; before
/// each tenth of a second, `before` does what it likes.
fn fifty_targets(harness: &mut Harness, from: u32, before: impl Fn(&mut Harness, u32)) -> Vec<String> {
    for step in 0..200 {
        before(harness, step);
        for target in (step % 10 * 5..step % 10 * 5 + 5).filter(|_| step >= from) {
            let place = [2e3 * f64::from(target), 0.0];
            harness.take(&report(0, target, 0.1 * f64::from(step), place, [0.0; 2]));
        }
    }
    let honest = harness.published.iter().filter(|track| track.trigger_source == 0);
    honest
        .map(|track| format!("{:?} {:?}", track.position_m, track.covariance))
        .collect()
}

#[test]
fn a_flood_of_new_tracks_leaves_those_of_another_source_untouched() {
    let calm = fifty_targets(&mut small_tables(), 0, |_, _| {});
    assert_eq!(calm.len(), 1000);
    let mut harness = small_tables();
    let flooded = fifty_targets(&mut harness, 0, |harness, step| {
        if step >= 20 {
            flood(harness, step);
        }
    });
    assert_eq!(flooded, calm);
    let dropped = |source| harness.engine.counts().source(source).unwrap()[Counter::DroppedTable];
    assert_eq!(dropped(0), 0);
    assert!(dropped(1) > 0);
}

#[test]
fn who_comes_into_flooded_tables_gets_its_share_as_the_flood_ends() {
    let mut harness = small_tables();
    fifty_targets(&mut harness, 100, flood);
    let honest = |from_s: i64| {
        let tracks = harness.published.iter();
        let late = tracks.filter(|track| track.trigger_source == 0 && track.reference_time_ns >= from_s * S);
        late.map(|track| track.track_number)
            .collect::<std::collections::BTreeSet<_>>()
    };
    assert_eq!(honest(19).len(), 50, "of {:?}", honest(10).len());
}

const HONEST_TARGETS: u32 = 50;

/// Where an honest target is, east and north, and its velocity: metres and metres per second.
fn course(target: u32) -> ([f64; 2], [f64; 2]) {
    let mut random = random(u64::from(target));
    let mut next = |scale: f64| scale * random();
    ([next(8e4), next(8e4)], [next(100.0), next(100.0)])
}

/// Half a minute of two sources on the same targets with the same addresses, five milliseconds and ten between reports.
/// The second one says strange things, as `strange` makes them, for two and a half seconds.
fn two_sources(mut strange: impl FnMut(&mut SensorTrack)) -> Vec<SensorTrack> {
    let of = |source: u16, target: u32, ms: u32| {
        let (place, velocity) = course(target);
        let mut report = with_address(
            report(source, target, f64::from(ms) / 1e3, place, velocity),
            0x30_0000 + target,
        );
        report.position_m[2] = 5000.0;
        report.valid |= sensor_track_bits::HEIGHT;
        report.covariance = Covariance::diagonal([400.0; 3], [4.0; 3]);
        report
    };
    let mut reports = Vec::new();
    for ms in (0..30_000).step_by(5) {
        reports.push(of(0, ms / 5 % HONEST_TARGETS, ms));
        if ms % 10 == 0 && ms > 3000 {
            let mut second = of(1, ms / 10 % HONEST_TARGETS, ms);
            second.time_of_measurement_ns += S / 500;
            if ms < 5500 {
                strange(&mut second);
            }
            reports.push(second);
        }
    }
    reports
}

/// Takes reports in the order of their times; nothing that is not finite comes out, and in the end every honest target
/// is where it is, followed by one track.
fn honest_targets_are_there(rule: messages::FusionRule, reports: &[SensorTrack]) -> Result<(), TestCaseError> {
    let mut settings = test_settings(2);
    settings.rule.name.0 = rule;
    settings.capacity.system_tracks = Some(500);
    settings.capacity.sensor_tracks = Some(500);
    let mut harness = Harness::new(settings);
    for report in reports {
        harness.take(report);
    }
    for track in &harness.published {
        let state = track
            .position_m
            .iter()
            .chain(&track.velocity_mps)
            .chain(&track.covariance.upper);
        prop_assert!(state.copied().all(f64::is_finite), "{:?}", track);
    }
    for target in 0..HONEST_TARGETS {
        let ([x, y], [vx, vy]) = course(target);
        let mut latest = harness.published.iter().rev();
        let address = Some(0x30_0000 + target);
        let track = latest.find(|track| track.identity.address() == address).unwrap();
        let seconds = track.reference_time_ns as f64 / S as f64;
        let off_m = (track.position_m[0] - x - vx * seconds).hypot(track.position_m[1] - y - vy * seconds);
        prop_assert!(
            off_m < 1000.0 && track.state == TrackState::Confirmed as u8,
            "{}: {} m",
            target,
            off_m
        );
        prop_assert!(seconds > 29.0, "{}: {} s", target, seconds);
    }
    Ok(())
}

/// Reports of two sources, of which the second states such speeds, and places 100 km away.
fn with_strange_speeds(seed: u64, speed_mps: f64) -> Vec<SensorTrack> {
    let mut random = random(seed);
    let mut chance = || 0.5 + random();
    two_sources(|report| {
        let (axis, value) = ((3.0 * chance()) as usize, if chance() < 0.5 { 99_999.0 } else { 0.0 });
        report.position_m[axis.min(2)] = value;
        let (axis, value) = ((3.0 * chance()) as usize, if chance() < 0.5 { speed_mps } else { 0.0 });
        report.velocity_mps[axis.min(2)] = value;
    })
}

/// The estimate follows a lie by 40 km; then both sources agree with each other, and not with the estimate.
#[test]
fn an_estimate_that_a_lie_took_along_is_restarted() {
    let reports = with_strange_speeds(1_152_326_923_783_210_848, 300.0);
    honest_targets_are_there(messages::FusionRule::Auto, &reports).unwrap();
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// Finite, and absurd: speeds and places that nothing has, beside an honest source.
    #[test]
    fn strange_speeds_and_places_make_nothing_that_is_not_finite(
        seed in any::<u64>(),
        rule in prop::sample::select(vec!["auto", "information", "best-source"]),
        speed_mps in prop::sample::select(vec![300.0, 3e3, 1e4, 3e4, 99_999.0]),
    ) {
        let reports = with_strange_speeds(seed, speed_mps);
        honest_targets_are_there(messages::FusionRule::from_word(rule).unwrap(), &reports)?;
    }

    /// The same of covariances: anything that is a number.
    #[test]
    fn strange_covariances_make_nothing_that_is_not_finite(
        seed in any::<u64>(),
        rule in prop::sample::select(vec!["auto", "information", "best-source"]),
    ) {
        let mut random = random(seed);
        let mut chance = || 0.5 + random();
        let reports = two_sources(|report| {
            for value in &mut report.covariance.upper {
                if chance() < 0.3 {
                    *value = (chance() - 0.3) * 10f64.powf(28.0 * chance() - 14.0);
                }
            }
        });
        honest_targets_are_there(messages::FusionRule::from_word(rule).unwrap(), &reports)?;
    }
}
