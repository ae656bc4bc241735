//! Sources whose period nobody has stated, and which is longer than usual.

use super::*;

/// Targets of a radar that turns once in `period_s`, each in a direction of its own.
const TARGETS: u32 = 12;

/// Counts the system tracks that a radar's `turns` start, whose period is stated or has to be learned.
fn started(period_s: f64, turns: u32, stated: bool) -> u64 {
    let mut settings = test_settings(1);
    settings.association.scan_wait = 0.05;
    if stated {
        settings.sources[0].period_ns = (period_s * S as f64) as i64;
        settings.sources[0].fresh_ns = (2.5 * period_s * S as f64) as i64;
    } else {
        settings.sources[0].learns_period = true;
    }
    let mut harness = Harness::new(settings);
    for turn in 0..turns {
        for target in 0..TARGETS {
            // Every seventh look sees nothing.
            if (turn + target) % 7 != 6 {
                let time_s = period_s * (f64::from(turn) + f64::from(target) / f64::from(TARGETS));
                let place = [1e4 * f64::from(target), 0.0];
                harness.take(&report(0, target, time_s, place, [0.0, 100.0]));
            }
        }
    }
    harness.count(Counter::TracksStarted)
}

#[test]
fn each_target_of_a_slow_radar_is_started_once() {
    for period_s in [4.0, 12.0, 22.0] {
        assert_eq!(started(period_s, 20, true), u64::from(TARGETS), "stated, {period_s} s");
        assert_eq!(
            started(period_s, 20, false),
            u64::from(TARGETS),
            "learned, {period_s} s"
        );
    }
}
