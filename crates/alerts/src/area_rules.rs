//! Rules about a target and an area: `enter` and `leave` (now, or predicted), and `stay`.
//!
//! Whether a target is inside now follows from its distance to the border and its height, in standard deviations. What
//! is ahead follows from a part of its [`futures`](crate::futures): each goes along its way in steps as long as its
//! distance from the border, so that no border is jumped over.

use areas::VerticalLimits;

use crate::areas_of::NamedArea;
use crate::board::Finding;
use crate::futures::{Draws, Future, Side};
use crate::target::Target;

use messages::alert_value_bits;

/// Futures of a target that are compared with an area.
const COMPARED: usize = 32;
/// Least time between two points of a future, seconds.
const STEP_MIN_S: f64 = 1.0;

/// Probability that a target is inside an area now, and its distance from the border, metres; `None` if it is far away.
pub(crate) fn inside(target: &Target, area: &NamedArea, reach_m: f64) -> Option<(f64, f64)> {
    let sigma_m = (0.5f64.sqrt() * target.place_sigma_m()).max(0.1);
    let distance_m = area.distance_m(target.place_m, reach_m + 6.0 * sigma_m)?;
    Some((
        normal(-distance_m / sigma_m) * within(target, &area.area.limits),
        distance_m,
    ))
}

/// Probability that the height of a target is between the limits; 1 of a target without a height.
fn within(target: &Target, limits: &VerticalLimits) -> f64 {
    let share = |level: Option<areas::Level>, sign: f64| match level.and_then(|level| target.above(level)) {
        Some((above_m, sigma_m)) => normal(sign * above_m / sigma_m.max(0.1)),
        None => 1.0,
    };
    share(limits.floor, 1.0) * share(limits.ceiling, -1.0)
}

/// Judges whether a target is in an area (`wanted`), or out of it, now or within a time.
pub(crate) fn crossing(
    target: &Target,
    area: &NamedArea,
    wanted: bool,
    (look_ahead_s, vertical_s): (f64, f64),
    draws: &Draws,
) -> Option<Finding> {
    let reach_m = (target.speed_mps() + 4.0 * target.velocity_sigma_mps()) * look_ahead_s;
    let near = inside(target, area, reach_m);
    let (inside_now, distance_m) = match (near, wanted) {
        (Some(found), _) => found,
        (None, true) => return None,
        (None, false) => (0.0, f64::INFINITY),
    };
    let now = if wanted { inside_now } else { 1.0 - inside_now };
    let mut finding = Finding {
        probability: now,
        distance_m: distance_m.clamp(-1e9, 1e9),
        valid: alert_value_bits::DISTANCE,
        ..Finding::default()
    };
    if now < 0.5 && look_ahead_s > 0.0 {
        let futures = draws.futures(Side::One, target, vertical_s).take(COMPARED);
        let times: Vec<f64> = futures
            .filter_map(|future| first_time_s(&future, target, area, wanted, look_ahead_s))
            .collect();
        let ahead = times.len() as f64 / COMPARED as f64;
        if ahead > now {
            finding.probability = ahead;
            finding.time_to_s = times.iter().sum::<f64>() / times.len() as f64;
            finding.valid |= alert_value_bits::PREDICTED;
        }
    }
    Some(finding)
}

/// First time at which a future is in the area (`wanted`), or out of it.
fn first_time_s(future: &Future, target: &Target, area: &NamedArea, wanted: bool, until_s: f64) -> Option<f64> {
    let speed_mps = future.speed_mps().max(1e-3);
    let start_m = target.height.map(|height| height.height_m);
    let mut time_s = 0.0;
    while time_s <= until_s {
        let distance_m = area.area.outline.distance_m(future.place_m(time_s));
        let is_inside = distance_m < 0.0 && {
            // The state's height by every reference, moved by the future's climb.
            let moved_m = start_m.map_or(0.0, |start_m| future.height_m(time_s) - start_m);
            let beyond = |level: Option<areas::Level>, sign: f64| {
                level
                    .and_then(|level| target.above(level))
                    .is_some_and(|(above_m, _)| sign * (above_m + moved_m) < 0.0)
            };
            !beyond(area.area.limits.floor, 1.0) && !beyond(area.area.limits.ceiling, -1.0)
        };
        if is_inside == wanted {
            return Some(time_s);
        }
        // On the way to the other side, the distance from the border; beyond it the height is all that is missing.
        let step_s = match (distance_m < 0.0) == wanted {
            true => STEP_MIN_S,
            false => (distance_m.abs() / speed_mps).max(STEP_MIN_S),
        };
        time_s += step_s;
    }
    None
}

/// Probability that a standard normal value is below `x`: Abramowitz and Stegun, 26.2.17, to 8e-8.
pub(crate) fn normal(x: f64) -> f64 {
    let t = 1.0 / (1.0 + 0.231_641_9 * x.abs());
    let series = [
        0.319_381_530,
        -0.356_563_782,
        1.781_477_937,
        -1.821_255_978,
        1.330_274_429,
    ];
    let tail = series.iter().rev().fold(0.0, |sum, factor| (sum + factor) * t);
    let density = (-0.5 * x * x).exp() / (2.0 * std::f64::consts::PI).sqrt();
    if x > 0.0 { 1.0 - density * tail } else { density * tail }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::areas_of::named_areas;
    use crate::futures::tests::{frame, state};
    use crate::settings::{AreaSettings, CircleSettings};

    fn zone(floor: Option<&str>) -> NamedArea {
        let circle = AreaSettings {
            name: "zone".to_owned(),
            circle: Some(CircleSettings {
                latitude_deg: 46.0,
                longitude_deg: 7.0,
                radius_nm: 5.0,
            }),
            floor: floor.map(str::to_owned),
            ..AreaSettings::default()
        };
        named_areas(&[circle], &areas::Ground::of(frame()), &|_| unreachable!())
            .unwrap()
            .remove(0)
    }

    fn target(position_m: [f64; 3], velocity_mps: [f64; 3]) -> Target {
        Target::of(&state(1, position_m, velocity_mps, [20.0, 1.0]), &frame()).unwrap()
    }

    #[test]
    fn the_normal_distribution_is_that_of_the_tables() {
        for (x, expected) in [(0.0, 0.5), (1.0, 0.841_344_7), (-2.0, 0.022_750_1), (6.0, 1.0)] {
            assert!((normal(x) - expected).abs() < 1e-6, "{x}: {}", normal(x));
        }
    }

    #[test]
    fn three_standard_deviations_outside_is_outside() {
        let draws = Draws::new();
        let at = |x: f64| {
            crossing(
                &target([x, 0.0, 3_000.0], [0.0, 100.0, 0.0]),
                &zone(None),
                true,
                (0.0, 0.0),
                &draws,
            )
        };
        // The border lies 9,260 m from the centre on the ground, and standard deviations are 20 m.
        assert!(at(9_330.0).unwrap().probability < 0.01);
        assert!(at(9_200.0).unwrap().probability > 0.99);
        assert!(at(9_600.0).is_none());
    }

    #[test]
    fn a_way_through_the_area_is_predicted_with_its_time() {
        let draws = Draws::new();
        let towards = target([-20_000.0, 0.0, 3_000.0], [100.0, 0.0, 0.0]);
        let found = crossing(&towards, &zone(None), true, (180.0, 60.0), &draws).unwrap();
        assert!(
            found.probability > 0.95 && (found.time_to_s - 107.4).abs() < 2.0,
            "{found:?}"
        );
        assert!(
            crossing(&towards, &zone(None), true, (60.0, 60.0), &draws).is_none_or(|found| found.probability < 0.1)
        );
        // Below the floor, and climbing to it after 100 s, inside the area by then.
        let climbing = target([-8_000.0, 0.0, 2_000.0], [50.0, 0.0, 5.0]);
        let above = zone(Some("2500 m"));
        let found = crossing(&climbing, &above, true, (180.0, 180.0), &draws).unwrap();
        assert!(
            found.probability > 0.9 && (found.time_to_s - 100.0).abs() < 15.0,
            "{found:?}"
        );
        let short = crossing(&climbing, &above, true, (180.0, 30.0), &draws);
        assert!(short.is_none_or(|found| found.probability < 0.1), "{short:?}");
    }

    #[test]
    fn leaving_is_the_other_way_round() {
        let draws = Draws::new();
        let leaving = target([8_000.0, 0.0, 3_000.0], [100.0, 0.0, 0.0]);
        let found = crossing(&leaving, &zone(None), false, (60.0, 0.0), &draws).unwrap();
        assert!(
            found.probability > 0.95 && (found.time_to_s - 12.6).abs() < 2.0,
            "{found:?}"
        );
        let far = crossing(
            &target([90_000.0, 0.0, 3_000.0], [0.0; 3]),
            &zone(None),
            false,
            (0.0, 0.0),
            &draws,
        );
        assert_eq!(far.unwrap().probability, 1.0);
    }
}
