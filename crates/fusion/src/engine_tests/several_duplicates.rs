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
    for step in 0..80 {
        let time_s = f64::from(step);
        for source in 0..6u16 {
            // Each pair of sources follows a place of its own, until all come together.
            let apart_m = if step < 20 { 3000.0 * f64::from(source / 2) } else { 0.0 };
            harness.take(&report(
                source,
                0,
                time_s + 0.01 * f64::from(source),
                [apart_m, 0.0],
                [0.0, 100.0],
            ));
        }
        most = most.max(harness.live());
    }
    assert_eq!((most, harness.live()), (3, 1));
}
