//! Intervals, shares, errors and repeatability of simulated AIS.

use std::collections::BTreeMap;

use super::*;
use crate::settings::ScenarioSettings;

fn truth(speed_max_mps: f64) -> Truth {
    let settings = ScenarioSettings {
        targets: 200,
        ship_share: 1.0,
        ship_speed_max_mps: speed_max_mps,
        ..ScenarioSettings::without_others()
    };
    Truth::new(&settings, 3).expect("valid")
}

fn receivers(change: impl FnOnce(&mut AisSettings)) -> SimulatedAis {
    let mut settings = AisSettings {
        detection_probability: 1.0,
        range_max_m: 1e6,
        ..AisSettings::default()
    };
    change(&mut settings);
    SimulatedAis::new(&settings, 3, 5, 1_500_000_000 * NS_PER_S + 250_000_000).expect("valid")
}

fn heard(receivers: &mut SimulatedAis, truth: &Truth, seconds: usize) -> Vec<AisMessage> {
    let mut out = Vec::new();
    (0..seconds).for_each(|_| receivers.hear(truth, &mut out));
    out
}

#[test]
fn intervals_are_those_of_the_recommendation() {
    for (is_class_b, speed_kt, is_turning, expected) in [
        (false, 0.1, false, 180.0),
        (false, 14.0, false, 10.0),
        (false, 5.0, true, 10.0 / 3.0),
        (false, 20.0, false, 6.0),
        (false, 20.0, true, 2.0),
        (false, 30.0, false, 2.0),
        (true, 1.0, false, 180.0),
        (true, 20.0, true, 30.0),
    ] {
        assert_eq!(interval_s(is_class_b, speed_kt, is_turning), expected, "{speed_kt} kn");
    }
}

#[test]
fn ships_report_in_their_intervals_and_name_themselves() {
    let (truth, mut receivers) = (truth(7.0), receivers(|_| ()));
    assert_eq!((receivers.measured_s(), receivers.next_delivery_s()), (0.75, 1.25));
    let found = heard(&mut receivers, &truth, 720);
    let mut counts: BTreeMap<u32, (AisShip, u32, u32)> = BTreeMap::new();
    for message in &found {
        let (_, reports, statics) = counts.entry(message.ship.mmsi).or_insert((message.ship, 0, 0));
        *reports += u32::from(message.report.is_some());
        *statics += u32::from(message.report.is_none());
    }
    assert_eq!(counts.len(), 200);
    for (ship, reports, statics) in counts.values() {
        assert_eq!(*statics, 2, "{ship:?}");
        // At most 13.6 kn: every 10 s, more often in turns.
        let expected = if ship.is_class_b { 24..=24 } else { 72..=216 };
        assert!(expected.contains(reports), "{ship:?}: {reports}");
    }
    let share = |of: fn(&AisShip) -> bool| counts.values().filter(|(ship, ..)| of(ship)).count();
    assert!((25..=55).contains(&share(|ship| ship.is_class_b)));
    assert!((75..=125).contains(&share(|ship| ship.is_accurate)));
}

#[test]
fn messages_are_heard_by_receivers_in_range() {
    let truth = truth(12.0);
    let mut far = receivers(|settings| settings.range_max_m = 20_000.0);
    let count = heard(&mut far, &truth, 60).len();
    let mut two = receivers(|settings| {
        settings.range_max_m = 20_000.0;
        settings.stations_m = vec![[0.0; 3]; 2];
    });
    let twice = heard(&mut two, &truth, 60);
    assert_eq!(twice.len(), 2 * count);
    assert!(
        twice
            .chunks(2)
            .all(|pair| (pair[0].ship, pair[0].report) == (pair[1].ship, pair[1].report))
    );
    let mut seldom = receivers(|settings| settings.detection_probability = 0.5);
    let all = heard(&mut receivers(|_| ()), &truth, 300).len() as f64;
    let share = heard(&mut seldom, &truth, 300).len() as f64 / all;
    assert!((0.45..0.55).contains(&share), "{share}");
    assert!(heard(&mut receivers(|settings| settings.equipped_share = 0.0), &truth, 60).is_empty());
}

#[test]
fn errors_are_as_stated() {
    for error_time_s in [0.0, 60.0] {
        let [place, velocity] = errors(error_time_s);
        // Errors of one ship last: 100 ships over seven nodes.
        assert!(
            (place - 1.0).abs() < if error_time_s > 0.0 { 0.15 } else { 0.05 },
            "{place}"
        );
        assert!((velocity - 1.0).abs() < 0.05, "{velocity}");
    }
}

/// Mean normalised squares of the errors of places and velocities.
fn errors(error_time_s: f64) -> [f64; 2] {
    let (truth, mut receivers) = (truth(12.0), receivers(|settings| settings.error_time_s = error_time_s));
    let mut sums = [0.0; 3];
    for _ in 0..400 {
        let time_s = receivers.measured_s();
        let mut out = Vec::new();
        receivers.hear(&truth, &mut out);
        for message in out {
            let (ship, Some(report)) = (message.ship, message.report) else {
                continue;
            };
            let target = truth.target_at(ship.id as usize, time_s);
            let course = course_rad(&target);
            let [bow, stern, port, starboard] = ship.distances_m.map(f64::from);
            let [ahead, right] = [(bow - stern) / 2.0, (starboard - port) / 2.0];
            let centre_m = [
                report.position_m[0] + ahead * course.sin() + right * course.cos(),
                report.position_m[1] + ahead * course.cos() - right * course.sin(),
            ];
            let [place, velocity, count] = &mut sums;
            let sigma_m = RADIUS95_M[usize::from(ship.is_accurate)] / RADIUS95_SIGMAS;
            *place += (0..2)
                .map(|axis| ((centre_m[axis] - target.position_m[axis]) / sigma_m).powi(2))
                .sum::<f64>()
                / 2.0;
            let [east, north] = [0, 1].map(|axis| report.velocity_mps[axis] - target.velocity_mps[axis]);
            let along = east * course.sin() + north * course.cos();
            let across = east * course.cos() - north * course.sin();
            let sigmas = velocity_sigmas_mps(speed_mps(&target));
            *velocity += ((along / sigmas[0]).powi(2) + (across / sigmas[1]).powi(2)) / 2.0;
            *count += 1.0;
        }
    }
    [sums[0] / sums[2], sums[1] / sums[2]]
}

#[test]
fn restarted_receivers_hear_the_same() {
    let truth = truth(12.0);
    let mut through = receivers(|settings| settings.detection_probability = 0.7);
    let mut restarted = through.clone();
    heard(&mut through, &truth, 50);
    restarted.restart_at(through.next_delivery_s() - 0.1);
    assert_eq!(restarted.second(), through.second());
    assert_eq!(heard(&mut restarted, &truth, 20), heard(&mut through, &truth, 20));
}

#[test]
fn receivers_need_places() {
    for stations_m in [Vec::new(), vec![[0.0; 3]; 65], vec![[f64::NAN, 0.0, 0.0]]] {
        let settings = AisSettings {
            stations_m,
            ..AisSettings::default()
        };
        let refused = SimulatedAis::new(&settings, 1, 0, 0).expect_err("unusable").to_string();
        assert!(refused.starts_with("stations_m"), "{refused}");
    }
}
