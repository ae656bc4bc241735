//! Positions of all targets, at any time.

use frames::{SystemFrame, Vertical};
use settings::SettingsError;

use crate::path::Kinematics;
use crate::settings::ScenarioSettings;
use crate::target::{SimulatedTarget, TargetState};
use crate::traffic;

/// Heights below this count as on the ground, metres.
const GROUND_HEIGHT_M: f64 = 0.5;

/// Simulated truth: a function of time.
#[derive(Clone, Debug)]
pub struct Truth {
    targets: Vec<SimulatedTarget>,
    /// Frame of the positions; `None`: the Earth is flat.
    frame: Option<SystemFrame>,
}

impl Truth {
    /// Creates the traffic. The same settings and seed give the same traffic.
    ///
    /// # Errors
    /// An invalid setting.
    pub fn new(settings: &ScenarioSettings, seed: u64) -> Result<Self, SettingsError> {
        settings::check(settings)?;
        Ok(Self {
            targets: traffic::targets(settings, seed),
            frame: None,
        })
    }

    /// Returns the same traffic over the round Earth: path heights become heights above the ellipsoid, and
    /// positions are given in `frame`. Otherwise, the Earth is the plane.
    #[must_use]
    pub fn round(self, frame: SystemFrame) -> Self {
        Self {
            frame: Some(frame),
            ..self
        }
    }

    /// Returns the number of targets; target numbers range from 0 to this, exclusive.
    pub fn len(&self) -> usize {
        self.targets.len()
    }

    /// Whether there are no targets (false for all valid settings).
    pub fn is_empty(&self) -> bool {
        self.targets.is_empty()
    }

    /// Returns every target `time_s` seconds after the scenario's start, in the order of their numbers.
    pub fn at(&self, time_s: f64) -> impl ExactSizeIterator<Item = TargetState> + '_ {
        (0..self.targets.len()).map(move |index| self.target_at(index, time_s))
    }

    /// Returns target number `index` `time_s` seconds after the scenario's start.
    ///
    /// # Panics
    /// If the target does not exist.
    pub fn target_at(&self, index: usize, time_s: f64) -> TargetState {
        let target = &self.targets[index];
        let Kinematics {
            mut position_m,
            mut velocity_mps,
        } = target.route.at(time_s);
        let [x, y, height_m] = position_m;
        let [vx, vy, climb_mps] = velocity_mps;
        if let Some(frame) = &self.frame {
            let vertical = Vertical { height_m, climb_mps };
            [position_m[2], velocity_mps[2]] = frame.above([x, y], [vx, vy], vertical);
        }
        TargetState {
            id: index as u32,
            kind: target.kind,
            position_m,
            velocity_mps,
            address: target.address,
            callsign: target.callsign,
            mode_3a: target.mode_3a,
            height_m,
            on_ground: height_m < GROUND_HEIGHT_M,
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use messages::Callsign;

    use super::*;
    use crate::target::TargetKind;

    fn truth(seed: u64) -> Truth {
        Truth::new(&ScenarioSettings::default(), seed).expect("valid")
    }

    #[test]
    fn same_seed_same_truth_in_any_order() {
        let (a, b) = (truth(7), truth(7));
        let forward: Vec<Vec<TargetState>> = (0..50).map(|step| a.at(f64::from(step) * 77.7).collect()).collect();
        let mut backward: Vec<Vec<TargetState>> = (0..50)
            .rev()
            .map(|step| b.at(f64::from(step) * 77.7).collect())
            .collect();
        backward.reverse();
        assert_eq!(forward, backward);
        assert_ne!(forward[0], truth(8).at(0.0).collect::<Vec<_>>());
    }

    #[test]
    fn identities_are_unique() {
        let settings = ScenarioSettings {
            targets: 3000,
            ..ScenarioSettings::default()
        };
        let truth = Truth::new(&settings, 1).expect("valid");
        let states: Vec<TargetState> = truth.at(0.0).collect();
        let addresses: HashSet<u32> = states.iter().map(|state| state.address).collect();
        let callsigns: HashSet<Callsign> = states.iter().map(|state| state.callsign).collect();
        let codes: Vec<u16> = states.iter().filter_map(|state| state.mode_3a).collect();
        assert_eq!(addresses.len(), 3000);
        assert_eq!(callsigns.len(), 3000);
        assert_eq!(codes.iter().collect::<HashSet<_>>().len(), codes.len());
        assert!(addresses.iter().all(|address| *address < 1 << 24));
        assert!(codes.iter().all(|code| *code <= 0o7400 && *code > 0));
    }

    /// Continuity over hours: no target moves farther than its speed limit allows, and all stay in the area.
    #[test]
    fn continuous_and_within_limits() {
        for seed in [1, 2, 3] {
            let truth = truth(seed);
            for start_s in [0.0, 7_200.0, 86_400.0] {
                let mut before: Vec<TargetState> = truth.at(start_s).collect();
                for step in 1..4000 {
                    let dt = 0.5;
                    let now: Vec<TargetState> = truth.at(start_s + f64::from(step) * dt).collect();
                    for (a, b) in before.iter().zip(&now) {
                        check_step(a, b, dt);
                    }
                    before = now;
                }
            }
        }
    }

    #[test]
    fn over_the_round_earth_heights_are_those_of_the_ellipsoid() {
        let frame = SystemFrame::at(frames::Geodetic::from_degrees(41.3, 2.1, 0.0).unwrap());
        let wide = ScenarioSettings {
            half_width_m: 300_000.0,
            ..ScenarioSettings::default()
        };
        let flat = Truth::new(&wide, 3).expect("valid");
        let round = flat.clone().round(frame);
        let mut farthest_m = 0.0_f64;
        for (flat, round) in flat.at(500.0).zip(round.at(500.0)) {
            let [x, y, height_m] = flat.position_m;
            let [vx, vy, climb_mps] = flat.velocity_mps;
            assert_eq!(
                ([x, y], [vx, vy]),
                (first_two(round.position_m), first_two(round.velocity_mps))
            );
            let vertical = frame.vertical(round.position_m, round.velocity_mps);
            assert!((vertical.height_m - height_m).abs() < 0.01, "{vertical:?} {flat:?}");
            assert!((vertical.climb_mps - climb_mps).abs() < 0.001, "{vertical:?} {flat:?}");
            assert_eq!((round.height_m, round.on_ground), (height_m, flat.on_ground));
            farthest_m = farthest_m.max(x.hypot(y));
        }
        assert!(farthest_m > 200_000.0, "{farthest_m}");
    }

    fn first_two([x, y, _]: [f64; 3]) -> [f64; 2] {
        [x, y]
    }

    fn check_step(a: &TargetState, b: &TargetState, dt: f64) {
        let limit = b.kind.speed_max_mps();
        let moved = length(std::array::from_fn(|axis| b.position_m[axis] - a.position_m[axis]));
        assert!(moved <= limit * dt + 1e-6, "{a:?} {b:?}");
        assert!(length(b.velocity_mps) <= limit, "{b:?}");
        let change = length(std::array::from_fn(|axis| b.velocity_mps[axis] - a.velocity_mps[axis]));
        assert!(change <= 12.0 * dt, "more than 12 m/s²: {a:?} {b:?}");
        assert!(b.velocity_mps[2].abs() <= 30.0, "{b:?}");
        assert!(b.position_m[2] >= -1e-9 && b.position_m[2] <= 13_000.0, "{b:?}");
        let [x, y, _] = b.position_m;
        assert!(x.abs() <= 220_000.0 && y.abs() <= 220_000.0, "{b:?}");
    }

    proptest::proptest! {
        #![proptest_config(proptest::prelude::ProptestConfig::with_cases(64))]

        /// All draws of any seed and size give paths that can be flown within their limits.
        #[test]
        fn every_draw_can_be_flown(
            seed: u64, half_width_m in 40_000.0..400_000.0f64, surface in 0.0..0.4f64, start_s in 0.0..1e5f64,
        ) {
            let settings = ScenarioSettings {
                targets: 200,
                half_width_m,
                surface_share: surface,
                ship_share: 0.1,
                crossing_share: 1.0,
                ..ScenarioSettings::default()
            };
            let truth = Truth::new(&settings, seed).expect("valid");
            for step in 0..50 {
                for state in truth.at(start_s + f64::from(step) * 61.7) {
                    assert!(length(state.velocity_mps) <= state.kind.speed_max_mps(), "{state:?}");
                    assert!(state.velocity_mps[2].abs() <= 30.0, "{state:?}");
                    assert!((-1e-9..=13_000.0).contains(&state.position_m[2]), "{state:?}");
                }
            }
        }
    }

    fn length(v: [f64; 3]) -> f64 {
        v.iter().map(|c| c * c).sum::<f64>().sqrt()
    }

    #[test]
    fn traffic_is_mixed_and_paths_cross() {
        let truth = truth(1);
        let states: Vec<TargetState> = truth.at(0.0).collect();
        let count = |kind| states.iter().filter(|state| state.kind == kind).count();
        assert_eq!(states.len(), 80);
        assert_eq!(count(TargetKind::EnRoute), 40);
        assert_eq!(count(TargetKind::Terminal), 16);
        assert_eq!(count(TargetKind::Holding), 8);
        assert_eq!(count(TargetKind::Surface), 16);
        // Six pairs meet: within 400 m in the plane at some time of an hour and a half.
        let mut met = HashSet::new();
        let mut ground = HashSet::new();
        for step in 0..5400 {
            let now: Vec<TargetState> = truth.at(f64::from(step)).collect();
            let en_route: Vec<&TargetState> = now.iter().filter(|state| state.kind == TargetKind::EnRoute).collect();
            for pair in en_route.chunks_exact(2) {
                let [dx, dy] = [0, 1].map(|axis| pair[0].position_m[axis] - pair[1].position_m[axis]);
                if dx.hypot(dy) < 400.0 {
                    met.insert(pair[0].id);
                }
            }
            ground.extend(
                now.iter()
                    .filter(|s| s.on_ground && s.kind == TargetKind::Terminal)
                    .map(|s| s.id),
            );
        }
        assert!(met.len() >= 6, "{met:?}");
        assert_eq!(ground.len(), 16, "every circuit lands");
    }
}
