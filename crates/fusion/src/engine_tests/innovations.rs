//! Normalised innovations squared, as they are published.

use super::*;

/// Width of uniform noise whose standard deviation is that of the reports' covariance, 10 m.
const WIDTH_M: f64 = 34.641;

/// Normalised innovations squared of a target that two sources follow with noise of `width_m`, from 20 s to 220 s.
fn published(width_m: f64) -> Vec<f64> {
    let mut noise = random(11);
    let mut settings = test_settings(2);
    settings.rule.name.0 = messages::FusionRule::Auto;
    let mut harness = Harness::new(settings);
    let mut found = Vec::new();
    for step in 0..220 {
        for source in [0, 1] {
            let time_s = f64::from(step) + 0.5 * f64::from(source);
            let place = [width_m * noise(), width_m * noise()];
            let track = harness.take(&report(source, 1, time_s, place, [80.0, 30.0]));
            found.extend(track.filter(|_| step >= 20).map(|track| f64::from(track.nis)));
        }
    }
    found
}

#[test]
fn innovations_of_honest_covariances_are_as_large_as_they_should_be() {
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let honest = published(WIDTH_M);
    assert_eq!(honest.len(), 400, "each report has one");
    assert!((1.2..2.8).contains(&mean(&honest)), "{}", mean(&honest));
    let quiet = published(0.2 * WIDTH_M);
    assert!(mean(&quiet) < 0.3, "{}", mean(&quiet));
}

#[test]
fn a_blunder_shows_and_what_was_not_compared_has_none() {
    let mut settings = test_settings(1);
    settings.rule.name.0 = messages::FusionRule::Auto;
    let mut harness = Harness::new(settings);
    let first = harness.take(&report(0, 1, 0.0, [0.0, 0.0], [80.0, 30.0]));
    assert_eq!(
        first.map(|track| track.nis),
        Some(0.0),
        "there was nothing to compare it with"
    );
    for step in 1..30 {
        harness.take(&report(0, 1, f64::from(step), [0.0, 0.0], [80.0, 30.0]));
    }
    let blunder = harness.take(&report(0, 1, 30.0, [45.0, 0.0], [80.0, 30.0]));
    assert!(blunder.is_some_and(|track| track.nis > 9.21), "beyond 99 %");
    harness
        .engine
        .advance(60 * S, &mut |track: &SystemTrack| assert_eq!(track.nis, 0.0));
}
