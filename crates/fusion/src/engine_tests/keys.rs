//! Keys that no other test sets, each with a value that changes the outcome.

use super::*;
use crate::settings::{AssociationSettings, CorrectionTable, GateProbability};
use ::settings::Degrees;
use messages::{Bias, BiasKind, Registration, registration_bits};

/// Fusion of two sources under which nothing is learned of them.
fn harness(change: impl FnOnce(&mut AssociationSettings)) -> Harness {
    let mut settings = test_settings(2);
    settings.consistency = false;
    settings.registration.enabled = false;
    change(&mut settings.association);
    Harness::new(settings)
}

/// Number of system tracks after one report of each source. The report of the second lies `aside_m` to the north and
/// states a speed `faster_mps` higher.
fn live_of_two(aside_m: f64, faster_mps: f64, change: impl FnOnce(&mut AssociationSettings)) -> usize {
    let mut harness = harness(change);
    harness.take(&report(0, 1, 0.0, [0.0, 0.0], [20.0, 0.0]));
    let mut second = report(1, 1, 0.0, [0.0, aside_m], [20.0, 0.0]);
    second.velocity_mps[0] += faster_mps;
    harness.take(&second);
    harness.live()
}

#[test]
fn the_probability_of_joining_sets_the_gate_in_the_plane() {
    // Sigma of the difference: 14 m.
    let live = |probability| {
        live_of_two(30.0, 0.0, |keys| {
            keys.join_probability = GateProbability::of(probability)
        })
    };
    assert_eq!((live(0.999), live(0.5)), (1, 2));
}

#[test]
fn the_probability_of_velocities_widens_the_gate_of_position_and_velocity() {
    // Sigma of the difference: 2.8 m/s.
    let live = |probability| {
        live_of_two(0.0, 15.0, |keys| {
            keys.velocity_probability = GateProbability::of(probability)
        })
    };
    assert_eq!((live(1.0 - 1e-9), live(0.5)), (1, 2));
}

#[test]
fn errors_in_common_make_a_difference_count_more() {
    let live = |correlation| live_of_two(40.0, 0.0, |keys| keys.error_correlation = correlation);
    assert_eq!((live(0.0), live(0.9)), (1, 2));
}

/// Number of reports of the second source after its track has left the target until it is taken out, if it is.
fn reports_until_split(change: impl FnOnce(&mut AssociationSettings)) -> Option<u32> {
    let mut harness = harness(change);
    for scan in 0..60 {
        let aside_m = if scan < 10 { 0.0 } else { 300.0 };
        let time_s = f64::from(scan);
        harness.take(&report(0, 1, time_s, [0.0, 0.0], [20.0, 0.0]));
        harness.take(&report(1, 1, time_s + 0.3, [0.0, aside_m], [20.0, 0.0]));
        if harness.count(Counter::ContributionsSplit) > 0 {
            return Some(scan - 9);
        }
    }
    None
}

#[test]
fn a_track_stays_as_long_as_its_gate_and_its_reports_permit() {
    let usual = reports_until_split(|_| ()).unwrap();
    let patient = reports_until_split(|keys| keys.split_reports += 7).unwrap();
    assert_eq!(patient, usual + 7);
    assert_eq!(reports_until_split(|keys| keys.keep_gate = 1e6), None);
}

/// Number of merged tracks after two tracks of one source each have come together.
fn merged(change: impl FnOnce(&mut AssociationSettings)) -> u64 {
    let mut harness = harness(change);
    for scan in 0..100 {
        let time_s = f64::from(scan);
        let away_m = (3_000.0 - 60.0 * time_s).max(0.0);
        harness.take(&report(0, 1, time_s, [0.0, 0.0], [20.0, 0.0]));
        let mut moving = report(1, 1, time_s + 0.3, [0.0, away_m], [20.0, 0.0]);
        moving.velocity_mps[1] -= if away_m > 0.0 { 60.0 } else { 0.0 };
        harness.take(&moving);
    }
    harness.count(Counter::TracksMerged)
}

#[test]
fn tracks_merge_after_as_many_reports_as_the_key_states() {
    assert!(merged(|_| ()) > 0);
    assert_eq!(merged(|keys| keys.merge_reports = 1_000_000), 0);
}

#[test]
fn recency_weighs_the_earlier_reports_of_a_sensor_track() {
    let accuracies = |recency| {
        let mut settings = test_settings(2);
        settings.rule.name.0 = messages::FusionRule::InverseTrace;
        settings.rule.recency = recency;
        settings.rule.accuracy_values = Some(true);
        let mut harness = Harness::new(settings);
        for scan in 0..20 {
            for source in 0..2 {
                let aside_m = 8.0 * f64::from((scan * 7 + source) % 3 - 1);
                let time_s = f64::from(scan) + 0.3 * f64::from(source);
                harness.take(&report(source as u16, 1, time_s, [0.0, aside_m], [20.0, 0.0]));
            }
        }
        let accuracy = |state: &SystemTrack| {
            let parts = state.contributions().iter();
            parts.map(|part| part.accuracy.to_bits()).collect::<Vec<_>>()
        };
        harness.published.iter().map(accuracy).collect::<Vec<_>>()
    };
    assert_ne!(accuracies(1.0), accuracies(0.1));
}

#[test]
fn known_biases_are_subtracted_from_every_report() {
    let place_m = [-20e3, 5e3];
    let correction = CorrectionTable {
        azimuth_deg: Degrees::of(2.0),
        range_m: 400.0,
        time_s: 3.0,
        east_m: 900.0,
        north_m: -600.0,
        up_m: 50.0,
    };
    let mut settings = test_settings(2);
    settings.registration.enabled = false;
    settings.sources[1].correction = Some(correction);
    let refused = settings.check().unwrap_err().to_string();
    assert!(
        refused.contains("correction") && refused.contains("position of the sensor"),
        "{refused}"
    );
    settings.sources[1].place_m = Some(place_m);
    settings.check().unwrap();
    let mut harness = Harness::new(settings);
    for scan in 0..10 {
        let time_s = 20.0 + f64::from(scan);
        harness.take(&report(0, 1, time_s, [10e3, 8e3], [100.0, 0.0]));
        let [x, y] = [10e3 + 100.0 * time_s, 8e3];
        // The same target by a sensor that is 3 s late in its time, too long in range, turned and shifted.
        let (dx, dy) = (x - place_m[0], y - place_m[1]);
        let longer = 1.0 + 400.0 / dx.hypot(dy);
        let (sin, cos) = 2f64.to_radians().sin_cos();
        let turned = [dx * cos + dy * sin, dy * cos - dx * sin].map(|part| part * longer);
        let seen = [place_m[0] + turned[0] + 900.0, place_m[1] + turned[1] - 600.0];
        let mut late = report(1, 7, time_s + 3.0, seen, [100.0 * cos, -100.0 * sin]);
        late.position_m = [seen[0], seen[1], late.position_m[2] + 50.0];
        let published = &mut harness.published;
        let now_ns = (time_s * S as f64) as i64;
        harness
            .engine
            .take_at(&late, now_ns, &mut |track: &SystemTrack| published.push(*track));
    }
    assert_eq!(harness.live(), 1, "both sources see one target");
    let shown = harness.published.last().unwrap();
    let expected = [10e3 + 100.0 * shown.reference_time_ns as f64 / S as f64, 8e3];
    let apart = [0, 1].map(|axis| shown.position_m[axis] - expected[axis]);
    assert!(apart[0].hypot(apart[1]) < 0.5, "{apart:?}");
}

#[test]
fn estimated_biases_are_written_as_lines_of_the_configuration() {
    let mut known = Registration {
        offset_m: [12.34, -0.04, 7.0],
        azimuth_bias_rad: 0.5f64.to_radians(),
        time_offset_s: 0.25,
        removed: registration_bits::EAST | registration_bits::NORTH | registration_bits::AZIMUTH,
        ..Registration::default()
    };
    let configured = CorrectionTable {
        azimuth_deg: Degrees::of(-0.2),
        up_m: 3.0,
        ..CorrectionTable::default()
    };
    let lines = configured.with_estimated(&known).lines();
    assert_eq!(lines, ["azimuth_deg = 0.300", "east_m = 12.3", "up_m = 3.0"]);
    known.set_gross_error(
        Some(Bias {
            kind: BiasKind::Range,
            value: [400.0, 0.0],
            partner: 1,
            is_certain: true,
            is_removed: true,
        }),
        None,
    );
    let lines = configured.with_estimated(&known).lines();
    assert_eq!(lines[1], "range_m = 400.0");
    assert!(
        CorrectionTable::default()
            .with_estimated(&Registration::default())
            .lines()
            .is_empty()
    );
}
