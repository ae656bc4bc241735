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

/// A single source with a period of a second, with or without false tracks.
struct Alone {
    harness: Harness,
    has_false_tracks: bool,
    second: u32,
}

impl Alone {
    fn after_40_s(has_false_tracks: bool) -> Self {
        let mut settings = test_settings(1);
        (settings.capacity.system_tracks, settings.capacity.sensor_tracks) = (Some(500), Some(2000));
        let mut alone = Self {
            harness: Harness::new(settings),
            has_false_tracks,
            second: 0,
        };
        (0..40).for_each(|_| {
            alone.look(None);
        });
        alone
    }

    /// A look at ten targets, and at one of this number and place at time 0. Returns whether the one is shown.
    fn look(&mut self, one: Option<(u32, [f64; 2])>) -> bool {
        let time_s = f64::from(self.second);
        let mut take = |number, place: [f64; 2]| self.harness.take(&report(0, number, time_s, place, [0.0, 50.0]));
        for target in 0..10 {
            take(target, [2e3 * f64::from(target), 0.0]);
        }
        if self.has_false_tracks {
            // Each has four reports.
            let begun = 1000 + 2 * (self.second / 4);
            for number in [begun, begun + 1] {
                // Everywhere, and never twice at one place.
                let [x, y] = [7919, 5381].map(|factor| 1e3 * f64::from(number * factor % 97));
                take(number, [-5e3 - x, y]);
            }
        }
        self.second += 1;
        one.and_then(|(number, place)| take(number, place))
            .is_some_and(|track| track.state == TrackState::Confirmed as u8)
    }

    /// Reports until a target with this number, and at this place at time 0, is shown.
    fn reports_until_shown(&mut self, number: u32, place: [f64; 2]) -> u32 {
        let shown = (1..30).find(|_| self.look(Some((number, place))));
        shown.expect("it is shown at last")
    }
}

#[test]
fn more_reports_are_awaited_where_a_source_alone_has_many_false_tracks() {
    let reports = [false, true].map(|has_false| Alone::after_40_s(has_false).reports_until_shown(50, [5e4, 0.0]));
    assert!(reports[0] <= 3 && (8..=16).contains(&reports[1]), "{reports:?}");
}

#[test]
fn a_former_target_at_its_expected_place_needs_few_reports() {
    let mut alone = Alone::after_40_s(true);
    let place = [5e4, 0.0];
    let first = alone.reports_until_shown(50, place);
    for (seconds, seen) in [(12, true), (25, false)] {
        (0..seconds).for_each(|_| {
            alone.look(seen.then_some((50, place)));
        });
    }
    let again = alone.reports_until_shown(51, place);
    let another = alone.reports_until_shown(52, [-5e4, -5e4]);
    assert!(again <= 4 && another >= 8, "{first} {again} {another}");
}
