//! Targets in formation: side by side for a part of the path, well apart before and after.
//!
//! A formation follows a closed path, in and back, with the half turns of a racetrack at both ends. Each member has
//! a place in a line across the inbound direction, and keeps it in turns too, so that all members fly at the same
//! speed. Only the distance between neighbours changes: by half a cosine wave during joining and parting, so that
//! velocity has no step.

use std::f64::consts::{FRAC_PI_2, PI};

use rand::RngExt as _;

use crate::formation_settings::FormationSettings;
use crate::path::{ClosedPath, Waypoint};
use crate::random::{Purpose, stream};

/// Formation of targets.
#[derive(Clone, Debug)]
pub(crate) struct Formation {
    pub(crate) members: u32,
    pub(crate) path: ClosedPath,
    /// Time within the lap at time 0, seconds.
    pub(crate) lead_s: f64,
    /// Direction of the line, east and north, unit vector.
    across: [f64; 2],
    spacing: Spacing,
}

impl Formation {
    /// Draws formation number `index` of kind `kind`.
    pub(crate) fn draw(settings: &FormationSettings, seed: u64, kind: usize, index: u32) -> Self {
        let mut random = stream(seed, Purpose::Formation, 0, kind as u64, u64::from(index));
        let members = size(&settings.sizes, random.random_range(0.0..1.0));
        let [first, last] = settings.sector_rad;
        let place = (f64::from(index) + random.random_range(0.0..1.0)) / f64::from(settings.count);
        let bearing_rad = first + place * (last - first);
        let between = |[a, b]: [f64; 2], part: f64| a + part * (b - a);
        let speed_mps = between(settings.speed_mps, random.random_range(0.0..1.0));
        let (path, turn_s) = path(settings, bearing_rad, speed_mps);
        let lead: f64 = random.random_range(0.0..1.0);
        let lead_s = match settings.start_m {
            Some(start_m) => turn_s + (settings.way_m[0] - between(start_m, lead)) / speed_mps,
            None => lead * path.lap_s(),
        };
        let (sin, cos) = bearing_rad.sin_cos();
        let joined_s = turn_s + (settings.way_m[0] - settings.together_m[0]) / speed_mps;
        Self {
            members,
            lead_s,
            across: [cos, -sin],
            spacing: Spacing {
                together_m: settings.spacing_m,
                apart_m: settings.apart_m,
                joined_s,
                parts_s: joined_s + settings.together_s(speed_mps),
                joining_s: settings.joining_s(members),
                lap_s: path.lap_s(),
            },
            path,
        }
    }

    /// Returns the offset and relative velocity of member `member` with respect to the path, east and north, metres
    /// and m/s, at a time since a lap's start.
    pub(crate) fn beside(&self, member: u32, time_s: f64) -> ([f64; 2], [f64; 2]) {
        let place = f64::from(member) - 0.5 * f64::from(self.members.saturating_sub(1));
        let (spacing_m, rate_mps) = self.spacing.at(time_s);
        (
            self.across.map(|part| part * place * spacing_m),
            self.across.map(|part| part * place * rate_mps),
        )
    }
}

/// Distance between neighbours.
#[derive(Clone, Copy, Debug)]
struct Spacing {
    together_m: f64,
    apart_m: f64,
    /// Times in a lap of complete joining and of the start of parting, seconds; less than a lap apart.
    joined_s: f64,
    parts_s: f64,
    /// Duration of joining, and of parting.
    joining_s: f64,
    lap_s: f64,
}

impl Spacing {
    /// Returns the distance, metres, and its rate, metres per second.
    fn at(&self, time_s: f64) -> (f64, f64) {
        let since_joined_s = (time_s - self.joined_s).rem_euclid(self.lap_s);
        let since_parting_s = since_joined_s - (self.parts_s - self.joined_s);
        let until_joined_s = self.lap_s - since_joined_s;
        // Relative distance, 0 to 1, and its rate.
        let wave = |phase_s: f64, sign: f64| {
            let phase = PI * (phase_s / self.joining_s).min(1.0);
            (
                0.5 * (1.0 - phase.cos()),
                sign * 0.5 * PI / self.joining_s * phase.sin(),
            )
        };
        let (part, rate) = if since_parting_s <= 0.0 {
            (0.0, 0.0)
        } else if since_parting_s < until_joined_s {
            wave(since_parting_s, 1.0)
        } else {
            wave(until_joined_s, -1.0)
        };
        let change_m = self.apart_m - self.together_m;
        (self.together_m + part * change_m, rate * change_m)
    }
}

/// Returns the number of members for a random number from 0 to 1.
fn size(sizes: &[(u32, f64)], drawn: f64) -> u32 {
    let mut left = drawn;
    for (size, probability) in sizes {
        if left < *probability {
            return *size;
        }
        left -= probability;
    }
    // Rounding may leave a little.
    sizes
        .iter()
        .rev()
        .find(|(_, probability)| *probability > 0.0)
        .map_or(1, |(size, _)| *size)
}

/// Returns the path, inbound on the bearing itself and outbound to its right, and the duration of the lap's first
/// turn, after which the inbound leg begins.
fn path(settings: &FormationSettings, bearing_rad: f64, speed_mps: f64) -> (ClosedPath, f64) {
    let radius_m = FormationSettings::turn_radius_m(speed_mps);
    let ([far_m, near_m], descent_m) = (settings.way_m, settings.descent_m(speed_mps));
    let (high_m, low_m) = (settings.height_m, settings.low_m.unwrap_or(settings.height_m));
    let (sin, cos) = bearing_rad.sin_cos();
    let [east, north] = settings.position_m;
    let point = |away_m: f64, aside_m: f64, height_m: f64| Waypoint {
        position_m: [
            east + away_m * sin - aside_m * cos,
            north + away_m * cos + aside_m * sin,
        ],
        height_m,
        speed_mps,
        turn_radius_m: radius_m,
        stop_s: 0.0,
    };
    let (begin_m, end_m, back_m) = (far_m + radius_m, near_m - radius_m, 2.0 * radius_m);
    let corners = [
        Some(point(begin_m, 0.0, high_m)),
        (descent_m > 0.0).then(|| point(near_m + descent_m, 0.0, high_m)),
        Some(point(end_m, 0.0, low_m)),
        Some(point(end_m, back_m, low_m)),
        (descent_m > 0.0).then(|| point(far_m - descent_m, back_m, low_m)),
        Some(point(begin_m, back_m, high_m)),
    ];
    let corners: Vec<Waypoint> = corners.into_iter().flatten().collect();
    (ClosedPath::new(&corners), FRAC_PI_2 * radius_m / speed_mps)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::settings::ScenarioSettings;
    use crate::target::TargetKind;
    use crate::truth::Truth;

    fn world(formation: FormationSettings) -> ScenarioSettings {
        ScenarioSettings {
            targets: 0,
            formations: vec![formation],
            ..ScenarioSettings::default()
        }
    }

    fn apart_m(truth: &Truth, [one, other]: [usize; 2], time_s: f64) -> f64 {
        let [a, b] = [one, other].map(|index| truth.target_at(index, time_s).position_m);
        (a[0] - b[0]).hypot(a[1] - b[1])
    }

    /// Four from the north: 3 km apart far away, 200 m apart from 45 to 20 km, 3 km apart again, and the same in
    /// each lap.
    #[test]
    fn members_join_and_part_again() {
        let settings = world(FormationSettings {
            sizes: vec![(4, 1.0)],
            sector_rad: [0.0; 2],
            way_m: [80_000.0, 5000.0],
            start_m: Some([80_000.0; 2]),
            speed_mps: [200.0; 2],
            ..FormationSettings::default()
        });
        let truth = Truth::new(&settings, 1).expect("valid");
        assert_eq!(truth.len(), 4);
        let lap_s = settings.formations[0].lap_s(200.0);
        for start_s in [0.0, lap_s, 7.0 * lap_s] {
            for (away_m, expected_m) in [(79_000.0, 3000.0), (44_900.0, 200.0), (20_100.0, 200.0)] {
                let time_s = start_s + (80_000.0 - away_m) / 200.0;
                let middle = (0..4)
                    .map(|index| truth.target_at(index, time_s).position_m[1])
                    .sum::<f64>()
                    / 4.0;
                assert!((middle - away_m).abs() < 1e-3, "{middle}");
                for first in 0..3 {
                    let found_m = apart_m(&truth, [first, first + 1], time_s);
                    assert!((found_m - expected_m).abs() < 1e-3, "{away_m}: {found_m}");
                }
                assert!((apart_m(&truth, [0, 3], time_s) - 3.0 * expected_m).abs() < 1e-3);
            }
            let parted_s = start_s + 60_100.0 / 200.0 + settings.formations[0].joining_s(4);
            assert!((apart_m(&truth, [1, 2], parted_s) - 3000.0).abs() < 1e-3);
        }
        assert!(truth.at(0.0).all(|target| target.kind == TargetKind::Formation));
    }

    /// Formations descend below the sensors' coverage, all members at once.
    #[test]
    fn low_ones_vanish_together() {
        let settings = world(FormationSettings {
            height_m: 1000.0,
            low_m: Some(50.0),
            start_m: Some([40_000.0; 2]),
            ..FormationSettings::default()
        });
        let truth = Truth::new(&settings, 3).expect("valid");
        let heights = |time_s: f64| truth.at(time_s).map(|target| target.position_m[2]).collect::<Vec<_>>();
        assert!(heights(0.0).iter().all(|height_m| (height_m - 1000.0).abs() < 1e-9));
        assert!(heights(300.0).iter().all(|height_m| (height_m - 50.0).abs() < 1e-9));
        let lap_s = settings.formations[0].lap_s(150.0);
        let again = (0..lap_s as u32).any(|second| heights(300.0 + f64::from(second))[0] > 999.0);
        assert!(again, "they climb on the way back");
    }

    #[test]
    fn sizes_come_as_often_as_set_and_sectors_are_kept() {
        let settings = world(FormationSettings {
            count: 2000,
            sizes: vec![(2, 0.5), (3, 0.2), (4, 0.3)],
            sector_rad: [0.5, 1.5],
            start_m: Some([50_000.0, 30_000.0]),
            ..FormationSettings::default()
        });
        let mut counts = [0u32; 5];
        for formation in settings.drawn_formations(7) {
            counts[formation.members as usize] += 1;
            let [east, north, _] = formation.path.at(formation.lead_s).position_m;
            assert!((0.5..=1.5).contains(&east.atan2(north)), "{east} {north}");
            assert!((30_000.0..=50_000.0).contains(&east.hypot(north)));
        }
        for (size, probability) in [(2, 0.5f64), (3, 0.2), (4, 0.3)] {
            let (share, sigma) = (
                f64::from(counts[size]) / 2000.0,
                (probability * (1.0 - probability) / 2000.0).sqrt(),
            );
            assert!((share - probability).abs() < 4.0 * sigma, "{size}: {share}");
        }
        assert_eq!(
            settings.target_count(7) as usize,
            Truth::new(&settings, 7).expect("valid").len()
        );
    }

    /// Formations do not change the targets beside them.
    #[test]
    fn other_targets_fly_as_without_formations() {
        let (without, mut with) = (ScenarioSettings::default(), ScenarioSettings::default());
        with.formations.push(FormationSettings::default());
        let [without, with] = [without, with].map(|settings| Truth::new(&settings, 5).expect("valid"));
        let all: Vec<_> = with.at(77.0).collect();
        assert_eq!(without.at(77.0).collect::<Vec<_>>(), all[..80]);
        assert_eq!(all.len(), 82);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        /// All permitted settings can be flown: velocity is the slope of position, within the limit of its kind.
        #[test]
        fn every_draw_can_be_flown(
            seed: u64, size in 1..12u32, spacing_m in 1.0..2000.0f64, more_m in 0.0..8000.0f64, far_m in 40e3..200e3f64,
            from in 0.0..1.0f64, to in 0.0..1.0f64, height_m in 0.0..12e3f64, low in 0.0..1.0f64, start_s in 0.0..1e5f64,
        ) {
            let together_m = [from.max(to), from.min(to)].map(|part| 5e3 + part * (far_m - 5e3));
            let settings = world(FormationSettings {
                count: 3,
                sizes: vec![(size, 1.0)],
                spacing_m,
                apart_m: spacing_m + more_m,
                way_m: [far_m, 5e3],
                together_m,
                height_m,
                low_m: Some(low * height_m),
                ..FormationSettings::default()
            });
            prop_assume!(settings::check(&settings).is_ok());
            let truth = Truth::new(&settings, seed).expect("valid");
            for step in 0..40 {
                let time_s = start_s + f64::from(step) * 31.7;
                for index in 0..truth.len() {
                    let [before, now, after] = [-1e-2, 0.0, 1e-2].map(|by| truth.target_at(index, time_s + by));
                    let mut square = 0.0;
                    for axis in 0..3 {
                        let slope = (after.position_m[axis] - before.position_m[axis]) / 2e-2;
                        prop_assert!((slope - now.velocity_mps[axis]).abs() < 0.2, "{now:?} {slope}");
                        square += now.velocity_mps[axis].powi(2);
                    }
                    prop_assert!(square.sqrt() <= now.kind.speed_max_mps(), "{now:?}");
                }
            }
        }
    }
}
