//! False tracks in great number.

use super::*;

/// Sources that all follow every target, and targets.
const SOURCES: u16 = 4;
const TARGETS: u32 = 10;
const SECONDS: u32 = 30;

/// Counts the targets shown at the end, where two sources report one more of late, and each so many false tracks.
fn shown(false_tracks: u32) -> usize {
    let mut settings = test_settings(usize::from(SOURCES));
    (settings.capacity.system_tracks, settings.capacity.sensor_tracks) = (Some(500), Some(2000));
    let mut harness = Harness::new(settings);
    for second in 0..SECONDS {
        for source in 0..SOURCES {
            let time_s = f64::from(second) + 0.2 * f64::from(source);
            let mut take = |number, place: [f64; 2]| harness.take(&report(source, number, time_s, place, [50.0, 0.0]));
            for target in 0..TARGETS {
                take(target, [0.0, 1e3 * f64::from(target)]);
            }
            // Each lasts for two seconds, where no other source has anything.
            for number in 0..false_tracks {
                let place = [3e3 * f64::from(source + 1), 1e3 * f64::from(number)];
                take(100 + number + 100 * (second / 2), place);
            }
            if source < 2 && second >= SECONDS - 2 {
                take(99, [-5e3, 0.0]);
            }
        }
    }
    harness.engine.count_in_state(TrackState::Confirmed)
}

#[test]
fn two_sources_that_agree_are_enough_unless_false_tracks_agree_by_chance() {
    let targets = TARGETS as usize;
    assert_eq!(shown(0), targets + 1);
    assert_eq!(shown(10), targets);
}
