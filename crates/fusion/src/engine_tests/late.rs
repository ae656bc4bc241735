//! Reports that come late.

use estimation::{Gaussian, NearlyConstantVelocity};
use messages::layout::Sample as _;
use test_support::Random;

use super::*;
use crate::settings::RuleName;
use crate::{FilterInput, Sink};

const TARGETS: u32 = 3;
const SOURCES: u16 = 3;
/// Until when all reports come in time, s: associations are then made.
const BEGUN_S: f64 = 8.0;
/// Until when reports come late, s.
const LATE_UNTIL_S: f64 = 20.0;

/// A report and the time at which it comes, nanoseconds.
type Coming = (i64, SensorTrack);

/// With a window for late reports. Tracks stay tentative, and so nothing is learned of sources and motion: what a
/// report changes depends on the reports before it alone.
fn settings() -> Settings {
    let mut settings = test_settings(usize::from(SOURCES));
    settings.rule.name = RuleName(messages::FusionRule::SystemFilter);
    settings.late_window_s = Some(Seconds::of_ns(10 * S));
    settings.refresh_s = Some(Seconds::of_ns(S));
    settings.life.confirm_reports = 1_000_000;
    settings.consistency = false;
    settings.registration.enabled = false;
    settings
}

fn coming(settings: &Settings, coming: &[Coming]) -> Harness {
    let mut harness = Harness::new(settings.clone());
    for (now_ns, report) in coming {
        let published = &mut harness.published;
        harness
            .engine
            .take_at(report, *now_ns, &mut |track: &SystemTrack| published.push(*track));
    }
    harness
}

/// Reports of targets that turn after a while, each source once a second. From `BEGUN_S` to `LATE_UNTIL_S` those of
/// `late` sources come late by up to `late_s`.
fn traffic(seed: u64, seconds: u32, late: &[u16], late_s: f64) -> Vec<Coming> {
    let mut random = Random::new(seed);
    let mut all = Vec::new();
    for (scan, source) in (0..seconds).flat_map(|scan| (0..SOURCES).map(move |source| (scan, source))) {
        for target in 0..TARGETS {
            let time_s = f64::from(scan) + 0.3 * f64::from(source) + 0.01 * f64::from(target);
            let angle = 0.15 * (time_s - 12.0).max(0.0);
            let mut report = report(source, target, time_s, [0.0; 2], [0.0; 2]);
            report.position_m = [
                120.0 * time_s.min(12.0) + 800.0 * angle.sin() + random.between(-20.0, 20.0),
                5000.0 * f64::from(target) + 800.0 * (1.0 - angle.cos()) + random.between(-20.0, 20.0),
                0.0,
            ];
            report.velocity_mps = [120.0 * angle.cos(), 120.0 * angle.sin(), 0.0];
            let is_late = late.contains(&source) && (BEGUN_S..LATE_UNTIL_S).contains(&time_s) && random.unit() < 0.7;
            let delay_s = if is_late { random.between(0.0, late_s) } else { 0.0 };
            all.push((report.time_of_measurement_ns + (delay_s * S as f64) as i64, report));
        }
    }
    all.sort_by_key(|(now_ns, report)| (*now_ns, report.time_of_measurement_ns));
    all
}

/// The same reports, all in time.
fn in_time(coming: &[Coming]) -> Vec<Coming> {
    let mut all: Vec<Coming> = coming
        .iter()
        .map(|(_, report)| (report.time_of_measurement_ns, *report))
        .collect();
    all.sort_by_key(|(now_ns, _)| *now_ns);
    all
}

/// Position, velocity and covariance of each target at 31 s.
fn states(harness: &mut Harness) -> Vec<(u32, [f64; 3], [f64; 3], Covariance)> {
    harness.published.clear();
    harness.advance(31.1);
    let at_end = |track: &&SystemTrack| track.reference_time_ns == 31 * S;
    let of = |track: &SystemTrack| {
        (
            track.track_number,
            track.position_m,
            track.velocity_mps,
            track.covariance,
        )
    };
    let last: Vec<_> = harness.published.iter().filter(at_end).map(of).collect();
    assert_eq!(last.len(), TARGETS as usize);
    last
}

fn count(harness: &Harness, counter: Counter) -> u64 {
    harness.engine.counts().get(counter)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    #[test]
    fn late_reports_give_the_state_of_reports_in_time(seed in 0u64..1 << 40, which in 0usize..4, late_s in 2.0f64..9.5) {
        let late: &[u16] = [&[1][..], &[0, 2], &[0, 1, 2], &[2]][which];
        let coming_late = traffic(seed, 30, late, late_s);
        // A filter that contradicts the only source that is left begins anew, and has no place for what came before.
        let begun = inputs(&settings(), &coming_late).iter().filter(|input| input.begins).count();
        prop_assume!(begun == TARGETS as usize);
        let mut found = coming(&settings(), &coming_late);
        prop_assert!(count(&found, Counter::LateUsed) > 5);
        let carried = [Counter::LateBeyondWindow, Counter::LateUnkept, Counter::RejectedOutOfOrder];
        for counter in carried {
            prop_assert_eq!(count(&found, counter), 0, "{}", counter.label());
        }
        let mut expected = coming(&settings(), &in_time(&coming_late));
        prop_assert_eq!(states(&mut found), states(&mut expected));
    }
}

#[test]
fn without_the_window_late_reports_are_carried_forward() {
    let coming_late = traffic(5, 30, &[1], 5.0);
    let mut without = settings();
    without.late_window_s = None;
    let mut found = coming(&without, &coming_late);
    let mut exact = coming(&settings(), &in_time(&coming_late));
    assert_eq!(count(&found, Counter::LateUsed), 0);
    assert!(
        count(&found, Counter::RejectedOutOfOrder) > 0,
        "overtaken ones are lost"
    );
    assert!(states(&mut found) != states(&mut exact));
}

#[test]
fn what_cannot_be_used_in_its_place_is_counted() {
    let mut coming_late = traffic(6, 40, &[], 0.0);
    let last_ns = 39 * S;
    // The reports of source 1 after a while: all of one target come at the end.
    for (now_ns, report) in &mut coming_late {
        if report.source == 1 && report.track_number == 0 && report.time_of_measurement_ns > 27 * S {
            *now_ns = last_ns + report.time_of_measurement_ns / 1000;
        }
    }
    coming_late.sort_by_key(|(now_ns, _)| *now_ns);
    let found = coming(&settings(), &coming_late);
    let of_source = |harness: &Harness, counter| harness.engine.counts().source(1).map(|counts| counts[counter]);
    let (used, beyond) = (Counter::LateUsed, Counter::LateBeyondWindow);
    // 27.3 and 28.3 s are more than 10 s before 39 s, the time of source 0.
    assert_eq!(
        [used, beyond].map(|counter| of_source(&found, counter)),
        [Some(10), Some(2)]
    );
    let mut small = settings();
    small.capacity.kept_measurements = Some(3);
    let found = coming(&small, &coming_late);
    assert_eq!(of_source(&found, beyond), Some(2));
    assert!(of_source(&found, Counter::LateUnkept).is_some_and(|count| count >= 5));
}

#[test]
fn a_repeated_report_counts_once_and_a_report_from_before_the_track_not_at_all() {
    let mut twice = traffic(7, 30, &[], 0.0);
    let early = twice.iter().filter(|(now_ns, _)| *now_ns < 20 * S);
    let again: Vec<Coming> = early.map(|(now_ns, report)| (now_ns + 3 * S, *report)).collect();
    let mut once = coming(&settings(), &twice);
    twice.extend(again);
    twice.sort_by_key(|(now_ns, report)| (*now_ns, report.time_of_measurement_ns));
    let mut found = coming(&settings(), &twice);
    assert_eq!(count(&found, Counter::LateUsed), 0);
    assert_eq!(count(&found, Counter::RejectedOutOfOrder), 20 * 9);
    assert_eq!(states(&mut found), states(&mut once));
}

/// All that a rule of its own accord learns, and joins by scans.
fn usual(rule: messages::FusionRule) -> Settings {
    let mut settings = test_settings(usize::from(SOURCES));
    settings.rule.name = RuleName(rule);
    settings.association.scan_wait = 0.7;
    settings.late_window_s = Some(Seconds::of_ns(10 * S));
    settings
}

#[test]
fn without_late_reports_the_window_changes_nothing() {
    let all = traffic(8, 40, &[], 0.0);
    for rule in [messages::FusionRule::Auto, messages::FusionRule::BestSource] {
        let with = usual(rule);
        let mut without = with.clone();
        without.late_window_s = None;
        let [with, without] = [with, without].map(|settings| coming(&settings, &all).published);
        assert!(with.len() > 200 && SystemTrack::octets(&with) == SystemTrack::octets(&without));
    }
}

#[test]
fn whoever_goes_on_from_an_image_uses_late_reports_alike() {
    let all = traffic(9, 40, &[0, 1, 2], 6.0);
    let settings = usual(messages::FusionRule::Auto);
    let (before, after) = all.split_at(all.len() / 3);
    let mut engine = coming(&settings, before);
    let mut other = Harness::new(settings);
    other.engine.resume_image(&engine.engine.image()).unwrap();
    engine.published.clear();
    for (now_ns, report) in after {
        for harness in [&mut engine, &mut other] {
            let published = &mut harness.published;
            harness
                .engine
                .take_at(report, *now_ns, &mut |track: &SystemTrack| published.push(*track));
        }
    }
    assert!(count(&other, Counter::LateUsed) > 30);
    assert!(SystemTrack::octets(&engine.published) == SystemTrack::octets(&other.published));
}

/// Reports of the trackers of two sources, which are Kalman filters, of a target on a straight path. From 20 to 30 s
/// those of source 1 come late by up to `late_s`.
fn tracked(seed: u64, late_s: f64) -> Vec<Coming> {
    let mut random = Random::new(seed);
    let mut all = Vec::new();
    for source in 0..2 {
        let model = NearlyConstantVelocity::new(10.0, 10.0);
        let mut state = Gaussian::new([0.0; 3], [100.0, 0.0, 0.0], &Covariance::diagonal([40.0; 3], [10.0; 3]));
        for scan in 0..40 {
            let time_s = f64::from(scan) + 0.4 * f64::from(source);
            let measured_m = [100.0 * time_s, 0.0, 0.0].map(|value| value + random.between(-70.0, 70.0));
            state = model.predicted(&state, 1.0);
            state
                .update_position::<3>(measured_m, &[1600.0, 0.0, 0.0, 1600.0, 0.0, 1600.0])
                .unwrap();
            let mut report = report(source, 1, time_s, [0.0; 2], [0.0; 2]);
            report.valid |= sensor_track_bits::HEIGHT | sensor_track_bits::VERTICAL_RATE;
            (report.position_m, report.velocity_mps) = (state.position_m(), state.velocity_mps());
            report.covariance = state.covariance;
            let is_late = source == 1 && (20..30).contains(&scan);
            let delay_s = if is_late { random.between(0.0, late_s) } else { 0.0 };
            all.push((report.time_of_measurement_ns + (delay_s * S as f64) as i64, report));
        }
    }
    all.sort_by_key(|(now_ns, report)| (*now_ns, report.time_of_measurement_ns));
    all
}

#[test]
fn the_measurements_behind_overtaken_reports_and_those_after_them_are_recovered() {
    for seed in 0..20 {
        let coming_late = tracked(seed, 6.0);
        let mut settings = settings();
        settings.sources.truncate(2);
        settings.refresh_s = None;
        let end = |harness: Harness| {
            harness
                .published
                .last()
                .map(|track| (track.position_m, track.covariance))
        };
        let late = coming(&settings, &coming_late);
        assert_eq!(count(&late, Counter::RejectedOutOfOrder), 0);
        assert!(count(&late, Counter::LateUsed) > 5);
        let (position_m, covariance) = end(late).unwrap();
        let (expected_m, expected) = end(coming(&settings, &in_time(&coming_late))).unwrap();
        for axis in 0..2 {
            let apart_m = position_m[axis] - expected_m[axis];
            assert!(apart_m.abs() < 1e-4, "seed {seed}: {position_m:?}, not {expected_m:?}");
            let (found, expected) = (covariance.get(axis, axis), expected.get(axis, axis));
            assert!(
                (found / expected - 1.0).abs() < 1e-6,
                "seed {seed}: {found}, not {expected}"
            );
        }
    }
}

/// Inputs of filters, in which later ones take the places of earlier ones.
#[derive(Default)]
struct InputTape(Vec<FilterInput>);

impl Sink for InputTape {
    fn track(&mut self, _: &SystemTrack) {}

    fn follows_inputs(&self) -> bool {
        true
    }

    fn input(&mut self, input: &FilterInput) {
        let same = self.0.iter_mut().find(|other| input.is_of_same_report(other));
        match same.filter(|_| input.replaces) {
            Some(same) => *same = *input,
            None => self.0.push(*input),
        }
    }
}

/// The inputs of filters, in the order of their times.
fn inputs(settings: &Settings, coming: &[Coming]) -> Vec<FilterInput> {
    let mut engine = Engine::new(settings.clone()).unwrap();
    let mut tape = InputTape::default();
    for (now_ns, report) in coming {
        engine.take_at(report, *now_ns, &mut tape);
    }
    tape.0.sort_by_key(|input| input.time_ns);
    tape.0
}

#[test]
fn readers_of_inputs_receive_overtaken_measurements_and_those_after_them_anew() {
    for seed in 0..5 {
        let coming_late = tracked(seed, 6.0);
        let mut settings = settings();
        settings.sources.truncate(2);
        let (found, expected) = (
            inputs(&settings, &coming_late),
            inputs(&settings, &in_time(&coming_late)),
        );
        assert_eq!(found.len(), expected.len(), "seed {seed}");
        for (found, expected) in found.iter().zip(&expected) {
            assert!(found.is_of_same_report(expected), "seed {seed}");
            let apart_m = found.position_m[0] - expected.position_m[0];
            let ratio = found.covariance_m2[0] / expected.covariance_m2[0];
            assert!(
                apart_m.abs() < 1e-4 && (ratio - 1.0).abs() < 1e-6,
                "seed {seed}: {found:?} {expected:?}"
            );
        }
    }
}
