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

#[test]
fn a_first_report_after_a_restart_does_not_join_what_its_target_flies_over() {
    for state in [TrackState::Tentative, TrackState::Confirmed] {
        fly_over(state);
    }
}

/// A radar restarts while a target of it flies over what a coarse locator follows; first reports bear `state`.
fn fly_over(state: TrackState) {
    let mut settings = test_settings(3);
    settings.association.scan_wait = 0.05;
    settings.sources[0].period_ns = 4 * S;
    settings.sources[0].fresh_ns = 10 * S;
    let mut harness = Harness::new(settings);
    for second in 0..40 {
        let time_s = f64::from(second);
        for target in 0..8 {
            let place = [1e4 * f64::from(target), 0.0];
            harness.take(&report(1, target, time_s, place, [0.0, 100.0]));
            // The radar is silent for a turn, and begins anew.
            if second % 4 == target % 4 && !(24..28).contains(&second) {
                let number = if second < 24 { target } else { target + 100 };
                let mut seen = report(0, number, time_s + 0.1, place, [0.0, 100.0]);
                // A tracker gives no velocity with the first report of a track.
                if second < 4 || (28..32).contains(&second) {
                    (seen.valid, seen.state) = (0, state as u8);
                }
                harness.take(&seen);
            }
        }
        // The track of a coarse locator comes towards the first target, and passes it as the radar begins anew.
        harness.take(&SensorTrack {
            covariance: Covariance::diagonal([300.0, 300.0, 100.0], [10.0, 10.0, 2.0]),
            ..report(2, 0, time_s + 0.2, [200.0, 5600.0], [0.0, -100.0])
        });
        harness.advance(time_s + 0.5);
    }
    let mut followed = [0; 8];
    for track in &harness.published {
        let sources = sources_of(track);
        assert!(!sources.contains(&2) || sources == [2], "{state:?} {track:?}");
        if track.time_of_measurement_ns > 33 * S && sources == [0, 1] {
            followed[(track.position_m[0] / 1e4).round() as usize] += 1;
        }
    }
    assert!(followed.iter().all(|states| *states > 2), "{followed:?}");
}
