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
/// Time to notice a turn with 1 m/s², seconds, shorter for harder turns by the root of the acceleration; and the least
/// time.
const UNNOTICED_S: f64 = 15.0;
const UNNOTICED_MIN_S: f64 = 6.0;
/// Time to notice a change of the rate of climb, and mean time between such changes, seconds.
const CLIMB_UNNOTICED_S: f64 = 7.0;
const CLIMB_STEADY_S: f64 = 80.0;

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

    /// Variance per axis of a velocity caused by turns not yet detected, m²/s².
    pub fn unnoticed_m2ps2(&self) -> f64 {
        // A turn is noticed after a time u, when the way a·u²/2 is beyond the noise. A fraction u of the time between
        // turns is spent so; meanwhile the velocity is off by 0 to a·u, on the mean square a²·u²/3 over two axes.
        let lateral_mps2 = self.lateral_mps2[0];
        let unnoticed_s = (UNNOTICED_S / lateral_mps2.sqrt()).max(UNNOTICED_MIN_S);
        let change_mps = lateral_mps2 * unnoticed_s;
        change_mps * change_mps * unnoticed_s / (6.0 * self.steady_s)
    }

    /// Variance of a rate of climb caused by changes not yet detected, m²/s².
    pub fn unnoticed_climb_m2ps2(&self) -> f64 {
        let share = CLIMB_UNNOTICED_S / CLIMB_STEADY_S;
        // White noise of this density lasts for half of that time at most; on average half of the noise is unnoticed.
        0.25 * share * CLIMB_UNNOTICED_S * self.climb_change_m2ps3
    }
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
    fn turns_that_nobody_has_noticed_matter_as_often_as_they_are() {
        // 4 m/s² for 7.5 s: 30 m/s; 30² · 7.5 / (6 · 225) = 5.
        assert!((motion(225.0, 4.0).unnoticed_m2ps2() - 5.0).abs() < 1e-9);
        assert!((motion(450.0, 4.0).unnoticed_m2ps2() - 2.5).abs() < 1e-9);
        // 16 m/s² for 6 s, the least: 96 m/s.
        assert!((motion(225.0, 16.0).unnoticed_m2ps2() - 96.0 * 96.0 / 225.0).abs() < 1e-9);
        // 7 of 80 s; in half of that time, the variance becomes 3.5 · 5 m²/s²; half of that variance on average.
        assert!((motion(225.0, 4.0).unnoticed_climb_m2ps2() - 0.5 * 7.0 / 80.0 * 17.5).abs() < 1e-9);
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
