//! What cannot be is refused or repaired, and counted; nobody else notices.

use messages::{Counter, SystemTrack};

use super::{Harness, report, with_address};
use crate::testing::test_settings;

#[test]
fn bad_reports_are_counted_and_change_nothing() {
    let mut harness = Harness::new(test_settings(1));
    harness.take(&report(0, 1, 1.0, [0.0, 0.0], [0.0, 0.0]));
    let good = report(0, 1, 2.0, [0.0, 0.0], [0.0, 0.0]);
    let mut bad = [good; 6];
    bad[0].position_m[1] = f64::NAN;
    bad[1].covariance.set(0, 0, -1.0);
    bad[2].state = 9;
    bad[3].source = 5;
    bad[4].position_m[0] = 1e12;
    bad[5].covariance.set(1, 1, 1e300);
    for report in &bad {
        assert_eq!(harness.take(report), None);
    }
    assert_eq!(harness.count(Counter::RejectedInvalid), 6);
    assert_eq!(harness.take(&report(0, 1, 0.5, [0.0, 0.0], [0.0, 0.0])), None);
    assert_eq!(harness.count(Counter::RejectedOutOfOrder), 1);
}

/// What is published of the tracks that start in the west, while `disturb` does its worst in the east.
fn picture_of_the_west(disturb: impl Fn(&mut Harness, u32)) -> (String, Harness) {
    let mut settings = test_settings(2);
    settings.rule.name.0 = messages::FusionRule::Auto;
    let mut harness = Harness::new(settings);
    for step in 0..40 {
        let time_s = 0.5 * f64::from(step);
        for source in 0..2 {
            let noise = 3.0 * f64::from((step * 7 + u32::from(source) * 3) % 5) - 6.0;
            let place = [-2e4 + noise, 0.0];
            harness.take(&report(
                source,
                1,
                time_s + 0.1 * f64::from(source),
                place,
                [50.0, 10.0],
            ));
        }
        disturb(&mut harness, step);
    }
    let west = |track: &&SystemTrack| track.position_m[0] < 0.0;
    let picture = harness
        .published
        .iter()
        .filter(west)
        .map(|track| format!("{:?} {:?} {:?}", track.position_m, track.velocity_mps, track.covariance))
        .collect();
    (picture, harness)
}

#[test]
fn bad_input_does_not_change_other_targets_by_one_bit() {
    let east = |step: u32, offset_s: f64| report(0, 9, 0.5 * f64::from(step) + 0.3 + offset_s, [2e4, 0.0], [0.0, 0.0]);
    let (calm, _) = picture_of_the_west(|harness, step| {
        harness.take(&east(step, 0.0));
    });
    assert!(!calm.is_empty());
    type Disturbance<'a> = (&'a str, Counter, Box<dyn Fn(&mut Harness, u32) + 'a>);
    let disturbances: [Disturbance<'_>; 5] = [
        (
            "not a number",
            Counter::RejectedInvalid,
            Box::new(|harness, step| {
                harness.take(&east(step, 0.0));
                let mut bad = east(step, 0.05);
                bad.position_m[1] = f64::NAN;
                harness.take(&bad);
            }),
        ),
        (
            "time backwards",
            Counter::RejectedOutOfOrder,
            Box::new(|harness, step| {
                harness.take(&east(step, 0.0));
                harness.take(&east(step, -0.2));
            }),
        ),
        (
            "repeated",
            Counter::RejectedOutOfOrder,
            Box::new(|harness, step| {
                harness.take(&east(step, 0.0));
                harness.take(&east(step, 0.0));
            }),
        ),
        (
            "not positive definite",
            Counter::CovariancesRepaired,
            Box::new(|harness, step| {
                let mut bad = east(step, 0.0);
                bad.covariance.set(0, 1, 500.0);
                harness.take(&bad);
            }),
        ),
        (
            "another target's address",
            Counter::IdentityConflicts,
            Box::new(|harness, step| {
                harness.take(&with_address(east(step, 0.0), 0x123));
                harness.take(&with_address(
                    report(0, 8, 0.5 * f64::from(step) + 0.3, [4e4, 0.0], [0.0, 0.0]),
                    0x123,
                ));
            }),
        ),
    ];
    for (what, counter, disturb) in disturbances {
        let (picture, harness) = picture_of_the_west(disturb);
        assert_eq!(picture, calm, "{what}");
        assert!(harness.count(counter) > 0, "{what} is counted");
    }
}

#[test]
fn ten_times_more_tracks_than_there_is_room_for_are_counted_and_the_others_stay() {
    let (calm, _) = picture_of_the_west(|_, _| {});
    let (full, harness) = picture_of_the_west(|harness, step| {
        for number in 0..50 {
            let number = 100 + 50 * step + number;
            harness.take(&report(
                0,
                number,
                0.5 * f64::from(step) + 0.3,
                [1e4 + 1e3 * f64::from(number), 0.0],
                [0.0, 0.0],
            ));
        }
    });
    assert!(harness.count(Counter::DroppedTable) > 0);
    assert_eq!(full, calm);
}
