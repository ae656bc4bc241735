//! Sources that correct the position of a track while its velocity stays what it was.

use messages::FusionRule;

use super::*;
use crate::settings::RuleName;

/// Velocity of the target, m/s.
const VELOCITY_MPS: [f64; 2] = [200.0, 0.0];
/// Number of reports of each source, and that with which the first source's displacement begins.
const REPORTS: u32 = 30;
const DISPLACED_FROM: u32 = 10;

/// A source's statements and its displacement.
#[derive(Clone, Copy, Debug)]
struct Case {
    period_s: f64,
    sigma_m: f64,
    sigma_mps: f64,
    /// By how much the first source is off, northwards, for so many reports.
    displaced_m: f64,
    displaced_reports: u32,
    /// Rounding or smoothing changes the stated velocity a little from report to report, m/s.
    unsteady_mps: f64,
    sources: u16,
}

/// Publishes the picture of a case. Returns the largest distance of the published velocity from the stated one, m/s,
/// and that of the published position from the latest statement of any source, metres.
fn deviation(rule: FusionRule, case: &Case) -> [f64; 2] {
    let mut settings = test_settings(usize::from(case.sources));
    settings.rule.name = RuleName(rule);
    for source in &mut settings.sources {
        source.period_ns = (case.period_s * S as f64) as i64;
    }
    let mut harness = Harness::new(settings);
    let mut largest = [0.0_f64; 2];
    for number in 0..REPORTS {
        for source in 0..case.sources {
            let time_s = case.period_s * (f64::from(number) + f64::from(source) / f64::from(case.sources));
            let is_displaced = (DISPLACED_FROM..DISPLACED_FROM + case.displaced_reports).contains(&number);
            let aside_m = if source == 0 && is_displaced {
                case.displaced_m
            } else {
                0.0
            };
            let unsteady_mps = case.unsteady_mps * f64::from(number * 7 % 5) - 2.0 * case.unsteady_mps;
            let mut stated = report(source, 1, time_s, [0.0, aside_m], VELOCITY_MPS);
            stated.velocity_mps[1] += unsteady_mps;
            stated.covariance = Covariance::diagonal(
                [case.sigma_m, case.sigma_m, 50.0],
                [case.sigma_mps, case.sigma_mps, 5.0],
            );
            // The first sensor track that is displaced may become a system track of its own.
            let Some(track) = harness.take(&stated) else { continue };
            let off_mps = [0, 1].map(|axis| track.velocity_mps[axis] - stated.velocity_mps[axis]);
            largest[0] = largest[0].max(off_mps[0].hypot(off_mps[1]));
            let [north_m, along_m] = [track.position_m[1], track.position_m[0] - stated.position_m[0]];
            let off_m = north_m.abs().min((north_m - case.displaced_m).abs()).hypot(along_m);
            largest[1] = largest[1].max(off_m);
        }
    }
    largest
}

const CENTRE: Case = Case {
    period_s: 5.0,
    sigma_m: 150.0,
    sigma_mps: 5.0,
    displaced_m: 2000.0,
    displaced_reports: REPORTS,
    unsteady_mps: 0.0,
    sources: 1,
};

#[test]
fn the_velocity_of_an_only_source_survives_its_corrections_of_position() {
    for rule in [FusionRule::Auto, FusionRule::SystemFilter] {
        for displaced_m in [200.0, 500.0, 1000.0, 2000.0, 5000.0] {
            for displaced_reports in [1, 3, REPORTS] {
                for (period_s, sigma_m, sigma_mps) in [
                    (1.0, 150.0, 5.0),
                    (5.0, 5.0, 1.0),
                    (5.0, 150.0, 5.0),
                    (5.0, 300.0, 10.0),
                    (12.0, 60.0, 10.0),
                ] {
                    let case = Case {
                        period_s,
                        sigma_m,
                        sigma_mps,
                        displaced_m,
                        displaced_reports,
                        unsteady_mps: 0.5 * sigma_mps,
                        ..CENTRE
                    };
                    let [off_mps, _] = deviation(rule, &case);
                    assert!(off_mps < 50.0, "{off_mps} m/s: {rule:?}, {case:?}");
                }
            }
        }
    }
}

#[test]
fn the_picture_of_an_only_source_follows_its_correction_at_once() {
    for displaced_reports in [3, REPORTS] {
        let case = Case {
            displaced_reports,
            ..CENTRE
        };
        let [off_mps, off_m] = deviation(FusionRule::Auto, &case);
        assert!(off_mps < 20.0 && off_m < 100.0, "{off_mps} m/s, {off_m} m");
    }
}

#[test]
fn a_displaced_source_does_not_deflect_what_another_one_shows() {
    for displaced_m in [1500.0, 2000.0, 5000.0] {
        for displaced_reports in [1, 3, REPORTS] {
            let case = Case {
                displaced_m,
                displaced_reports,
                sources: 2,
                ..CENTRE
            };
            let [off_mps, _] = deviation(FusionRule::Auto, &case);
            assert!(off_mps < 3.0 * case.sigma_mps, "{off_mps} m/s: {case:?}");
        }
    }
}
