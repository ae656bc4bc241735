//! Errors of sources in smoothed trajectories.

use super::tests::{errors, reports, settings, smoothed};
use super::*;

/// By how much the second of two sources is off; the first is the reference.
const OFFSET_M: f64 = 240.0;

/// Smoothed states of a run in which the second source is off by `offset_m` at each time.
fn after(offset_m: impl Fn(f64) -> f64) -> Vec<SystemTrack> {
    let mut settings = settings();
    settings.registration.reference_source = Some(0.into());
    let of_source = |source: u16, time_s: f64| f64::from(source) * offset_m(time_s);
    let (live, smoothed) = smoothed(settings, reports(8, (2, 5), of_source));
    live.iter().map(|state| smoothed.of(state).unwrap()).collect()
}

#[test]
fn the_error_of_a_source_is_taken_off_everywhere() {
    let states = after(|_| OFFSET_M);
    // The mean of both sources lies 120 m to the east.
    for span_s in [[5.0, 30.0], [30.0, 60.0], [95.0, 140.0]] {
        let found = errors(&states, span_s, 0.0);
        assert!(found[0] < 30.0, "{span_s:?} {found:?}");
    }
}

#[test]
fn an_error_that_changes_is_taken_off_as_it_was_at_each_time() {
    const CHANGES_S: f64 = 70.0;
    let states = after(|time_s| if time_s < CHANGES_S { OFFSET_M } else { -OFFSET_M });
    for span_s in [[10.0, 60.0], [95.0, 140.0]] {
        let found = errors(&states, span_s, 0.0);
        assert!(found[0] < 35.0, "{span_s:?} {found:?}");
    }
}
