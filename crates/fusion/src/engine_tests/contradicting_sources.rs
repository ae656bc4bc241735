//! Sources that are wrong within all limits: they move no track of those that agree with each other.

use messages::{Covariance, FusionRule, SystemTrack, TrackState};

use super::{S, random, report, with_address};
use crate::testing::test_settings;
use crate::{Engine, Settings};

const TARGETS: u32 = 30;
const SIGMA_M: f64 = 30.0;
const SPEED_MPS: f64 = 100.0;
const NOW_NS: i64 = 1_700_000_000 * S;

/// What is wrong with a source.
#[derive(Clone, Copy, Debug, Default)]
struct Wrong {
    /// Offset east of all that it reports, metres.
    aside_m: f64,
    /// Offset of its clock, seconds.
    clock_s: f64,
    /// Accuracy that it claims, metres.
    claim_m: f64,
    /// When it begins to report, seconds.
    from_s: f64,
}

const SOUND: Wrong = Wrong {
    aside_m: 0.0,
    clock_s: 0.0,
    claim_m: SIGMA_M,
    from_s: 0.0,
};

/// Root mean square error in the plane, metres, of the tracks of all targets from `since_s` on, where these sources
/// report each target once a second.
fn rms_m(rule: FusionRule, sources: &[Wrong], since_s: f64) -> f64 {
    let mut settings = test_settings(sources.len());
    settings.rule.name.0 = rule;
    let (_, published) = run(settings, sources);
    let (mut sum, mut count) = (0.0, 0.0);
    for track in published {
        let seconds = (track.reference_time_ns - NOW_NS) as f64 / S as f64;
        let Some(address) = track.identity.address() else {
            continue;
        };
        if seconds >= since_s && track.state == TrackState::Confirmed as u8 {
            let [east, north] = place(address - 0x40_0000);
            let [x, y, _] = track.position_m;
            sum += (x - east - SPEED_MPS * seconds).powi(2) + (y - north).powi(2);
            count += 1.0;
        }
    }
    assert!(count > 300.0, "{count}");
    f64::sqrt(sum / count)
}

/// Where a target is at first.
fn place(target: u32) -> [f64; 2] {
    [0.0, 6e3 * f64::from(target)]
}

/// The engine, and the tracks that it has published, after 40 s.
fn run(settings: Settings, sources: &[Wrong]) -> (Engine, Vec<SystemTrack>) {
    let (mut engine, mut noise) = (Engine::new(settings).unwrap(), random(7));
    for (number, source) in sources.iter().enumerate() {
        engine.set_source_clock(number as u16, Some(source.clock_s));
    }
    let mut published: Vec<SystemTrack> = Vec::new();
    for step in 0..40 * TARGETS {
        let (target, seconds) = (step % TARGETS, f64::from(step) / f64::from(TARGETS));
        let now_ns = NOW_NS + (seconds * S as f64) as i64;
        for (number, source) in (0..).zip(sources).filter(|(_, source)| seconds >= source.from_s) {
            let [east, north] = place(target);
            let at = [
                east + source.aside_m + 3.46 * SIGMA_M * noise(),
                north + 3.46 * SIGMA_M * noise(),
            ];
            let mut report = with_address(
                report(number, target, seconds, at, [SPEED_MPS, 0.0]),
                0x40_0000 + target,
            );
            report.time_of_measurement_ns = now_ns + (source.clock_s * S as f64) as i64;
            report.covariance = Covariance::diagonal([source.claim_m, source.claim_m, 100.0], [3.0; 3]);
            engine.take_at(&report, now_ns, &mut |track: &SystemTrack| published.push(*track));
        }
    }
    (engine, published)
}

#[test]
fn one_that_contradicts_two_and_claims_to_be_exact_moves_no_track() {
    for rule in [FusionRule::Auto, FusionRule::InverseTrace] {
        let honest = rms_m(rule, &[SOUND, SOUND], 2.0);
        for aside_m in [300.0, -3000.0] {
            for from_s in [0.0, 10.0] {
                let liar = Wrong {
                    aside_m,
                    claim_m: 1.0,
                    from_s,
                    ..SOUND
                };
                // The liar reports each target first, last, and between the others.
                for place in 0..3 {
                    let mut sources = vec![SOUND, SOUND];
                    sources.insert(place, liar);
                    let beside = rms_m(rule, &sources, from_s + 2.0);
                    assert!(
                        beside <= 1.5 * honest,
                        "{rule:?}, {aside_m} m from {from_s} s on, place {place}: {beside:.1} m, {honest:.1} m without"
                    );
                }
            }
        }
    }
}

#[test]
fn of_two_the_one_whose_clock_is_off_is_the_wrong_one() {
    let alone = rms_m(FusionRule::Auto, &[SOUND], 10.0);
    for clock_s in [2.0, 4.5, -4.5] {
        for from_s in [0.0, 8.0] {
            let late = Wrong {
                clock_s,
                from_s,
                ..SOUND
            };
            for sources in [[SOUND, late], [late, SOUND]] {
                let beside = rms_m(FusionRule::Auto, &sources, from_s + 10.0);
                assert!(
                    beside <= 1.5 * alone,
                    "{clock_s} s from {from_s} s on: {beside:.1} m, {alone:.1} m alone"
                );
            }
        }
    }
}

#[test]
fn a_source_that_agrees_again_is_used_again() {
    // Its error is found by comparison, and taken off: then it contributes as the others do.
    let two = rms_m(FusionRule::Auto, &[SOUND, SOUND], 25.0);
    let three = rms_m(FusionRule::Auto, &[SOUND, SOUND, SOUND], 25.0);
    let off = Wrong {
        aside_m: 400.0,
        ..SOUND
    };
    let beside = rms_m(FusionRule::Auto, &[SOUND, SOUND, off], 25.0);
    assert!(
        beside <= 1.2 * three && beside < two,
        "{beside:.1} m, {three:.1} m of three sound ones, {two:.1} m of two"
    );
}

#[test]
fn a_source_that_is_not_registered_is_compared_with_no_other() {
    // Samples of the biases of both sources, and whether the spread of their detection points is known.
    let learned = |left_out: Option<usize>| {
        let mut settings = test_settings(2);
        settings.registration.enabled = true;
        for (number, source) in settings.sources.iter_mut().enumerate() {
            source.is_registered = left_out != Some(number);
        }
        let unknown = Engine::new(settings.clone()).unwrap();
        let (engine, _) = run(settings, &[SOUND, SOUND]);
        let spread_m2 = |engine: &Engine, source| {
            let association = &engine.settings().association;
            engine.sources().spread_m2(association, Some(source))
        };
        [0, 1].map(|source: u16| {
            let samples = engine.sources().source_errors(source).unwrap().samples;
            (samples, spread_m2(&engine, source) < spread_m2(&unknown, source))
        })
    };
    assert!(learned(None).iter().all(|(samples, points)| *samples > 20.0 && *points));
    for left_out in 0..2 {
        let learned = learned(Some(left_out));
        assert_eq!(learned.map(|(samples, _)| samples), [0.0; 2]);
        assert!(learned.iter().all(|(_, knows_points)| !knows_points), "{left_out}");
    }
}
