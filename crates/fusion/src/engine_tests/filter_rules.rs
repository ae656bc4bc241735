//! What every rule promises, of those whose states come from the targets' filters: whatever a few sources state of one
//! target.

use estimation::{is_positive_definite, unpacked};

use super::*;

/// How one source sees: standard deviation, metres; correlation of east with north and of each position with its
/// velocity; phase of its reports, seconds; whether it measures height.
type Way = (f64, f64, f64, bool);

fn ways() -> impl Strategy<Value = Vec<Way>> {
    let way = (5.0..200.0f64, -0.7..0.7f64, 0.0..1.0f64, any::<bool>());
    prop::collection::vec(way, 1..6)
}

/// What is published of a target that is seen in these ways for so many seconds.
fn published(rule: messages::FusionRule, ways: &[Way], seed: u64) -> Vec<SystemTrack> {
    let mut settings = test_settings(ways.len());
    settings.rule.name.0 = rule;
    let (mut harness, mut noise) = (Harness::new(settings), random(seed));
    let mut reports = Vec::new();
    for step in 0..12 {
        for (source, &(sigma_m, correlation, phase_s, has_height)) in ways.iter().enumerate() {
            let place = [0, 1].map(|_| 2.0 * sigma_m * noise());
            let mut report = report(source as u16, 1, f64::from(step) + phase_s, place, [20.0, 0.0]);
            report.covariance = Covariance::diagonal([sigma_m; 3], [0.1 * sigma_m; 3]);
            report.covariance.set(0, 1, 0.5 * correlation * sigma_m * sigma_m);
            for axis in 0..2 {
                let both = 0.05 * correlation.abs() * sigma_m * sigma_m;
                report.covariance.set(axis, axis + 3, both);
            }
            report.valid |= if has_height { sensor_track_bits::HEIGHT } else { 0 };
            reports.push(with_address(report, 0x3c_0001));
        }
    }
    reports.sort_by_key(|report| report.time_of_measurement_ns);
    for report in &reports {
        harness.take(report);
    }
    assert!(
        harness.published.iter().all(|track| track.track_number == 1),
        "one target"
    );
    harness.published
}

proptest! {
    #[test]
    fn weights_sum_to_1_and_covariances_are_positive_definite(ways in ways(), seed in any::<u64>()) {
        for rule in [messages::FusionRule::Auto, messages::FusionRule::SystemFilter] {
            let published = published(rule, &ways, seed);
            prop_assert!(published.len() >= ways.len());
            for track in published {
                let weights = track.contributions().iter().map(|contribution| contribution.weight);
                prop_assert!(weights.clone().all(|weight| (0.0..=1.0).contains(&weight)), "{rule:?}");
                prop_assert!((weights.sum::<f64>() - 1.0).abs() < 1e-9, "{rule:?}");
                prop_assert!(is_positive_definite(&unpacked(&track.covariance)), "{rule:?}: {:?}", track.covariance);
                let numbers = track.position_m.iter().chain(&track.velocity_mps);
                prop_assert!(numbers.into_iter().all(|number| number.is_finite()), "{rule:?}");
            }
        }
    }

    #[test]
    fn a_single_source_has_all_the_weight_and_the_state_is_no_farther_from_it_than_it_may_err(
        ways in ways(),
        seed in any::<u64>(),
    ) {
        for rule in [messages::FusionRule::Auto, messages::FusionRule::SystemFilter] {
            for track in published(rule, &ways[..1], seed) {
                prop_assert_eq!(track.contributions()[0].weight, 1.0);
                let time_s = track.reference_time_ns as f64 / S as f64;
                let off_m = (track.position_m[0] - 20.0 * time_s).hypot(track.position_m[1]);
                prop_assert!(off_m < 3.0 * ways[0].0, "{rule:?}: {off_m}");
            }
        }
    }
}
