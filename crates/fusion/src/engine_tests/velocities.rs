//! Velocities by each rule, of targets that the trackers of some sources follow: on straight paths, and weaving ones.

use estimation::{FirstVelocity, Gaussian, NearlyConstantVelocity};
use messages::{AXES, FusionRule};
use test_support::Random;

use super::*;
use crate::rules::REGISTRY;

/// Standard deviation of a measured position per axis, metres; period of a source, seconds; number of its reports; of
/// them those that the figures leave out; and targets.
const SIGMA_M: f64 = 50.0;
const PERIOD_S: f64 = 4.0;
const REPORTS: u32 = 40;
const FIRST_REPORTS: u32 = 8;
const TARGETS: u32 = 12;
const VELOCITY_MPS: [f64; 2] = [150.0, -60.0];
/// Angular rate of a weaving target, radians a second.
const WEAVE_RADPS: f64 = 0.15;

/// Root of the mean square of the errors of velocity, m/s: of the sources' own tracks, and of the picture.
fn errors_mps(rule: FusionRule, sources: u16) -> [f64; 2] {
    errors(rule, sources, 0.0)[1]
}

/// Roots of the mean squares of the errors of position and of velocity: of the sources' own tracks, and of the
/// picture. Targets weave to the north and south with this acceleration.
fn errors(rule: FusionRule, sources: u16, weave_mps2: f64) -> [[f64; 2]; 2] {
    let mut settings = test_settings(usize::from(sources));
    settings.rule.name.0 = rule;
    for source in &mut settings.sources {
        source.period_ns = (PERIOD_S * S as f64) as i64;
    }
    let mut harness = Harness::new(settings);
    let mut random = Random::new(11);
    let mut normal = || (0..12).map(|_| random.unit()).sum::<f64>() - 6.0;
    let motion = NearlyConstantVelocity::new(20.0, 2.0);
    let variance_m2 = [SIGMA_M * SIGMA_M, 0.0, 0.0, SIGMA_M * SIGMA_M, 0.0, SIGMA_M * SIGMA_M];
    let first = FirstVelocity {
        horizontal_sigma_mps: 150.0,
        vertical_sigma_mps: 15.0,
    };
    let mut trackers = vec![None::<Gaussian>; usize::from(sources) * TARGETS as usize];
    let (mut squares, mut count) = ([[0.0; 2]; 2], 0.0);
    for number in 0..REPORTS {
        for source in 0..sources {
            let time_s = PERIOD_S * (f64::from(number) + f64::from(source) / f64::from(sources));
            for target in 0..TARGETS {
                let (sine, cosine) = (WEAVE_RADPS * time_s + f64::from(target)).sin_cos();
                let velocity_mps = [VELOCITY_MPS[0], VELOCITY_MPS[1] + weave_mps2 / WEAVE_RADPS * cosine];
                let weave_m = [0.0, weave_mps2 / (WEAVE_RADPS * WEAVE_RADPS) * sine];
                let at = |axis: usize| {
                    20e3 * f64::from(target) * [1.0, 0.3][axis] + VELOCITY_MPS[axis] * time_s + weave_m[axis]
                };
                let measured_m = [
                    at(0) + SIGMA_M * normal(),
                    at(1) + SIGMA_M * normal(),
                    SIGMA_M * normal(),
                ];
                let tracker = &mut trackers[usize::from(source) * TARGETS as usize + target as usize];
                let state = match tracker {
                    Some(before) => {
                        let mut state = motion.predicted(before, PERIOD_S);
                        state.update_position::<3>(measured_m, &variance_m2).unwrap();
                        state
                    }
                    None => Gaussian::from_first_position::<3>(measured_m, &variance_m2, first),
                };
                *tracker = Some(state);
                let stated = SensorTrack {
                    valid: sensor_track_bits::VELOCITY | sensor_track_bits::HEIGHT,
                    position_m: state.position_m(),
                    velocity_mps: state.velocity_mps(),
                    covariance: state.covariance,
                    ..report(source, target + 1, time_s, [0.0; 2], [0.0; 2])
                };
                let Some(track) = harness.take(&stated) else { continue };
                if number < FIRST_REPORTS {
                    continue;
                }
                count += 1.0;
                let off = |of: [f64; AXES], truth: [f64; 2]| (of[0] - truth[0]).powi(2) + (of[1] - truth[1]).powi(2);
                for (place, of) in [stated.position_m, track.position_m].into_iter().enumerate() {
                    squares[0][place] += off(of, [at(0), at(1)]);
                }
                for (place, of) in [stated.velocity_mps, track.velocity_mps].into_iter().enumerate() {
                    squares[1][place] += off(of, velocity_mps);
                }
            }
        }
    }
    squares.map(|sums| sums.map(|sum| f64::sqrt(sum / count)))
}

/// A tracker lags behind such a motion, and the filter contradicts it again and again.
#[test]
fn the_picture_of_an_only_source_lags_behind_weaving_targets_little_more_than_the_source() {
    for weave_mps2 in [10.0, 20.0, 30.0] {
        let [[own_m, fused_m], [own_mps, fused_mps]] = errors(FusionRule::Auto, 1, weave_mps2);
        let figures = format!("{weave_mps2} m/s²: {fused_m} m, {own_m} m; {fused_mps} m/s, {own_mps} m/s");
        assert!(fused_m < 1.3 * own_m && fused_mps < 1.2 * own_mps, "{figures}");
    }
}

/// A tracker with several models of motion changes its covariance as no single one does.
#[test]
fn the_picture_of_an_only_source_whose_filter_cannot_be_undone_is_what_the_source_states() {
    let mut settings = test_settings(1);
    settings.rule.name.0 = FusionRule::Auto;
    let mut harness = Harness::new(settings);
    for number in 0..80 {
        let unsteady = 1.0 + f64::from(number * 7 % 5);
        let mut stated = report(
            0,
            1,
            f64::from(number),
            [150.0 * f64::from(number) + 9.0 * unsteady, 0.0],
            [150.0, 0.0],
        );
        stated.covariance = Covariance::diagonal([30.0 * unsteady.sqrt(), 30.0, 30.0], [10.0; AXES]);
        stated.covariance.set(0, AXES, 200.0 * unsteady.sqrt());
        stated.covariance.set(1, AXES + 1, 200.0);
        let track = harness.take(&stated);
        if number > 40 {
            let track = track.unwrap();
            assert_eq!(track.position_m[..2], stated.position_m[..2], "{number}");
            assert_eq!(track.velocity_mps[..2], stated.velocity_mps[..2], "{number}");
        }
    }
}

#[test]
fn no_rule_states_a_velocity_worse_than_that_of_an_only_source() {
    for rule in REGISTRY {
        let [own_mps, fused_mps] = errors_mps(rule.code, 1);
        assert!(fused_mps < 1.01 * own_mps, "{:?}: {fused_mps}, {own_mps}", rule.code);
    }
}

#[test]
fn no_rule_states_a_velocity_much_worse_than_those_of_three_sources() {
    for rule in REGISTRY {
        let [own_mps, fused_mps] = errors_mps(rule.code, 3);
        // A rule that chooses a source is no better than the sources, and `best-source` may choose one that is worse
        // just then.
        let most = if rule.is_from_filter() { 0.7 } else { 1.25 };
        assert!(fused_mps < most * own_mps, "{:?}: {fused_mps}, {own_mps}", rule.code);
    }
}
