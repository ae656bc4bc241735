//! The engine as its caller sees it.

mod addresses;
mod bad_input;
mod centres;
mod clutter;
mod contradicting_sources;
mod corrected_sources;
mod dependent_sources;
mod filter_rules;
mod formations;
mod gates;
mod hostile_sources;
mod image;
mod innovations;
mod keys;
mod large_targets;
mod late;
mod levels;
mod moving_coverage;
mod names;
mod orders;
mod partial_coverage;
mod passing_time;
mod resting_numbers;
mod resumption;
mod several_duplicates;
mod ships;
mod slow_sources;
mod slow_targets;
mod turning_targets;
mod velocities;

use messages::{
    Counter, Covariance, Identity, NO_SOURCE, SensorTrack, SystemTrack, TargetType, TrackKind, TrackState, alert_bits,
    sensor_track_bits,
};
use proptest::prelude::*;

use crate::settings::DropOut;
use crate::testing::test_settings;
use crate::{Engine, Settings};
use settings::Seconds;
use test_support::S;

/// A report of a target on a straight path: sources differ by an offset, as body-fixed detection points do.
fn report(source: u16, number: u32, time_s: f64, place: [f64; 2], velocity: [f64; 2]) -> SensorTrack {
    SensorTrack {
        time_of_measurement_ns: (time_s * S as f64) as i64,
        source,
        track_number: number,
        valid: sensor_track_bits::VELOCITY,
        position_m: [place[0] + velocity[0] * time_s, place[1] + velocity[1] * time_s, 0.0],
        velocity_mps: [velocity[0], velocity[1], 0.0],
        covariance: Covariance::diagonal([10.0, 10.0, 100.0], [2.0, 2.0, 2.0]),
        state: TrackState::Confirmed as u8,
        ..SensorTrack::default()
    }
}

fn with_address(mut report: SensorTrack, address: u32) -> SensorTrack {
    report.identity = Identity::default().with_address(address);
    report
}

struct Harness {
    engine: Engine,
    published: Vec<SystemTrack>,
}

impl Harness {
    fn new(settings: Settings) -> Self {
        Self {
            engine: Engine::new(settings).unwrap(),
            published: Vec::new(),
        }
    }

    fn take(&mut self, report: &SensorTrack) -> Option<SystemTrack> {
        let before = self.published.len();
        self.engine
            .take(report, &mut |track: &SystemTrack| self.published.push(*track));
        self.published[before..].last().copied()
    }

    fn advance(&mut self, time_s: f64) {
        self.engine
            .advance((time_s * S as f64) as i64, &mut |track: &SystemTrack| {
                self.published.push(*track)
            });
    }

    fn count(&self, counter: Counter) -> u64 {
        self.engine.counts().get(counter)
    }

    fn live(&self) -> usize {
        [TrackState::Tentative, TrackState::Confirmed, TrackState::Coasted]
            .map(|state| self.engine.count_in_state(state))
            .iter()
            .sum()
    }
}

fn sources_of(track: &SystemTrack) -> Vec<u16> {
    track
        .contributions()
        .iter()
        .map(|contribution| contribution.source)
        .collect()
}

#[test]
fn more_sources_than_a_message_can_list_are_counted() {
    for rule in [messages::FusionRule::Auto, messages::FusionRule::InverseTrace] {
        let mut settings = test_settings(20);
        settings.rule.name.0 = rule;
        let mut harness = Harness::new(settings);
        let mut last = None;
        for step in 0..3 {
            // Those that come last are of the first sources.
            for source in (0..20).rev() {
                let time_s = f64::from(step) + 0.01 * f64::from(20 - source);
                let aside = [0.1 * f64::from(source), 0.0];
                last = harness.take(&report(source, 1, time_s, aside, [20.0, 0.0]));
            }
        }
        let track = last.unwrap();
        assert_eq!((track.source_count, track.contribution_count), (20, 16), "{rule:?}");
        assert_eq!(sources_of(&track), (0..16).collect::<Vec<u16>>(), "{rule:?}");
    }
}

#[test]
fn a_source_that_gives_its_trace_alone_counts_as_much_as_its_trace_says() {
    for rule in [messages::FusionRule::Auto, messages::FusionRule::InverseTrace] {
        let run = |trace_alone: bool| {
            let mut settings = test_settings(2);
            settings.rule.name.0 = rule;
            let (mut harness, mut noise) = (Harness::new(settings), random(5));
            for step in 0..20 {
                let time_s = f64::from(step);
                let mut place = |sigma_m: f64| [0, 1].map(|_| 3.5 * sigma_m * noise());
                harness.take(&report(0, 1, time_s, place(10.0), [20.0, 0.0]));
                let mut coarse = report(1, 1, time_s + 0.5, place(30.0), [20.0, 0.0]);
                coarse.covariance = if trace_alone {
                    Covariance::default()
                } else {
                    Covariance::diagonal([30.0; 3], [std::f64::consts::SQRT_2 * 30.0; 3])
                };
                (coarse.valid, coarse.trace_m2) = (coarse.valid | sensor_track_bits::TRACE, 1800.0);
                harness.take(&coarse);
            }
            assert_eq!(harness.count(Counter::RejectedInvalid), 0);
            harness.published
        };
        let [published, whole] = [true, false].map(run);
        assert_eq!(published.len(), whole.len());
        for (track, whole) in published.iter().zip(&whole) {
            assert_eq!(
                (track.position_m, track.covariance),
                (whole.position_m, whole.covariance),
                "{rule:?}"
            );
        }
        let [fine, coarse] = [0, 1].map(|place| published.last().unwrap().contributions()[place].weight);
        assert!(coarse > 0.0 && fine > 2.0 * coarse, "{rule:?}: {fine} {coarse}");
    }
    let mut harness = Harness::new(test_settings(1));
    for trace_m2 in [-1.0, 0.0, f64::NAN, f64::INFINITY] {
        let mut wrong = report(0, 1, 0.0, [0.0; 2], [20.0, 0.0]);
        (wrong.covariance, wrong.trace_m2) = (Covariance::default(), trace_m2);
        wrong.valid |= sensor_track_bits::TRACE;
        assert_eq!(harness.take(&wrong), None);
    }
    assert_eq!(harness.count(Counter::RejectedInvalid), 4);
}

#[test]
fn accuracy_values_tell_the_steady_source_under_rules_that_need_none_too() {
    for rule in [messages::FusionRule::Auto, messages::FusionRule::SystemFilter] {
        for (stated, refresh_s, wanted) in [
            (None, None, false),
            (Some(true), None, true),
            (None, Some(1.0), true),
            (Some(false), Some(1.0), false),
        ] {
            let mut settings = test_settings(2);
            settings.rule.name.0 = rule;
            settings.rule.accuracy_values = stated;
            settings.refresh_s = refresh_s.map(Seconds::of);
            let (mut harness, mut noise) = (Harness::new(settings), random(3));
            for step in 0..20 {
                let time_s = f64::from(step);
                let place = [20.0 * noise(), 20.0 * noise()];
                harness.take(&report(0, 1, time_s, place, [20.0, 0.0]));
                harness.take(&report(1, 1, time_s + 0.5, [0.0; 2], [20.0, 0.0]));
            }
            let track = harness.published.last().unwrap();
            let [unsteady, steady] = [0, 1].map(|place| track.contributions()[place].accuracy);
            assert_eq!([unsteady, steady].map(f64::is_finite), [wanted; 2], "{rule:?}");
            assert!(!wanted || unsteady > 10.0 * steady, "{rule:?}: {unsteady} {steady}");
            let [east, north, up] = track.contributions()[0].axis_accuracies;
            let norm = east.hypot(north);
            assert!(
                !wanted || (norm - unsteady as f32).abs() < 1e-3 * norm,
                "{rule:?}: {east} {north}"
            );
            assert_eq!((up, east > 0.0), (0.0, wanted), "{rule:?}: no source gives heights");
        }
    }
}

#[test]
fn alerts_and_ground_come_from_whoever_contributes() {
    let mut harness = Harness::new(test_settings(2));
    let place = [0.0, 0.0];
    let alarmed = SensorTrack {
        alerts: alert_bits::EMERGENCY,
        ..report(0, 1, 1.0, place, [20.0, 0.0])
    };
    let on_ground = |time_s| SensorTrack {
        alerts: alert_bits::SPECIAL_IDENTIFICATION,
        valid: sensor_track_bits::VELOCITY | sensor_track_bits::ON_GROUND,
        ..report(1, 1, time_s, place, [20.0, 0.0])
    };
    let first = harness.take(&alarmed).unwrap();
    assert_eq!((first.alerts, first.on_ground), (alert_bits::EMERGENCY, 0));
    let both = harness.take(&on_ground(1.1)).unwrap();
    let bits = alert_bits::EMERGENCY | alert_bits::SPECIAL_IDENTIFICATION;
    assert_eq!((both.alerts, both.on_ground), (bits, 1));
    let calm = harness.take(&report(0, 1, 2.0, place, [20.0, 0.0])).unwrap();
    assert_eq!((calm.alerts, calm.on_ground), (alert_bits::SPECIAL_IDENTIFICATION, 1));
}

#[test]
fn kind_members_and_type_come_from_those_who_know_and_move_nothing() {
    let (mut harness, mut plain) = (Harness::new(test_settings(2)), Harness::new(test_settings(2)));
    for step in 0..6 {
        let time_s = f64::from(step);
        let ignorant = report(0, 1, time_s, [0.0, 0.0], [20.0, 0.0]);
        let unsaid = report(1, 1, time_s + 0.1, [0.0, 0.0], [20.0, 0.0]);
        // What a source no longer says no longer holds.
        let knowing = match step {
            0..4 => SensorTrack {
                kind: TrackKind::Group as u8,
                members: 3,
                target_type: TargetType::new("patrol", 0.8).unwrap(),
                ..unsaid
            },
            _ => unsaid,
        };
        harness.take(&ignorant).unwrap();
        let track = harness.take(&knowing).unwrap();
        let expected = match step {
            0..4 => (TrackKind::Group as u8, 3, Some("patrol")),
            _ => (TrackKind::Single as u8, 0, None),
        };
        assert_eq!(
            (track.kind, track.members, track.target_type.name()),
            expected,
            "{step}"
        );
        plain.take(&ignorant).unwrap();
        let without = SystemTrack {
            kind: TrackKind::Single as u8,
            members: 0,
            target_type: TargetType::default(),
            ..track
        };
        // Not compared by value: a weight without a score is no number.
        assert_eq!(format!("{:?}", plain.take(&unsaid).unwrap()), format!("{without:?}"));
    }
}

#[test]
fn one_target_seen_by_one_source_passes_through_unchanged() {
    let mut harness = Harness::new(test_settings(1));
    for step in 0..5 {
        let report = report(0, 7, f64::from(step), [100.0, 200.0], [10.0, -5.0]);
        let track = harness.take(&report).unwrap();
        assert_eq!(track.position_m, report.position_m);
        assert_eq!(track.velocity_mps, report.velocity_mps);
        assert_eq!(track.covariance, report.covariance);
        assert_eq!(track.contributions()[0].weight, 1.0);
        let expected = if step < 2 {
            TrackState::Tentative
        } else {
            TrackState::Confirmed
        };
        assert_eq!(track.state, expected as u8);
    }
}

#[test]
fn anonymous_reports_join_by_place_and_motion_and_others_do_not() {
    let mut harness = Harness::new(test_settings(2));
    harness.take(&report(0, 1, 0.0, [0.0, 0.0], [50.0, 0.0]));
    let joined = harness.take(&report(1, 1, 0.5, [15.0, -10.0], [50.0, 1.0])).unwrap();
    assert_eq!(sources_of(&joined), [0, 1]);
    let other_way = harness.take(&report(1, 2, 0.5, [25.0, 0.0], [-50.0, 0.0])).unwrap();
    assert_ne!(
        other_way.track_number, joined.track_number,
        "the same place, the opposite motion"
    );
    let far = harness.take(&report(1, 3, 0.5, [500.0, 0.0], [50.0, 0.0])).unwrap();
    assert_eq!(harness.live(), 3);
    assert_ne!(far.track_number, joined.track_number);
}

#[test]
fn identity_joins_what_place_would_not_and_parts_what_place_would_join() {
    let mut harness = Harness::new(test_settings(2));
    let first = harness
        .take(&with_address(report(0, 1, 0.0, [0.0, 0.0], [0.0, 0.0]), 0xabc))
        .unwrap();
    let apart = harness
        .take(&with_address(report(1, 1, 0.1, [500.0, 0.0], [0.0, 0.0]), 0xabc))
        .unwrap();
    assert_eq!(first.track_number, apart.track_number);
    let other = harness
        .take(&with_address(report(1, 2, 0.1, [5.0, 0.0], [0.0, 0.0]), 0xdef))
        .unwrap();
    assert_ne!(first.track_number, other.track_number);

    let mut settings = test_settings(2);
    settings.association.use_identity = false;
    let mut hidden = Harness::new(settings);
    let first = hidden
        .take(&with_address(report(0, 1, 0.0, [0.0, 0.0], [0.0, 0.0]), 0xabc))
        .unwrap();
    let other = hidden
        .take(&with_address(report(1, 2, 0.1, [5.0, 0.0], [0.0, 0.0]), 0xdef))
        .unwrap();
    assert_eq!(
        first.track_number, other.track_number,
        "hidden, identity neither joins nor parts"
    );
}

#[test]
fn the_best_source_is_followed_and_a_worse_one_is_left() {
    let mut harness = Harness::new(test_settings(2));
    let mut selected = Vec::new();
    for step in 0..8 {
        // Source 0 is the steadier one until it jumps about from t = 4 on; source 1 lies 15 m to the side.
        let time = f64::from(step);
        let sign = if step % 2 == 0 { 1.0 } else { -1.0 };
        let wander = if step >= 4 { 12.0 * sign } else { 0.1 * sign };
        harness.take(&report(0, 1, time, [0.0, wander], [20.0, 0.0]));
        let steady = report(1, 1, time + 0.1, [0.0, 15.0 + sign], [20.0, 0.0]);
        selected.push(harness.take(&steady).unwrap().selected_source);
    }
    assert_eq!(selected, [0, 0, 0, 0, 1, 1, 1, 1]);
    assert_eq!(harness.count(Counter::HandOvers), 1);
}

#[test]
fn a_broken_up_target_stays_one_system_track() {
    let mut harness = Harness::new(test_settings(2));
    for step in 0..6 {
        let time = f64::from(step);
        harness.take(&report(1, 1, time, [0.0, 0.0], [0.0, 0.0]));
        harness.take(&report(0, 1, time, [10.0, 0.0], [0.0, 0.0]));
        let part = harness.take(&report(0, 2, time, [-20.0, 5.0], [0.0, 0.0]));
        assert_eq!(part, None, "a second part of the same target is recognised, not used");
    }
    assert_eq!(harness.live(), 1);
    assert_eq!(harness.count(Counter::RejectedDuplicate), 6);
    // The first part disappears; the second takes over once the first is no longer fresh.
    let mut last = None;
    for step in 6..12 {
        harness.take(&report(1, 1, f64::from(step), [0.0, 0.0], [0.0, 0.0]));
        last = harness.take(&report(0, 2, f64::from(step), [-20.0, 5.0], [0.0, 0.0]));
    }
    assert_eq!(sources_of(&last.unwrap()), [0, 1]);
    assert_eq!(harness.live(), 1);
}

#[test]
fn a_wrong_join_is_split_and_a_target_started_twice_is_merged() {
    let mut settings = test_settings(2);
    let exact = Some(crate::settings::StampRounding::Exact);
    settings.sources.iter_mut().for_each(|source| source.stamps = exact);
    let mut harness = Harness::new(settings);
    // Side by side at first, they join; then source 1's target drives away.
    for step in 0..20 {
        let time = f64::from(step);
        harness.take(&report(0, 1, time, [0.0, 0.0], [0.0, 0.0]));
        let away = if step < 4 { 0.0 } else { 15.0 * f64::from(step - 3) };
        let mut leaving = report(1, 1, time, [0.0, away], [0.0, 0.0]);
        leaving.velocity_mps[1] = if step < 4 { 0.0 } else { 15.0 };
        harness.take(&leaving);
    }
    // Near by it may be tried once more: the two could be points of one large target.
    assert!((1..=2).contains(&harness.count(Counter::ContributionsSplit)));
    assert_eq!(harness.live(), 2);
    let numbers: Vec<u32> = harness.published.iter().map(|track| track.track_number).collect();
    // It comes back and stays: one target again, under the older number.
    for step in 20..40 {
        let time = f64::from(step);
        harness.take(&report(0, 1, time, [0.0, 0.0], [0.0, 0.0]));
        harness.take(&report(1, 1, time, [0.0, 4.0], [0.0, 0.0]));
    }
    assert_eq!(harness.live(), 1);
    assert_eq!(harness.count(Counter::TracksMerged), 1);
    let merged = harness.published.iter().find(|track| track.merged_into != 0).unwrap();
    assert_eq!(merged.merged_into, numbers[0]);
    assert_eq!(merged.state, TrackState::Terminated as u8);
}

#[test]
fn a_filter_begins_anew_only_if_what_it_was_told_was_very_wrong() {
    for (claimed_too_much, begins_anew) in [(1.3, false), (10.0, true)] {
        let mut harness = Harness::new(test_settings(2));
        for second in 0..30 {
            let (time_s, east_m) = (f64::from(second), 100.0 * f64::from(second));
            harness.take(&report(0, 1, time_s, [east_m, 0.0], [100.0, 0.0]));
            harness.take(&report(1, 1, time_s + 0.5, [east_m + 50.0, 0.0], [100.0, 0.0]));
        }
        let sensor = harness.engine.tracks.sensors.find(0, 1).unwrap();
        let entry = harness.engine.tracks.sensors.get_mut(sensor);
        (entry.claimed_too_much, entry.share) = (claimed_too_much, 0.6);
        let began = harness.engine.corrects_claims(sensor, &mut |_: &SystemTrack| {});
        assert_eq!(began, begins_anew, "{claimed_too_much}");
        assert_eq!(harness.count(Counter::EstimatesRestarted), u64::from(begins_anew));
    }
}

#[test]
fn a_fix_whose_error_persists_moves_no_target_that_is_known_better() {
    let furthest_m = |is_registered: bool| {
        let mut settings = test_settings(2);
        settings.rule.name.0 = messages::FusionRule::SystemFilter;
        settings.sources[1].is_registered = is_registered;
        let mut harness = Harness::new(settings);
        let mut furthest_m = 0.0_f64;
        for second in 0..70 {
            let (time_s, east_m) = (f64::from(second), 20.0 * f64::from(second));
            // The better source misses the target for some seconds.
            if !(60..65).contains(&second) {
                harness.take(&report(0, 1, time_s, [east_m, 0.0], [20.0, 0.0]));
            }
            let mut fix = report(1, 1, time_s + 0.5, [east_m + 10.0, 300.0], [20.0, 0.0]);
            fix.covariance = Covariance::diagonal([200.0; 3], [20.0; 3]);
            let shown = harness.take(&fix);
            if second >= 30 {
                furthest_m = shown.map_or(furthest_m, |track| furthest_m.max(track.position_m[1].abs()));
            }
        }
        furthest_m
    };
    let [averaged_m, left_out_m] = [true, false].map(furthest_m);
    assert!(left_out_m < 2.0 && averaged_m > 10.0, "{left_out_m} m, {averaged_m} m");
}

#[test]
fn a_fix_that_adds_nothing_to_a_target_leads_to_no_state() {
    let states = |fix_sigma_m: f64, late_s: f64| {
        let mut settings = test_settings(2);
        settings.sources[1].is_registered = false;
        let mut harness = Harness::new(settings);
        for second in 0..20 {
            let time_s = f64::from(second);
            let mut fix = report(1, 1, time_s - late_s, [10.0, 0.0], [20.0, 0.0]);
            fix.covariance = Covariance::diagonal([fix_sigma_m; 3], [20.0; 3]);
            harness.take(&report(0, 1, time_s, [0.0, 0.0], [20.0, 0.0]));
            harness.take(&fix);
        }
        let by_fix = harness.published.iter().filter(|track| track.trigger_source == 1);
        let (states, track) = (by_fix.count(), harness.published.last().unwrap());
        assert_eq!(sources_of(track), [0, 1], "the fix shows that the target is there");
        states
    };
    assert_eq!(
        [states(200.0, 0.1), states(5.0, 0.1), states(200.0, -0.1)].map(|states| states > 10),
        [false, true, true]
    );
}

#[test]
fn what_has_just_left_a_track_waits_beside_it() {
    let shown_s = |has_left: bool| {
        let mut harness = Harness::new(test_settings(2));
        (0..60).map(f64::from).find(|time_s| {
            harness.take(&report(0, 1, *time_s, [100.0 * time_s, 0.0], [100.0, 0.0]));
            let aside = report(1, 1, time_s + 0.5, [100.0 * time_s + 50.0, 400.0], [100.0, 0.0]);
            let state = harness.take(&aside).map(|track| track.state);
            if has_left && *time_s == 0.0 {
                let sensor = harness.engine.tracks.sensors.find(1, 1).unwrap();
                harness.engine.tracks.sensors.get_mut(sensor).has_left = true;
            }
            state == Some(TrackState::Confirmed as u8)
        })
    };
    let [new_s, left_s] = [false, true].map(|has_left| shown_s(has_left).unwrap());
    assert!(new_s < 10.0 && (18.0..25.0).contains(&left_s), "{new_s}, {left_s}");
}

#[test]
fn without_reports_a_track_coasts_and_ends_at_the_configured_times() {
    let mut harness = Harness::new(test_settings(1));
    for step in 0..4 {
        harness.take(&report(0, 1, f64::from(step), [0.0, 0.0], [10.0, 0.0]));
    }
    harness.advance(5.5);
    assert_eq!(
        harness.published.last().unwrap().state,
        TrackState::Confirmed as u8,
        "fresh until 5.5 s, inclusive"
    );
    harness.advance(5.6);
    let coasted = *harness.published.last().unwrap();
    assert_eq!(coasted.state, TrackState::Coasted as u8);
    assert_eq!(coasted.reference_time_ns, 5_500_000_000);
    assert!((coasted.position_m[0] - 55.0).abs() < 1e-9);
    assert_eq!((coasted.trigger_source, coasted.source_count), (NO_SOURCE, 0));
    harness.advance(23.0);
    assert_eq!(harness.live(), 1);
    harness.advance(23.1);
    assert_eq!(harness.published.last().unwrap().state, TrackState::Suspended as u8);
    assert_eq!(harness.live(), 0);
}

#[test]
fn a_report_brings_a_coasted_track_back_and_it_coasts_again_in_time() {
    let mut harness = Harness::new(test_settings(1));
    for step in 0..4 {
        harness.take(&report(0, 1, f64::from(step), [0.0, 0.0], [10.0, 0.0]));
    }
    let number = harness.published[0].track_number;
    let back = harness.take(&report(0, 2, 8.0, [0.0, 0.0], [10.0, 0.0])).unwrap();
    assert_eq!(
        (back.track_number, back.state),
        (number, TrackState::Confirmed as u8),
        "renumbered by its source"
    );
    harness.advance(10.6);
    let coasted = harness.published.last().unwrap();
    assert_eq!(
        (coasted.state, coasted.reference_time_ns),
        (TrackState::Coasted as u8, 10_500_000_000)
    );
}

#[test]
fn full_tables_refuse_new_entries_and_serve_the_rest() {
    let mut settings = test_settings(1);
    settings.capacity.system_tracks = Some(2);
    settings.capacity.sensor_tracks = Some(3);
    let mut harness = Harness::new(settings);
    for number in 0..5 {
        harness.take(&report(
            0,
            number,
            0.1 * f64::from(number),
            [1e4 * f64::from(number), 0.0],
            [0.0, 0.0],
        ));
    }
    assert_eq!(harness.live(), 2);
    assert_eq!(harness.count(Counter::DroppedTable), 3);
    assert!(harness.take(&report(0, 1, 1.0, [1e4, 0.0], [0.0, 0.0])).is_some());
}

#[test]
fn sensor_tracks_that_fall_silent_do_not_fill_the_table() {
    let mut settings = test_settings(1);
    settings.capacity.sensor_tracks = Some(20);
    let mut harness = Harness::new(settings);
    // Seen once, believed by nobody, never ended: a source's noise, for minutes.
    for number in 0..400 {
        let noise = SensorTrack {
            state: TrackState::Tentative as u8,
            ..report(0, number, 2.5 * f64::from(number), [0.0, 0.0], [0.0, 0.0])
        };
        harness.take(&noise);
    }
    assert_eq!(harness.count(Counter::DroppedTable), 0);
}

#[test]
fn an_extrapolation_is_no_observation_and_a_guessed_velocity_does_not_win() {
    let mut harness = Harness::new(test_settings(2));
    for step in 0..4 {
        let time = f64::from(step);
        let wander = if step % 2 == 0 { 3.0 } else { -3.0 };
        harness.take(&report(0, 1, time, [0.0, wander], [100.0, 0.0]));
        // Source 1 has seen the target once, believes it to stand still, and agrees with itself ever after.
        let mut guess = report(1, 1, time + 0.1, [0.0, 0.0], [0.0, 0.0]);
        guess.covariance = Covariance::diagonal([10.0, 10.0, 100.0], [150.0; 3]);
        guess.state = if step == 0 {
            TrackState::Tentative
        } else {
            TrackState::Coasted
        } as u8;
        harness.take(&guess);
    }
    assert_eq!(harness.count(Counter::RejectedExtrapolated), 3);
    assert!(harness.published.iter().all(|track| track.selected_source == 0));
    let mut second = report(1, 1, 3.5, [350.0, 0.0], [0.0, 0.0]);
    second.state = TrackState::Tentative as u8;
    second.covariance = Covariance::diagonal([10.0, 10.0, 100.0], [150.0; 3]);
    assert_eq!(
        harness.take(&second).unwrap().selected_source,
        0,
        "two reports, but not believed yet"
    );
}

#[test]
fn an_ended_sensor_track_stops_contributing_at_once() {
    let mut harness = Harness::new(test_settings(2));
    harness.take(&report(0, 1, 0.0, [0.0, 0.0], [0.0, 0.0]));
    let both = harness.take(&report(1, 1, 0.1, [0.0, 0.0], [0.0, 0.0])).unwrap();
    assert_eq!(sources_of(&both), [0, 1]);
    let mut last = report(0, 1, 0.2, [0.0, 0.0], [0.0, 0.0]);
    last.state = TrackState::Terminated as u8;
    harness.take(&last);
    let one = harness.take(&report(1, 1, 0.3, [0.0, 0.0], [0.0, 0.0])).unwrap();
    assert_eq!(sources_of(&one), [1]);
}

#[test]
fn of_two_targets_one_above_the_other_height_decides() {
    let at_height = |mut report: SensorTrack, height: f64| {
        report.valid |= sensor_track_bits::HEIGHT;
        report.position_m[2] = height;
        report.covariance.set(2, 2, 400.0);
        report
    };
    let mut harness = Harness::new(test_settings(2));
    harness.take(&at_height(report(1, 1, 0.0, [0.0, 0.0], [0.0, 0.0]), 3000.0));
    let upper = harness
        .take(&at_height(report(1, 2, 0.0, [12.0, 0.0], [0.0, 0.0]), 3300.0))
        .unwrap();
    let joined = harness
        .take(&at_height(report(0, 1, 0.1, [2.0, 0.0], [0.0, 0.0]), 3310.0))
        .unwrap();
    assert_eq!(
        joined.track_number, upper.track_number,
        "nearer in the plane to the lower one"
    );
}

#[test]
fn a_ground_sensor_does_not_join_what_flies_overhead() {
    let mut settings = test_settings(2);
    settings.sources[0].ceiling_m = 300.0;
    let mut harness = Harness::new(settings);
    let mut high = report(1, 1, 0.0, [0.0, 0.0], [0.0, 0.0]);
    high.valid |= sensor_track_bits::HEIGHT;
    high.position_m[2] = 3000.0;
    let high = harness.take(&high).unwrap();
    let ground = harness.take(&report(0, 1, 0.1, [0.0, 0.0], [0.0, 0.0])).unwrap();
    assert_ne!(high.track_number, ground.track_number);
}

#[test]
fn with_a_refresh_time_states_come_at_its_multiples_and_at_no_other_time() {
    let mut settings = test_settings(2);
    settings.refresh_s = Some(Seconds::of_ns(2 * S));
    let mut harness = Harness::new(settings);
    for step in 0..8 {
        let time = f64::from(step);
        harness.take(&report(0, 1, time, [0.0, 0.0], [10.0, 0.0]));
        harness.take(&report(1, 1, time + 0.5, [0.0, 3.0], [10.0, 0.0]));
    }
    harness.advance(8.001);
    let times: Vec<i64> = harness
        .published
        .iter()
        .map(|track| track.reference_time_ns / S)
        .collect();
    assert_eq!(
        times,
        [0, 2, 4, 6, 8],
        "one target, one state each, the last as soon as 8 s has passed"
    );
    let sources: Vec<_> = harness.published.iter().map(sources_of).collect();
    assert_eq!(sources[0], [0], "a report measured exactly then is in");
    assert_eq!(sources[1..], [[0, 1], [0, 1], [0, 1], [0, 1]]);
    assert_eq!(harness.published[0].state, TrackState::Tentative as u8);
    assert_eq!(
        harness.published[1].state,
        TrackState::Confirmed as u8,
        "five reports by then"
    );
    assert!(harness.published.iter().all(|track| track.trigger_source == NO_SOURCE));
    assert!((harness.published[4].position_m[0] - 80.0).abs() < 1e-9);
    // It coasts silently at 10 s, and ends when its time is up.
    harness.advance(1e9);
    let coasted: Vec<_> = harness
        .published
        .iter()
        .filter(|track| track.state == TrackState::Coasted as u8)
        .collect();
    assert!(coasted.len() >= 8 && coasted.iter().all(|track| track.reference_time_ns % (2 * S) == 0));
    assert_eq!(harness.published.last().unwrap().state, TrackState::Terminated as u8);
    assert_eq!(harness.live(), 0);
}

#[test]
fn with_a_delay_slow_sources_are_interpolated() {
    let at_4_s = |delay_ns| {
        let mut settings = test_settings(1);
        settings.sources[0].period_ns = 4 * S;
        settings.sources[0].fresh_ns = 10 * S;
        settings.refresh_s = Some(Seconds::of_ns(4 * S));
        settings.refresh_delay_s = Seconds::of_ns(delay_ns);
        let mut harness = Harness::new(settings);
        // It flies east until 2 s, then turns north at once.
        harness.take(&report(0, 1, 2.0, [0.0, 0.0], [100.0, 0.0]));
        let mut turned = report(0, 1, 6.0, [0.0, 0.0], [0.0, 100.0]);
        turned.position_m = [200.0, 400.0, 0.0];
        harness.take(&turned);
        harness.advance(12.0);
        let found = harness.published.iter().find(|track| track.reference_time_ns == 4 * S);
        found.expect("a state at 4 s").position_m
    };
    assert_eq!(at_4_s(0), [400.0, 0.0, 0.0], "extrapolated");
    assert_eq!(
        at_4_s(3 * S),
        [200.0, 200.0, 0.0],
        "half-way between the reports on either side"
    );
}

#[test]
fn a_track_that_no_usable_source_sees_coasts_until_one_does() {
    let mut settings = test_settings(1);
    settings.rule.name.0 = messages::FusionRule::QualityFactor;
    let mut harness = Harness::new(settings);
    let with_state = |time_s: f64, state: TrackState| {
        let mut report = report(0, 1, time_s, [0.0, 0.0], [10.0, 0.0]);
        report.state = state as u8;
        report
    };
    let states: Vec<u8> = (0..8)
        .map(|step| {
            let believed = !(3..=5).contains(&step);
            let state = if believed {
                TrackState::Confirmed
            } else {
                TrackState::Tentative
            };
            harness.take(&with_state(f64::from(step), state)).unwrap().state
        })
        .collect();
    let (tentative, confirmed, coasted) = (0, TrackState::Confirmed as u8, TrackState::Coasted as u8);
    assert_eq!(tentative, TrackState::Tentative as u8);
    assert_eq!(states[..2], [tentative; 2]);
    assert_eq!(
        states[2..],
        [confirmed, coasted, coasted, coasted, confirmed, confirmed]
    );
    let unused = harness.published[4];
    assert_eq!(
        (unused.selected_source, unused.contributions()[0].weight),
        (NO_SOURCE, 0.0)
    );
    assert!((unused.position_m[0] - 40.0).abs() < 1e-9);
}

#[test]
fn a_source_that_drops_out_is_blended_out_by_its_last_report() {
    let run = |drop_out| {
        let mut settings = test_settings(2);
        settings.rule.hand_over.ramp = vec![0.25, 0.5, 0.75];
        settings.rule.hand_over.drop_out = drop_out;
        let mut harness = Harness::new(settings);
        for step in 0..10 {
            let time = f64::from(step);
            // Source 0 agrees with itself, source 1 wanders a little; source 0 falls silent after 4 s.
            if step <= 4 {
                harness.take(&report(0, 1, time, [0.0, 0.0], [20.0, 0.0]));
            }
            let wander = if step % 2 == 0 { 0.01 } else { -0.01 };
            harness.take(&report(1, 1, time + 0.1, [0.0, 8.0 + wander], [20.0, 0.0]));
        }
        let weight = |track: &SystemTrack| {
            let contributions = track.contributions().iter();
            let own = contributions.filter(|contribution| contribution.source == 1);
            (
                own.map(|contribution| contribution.weight).sum::<f64>(),
                track.position_m[1].round(),
            )
        };
        let last = harness.published.iter().rev().take(4).rev();
        last.map(weight).collect::<Vec<_>>()
    };
    // Fresh until 6.5 s: at 7.1, 8.1 and 9.1 s the output goes over.
    assert_eq!(run(DropOut::Blend), [(0.0, 0.0), (0.25, 2.0), (0.5, 4.0), (0.75, 6.0)]);
    assert_eq!(run(DropOut::Switch), [(0.0, 0.0), (1.0, 8.0), (1.0, 8.0), (1.0, 8.0)]);
}

#[test]
fn a_source_that_has_missed_its_report_is_left_at_once_though_the_last_one_is_fresh() {
    let run = |drop_out| {
        let mut settings = test_settings(2);
        settings.rule.hand_over.ramp = vec![0.25, 0.5, 0.75];
        settings.rule.hand_over.drop_out = drop_out;
        // The twelfth state is the first that may leave source 0: at 6.1 s.
        settings.rule.hold_refreshes = 11;
        let mut harness = Harness::new(settings);
        for step in 0..7 {
            let time = f64::from(step);
            // The last report of source 0, at 4 s, is off: it is overdue from 5.5 s on, and fresh until 6.5 s.
            let off_m = if step == 4 { 5.0 } else { 0.0 };
            if step <= 4 {
                harness.take(&report(0, 1, time, [0.0, off_m], [20.0, 0.0]));
            }
            let wander = if step % 2 == 0 { 0.01 } else { -0.01 };
            harness.take(&report(1, 1, time + 0.1, [0.0, 8.0 + wander], [20.0, 0.0]));
        }
        let weight = |track: &SystemTrack| {
            let own = track
                .contributions()
                .iter()
                .filter(|contribution| contribution.source == 1);
            own.map(|contribution| contribution.weight).sum::<f64>()
        };
        harness
            .published
            .iter()
            .rev()
            .take(2)
            .rev()
            .map(weight)
            .collect::<Vec<_>>()
    };
    assert_eq!(run(DropOut::Switch), [0.0, 1.0]);
    assert_eq!(run(DropOut::Blend), [0.0, 0.25]);
}

#[test]
fn what_cannot_be_used_for_weighing_is_counted_at_its_source() {
    let mut settings = test_settings(2);
    settings.rule.name.0 = messages::FusionRule::Information;
    let mut harness = Harness::new(settings);
    let mut bad = report(1, 1, 0.1, [0.0, 0.0], [0.0, 0.0]);
    bad.covariance.set(0, 1, 150.0);
    harness.take(&report(0, 1, 0.0, [0.0, 0.0], [0.0, 0.0]));
    assert!(harness.take(&bad).is_some());
    let of = |source| harness.engine.counts().source(source).unwrap()[Counter::CovariancesRepaired];
    assert_eq!((of(0), of(1)), (0, 1));

    let mut settings = test_settings(2);
    settings.rule.name.0 = messages::FusionRule::InverseTrace;
    let mut harness = Harness::new(settings);
    let mut bad = report(1, 1, 0.1, [0.0, 0.0], [0.0, 0.0]);
    (bad.valid, bad.trace_m2) = (bad.valid | sensor_track_bits::TRACE, f64::NAN);
    harness.take(&report(0, 1, 0.0, [0.0, 0.0], [0.0, 0.0]));
    assert!(harness.take(&bad).is_some());
    assert_eq!(harness.count(Counter::TracesRejected), 1);
}

/// Numbers from −0.5 to 0.5, the same ones for the same seed.
fn random(seed: u64) -> impl FnMut() -> f64 {
    let mut noise = seed | 1;
    move || {
        noise ^= noise << 13;
        noise ^= noise >> 7;
        noise ^= noise << 17;
        (noise >> 11) as f64 / (1u64 << 53) as f64 - 0.5
    }
}

/// Reports of a few wandering targets by three sources, in time order.
fn traffic(seed: u64, seconds: u32) -> Vec<SensorTrack> {
    let mut random = random(seed);
    let mut reports = Vec::new();
    for second in 0..seconds {
        for source in 0..3u16 {
            for target in 0..12u32 {
                if random() > 0.4 {
                    continue;
                }
                let place = [
                    1500.0 * f64::from(target % 4) + 30.0 * random(),
                    800.0 * f64::from(target / 4) + 30.0 * random(),
                ];
                let time = f64::from(second) + 0.3 * f64::from(source);
                let renumbered = target + 100 * (second / 17);
                let mut report = report(source, renumbered, time, place, [10.0, f64::from(target) - 6.0]);
                if source > 0 {
                    report.identity = Identity::default().with_address(0x40_0000 + target);
                }
                reports.push(report);
            }
        }
    }
    reports
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(16))]

    #[test]
    fn invariants_hold_over_random_traffic(seed in any::<u64>()) {
        let mut harness = Harness::new(test_settings(3));
        let mut addresses = std::collections::BTreeMap::new();
        for report in traffic(seed, 60) {
            // A report that is not used itself may still let time pass, and tracks coast or end.
            let Some(track) = harness.take(&report).filter(|track| track.trigger_source != NO_SOURCE) else { continue };
            let weights: f64 = track.contributions().iter().map(|contribution| contribution.weight).sum();
            prop_assert!((weights - 1.0).abs() < 1e-12);
            let sources = sources_of(&track);
            prop_assert!(sources.windows(2).all(|pair| pair[0] < pair[1]), "one contribution per source");
            if let Some(address) = track.identity.address() {
                prop_assert_eq!(*addresses.entry(track.track_number).or_insert(address), address);
            }
        }
        harness.advance(1e4);
        prop_assert_eq!(harness.live(), 0, "everything ends");
    }

    #[test]
    fn the_same_reports_give_the_same_bits(seed in any::<u64>()) {
        let run = || {
            let mut harness = Harness::new(test_settings(3));
            for report in traffic(seed, 30) {
                harness.take(&report);
            }
            harness.published
        };
        // Debug output, because an absent accuracy value is NaN and NaN differs from itself.
        prop_assert_eq!(format!("{:?}", run()), format!("{:?}", run()));
    }
}

#[test]
fn a_target_with_four_sources_and_eight_stored_reports_takes_less_than_12_kilobytes() {
    let per_sensor_track =
        size_of::<crate::tables::sensor_tracks::SensorEntry>() + crate::history::bytes_per_track(8 + 1);
    let per_target = size_of::<crate::tables::system_tracks::SystemEntry>() + 4 * per_sensor_track;
    // Maps, grid, deadlines and quality indices take a few words per entry.
    let rest = 5 * 128;
    assert!(per_target + rest <= 12 * 1024, "{per_target} bytes");
}
