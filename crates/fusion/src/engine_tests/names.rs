//! Codes and call signs as evidence, and positions that targets report themselves.

use test_support::Random;

use super::*;
use crate::settings::FactorExponents;

/// Error of the second source's positions, metres.
const BIAS_M: f64 = 1500.0;

fn with_code(mut report: SensorTrack, code: u16) -> SensorTrack {
    report.identity = report.identity.with_mode_3a(code);
    report
}

/// The targets of one world, 8 km apart, seen by two sources of which the second has a bias, for a minute; `named`
/// gives each report its names. System tracks at the end.
fn tracks_of(
    settings: Settings,
    targets: u32,
    mut named: impl FnMut(SensorTrack, u16, u32, i32) -> SensorTrack,
) -> Vec<SystemTrack> {
    let mut harness = Harness::new(settings);
    let mut random = Random::new(7);
    for step in 0..60 {
        for source in 0..2_u16 {
            for target in 0..targets {
                let time_s = f64::from(step) + 0.4 * f64::from(source) + 0.001 * f64::from(target);
                let heading = f64::from(target);
                let bias_m = BIAS_M * f64::from(source);
                let mut noise = || 20.0 * (random.unit() - 0.5);
                let place = [8e3 * f64::from(target) + bias_m + noise(), noise()];
                let velocity = [150.0 * heading.cos(), 150.0 * heading.sin()];
                harness.take(&named(
                    report(source, target, time_s, place, velocity),
                    source,
                    target,
                    step,
                ));
            }
        }
    }
    let mut last: Vec<SystemTrack> = Vec::new();
    for track in harness.published.iter().rev() {
        let is_shown = track.state == TrackState::Confirmed.code();
        let is_late = track.reference_time_ns > 57 * S;
        if is_shown && is_late && last.iter().all(|known| known.track_number != track.track_number) {
            last.push(*track);
        }
    }
    last
}

fn codes(report: SensorTrack, _: u16, target: u32, _: i32) -> SensorTrack {
    with_code(report, 0o1001 + target as u16)
}

#[test]
fn rare_codes_join_what_a_bias_keeps_apart() {
    let joined = tracks_of(test_settings(2), 6, codes);
    assert_eq!(joined.len(), 6);
    assert!(joined.iter().all(|track| sources_of(track).len() == 2));
    // A reach below the bias, codes without weight, codes that all share, and no codes join nothing.
    let mut near = test_settings(2);
    near.identity.reach_m = 500.0;
    let mut weightless = test_settings(2);
    weightless.association.exponents = FactorExponents {
        code: 0.0,
        ..FactorExponents::default()
    };
    let apart = [
        tracks_of(near, 6, codes),
        tracks_of(weightless, 6, codes),
        tracks_of(test_settings(2), 6, |report, _, _, _| with_code(report, 0o2000)),
        tracks_of(test_settings(2), 6, |report, _, _, _| report),
    ];
    assert_eq!(apart.map(|tracks| tracks.len()), [12; 4]);
}

#[test]
fn a_shared_code_joins_nothing_even_where_nobody_else_bears_it() {
    let conspicuous = |report, _, _, _| with_code(report, 0o7000);
    assert_eq!(tracks_of(test_settings(2), 1, conspicuous).len(), 2);
    let mut settings = test_settings(2);
    settings.identity.shared_codes.clear();
    assert_eq!(tracks_of(settings, 1, conspicuous).len(), 1);
}

#[test]
fn call_signs_join_in_spite_of_blanks_and_of_one_code_for_all() {
    let joined = tracks_of(test_settings(2), 6, |report, source, target, _| {
        let mut callsign = *b"ABC1    ";
        callsign[3] += target as u8;
        if source == 1 {
            callsign[4..].fill(0);
        }
        let mut report = with_code(report, 0o7000);
        report.identity = report.identity.with_callsign(callsign);
        report
    });
    assert_eq!(joined.len(), 6);
}

#[test]
fn a_change_of_code_and_a_garbled_code_leave_the_tracks_as_they_are() {
    let changed = tracks_of(test_settings(2), 6, |report, source, target, step| {
        let after = step >= 30 + 4 * i32::from(source);
        let code = if after {
            0o3001 + target as u16
        } else {
            0o1001 + target as u16
        };
        // Every tenth code is that of a neighbour.
        let garbled = (step + target as i32) % 10 == 9;
        with_code(
            report,
            if garbled {
                0o1001 + (target as u16 + 1) % 6
            } else {
                code
            },
        )
    });
    let mut numbers: Vec<u32> = changed.iter().map(|track| track.track_number).collect();
    numbers.sort_unstable();
    assert_eq!(numbers.len(), 6);
    assert!(numbers.iter().all(|number| *number <= 12), "{numbers:?}: none is new");
    assert!(
        changed
            .iter()
            .all(|track| track.identity.mode_3a().is_some_and(|code| code >= 0o3001))
    );
}

#[test]
fn codes_that_one_source_exchanges_join_no_targets_for_long() {
    // Four of six targets show the bias.
    let tracks = tracks_of(test_settings(2), 6, |report, source, target, step| {
        let exchanged = if source == 1 && target < 2 { 1 - target } else { target };
        codes(report, source, exchanged, step)
    });
    let is_mixed = |track: &&SystemTrack| {
        let numbers: Vec<u32> = track.contributions().iter().map(|part| part.track_number).collect();
        numbers.len() == 2 && numbers[0] != numbers[1]
    };
    assert_eq!(tracks.iter().filter(is_mixed).count(), 0);
}

/// Targets that report their positions.
const REPORTING: u32 = 12;

/// Error of the first target's own report of its position after so many seconds.
fn self_reported(error_m: impl Fn(f64) -> f64) -> (Harness, usize) {
    let mut settings = test_settings(2);
    settings.sources[1].is_self_reported = true;
    let mut harness = Harness::new(settings);
    for step in 0..60 {
        let time_s = f64::from(step);
        for target in 0..REPORTING {
            let place = [8e3 * f64::from(target), 0.0];
            let measured = report(0, target, time_s, place, [100.0, 0.0]);
            harness.take(&with_address(measured, 0xa0 + target));
            let error_m = if target == 0 { error_m(time_s) } else { 0.0 };
            let said = report(1, target, time_s + 0.4, [place[0] + error_m, 0.0], [100.0, 0.0]);
            harness.take(&with_address(said, 0xa0 + target));
        }
    }
    let late = harness
        .published
        .iter()
        .filter(|track| track.reference_time_ns > 50 * S);
    let true_one = |track: &&SystemTrack| {
        let seconds = track.reference_time_ns as f64 / S as f64;
        (track.position_m[0] - 100.0 * seconds).abs() < 200.0 && track.identity.address() == Some(0xa0)
    };
    let shown = late.filter(true_one).count();
    (harness, shown)
}

#[test]
fn a_false_position_isolates_its_address_and_no_other() {
    for error_m in [3e3, 30e3] {
        let (harness, shown) = self_reported(|_| error_m);
        let rejected = harness.count(Counter::RejectedFalsePosition);
        assert!((30..=60).contains(&rejected), "{error_m}: {rejected}");
        assert!(shown > 5, "{error_m}: the track of the radar bears the address");
        assert_eq!(harness.live(), REPORTING as usize, "{error_m}");
    }
}

#[test]
fn a_frozen_position_is_isolated_and_a_good_one_comes_back() {
    let (harness, shown) = self_reported(|time_s| if time_s > 20.0 { -100.0 * (time_s - 20.0) } else { 0.0 });
    assert!(harness.count(Counter::RejectedFalsePosition) > 10 && shown > 5);
    let (harness, _) = self_reported(|time_s| if (20.0..30.0).contains(&time_s) { 4e3 } else { 0.0 });
    let rejected = harness.count(Counter::RejectedFalsePosition);
    assert!((5..20).contains(&rejected), "{rejected}");
    let (harness, _) = self_reported(|_| 0.0);
    assert_eq!(harness.count(Counter::RejectedFalsePosition), 0);
}
