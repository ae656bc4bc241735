//! The filter of the vertical: level flight, climbs, and changes between both.
//!
//! The vertical has separate models and probabilities: a climb leaves the plane unchanged. In level flight the height
//! is constant: the rate of climb is 0 but for a small remainder. In a climb or descent the rate is nearly constant.
//! Between both the rate changes (interacting multiple models, as in `plane_filter`).

use estimation::Vertical;
use serde::{Deserialize, Serialize};
use source_models::Motion;

/// Number of models: level, climb, change.
pub(crate) const MODELS: usize = 3;
const LEVEL: usize = 0;
const CLIMB: usize = 1;
const CHANGE: usize = 2;
/// Mean durations, seconds.
pub(crate) const LEVEL_S: f64 = 80.0;
pub(crate) const CLIMB_S: f64 = 100.0;
pub(crate) const CHANGE_S: f64 = 4.0;
/// Share of the changes after which the target flies level.
pub(crate) const LEVELS_OFF: f64 = 0.5;
/// Remaining rate of climb in level flight, m/s, and white noise of the height, m²/s.
pub(crate) const REMAINDER_MPS: f64 = 0.3;
pub(crate) const WANDER_M2PS: f64 = 0.01;
/// Noise of the rate in a climb, m²/s³.
pub(crate) const CLIMB_M2PS3: f64 = 0.002;
pub(crate) const PRIOR: [f64; MODELS] = [0.3, 0.5, 0.2];
const PROBABILITY_MIN: f64 = 1e-4;
/// Largest logarithm of a ratio of likelihoods.
const EXPONENT_MAX: f64 = 100.0;
/// Normalised innovation squared beyond which a height is weighed down.
const BLUNDER: f64 = 25.0;

/// All models of one target.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(crate) struct VerticalFilter {
    models: [Vertical; MODELS],
    probability: [f64; MODELS],
}

impl VerticalFilter {
    pub(crate) fn new(estimate: Vertical) -> Self {
        Self::with(estimate, PRIOR)
    }

    pub(crate) fn with(estimate: Vertical, probability: [f64; MODELS]) -> Self {
        Self {
            models: [estimate; MODELS],
            probability,
        }
    }

    /// Probabilities: level, climb, change.
    pub(crate) fn probabilities(&self) -> [f64; MODELS] {
        self.probability
    }

    /// Returns the expected square of the error of a climb rate, m²/s², in level flight or in a constant climb,
    /// whichever is more probable.
    pub(crate) fn steady_square(&self, climb_mps: f64) -> f64 {
        let [level, climb, _] = self.probability;
        let Vertical { mean, covariance } = &self.models[if level < climb { CLIMB } else { LEVEL }];
        let off_mps = mean[1] - climb_mps;
        covariance[2] + off_mps * off_mps
    }

    /// White noise of the rate of climb by all models together, m²/s³.
    pub(crate) fn density_m2ps3(&self, motion: &Motion) -> f64 {
        self.probability[CLIMB] * CLIMB_M2PS3 + self.probability[CHANGE] * motion.climb_change_m2ps3
    }

    /// Multiplies the covariances of all models by a factor.
    pub(crate) fn inflate(&mut self, factor: f64) {
        for model in &mut self.models {
            model.covariance.iter_mut().for_each(|value| *value *= factor);
        }
    }

    /// Brings the models forward by `seconds` > 0.
    pub(crate) fn advance(&mut self, seconds: f64, motion: &Motion) {
        let leave = [LEVEL_S, CLIMB_S, CHANGE_S].map(|duration| seconds / (seconds + duration));
        let [level, climb, change] = self.probability;
        let from_change = change * leave[CHANGE];
        // Probabilities by origin: level and change, climb and change, all.
        let to_level = [level * (1.0 - leave[LEVEL]), from_change * LEVELS_OFF];
        let to_climb = [climb * (1.0 - leave[CLIMB]), from_change * (1.0 - LEVELS_OFF)];
        let to_change = [
            level * leave[LEVEL],
            climb * leave[CLIMB],
            change * (1.0 - leave[CHANGE]),
        ];
        let sums = [
            to_level[0] + to_level[1],
            to_climb[0] + to_climb[1],
            to_change[0] + to_change[1] + to_change[2],
        ];
        let inverse = sums.map(|sum| 1.0 / sum);
        let [a, b, c] = self.models;
        self.models = [
            Vertical::mixture(&[a, c], to_level.map(|weight| weight * inverse[LEVEL])),
            Vertical::mixture(&[b, c], to_climb.map(|weight| weight * inverse[CLIMB])),
            Vertical::mixture(&[a, b, c], to_change.map(|weight| weight * inverse[CHANGE])),
        ];
        self.probability = sums;
        let [level, climb, change] = &mut self.models;
        level.mean[1] = 0.0;
        level.covariance = [
            level.covariance[0] + WANDER_M2PS * seconds,
            0.0,
            REMAINDER_MPS * REMAINDER_MPS,
        ];
        climb.advance(seconds, CLIMB_M2PS3);
        change.advance(seconds, motion.climb_change_m2ps3);
    }

    /// All models together.
    pub(crate) fn combined(&self) -> Vertical {
        Vertical::mixture(&self.models, self.probability)
    }

    /// Updates all models with a measured height; `None` if a value is not usable. A height far outside the change
    /// model has less weight.
    pub(crate) fn update(&mut self, measured_m: f64, variance_m2: f64) -> Option<()> {
        let change = &self.models[CHANGE];
        let residual_m = measured_m - change.mean[0];
        let squared = residual_m * residual_m / (change.covariance[0] + variance_m2);
        let variance_m2 = if squared > BLUNDER {
            variance_m2 * squared / BLUNDER
        } else {
            variance_m2
        };
        let level = self.models[LEVEL].update(measured_m, variance_m2)?;
        self.probability[LEVEL] /= level.1.sqrt();
        let mut sum = self.probability[LEVEL];
        for index in CLIMB..MODELS {
            let (squared, variance) = self.models[index].update(measured_m, variance_m2)?;
            let exponent = (0.5 * (level.0 - squared)).clamp(-EXPONENT_MAX, EXPONENT_MAX);
            self.probability[index] *= exponent.exp() / variance.sqrt();
            sum += self.probability[index];
        }
        let inverse = 1.0 / sum;
        let mut sum = 0.0;
        for value in &mut self.probability {
            *value = (*value * inverse).max(PROBABILITY_MIN);
            sum += *value;
        }
        let inverse = 1.0 / sum;
        self.probability.iter_mut().for_each(|value| *value *= inverse);
        Some(())
    }
}
