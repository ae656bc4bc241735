//! Level of a target's transponder on its way through the engine.

use messages::{SensorTrack, SystemTrack, sensor_track_bits};

use super::{Harness, report};
use crate::testing::test_settings;

/// A report of a target that stands still, with a level (in steps) of this age if it has one.
fn stating(source: u16, time_s: f64, level: Option<(i16, u32)>) -> SensorTrack {
    let mut report = report(source, 1, time_s, [0.0, 0.0], [0.0, 0.0]);
    if let Some((level, age_ms)) = level {
        report.valid |= sensor_track_bits::LEVEL;
        (report.level, report.level_age_ms) = (level, age_ms);
    }
    report
}

fn shown(track: Option<SystemTrack>) -> Option<(i16, u32)> {
    let track = track.unwrap();
    assert!(track.level_valid != 0 || (track.level, track.level_age_ms) == (0, 0));
    (track.level_valid != 0).then_some((track.level, track.level_age_ms))
}

#[test]
fn a_state_has_the_newest_level_of_those_that_support_it() {
    let mut settings = test_settings(3);
    for source in &mut settings.sources {
        (source.period_ns, source.fresh_ns) = (4_000_000_000, 10_000_000_000);
    }
    let mut harness = Harness::new(settings);
    assert_eq!(shown(harness.take(&stating(0, 0.0, None))), None);
    assert_eq!(shown(harness.take(&stating(1, 1.0, Some((-2, 0))))), Some((-2, 0)));
    assert_eq!(
        shown(harness.take(&stating(2, 2.0, None))),
        Some((-2, 1_000)),
        "of another source"
    );
    assert_eq!(
        shown(harness.take(&stating(2, 3.0, Some((400, 2_500))))),
        Some((-2, 2_000)),
        "older than what is known"
    );
    assert_eq!(
        shown(harness.take(&stating(0, 4.0, Some((0, 0))))),
        Some((0, 0)),
        "level 0 is one"
    );
}

#[test]
fn a_level_holds_for_two_periods_of_its_source() {
    let mut settings = test_settings(2);
    (settings.sources[0].period_ns, settings.sources[0].fresh_ns) = (4_000_000_000, 60_000_000_000);
    let mut harness = Harness::new(settings);
    harness.take(&stating(0, 0.0, Some((1_440, 0))));
    for (time_s, expected) in [(4.0, Some((1_440, 4_000))), (8.1, Some((1_440, 8_100))), (9.0, None)] {
        let age_ms = (time_s * 1_000.0) as u32;
        assert_eq!(
            shown(harness.take(&stating(0, time_s, Some((1_440, age_ms))))),
            expected,
            "{time_s} s"
        );
        assert_eq!(
            shown(harness.take(&stating(1, time_s + 0.01, None))).is_some(),
            expected.is_some()
        );
    }
}

#[test]
fn states_have_the_difference_of_both_heights_where_reports_have_shown_it() {
    let mut harness = Harness::new(test_settings(2));
    for step in 0..20 {
        let mut both = report(0, 1, f64::from(step), [0.0, 0.0], [0.0, 0.0]);
        both.valid |= sensor_track_bits::PRESSURE_OFFSET | sensor_track_bits::HEIGHT;
        both.pressure_offset_m = 120.0;
        let offset_m = harness.take(&both).unwrap().pressure_offset();
        assert_eq!(offset_m, (step >= 15).then_some(120.0), "{step}");
    }
    let mut other = report(1, 7, 20.5, [9e3, 9e3], [0.0, 0.0]);
    let without_height = harness.take(&other).unwrap();
    assert_eq!(without_height.pressure_offset(), None);
    other.time_of_measurement_ns += 1_000_000_000;
    other.valid |= sensor_track_bits::HEIGHT;
    let state = harness.take(&other).unwrap();
    assert_eq!(
        state.pressure_offset(),
        Some(120.0),
        "learned of another source's reports"
    );
}
