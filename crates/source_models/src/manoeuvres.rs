//! Strength and frequency of manoeuvres, per class of targets, learned from innovations.
//!
//! A target with the usual turn rate of its kind has an acceleration in proportion to its speed. Therefore slow targets
//! (vessels, vehicles, taxiing aircraft) and fast targets (aircraft) are separate classes. Each class begins with the
//! assumption of the sources' own trackers, if visible. A tracker with a single model compromises between straight
//! flight and turns, so real manoeuvres are harder. Otherwise the class begins with the default.
//!
//! Then four figures are learned:
//!
//! - *how long targets fly straight*, from the beginnings of certain manoeuvres;
//! - *the usual lateral acceleration of turns*. During certain manoeuvres, turns of several accelerations compete in
//!   the filter. The usual acceleration moves towards the probable accelerations;
//! - *the share of manoeuvres other than turns*, from the probability of the agile model;
//! - *the noise of agile motion*. While the agile model certainly holds, its innovations should be as large, relative
//!   to their covariances, as innovations of the steady model on straight legs. Because both are compared with each
//!   other, wrong covariances of sources do not matter. Medians are compared, so wrong associations have no influence.

use estimation::NearlyConstantVelocity;
use kept::kept;
use serde::{Deserialize, Serialize};

use crate::innovation::{FilterInnovation, Fit, Manoeuvre};
use crate::motion::{LEVELS, Motion};
use crate::seeker::Seeker;
use crate::source_model::CHI2_MEDIAN_2;

/// Classes of targets: slow and fast.
pub(crate) const CLASSES: usize = 2;
/// Speed from which on a target is fast, metres per second.
const FAST_MPS: f64 = 30.0;
/// Least process noise that a tracker with a single model should assume for fast targets, m²/s³.
const FAST_M2PS3: f64 = 20.0;
/// Process noise of turns relative to the assumption of a tracker with a single model, and logarithms of the search
/// limits, relative to that assumption.
const TURNING: f64 = 2.5;
const LEAST: f64 = -1.5;
const MOST: f64 = 0.7;
/// Factor from the process noise of turns to the square of the usual acceleration, s.
const LATERAL_S: f64 = 0.5;
/// Limits of the logarithm of the usual acceleration, relative to the assumed acceleration.
const LATERAL_LEAST: f64 = -2.5;
const LATERAL_MOST: f64 = 1.5;
/// Hardest acceleration of turns of slow and of fast targets, m/s².
const HARDEST_MPS2: [f64; CLASSES] = [8.0, 36.0];
/// Speeds of both below which the rate of turns no longer rises, m/s.
const SLOW_MPS: [f64; CLASSES] = [3.0, 20.0];
/// Share of the manoeuvres other than turns: prior, and limits.
const AGILE: f64 = 0.4;
const AGILE_MIN: f64 = 0.1;
const AGILE_MAX: f64 = 0.8;
/// Process noise of changes of the rate of climb relative to that of turns assumed, and the least, m²/s³.
const CLIMB_CHANGE: f64 = 0.2;
const CLIMB_CHANGE_MIN_M2PS3: f64 = 1.0;
/// Worth of the assumptions, in measurements during manoeuvres, and number of measurements after which older values
/// fade.
const ASSUMED: f64 = 8.0;
const REMEMBERED: f64 = 300.0;
/// Prior mean time of straight flight, s, with the worth of so many observed turns.
const STEADY_S: f64 = 200.0;
const TURNS: f64 = 4.0;
/// Number of turns beyond which older turns count half.
const TURNS_MAX: f64 = 1000.0;
/// Limits of the mean time of straight flight, s.
const STEADY_MIN_S: f64 = 50.0;
const STEADY_MAX_S: f64 = 1000.0;
/// Speed from which on a target moves, metres per second.
const MOVING_MPS: f64 = 3.0;
/// Relative step of the median of innovations on the straight.
const STEP: f64 = 0.02;

kept! {
    /// One class of targets.
    #[derive(Clone, Copy, Debug, Serialize, Deserialize)]
    pub(crate) struct Class {
        /// Process noise assumed by a tracker with a single model.
        assumed: NearlyConstantVelocity,
        /// Factor on the noise of turns.
        factor: Seeker,
        motion: Motion,
        /// Total time of straight flight before turns, s, and number of turns.
        straight_s: f64,
        turns: f64,
        /// Median of the normalised innovations squared on the straight.
        straight: f64,
        /// Logarithm of the usual acceleration of turns, relative to the assumed acceleration, and the hardest
        /// acceleration, m/s².
        lateral: f64,
        hardest_mps2: f64,
        /// Number of measurements in manoeuvres.
        seen: f64,
    }
}

impl Class {
    fn new((density_m2ps3, hardest_mps2, slow_mps): (f64, f64, f64)) -> Self {
        let assumed = NearlyConstantVelocity::new(density_m2ps3, density_m2ps3);
        let mut class = Self {
            assumed,
            factor: Seeker::default(),
            motion: Motion {
                turns: assumed,
                steady_s: STEADY_S,
                agile_share: AGILE,
                lateral_mps2: [0.0; LEVELS],
                slow_mps,
                climb_change_m2ps3: 0.0,
            },
            straight_s: STEADY_S * TURNS,
            turns: TURNS,
            straight: CHI2_MEDIAN_2,
            lateral: 0.0,
            hardest_mps2,
            seen: 0.0,
        };
        class.update();
        class
    }

    fn update(&mut self) {
        let factor = TURNING * self.factor.logarithm().exp();
        self.motion.turns.density_m2ps3 = self.assumed.density_m2ps3.map(|density| density * factor);
        let assumed_mps2 = (LATERAL_S * TURNING * self.assumed.density_m2ps3[0]).sqrt();
        let usual_mps2 = (assumed_mps2 * self.lateral.exp()).min(0.5 * self.hardest_mps2);
        self.motion.lateral_mps2 = Motion::levels(usual_mps2, self.hardest_mps2);
        let climb_m2ps3 = CLIMB_CHANGE * TURNING * self.assumed.density_m2ps3[0];
        self.motion.climb_change_m2ps3 = climb_m2ps3.max(CLIMB_CHANGE_MIN_M2PS3);
    }

    /// Learns from a certain manoeuvre of a target.
    fn learn_manoeuvre(&mut self, manoeuvre: &Manoeuvre) {
        let gain = 1.0 / (ASSUMED + self.seen);
        self.seen = (self.seen + 1.0).min(REMEMBERED);
        let share = manoeuvre.agile / (manoeuvre.agile + manoeuvre.turn);
        let agile = &mut self.motion.agile_share;
        *agile = (*agile + gain * (share - *agile)).clamp(AGILE_MIN, AGILE_MAX);
        self.lateral = (self.lateral + gain * manoeuvre.hardness).clamp(LATERAL_LEAST, LATERAL_MOST);
        self.update();
    }
}

/// Knowledge of all classes.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct Manoeuvres {
    classes: [Class; CLASSES],
}

impl Manoeuvres {
    /// Assumption without knowledge: `density_m2ps3`, for fast targets at least [`FAST_M2PS3`].
    pub(crate) fn new(density_m2ps3: f64) -> Self {
        Self {
            classes: std::array::from_fn(|class| {
                let density_m2ps3 = [density_m2ps3, density_m2ps3.max(FAST_M2PS3)][class];
                Class::new((density_m2ps3, HARDEST_MPS2[class], SLOW_MPS[class]))
            }),
        }
    }

    /// All classes, for checkpoints.
    pub(crate) fn classes_mut(&mut self) -> &mut [Class; CLASSES] {
        &mut self.classes
    }

    /// Motion of a target that flies at `velocity_mps`.
    #[inline]
    pub(crate) fn motion(&self, velocity_mps: [f64; 3]) -> &Motion {
        &self.classes[class_of(velocity_mps)].motion
    }

    /// Sets the common process noise assumed by the sources' own trackers for all targets.
    pub(crate) fn assume(&mut self, noise: NearlyConstantVelocity) {
        for class in self.classes.iter_mut().filter(|class| class.assumed != noise) {
            class.assumed = noise;
            class.update();
        }
    }

    /// Learns from the innovation of a measurement of a target at `velocity_mps`.
    pub(crate) fn learn(&mut self, velocity_mps: [f64; 3], innovation: &FilterInnovation) {
        let class = &mut self.classes[class_of(velocity_mps)];
        let [east, north, _] = velocity_mps;
        // Standing targets show nothing of turns.
        if east * east + north * north > MOVING_MPS * MOVING_MPS {
            class.straight_s += innovation.straight_s;
        }
        class.turns += f64::from(u8::from(innovation.begins_turn));
        if class.turns > TURNS_MAX {
            (class.straight_s, class.turns) = (0.5 * class.straight_s, 0.5 * class.turns);
        }
        class.motion.steady_s = (class.straight_s / class.turns).clamp(STEADY_MIN_S, STEADY_MAX_S);
        if let Some(manoeuvre) = &innovation.manoeuvre {
            class.learn_manoeuvre(manoeuvre);
        }
        match innovation.fit {
            Fit::Straight(squared) => class.straight *= 1.0 + f64::copysign(STEP, squared - class.straight),
            Fit::Turning(squared) => {
                class.factor.step(squared - class.straight, LEAST, MOST);
                class.update();
            }
            Fit::Undecided => {}
        }
    }
}

fn class_of([east, north, _]: [f64; 3]) -> usize {
    usize::from(east * east + north * north > FAST_MPS * FAST_MPS)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::innovation;

    const FAST: [f64; 3] = [100.0, 0.0, 0.0];

    /// The noise of turns of fast targets with these medians of innovations on the straight and in turns.
    fn learned(straight: f64, turning: f64) -> f64 {
        let mut manoeuvres = Manoeuvres::new(1.0);
        let mut random = test_support::Random::new(1);
        for _ in 0..1000 {
            let about = random.between(0.2, 1.8);
            manoeuvres.learn(FAST, &innovation(Fit::Straight(straight * about)));
            manoeuvres.learn(FAST, &innovation(Fit::Turning(turning * random.between(0.2, 1.8))));
        }
        assert_eq!(
            manoeuvres.motion([10.0; 3]).turns.density_m2ps3,
            [TURNING; 3],
            "slow targets are others"
        );
        manoeuvres.motion(FAST).turns.density_m2ps3[0]
    }

    #[test]
    fn harder_turns_than_assumed_are_learned_of_whatever_the_sources_claim() {
        let assumed = TURNING * FAST_M2PS3;
        for claim in [0.25, 1.0, 4.0] {
            let found = [1.0, 4.0, 0.25].map(|turning| learned(claim, claim * turning) / assumed);
            assert!((0.5..1.7).contains(&found[0]), "{found:?}");
            assert!(found[1] > 1.9 && found[2] < 0.3, "{found:?}");
        }
    }

    #[test]
    fn usual_turns_and_the_share_of_other_manoeuvres_are_learned() {
        let mut manoeuvres = Manoeuvres::new(1.0);
        let usual_mps2 = |manoeuvres: &Manoeuvres| manoeuvres.motion(FAST).lateral_mps2[0];
        let assumed_mps2 = usual_mps2(&manoeuvres);
        let mut observe = |agile: f64, hardness: f64| {
            for _ in 0..200 {
                let manoeuvre = Some(Manoeuvre {
                    agile,
                    turn: 0.9 - agile,
                    hardness,
                });
                let innovation = FilterInnovation {
                    manoeuvre,
                    ..innovation(Fit::Undecided)
                };
                manoeuvres.learn(FAST, &innovation);
            }
            (
                usual_mps2(&manoeuvres) / assumed_mps2,
                manoeuvres.motion(FAST).agile_share,
            )
        };
        let (factor, share) = observe(0.09, 0.3);
        assert!(
            (2.0..4.0).contains(&factor) && (0.1..0.15).contains(&share),
            "{factor} {share}"
        );
        let (_, share) = observe(0.8, 0.0);
        assert!(share > 0.4, "{share}");
        for _ in 0..20 {
            observe(0.0, 1.0);
        }
        let hardest_mps2 = HARDEST_MPS2[1];
        assert!(usual_mps2(&manoeuvres) <= 0.5 * hardest_mps2);
        assert_eq!(manoeuvres.motion(FAST).lateral_mps2[3], hardest_mps2);
        assert!(
            manoeuvres.motion([1.0; 3]).lateral_mps2[0] < assumed_mps2,
            "slow targets are others"
        );
    }

    #[test]
    fn how_long_targets_fly_straight_is_learned_and_followed() {
        let mut manoeuvres = Manoeuvres::new(1.0);
        let mut fly = |velocity_mps: [f64; 3], straight_s: f64, turns: usize| {
            for flight in 0..40 * turns {
                let innovation = FilterInnovation {
                    straight_s: straight_s / 40.0,
                    begins_turn: flight % 40 == 39,
                    ..innovation(Fit::Undecided)
                };
                manoeuvres.learn(velocity_mps, &innovation);
            }
            manoeuvres.motion(FAST).steady_s
        };
        assert_eq!(fly([0.0; 3], 600.0, 0), STEADY_S, "nothing was seen");
        let airway_s = fly(FAST, 600.0, 100);
        assert!((airway_s - 600.0).abs() < 30.0, "{airway_s}");
        let airport_s = fly(FAST, 80.0, 3000);
        assert!((airport_s - 80.0).abs() < 30.0, "{airport_s}");
        assert_eq!(fly(FAST, 1.0, 5000), STEADY_MIN_S);
        assert_eq!(
            fly([1.0, 0.0, 0.0], 600.0, 100),
            STEADY_MIN_S,
            "those that stand are others"
        );
    }
}
