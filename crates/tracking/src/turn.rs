//! Coordinated turns: a turning target continues the turn (HT-13).
//!
//! With manoeuvres modelled as strong acceleration noise, a turning target may go anywhere at each scan; the filter
//! lags behind on the outside of the curve. Vehicles instead turn at a nearly constant rate with constant speed. The
//! turn rate ω is unknown; so the manoeuvring model estimates ω as a seventh component of the state, beside position
//! and velocity. A pair of models with fixed rates to the left and to the right would need a third Gaussian per track,
//! and fits only these rates.
//!
//! The state moves on a circle, a nonlinear function of ω; covariances follow the tangent of this function (extended
//! Kalman filter). The first six components stay a [`Gaussian`] as in all other models; this module holds the rest: ω,
//! the variance of ω, and the covariance with the six. Measurements do not depend on ω; updates reach ω through this
//! covariance.
//!
//! Limits: turns are in the plane. The tangent is good for turns of up to about a radian between two detections.
//!
//! Source: Y. Bar-Shalom, X. R. Li, T. Kirubarajan, *Estimation with Applications to Tracking and Navigation* (Wiley,
//! 2001), section 11.7.

use estimation::Gaussian;
use kept::kept;
use messages::STATE_LEN;

/// Below this angle, radians, series stand for quotients of small numbers.
const SMALL_RAD: f64 = 1e-4;
const TURN: usize = STATE_LEN;
const WITH_TURN: usize = STATE_LEN + 1;

settings::settings! {
    /// Assumptions on turn rates.
    #[derive(Copy)]
    pub struct TurnSettings {
        /// Standard deviation of the rate of a turn that begins.
        rate_sigma_radps: f64, in [1e-6, 10];
        /// Spectral density of the changes of the rate.
        rate_noise_rad2ps3: f64, in [1e-15, 10];
    }
}

kept! {
    /// Turn rate of a target. Single precision suffices for an estimate with errors above a thousandth.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub(crate) struct TurnRate {
        /// Counter-clockwise, rad/s.
        pub(crate) rate: f32,
        variance: f32,
        /// Covariance with position and velocity.
        cross: [f32; STATE_LEN],
    }
}

impl TurnRate {
    /// Rate of targets that do not turn.
    pub(crate) const NONE: Self = Self {
        rate: 0.0,
        variance: 0.0,
        cross: [0.0; STATE_LEN],
    };

    /// Rate of a turn that has just begun.
    pub(crate) fn begun(turn: &TurnSettings) -> Self {
        Self {
            variance: turn.rate_sigma_radps.powi(2) as f32,
            ..Self::NONE
        }
    }

    /// Moves a state on the circle, without the noise of accelerations.
    pub(crate) fn turn(&mut self, state: &mut Gaussian, seconds: f64, turn: &TurnSettings) {
        let (rate, t) = (f64::from(self.rate), seconds);
        let [vx, vy] = [state.mean[3], state.mean[4]];
        let [along, across, along_by_rate, across_by_rate] = arcs(rate, t);
        let (sin, cos) = (rate * t).sin_cos();
        let mut jacobian = [[0.0; WITH_TURN]; WITH_TURN];
        for (place, row) in jacobian.iter_mut().enumerate() {
            row[place] = 1.0;
        }
        jacobian[0][3..5].copy_from_slice(&[along, -across]);
        jacobian[1][3..5].copy_from_slice(&[across, along]);
        jacobian[2][5] = t;
        jacobian[3][3..5].copy_from_slice(&[cos, -sin]);
        jacobian[4][3..5].copy_from_slice(&[sin, cos]);
        jacobian[0][TURN] = along_by_rate * vx - across_by_rate * vy;
        jacobian[1][TURN] = across_by_rate * vx + along_by_rate * vy;
        jacobian[3][TURN] = t * (-sin * vx - cos * vy);
        jacobian[4][TURN] = t * (cos * vx - sin * vy);
        state.mean[0] += along * vx - across * vy;
        state.mean[1] += across * vx + along * vy;
        state.mean[2] += t * state.mean[5];
        state.mean[3] = cos * vx - sin * vy;
        state.mean[4] = sin * vx + cos * vy;
        let before = self.joint(state);
        let mut half = [[0.0; WITH_TURN]; WITH_TURN];
        for row in 0..WITH_TURN {
            for column in 0..WITH_TURN {
                half[row][column] = (0..WITH_TURN).map(|k| jacobian[row][k] * before[k][column]).sum();
            }
        }
        let after = |row: usize, column: usize| (0..WITH_TURN).map(|k| half[row][k] * jacobian[column][k]).sum::<f64>();
        for row in 0..STATE_LEN {
            for column in row..STATE_LEN {
                state.covariance.set(row, column, after(row, column));
            }
            self.cross[row] = after(row, TURN) as f32;
        }
        let noise = turn.rate_noise_rad2ps3 * t.abs();
        self.variance = (after(TURN, TURN) + noise) as f32;
    }

    /// Applies an update of the state: `whitened` and `gain` are L⁻¹·ν and L⁻¹·H·P, `gain_of_turn` is L⁻¹·H·c with
    /// the covariance c of [`Self::cross`] (see [`crate::measurement`]).
    pub(crate) fn learn(&mut self, whitened: &[f64], gain: &[[f64; STATE_LEN]], gain_of_turn: &[f64]) {
        for ((whitened, gain), of_turn) in whitened.iter().zip(gain).zip(gain_of_turn) {
            self.rate += (of_turn * whitened) as f32;
            self.variance = (f64::from(self.variance) - of_turn * of_turn).max(0.0) as f32;
            for (cross, gain) in self.cross.iter_mut().zip(gain) {
                *cross -= (of_turn * gain) as f32;
            }
        }
    }

    pub(crate) fn cross(&self) -> [f64; STATE_LEN] {
        self.cross.map(f64::from)
    }

    /// Rate of a mixture of two states with turn rates.
    pub(crate) fn mixture(
        (a, a_state): (&Self, &Gaussian),
        (b, b_state): (&Self, &Gaussian),
        weight_of_b: f64,
    ) -> Self {
        let [p, q] = [1.0 - weight_of_b, weight_of_b];
        let weighted = |of_a: f32, of_b: f32| p * f64::from(of_a) + q * f64::from(of_b);
        let apart = f64::from(a.rate) - f64::from(b.rate);
        let cross = |row: usize| {
            let spread = p * q * apart * (a_state.mean[row] - b_state.mean[row]);
            (weighted(a.cross[row], b.cross[row]) + spread) as f32
        };
        Self {
            rate: weighted(a.rate, b.rate) as f32,
            variance: (weighted(a.variance, b.variance) + p * q * apart * apart) as f32,
            cross: std::array::from_fn(cross),
        }
    }

    fn joint(&self, state: &Gaussian) -> [[f64; WITH_TURN]; WITH_TURN] {
        std::array::from_fn(|row| {
            std::array::from_fn(|column| match (row, column) {
                (TURN, TURN) => f64::from(self.variance),
                (TURN, other) | (other, TURN) => f64::from(self.cross[other]),
                _ => state.covariance.get(row.min(column), row.max(column)),
            })
        })
    }
}

/// sin(ωt)/ω, (1 − cos(ωt))/ω, and the derivatives of both by ω.
fn arcs(rate: f64, t: f64) -> [f64; 4] {
    let angle = rate * t;
    if angle.abs() < SMALL_RAD {
        return [t, 0.5 * angle * t, -angle * t * t / 3.0, 0.5 * t * t];
    }
    let (sin, cos) = angle.sin_cos();
    let (along, across) = (sin / rate, (1.0 - cos) / rate);
    [along, across, (t * cos - along) / rate, (t * sin - across) / rate]
}

#[cfg(test)]
mod tests {
    use messages::Covariance;

    use super::*;

    const TURN_SETTINGS: TurnSettings = TurnSettings {
        rate_sigma_radps: 0.1,
        rate_noise_rad2ps3: 1e-4,
    };

    fn state() -> Gaussian {
        Gaussian {
            mean: [10.0, 20.0, 30.0, 50.0, -20.0, 1.0],
            covariance: Covariance::diagonal([10.0, 12.0, 14.0], [3.0, 4.0, 5.0]),
        }
    }

    fn turned(rate: f32, seconds: f64) -> (Gaussian, TurnRate) {
        let mut turn = TurnRate {
            rate,
            ..TurnRate::begun(&TURN_SETTINGS)
        };
        let mut moved = state();
        turn.turn(&mut moved, seconds, &TURN_SETTINGS);
        (moved, turn)
    }

    #[test]
    fn a_quarter_of_a_circle() {
        let rate = std::f32::consts::FRAC_PI_2 / 10.0;
        let (moved, turn) = turned(rate, 10.0);
        let radius = 1.0 / f64::from(rate);
        let expected = [10.0 + radius * 70.0, 20.0 + radius * 30.0, 40.0, 20.0, 50.0, 1.0];
        for (found, expected) in moved.mean.iter().zip(expected) {
            assert!((found - expected).abs() < 1e-4, "{:?} {expected:?}", moved.mean);
        }
        assert_eq!(turn.rate, rate);
        assert!(estimation::is_usable(&moved.covariance));
        let speed = moved.mean[3].hypot(moved.mean[4]);
        assert!((speed - 50f64.hypot(20.0)).abs() < 1e-9, "nothing is lost in a turn");
    }

    #[test]
    fn without_a_turn_it_is_straight() {
        let (moved, _) = turned(0.0, 3.0);
        let (nearly, _) = turned(1e-7, 3.0);
        for (row, expected) in [160.0, -40.0, 33.0, 50.0, -20.0, 1.0].into_iter().enumerate() {
            assert!((moved.mean[row] - expected).abs() < 1e-9);
            assert!((nearly.mean[row] - expected).abs() < 1e-3);
        }
    }

    /// The covariance with the rate is how the state moves if the rate does.
    #[test]
    fn the_tangent_is_that_of_the_circle() {
        for rate in [0.0f32, 2e-5, 0.05, -0.3] {
            let (_, turn) = turned(rate, 4.0);
            let step = 1.0 / 4096.0;
            let (before, after) = (turned(rate - step, 4.0).0, turned(rate + step, 4.0).0);
            let variance = f64::from(TurnRate::begun(&TURN_SETTINGS).variance);
            for row in 0..STATE_LEN {
                let slope = (after.mean[row] - before.mean[row]) / (2.0 * f64::from(step));
                let found = f64::from(turn.cross[row]) / variance;
                assert!(
                    (found - slope).abs() < 0.05 + 1e-3 * slope.abs(),
                    "{rate} {row}: {found} {slope}"
                );
            }
        }
    }

    #[test]
    fn a_mixture_has_the_moments_of_both() {
        let (one, one_turn) = turned(0.1, 2.0);
        let (other, other_turn) = turned(-0.2, 2.0);
        let mixed = TurnRate::mixture((&one_turn, &one), (&other_turn, &other), 0.25);
        assert!((mixed.rate - 0.025).abs() < 1e-6);
        let variance = f64::from(one_turn.variance) + 0.75 * 0.25 * 0.09;
        assert!((f64::from(mixed.variance) - variance).abs() < 1e-6);
        let same = TurnRate::mixture((&one_turn, &one), (&one_turn, &one), 0.4);
        assert!((same.cross[0] - one_turn.cross[0]).abs() < 1e-4);
    }
}
