//! Motion model of a class of targets, as the filter assumes it.

use estimation::NearlyConstantVelocity;
use kept::kept;
use serde::{Deserialize, Serialize};

/// Number of assumed lateral accelerations of turns.
pub const LEVELS: usize = 4;
/// Process noise of steady motion, relative to the noise of turns: of fast targets, and of slow targets (aircraft on
/// the ground, vessels, vehicles) with continual small changes of speed.
const STEADY: f64 = 4e-4;
const STEADY_SLOW: f64 = 2.4e-3;
/// Speed below which the rate of a turn no longer rises, m/s; identifies slow targets.
const SLOW_MPS: f64 = 10.0;
/// The same of agile motion along the course and across.
const AGILE: [f64; 2] = [0.6, 0.12];
/// Process noise of a turn relative to the square of its acceleration, over up to 1 s, s.
const UNEVEN_S: f64 = 0.1;
/// Mean duration of manoeuvres, seconds.
pub const MANOEUVRE_S: f64 = 15.0;
/// Way beyond the straight course that shows a manoeuvre, in standard deviations of the estimated position. The filter
/// needs this way, because manoeuvres are rare and each measurement is noisier than the estimate.
const NOTICED_SIGMAS: f64 = 13.0;
/// Square of the acceleration of a change of the climb rate, relative to the noise of such changes, 1/s.
const CLIMB_ACCELERATION_PER_S: f64 = 0.5;
/// Mean time between changes of the climb rate, and duration of a change, seconds.
const CLIMB_STEADY_S: f64 = 80.0;
const CLIMB_CHANGE_S: f64 = 7.0;

kept! {
    /// Model of how the targets of a class move.
    #[derive(Clone, Copy, Debug, Serialize, Deserialize)]
    pub struct Motion {
        /// Process noise of turns.
        pub turns: NearlyConstantVelocity,
        /// Mean time of straight flight before a turn, s.
        pub steady_s: f64,
        /// Share of the manoeuvres other than turns.
        pub agile_share: f64,
        /// Lateral accelerations of turns, m/s²: the usual one, less, more, and the hardest of the class.
        pub lateral_mps2: [f64; LEVELS],
        /// Speed below which the rate of a turn no longer rises, m/s.
        pub slow_mps: f64,
        /// White noise of changes of the rate of climb, m²/s³.
        pub climb_change_m2ps3: f64,
    }
}

impl Motion {
    /// White noise of steady motion, m²/s³.
    #[inline]
    pub fn steady_m2ps3(&self) -> f64 {
        let steady = if self.slow_mps < SLOW_MPS { STEADY_SLOW } else { STEADY };
        steady * self.turns.density_m2ps3[0]
    }

    /// White noise of agile motion over so many seconds, along the course and across, m²/s³.
    #[inline]
    pub fn agile_m2ps3(&self, seconds: f64) -> [f64; 2] {
        let [along, across] = AGILE.map(|factor| factor * self.turns.density_m2ps3[0]);
        [along, across + Self::turn_m2ps3(self.lateral_mps2[0], seconds)]
    }

    /// White noise of a turn with this lateral acceleration over so many seconds, m²/s³.
    #[inline]
    pub fn turn_m2ps3(lateral_mps2: f64, seconds: f64) -> f64 {
        // The acceleration lies anywhere between the accelerations of the models, and over long times the turn begins
        // or ends. This deviation is an unknown constant, equivalent to white noise in proportion to the time.
        UNEVEN_S * lateral_mps2 * lateral_mps2 * seconds.max(1.0)
    }

    /// Logarithms of the lateral accelerations relative to the usual one.
    pub fn hardness(&self) -> [f64; LEVELS] {
        self.lateral_mps2
            .map(|lateral_mps2| (lateral_mps2 / self.lateral_mps2[0]).ln())
    }

    /// Lateral accelerations around a usual one, m/s².
    pub fn levels(usual_mps2: f64, hardest_mps2: f64) -> [f64; LEVELS] {
        [
            usual_mps2,
            0.5 * usual_mps2,
            (usual_mps2 * hardest_mps2).sqrt(),
            hardest_mps2,
        ]
    }

    /// Variance per axis of a velocity caused by turns not yet detected, m²/s², of a target whose position is estimated
    /// with `variance_m2` per axis.
    #[inline]
    pub fn unnoticed_m2ps2(&self, variance_m2: f64) -> f64 {
        // The square is that of two axes.
        sum_of_squares((self.lateral_mps2[0], MANOEUVRE_S), variance_m2) / (2.0 * self.steady_s)
    }

    /// Variance of a rate of climb caused by changes not yet detected, m²/s², of a target whose height is estimated
    /// with `variance_m2`.
    #[inline]
    pub fn unnoticed_climb_m2ps2(&self, variance_m2: f64) -> f64 {
        let acceleration_mps2 = (CLIMB_ACCELERATION_PER_S * self.climb_change_m2ps3).sqrt();
        sum_of_squares((acceleration_mps2, CLIMB_CHANGE_S), variance_m2) / CLIMB_STEADY_S
    }
}

/// Squared error of a velocity from the begin of a manoeuvre, of this acceleration and duration, until a filter with
/// this variance of the position notices it, summed over the time, m²/s.
#[inline]
fn sum_of_squares((acceleration_mps2, duration_s): (f64, f64), variance_m2: f64) -> f64 {
    // A manoeuvre is noticed after a time u, when the way a·u²/2 is large enough; until then the velocity is off by 0
    // to a·u. The sum of the squares is a²·u³/3, with a·u² = w and u = √(w / a).
    let shown_m = 2.0 * NOTICED_SIGMAS * variance_m2.sqrt();
    let twice_way_m = shown_m.min(acceleration_mps2 * duration_s * duration_s);
    twice_way_m * (acceleration_mps2 * twice_way_m).sqrt() / 3.0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn motion(steady_s: f64, lateral_mps2: f64) -> Motion {
        Motion {
            turns: NearlyConstantVelocity::new(50.0, 50.0),
            steady_s,
            agile_share: 0.4,
            lateral_mps2: Motion::levels(lateral_mps2, 36.0),
            slow_mps: 20.0,
            climb_change_m2ps3: 5.0,
        }
    }

    #[test]
    fn manoeuvres_that_nobody_has_noticed_matter_by_rate_strength_and_accuracy() {
        let close = |found: f64, expected: f64| assert!((found - expected).abs() < 1e-9, "{found} {expected}");
        // A way of 2·13·10 m, 65 m/s² · u²: u = 2 s, 65² · 2³ / (3 · 2 · 225).
        close(motion(225.0, 65.0).unnoticed_m2ps2(100.0), 65.0 * 65.0 * 8.0 / 1350.0);
        close(motion(450.0, 65.0).unnoticed_m2ps2(100.0), 65.0 * 65.0 * 8.0 / 2700.0);
        // Four times the way takes twice the time.
        close(motion(225.0, 65.0).unnoticed_m2ps2(1600.0), 65.0 * 65.0 * 64.0 / 1350.0);
        // A turn ends, noticed or not: 4 m/s² for 15 s.
        close(motion(225.0, 4.0).unnoticed_m2ps2(1e8), 16.0 * 3375.0 / 1350.0);
        // √2.5 m/s²; 26 m in √(26 / √2.5) s; one axis, each 80 s.
        let (square, seconds) = (2.5f64, (26.0 / 2.5f64.sqrt()).sqrt());
        close(
            motion(225.0, 4.0).unnoticed_climb_m2ps2(1.0),
            square * seconds.powi(3) / 240.0,
        );
        close(motion(225.0, 4.0).unnoticed_climb_m2ps2(1e6), square * 343.0 / 240.0);
    }

    #[test]
    fn lateral_accelerations_lie_around_the_usual_one_up_to_the_hardest() {
        let motion = motion(200.0, 9.0);
        assert_eq!(motion.lateral_mps2, [9.0, 4.5, 18.0, 36.0]);
        let [usual, less, more, hardest] = motion.hardness();
        assert_eq!(usual, 0.0);
        assert!((less + more).abs() < 1e-12 && (hardest - 2.0 * more).abs() < 1e-12 && more > 0.69);
        // White over short times, an unknown constant over long ones.
        assert_eq!(Motion::turn_m2ps3(9.0, 0.5), Motion::turn_m2ps3(9.0, 1.0));
        assert_eq!(Motion::turn_m2ps3(9.0, 12.0), 12.0 * Motion::turn_m2ps3(9.0, 1.0));
    }
}
