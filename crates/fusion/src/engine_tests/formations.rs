//! Targets that fly side by side.

use messages::FusionRule;
use test_support::Random;

use super::*;
use crate::settings::RuleName;

/// Distance of the two targets, metres.
const APART_M: f64 = 250.0;
/// Standard deviations of the sources' positions, east and north, metres: the last one, far off, is poor across its
/// line of sight.
const SIGMA_M: [[f64; 2]; 3] = [[50.0, 50.0], [50.0, 50.0], [80.0, 400.0]];

/// Of each source, which of its two tracks contributes to the system track that the first source's first track is in,
/// after a minute in which the last source has taken the one target for the other until `crossed_s`.
fn together(seed: u64, crossed_s: f64) -> Vec<u32> {
    let mut settings = test_settings(SIGMA_M.len());
    settings.rule.name = RuleName(FusionRule::Auto);
    let mut harness = Harness::new(settings);
    let mut random = Random::new(seed);
    let mut normal = || (0..12).map(|_| random.unit()).sum::<f64>() - 6.0;
    for step in 0..60 {
        for (source, sigma_m) in SIGMA_M.into_iter().enumerate() {
            let time_s = f64::from(step) + 0.3 * source as f64;
            for target in 0..2_u32 {
                let is_crossed = source == 2 && time_s < crossed_s;
                let east_m = APART_M * f64::from(if is_crossed { 1 - target } else { target });
                let place = [east_m + sigma_m[0] * normal(), sigma_m[1] * normal()];
                let report = SensorTrack {
                    covariance: Covariance::diagonal([sigma_m[0], sigma_m[1], 100.0], [20.0; 3]),
                    ..report(source as u16, target, time_s, place, [0.0, 150.0])
                };
                harness.take(&report);
            }
        }
    }
    let of_first = |track: &&SystemTrack| {
        let first = track.contributions().iter().find(|part| part.source == 0);
        first.is_some_and(|part| part.track_number == 0)
    };
    let last = harness.published.iter().rev().find(of_first).unwrap();
    last.contributions().iter().map(|part| part.track_number).collect()
}

#[test]
fn a_source_that_took_one_for_the_other_at_first_is_put_right() {
    for seed in 0..20 {
        assert_eq!(together(seed, 4.0), [0; 3], "seed {seed}");
    }
}

#[test]
fn one_that_was_right_stays_where_it_is() {
    for seed in 0..20 {
        assert_eq!(together(seed, 0.0), [0; 3], "seed {seed}");
    }
}
