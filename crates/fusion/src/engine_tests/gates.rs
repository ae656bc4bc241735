//! Limits of association and of life, each tried from both sides.

use super::*;

/// Settings under which nothing is learned of the sources.
fn unlearned(sources: usize) -> Settings {
    let mut settings = test_settings(sources);
    settings.consistency = false;
    settings.registration.enabled = false;
    settings
}

/// Number of system tracks after ten reports of two sources, the second `apart_m` to the north and `higher_m` higher.
fn live_of_two(apart_m: f64, higher_m: f64) -> usize {
    let mut harness = Harness::new(unlearned(2));
    for step in 0..10 {
        for source in 0..2 {
            let place = [0.0, apart_m * f64::from(source)];
            let mut report = report(
                source as u16,
                1,
                f64::from(step) + 0.3 * f64::from(source),
                place,
                [20.0, 0.0],
            );
            report.valid |= sensor_track_bits::HEIGHT;
            report.position_m[2] = 5_000.0 + higher_m * f64::from(source);
            report.covariance = Covariance::diagonal([10.0, 10.0, 1_000.0], [2.0; 3]);
            harness.take(&report);
        }
    }
    harness.live()
}

#[test]
fn tracks_join_inside_the_gate_in_the_plane_and_not_beyond() {
    // Sigma of the difference: 14 m. The gate is 3.7 sigma; equal velocities would allow more.
    assert_eq!(live_of_two(20.0, 0.0), 1);
    assert_eq!(live_of_two(64.0, 0.0), 2);
}

#[test]
fn tracks_join_inside_the_gate_of_height_and_not_beyond() {
    // Sigma of the difference: 1,400 m. Only the fixed gate of 600 m keeps the two apart.
    assert_eq!(live_of_two(20.0, 550.0), 1);
    assert_eq!(live_of_two(20.0, 650.0), 2);
}

#[test]
fn a_duplicate_is_merged_inside_the_gate_and_not_beyond() {
    // A track that two sources see comes alongside a track that two other sources see.
    let live = |aside: f64| {
        let mut harness = Harness::new(unlearned(4));
        for step in 0..120 {
            let time_s = f64::from(step);
            let away = (3_000.0 - 60.0 * time_s).max(0.0);
            for source in [0, 2] {
                let mut moving = report(source, 1, time_s + 0.1 * f64::from(source), [0.0, 0.0], [20.0, 0.0]);
                moving.position_m[0] -= away;
                moving.velocity_mps[0] += if away > 0.0 { 60.0 } else { 0.0 };
                harness.take(&moving);
            }
            for source in [1, 3] {
                harness.take(&report(
                    source,
                    1,
                    time_s + 0.1 * f64::from(source),
                    [0.0, aside],
                    [20.0, 0.0],
                ));
            }
        }
        harness.live()
    };
    assert_eq!(live(21.0), 1);
    assert_eq!(live(60.0), 2);
}

#[test]
fn a_track_that_its_source_does_not_believe_has_no_accuracy_value() {
    for (state, is_scored) in [(TrackState::Confirmed, true), (TrackState::Tentative, false)] {
        let mut settings = test_settings(2);
        settings.rule.name.0 = messages::FusionRule::Auto;
        settings.rule.accuracy_values = Some(true);
        let (mut harness, mut noise) = (Harness::new(settings), random(3));
        for step in 0..20 {
            let time_s = f64::from(step);
            let place = [20.0 * noise(), 20.0 * noise()];
            harness.take(&report(0, 1, time_s, place, [20.0, 0.0]));
            let mut second = report(1, 1, time_s + 0.5, [0.0; 2], [20.0, 0.0]);
            second.state = state as u8;
            harness.take(&second);
        }
        let track = harness.published.last().unwrap();
        let accuracies: Vec<bool> = track
            .contributions()
            .iter()
            .map(|part| part.accuracy.is_finite())
            .collect();
        assert_eq!(accuracies, [true, is_scored], "{state:?}");
    }
}

#[test]
fn covariances_that_claim_too_much_are_scaled_before_they_weigh() {
    let weights = |consistency: bool| {
        let mut settings = unlearned(2);
        settings.consistency = consistency;
        settings.rule.name.0 = messages::FusionRule::InverseTrace;
        let (mut harness, mut noise) = (Harness::new(settings), random(11));
        let mut last = None;
        for step in 0..300 {
            let time_s = f64::from(step);
            let mut place = |sigma_m: f64| [0, 1].map(|_| 3.5 * sigma_m * noise());
            for target in 1..=5u32 {
                let aside = 5_000.0 * f64::from(target);
                let [east, north] = place(10.0);
                harness.take(&report(0, target, time_s, [east, north + aside], [20.0, 0.0]));
                // Sigma of 40 m, stated as 8 m.
                let [east, north] = place(40.0);
                let mut boastful = report(1, target, time_s + 0.5, [east, north + aside], [20.0, 0.0]);
                boastful.covariance = Covariance::diagonal([8.0, 8.0, 100.0], [2.0; 3]);
                last = harness.take(&boastful).or(last);
            }
        }
        let track = last.unwrap();
        assert_eq!(sources_of(&track), [0, 1]);
        [0, 1].map(|place| track.contributions()[place].weight)
    };
    let [honest, boastful] = weights(false);
    assert!(boastful > honest, "as stated: {honest} {boastful}");
    let [honest, boastful] = weights(true);
    assert!(honest > 2.0 * boastful, "as shown: {honest} {boastful}");
}

#[test]
fn a_target_is_gone_when_several_sources_miss_it_and_not_when_one_does() {
    let state_after = |misses: &[u16]| {
        let mut settings = unlearned(3);
        settings.existence.gone = -12.0;
        let mut harness = Harness::new(settings);
        let report = |source: u16, time_s: f64| report(source, 1, time_s, [0.0; 2], [20.0, 0.0]);
        for step in 0..20 {
            for source in 0..3 {
                harness.take(&report(source, f64::from(step) + 0.1 * f64::from(source)));
            }
        }
        // The sources' own tracks go on without a detection.
        for (step, source) in (1..).zip(misses) {
            let mut missed = report(*source, 19.3 + 0.1 * f64::from(step));
            missed.state = TrackState::Coasted as u8;
            harness.take(&missed);
        }
        let [confirmed, tentative] =
            [TrackState::Confirmed, TrackState::Tentative].map(|state| harness.engine.count_in_state(state));
        (confirmed, tentative)
    };
    assert_eq!(state_after(&[]), (1, 0));
    assert_eq!(
        state_after(&[0; 12]),
        (1, 0),
        "only the first two misses in a row of a source count"
    );
    assert_eq!(state_after(&[0, 1, 2, 0, 1, 2]), (0, 1));
}
