//! One target that several system tracks have come to follow.

use messages::FusionRule;

use super::*;
use crate::settings::RuleName;

#[test]
fn three_system_tracks_of_one_target_become_one() {
    let mut settings = test_settings(6);
    settings.rule.name = RuleName(FusionRule::Auto);
    let mut harness = Harness::new(settings);
    let mut most = 0;
    for step in 0..120 {
        let time_s = f64::from(step);
        for source in 0..6u16 {
            let time_s = time_s + 0.01 * f64::from(source);
            // Each pair of sources follows a way of its own, until all ways meet. The ways come from three sides: each
            // track is as far from one of the others as from the other.
            let (sin, cos) = (f64::from(source / 2) * std::f64::consts::TAU / 3.0).sin_cos();
            let left_s = (60.0 - time_s).max(0.0);
            let closing_mps = if left_s > 0.0 { 50.0 } else { 0.0 };
            let velocity_mps = [-closing_mps * cos, 100.0 - closing_mps * sin];
            let mut seen = report(source, 0, time_s, [0.0; 2], velocity_mps);
            seen.position_m = [50.0 * left_s * cos, 100.0 * time_s + 50.0 * left_s * sin, 0.0];
            harness.take(&seen);
        }
        most = most.max(harness.live());
    }
    assert_eq!((most, harness.live()), (3, 1));
}
