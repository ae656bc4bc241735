//! Sources that see a part of the area each, and sources that have not looked yet.

use super::*;

const TARGETS: u32 = 12;

/// A tentative report, as a sensor gives before its third detection.
fn first_reports(report: SensorTrack, hits: u32) -> SensorTrack {
    let state = if hits < 3 {
        TrackState::Tentative
    } else {
        TrackState::Confirmed
    };
    SensorTrack {
        state: state as u8,
        ..report
    }
}

/// The targets that two sources with these `parts` of the area show after `seconds`; both look every second.
fn shown(sees: impl Fn(u16, f64) -> bool, seconds: u32) -> usize {
    let mut harness = Harness::new(test_settings(2));
    for second in 0..seconds {
        for target in 0..TARGETS {
            let x = 4e3 * (f64::from(target) - 5.5);
            for source in 0..2 {
                if sees(source, x) {
                    let time_s = f64::from(second) + 0.3 * f64::from(source);
                    let report = report(source, target, time_s, [x, 1e3 * f64::from(target)], [0.0, 50.0]);
                    harness.take(&first_reports(report, second + 1));
                }
            }
        }
    }
    harness.engine.count_in_state(TrackState::Confirmed)
}

#[test]
fn what_only_one_source_can_see_is_shown_as_soon_as_what_both_see() {
    let all = TARGETS as usize;
    let everywhere = |_: u16, _: f64| true;
    let halves = |source: u16, x: f64| (source == 0) == (x < 0.0);
    let overlapping = |source: u16, x: f64| if source == 0 { x < 6e3 } else { x > -6e3 };
    assert_eq!(shown(everywhere, 4), all);
    assert_eq!(shown(halves, 5), all);
    assert_eq!(shown(overlapping, 8), all);
}

/// The probability of existence that is published, after each report, of a target that both sources see, or that the
/// first source alone reports among targets that both see.
fn existence(by_both: bool) -> Vec<f32> {
    let mut harness = Harness::new(test_settings(2));
    let mut found = Vec::new();
    for second in 0..12 {
        for target in 0..TARGETS {
            for source in 0..2 {
                if target == 0 && (second < 4 || (source == 1 && !by_both)) {
                    continue;
                }
                let time_s = f64::from(second) + 0.3 * f64::from(source);
                let place = [4e3 * f64::from(target), 0.0];
                let track = harness.take(&report(source, target, time_s, place, [0.0, 50.0]));
                if target == 0 {
                    found.extend(track.map(|track| track.existence));
                }
            }
        }
    }
    found
}

#[test]
fn the_probability_of_existence_tells_a_target_from_what_one_source_alone_sees() {
    let (target, doubted) = (existence(true), existence(false));
    assert!(*target.last().unwrap() > 0.99, "{target:?}");
    assert!(
        doubted.iter().any(|existence| (0.01..0.4).contains(existence)),
        "{doubted:?}"
    );
    let all = target.iter().chain(&doubted);
    assert!(all.clone().all(|existence| (0.0..=1.0).contains(existence)));
}

#[test]
fn a_slow_source_joins_by_its_first_report_where_one_target_fits() {
    let joined = |neighbour_m: f64, period_s: i64| {
        let mut settings = test_settings(2);
        (settings.sources[1].period_ns, settings.sources[1].fresh_ns) = (period_s * S, 10 * S);
        let mut harness = Harness::new(settings);
        for second in 0..6 {
            let time_s = f64::from(second);
            harness.take(&report(0, 1, time_s, [0.0; 2], [50.0, 0.0]));
            harness.take(&report(0, 2, time_s, [0.0, neighbour_m], [50.0, 0.0]));
        }
        let first = SensorTrack {
            covariance: Covariance::diagonal([200.0, 200.0, 100.0], [100.0; 3]),
            ..report(1, 7, 5.2, [0.0, 5.0], [50.0, 0.0])
        };
        harness.take(&first_reports(first, 1));
        // Its scan is over a part of its period later.
        let later = harness.take(&report(0, 1, 8.0, [0.0; 2], [50.0, 0.0])).unwrap();
        usize::from(later.source_count)
    };
    assert_eq!(joined(5e3, 4), 2, "no other target is near");
    assert_eq!(joined(300.0, 4), 1, "two targets fit");
    assert_eq!(joined(5e3, 1), 1, "the second report of a fast source comes soon");
}

#[test]
fn what_one_source_alone_followed_for_long_was_a_target() {
    let mut harness = Harness::new(test_settings(2));
    for target in 0..20 {
        let begin_s = 100.0 * f64::from(target);
        for second in 0..30 {
            harness.take(&report(0, target, begin_s + f64::from(second), [0.0; 2], [0.0, 50.0]));
        }
    }
    assert!(harness.count(Counter::TracksTerminated) >= 19);
    assert_eq!(harness.engine.tracks.sources.target_log_odds(0), 0.0);
}
