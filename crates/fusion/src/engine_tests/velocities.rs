//! Velocities by each rule: of targets on straight paths that the trackers of some sources follow.

use estimation::{FirstVelocity, Gaussian, NearlyConstantVelocity};
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

/// Root of the mean square of the errors of velocity, m/s: of the sources' own tracks, and of the picture.
fn errors_mps(rule: messages::FusionRule, sources: u16) -> [f64; 2] {
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
    let (mut squares, mut count) = ([0.0; 2], 0.0);
    for number in 0..REPORTS {
        for source in 0..sources {
            let time_s = PERIOD_S * (f64::from(number) + f64::from(source) / f64::from(sources));
            for target in 0..TARGETS {
                let at = |axis: usize| 20e3 * f64::from(target) * [1.0, 0.3][axis] + VELOCITY_MPS[axis] * time_s;
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
                for (sum, velocity_mps) in squares.iter_mut().zip([stated.velocity_mps, track.velocity_mps]) {
                    *sum += (velocity_mps[0] - VELOCITY_MPS[0]).powi(2) + (velocity_mps[1] - VELOCITY_MPS[1]).powi(2);
                }
            }
        }
    }
    squares.map(|sum| f64::sqrt(sum / count))
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
