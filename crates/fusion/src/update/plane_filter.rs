//! The filter of the plane: several models of motion in parallel.
//!
//! A target flies straight most of the time, and sometimes changes speed or turns. A single filter for all these
//! motions discards most information on straight legs. Therefore a filter runs for each kind of motion:
//!
//! - *steady*: constant velocity, hardly disturbed;
//! - *agile*: white acceleration, more along the course than across: changes of speed, and all motions outside the
//!   other models;
//! - *turns* to the left and to the right: a constant lateral acceleration at any speed, the motion of a coordinated
//!   turn. The velocities do not forget: these models collect the evidence of a turn over many measurements, and detect
//!   a turn long before a model of white noise.
//!
//! The probabilities follow from the predictions of the measurements (interacting multiple models). In straight flight,
//! a turn of usual hardness to either side is enough. When the target leaves straight flight, turns of other hardness
//! join (variable structure), up to the limits of class and speed. In straight flight these models leave.
//!
//! The next motion of a target depends on the presence of a manoeuvre, not on the kind. All mixtures therefore have two
//! components: the model itself, and the targets at the start of a manoeuvre. The second component follows from the
//! steady model and from the estimate of all models together.
//!
//! Source: H. A. P. Blom, Y. Bar-Shalom, *The interacting multiple model algorithm for systems with Markovian switching
//! coefficients*, IEEE Transactions on Automatic Control 33 (1988); X. R. Li, Y. Bar-Shalom, *Multiple-model estimation
//! with variable structure*, IEEE Transactions on Automatic Control 41 (1996), for models that join and leave.

use estimation::{Moments, Plane, PlanePair, Rotation, Two};
use serde::{Deserialize, Serialize};
use source_models::{LEVELS, MANOEUVRE_S, Motion};

/// Number of models: steady, agile, and turns of each hardness to the left and to the right.
pub(crate) const MODELS: usize = 2 + 2 * LEVELS;
/// Models stand in pairs: steady and agile, and both turns of each hardness.
const PAIRS: usize = MODELS / 2;
/// Number of models that always run: without the turns of unusual hardness.
const USUAL: usize = 4;
pub(crate) const STEADY: usize = 0;
pub(crate) const AGILE: usize = 1;
/// Share of the manoeuvres followed by straight flight; another manoeuvre follows the rest.
pub(crate) const HOME: f64 = 0.6;
/// Probabilities of a manoeuvre: all models run above the first, and the usual models are enough below the second.
const WIDE: f64 = 0.25;
const NARROW: f64 = 0.08;
/// Probabilities at the start: steady, agile, each usual turn.
const PRIOR: [f64; USUAL] = [0.86, 0.06, 0.04, 0.04];
/// Share of the turns with each level of hardness. The mean of the logarithm is 0 at the initial values of fast
/// targets: measurements without evidence do not change the assumptions on turns.
pub(crate) const HARDNESS: [f64; LEVELS] = [0.45, 0.35, 0.15, 0.05];
/// Smallest probability of a manoeuvre, and of straight flight: both must be able to return.
const PROBABILITY_MIN: f64 = 1e-4;
/// Largest logarithm of a ratio of likelihoods.
const EXPONENT_MAX: f64 = 100.0;

/// All models of one target.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(crate) struct PlaneFilter {
    pairs: [PlanePair; PAIRS],
    probability: [f64; MODELS],
    is_wide: bool,
}

/// Expected motion of the target in the plane.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(crate) struct Course {
    /// Lateral acceleration to the left, m/s², and the variance.
    pub(crate) left_mps2: f64,
    pub(crate) variance_m2ps4: f64,
    /// White noise of all models together, m²/s³.
    pub(crate) density_m2ps3: f64,
}

impl PlaneFilter {
    pub(crate) fn new(estimate: Plane) -> Self {
        let mut probability = [0.0; MODELS];
        probability[..USUAL].copy_from_slice(&PRIOR);
        Self {
            pairs: [PlanePair::both(&estimate); PAIRS],
            probability,
            is_wide: false,
        }
    }

    /// Starts with these probabilities: steady, agile, left, right.
    pub(crate) fn with(estimate: Plane, probability: [f64; USUAL]) -> Self {
        let mut filter = Self::new(estimate);
        filter.probability[..USUAL].copy_from_slice(&probability);
        filter
    }

    /// Number of models that run.
    #[inline]
    fn running(&self) -> usize {
        if self.is_wide { MODELS } else { USUAL }
    }

    /// Probability that the target flies straight.
    #[inline]
    pub(crate) fn steady(&self) -> f64 {
        self.probability[STEADY]
    }

    /// Probabilities: steady, agile, turn to the left, to the right.
    pub(crate) fn probabilities(&self) -> [f64; USUAL] {
        let mut sums = [self.probability[STEADY], self.probability[AGILE], 0.0, 0.0];
        for pair in self.probability[AGILE + 1..self.running()].chunks_exact(2) {
            sums[2] += pair[0];
            sums[3] += pair[1];
        }
        sums
    }

    /// Sum over the turns: probability times logarithm of the lateral acceleration relative to the usual turn; `None`
    /// while only the usual turns run.
    pub(crate) fn hardness(&self, motion: &Motion) -> Option<f64> {
        self.is_wide.then(|| {
            let pairs = self.probability[AGILE + 1..].chunks_exact(2);
            pairs
                .zip(motion.hardness())
                .map(|(pair, logarithm)| (pair[0] + pair[1]) * logarithm)
                .sum()
        })
    }

    /// Returns the position predicted by a model, and the covariance (xx, xy, yy).
    #[inline]
    pub(crate) fn position_of(&self, model: usize) -> ([f64; 2], [f64; 3]) {
        self.pairs[model / 2].position(model % 2)
    }

    /// Returns the expected square of the error of a velocity in straight flight (xx, xy, yy), m²/s².
    #[inline]
    pub(crate) fn steady_square(&self, velocity_mps: [f64; 2]) -> [f64; 3] {
        let ([vx, vy], [xx, xy, yy]) = self.pairs[0].velocity(STEADY);
        let [dx, dy] = [vx - velocity_mps[0], vy - velocity_mps[1]];
        [xx + dx * dx, xy + dx * dy, yy + dy * dy]
    }

    /// Probabilities of a pair of models.
    #[inline]
    fn weights(&self, pair: usize) -> Two {
        Two([self.probability[2 * pair], self.probability[2 * pair + 1]])
    }

    pub(crate) fn shift(&mut self, by_m: [f64; 2]) {
        self.pairs.iter_mut().for_each(|pair| pair.shift(by_m));
    }

    /// Returns the expected motion of the target.
    #[inline]
    pub(crate) fn course(&self, motion: &Motion) -> Course {
        let mut course = Course {
            left_mps2: 0.0,
            variance_m2ps4: 0.0,
            density_m2ps3: self.probability[STEADY] * motion.steady_m2ps3()
                + self.probability[AGILE] * motion.agile_m2ps3(1.0)[0],
        };
        let pairs = self.probability[AGILE + 1..self.running()].chunks_exact(2);
        for (pair, lateral_mps2) in pairs.zip(motion.lateral_mps2) {
            let (both, square) = (pair[0] + pair[1], lateral_mps2 * lateral_mps2);
            course.left_mps2 += (pair[0] - pair[1]) * lateral_mps2;
            course.variance_m2ps4 += both * square;
            course.density_m2ps3 += both * Motion::turn_m2ps3(lateral_mps2, 1.0);
        }
        course.variance_m2ps4 -= course.left_mps2 * course.left_mps2;
        course
    }

    /// Adds so much to the variances of the positions of all models, m² per axis.
    pub(crate) fn blur(&mut self, variance_m2: f64) {
        self.pairs.iter_mut().for_each(|pair| pair.blur(variance_m2));
    }

    /// Multiplies the covariances of all models by a factor.
    pub(crate) fn inflate(&mut self, factor: f64) {
        self.pairs.iter_mut().for_each(|pair| pair.inflate(factor));
    }

    /// Brings the models forward by `seconds` > 0. `estimate` is all models together.
    #[inline]
    pub(crate) fn advance(&mut self, seconds: f64, motion: &Motion, estimate: &Plane) {
        self.mix(seconds, motion, estimate);
        let running = self.running();
        let [vx, vy] = [estimate.mean[2], estimate.mean[3]];
        let square = vx * vx + vy * vy;
        let straight = &mut self.pairs[0];
        straight.advance(seconds);
        straight.disturb_one_evenly(STEADY, motion.steady_m2ps3(), seconds);
        let [along, across] = motion.agile_m2ps3(seconds);
        if square > motion.slow_mps * motion.slow_mps {
            let (excess, inverse) = (along - across, 1.0 / square);
            let noise = [vx * vx, vx * vy, vy * vy].map(|value| excess * value * inverse);
            straight.disturb_one(AGILE, [across + noise[0], noise[1], across + noise[2]], seconds);
        } else {
            straight.disturb_one_evenly(AGILE, along, seconds);
        }
        let speed_mps = square.sqrt().max(motion.slow_mps);
        for (pair, lateral_mps2) in self.pairs[1..running / 2].iter_mut().zip(motion.lateral_mps2) {
            pair.turn_apart(&Rotation::new(lateral_mps2 / speed_mps, seconds));
            pair.disturb_evenly(Motion::turn_m2ps3(lateral_mps2, seconds), seconds);
        }
    }

    /// Targets may have begun or ended a manoeuvre in `seconds`. `estimate` is all models together.
    fn mix(&mut self, seconds: f64, motion: &Motion, estimate: &Plane) {
        let running = self.running();
        let [begins, ends] = [motion.steady_s, MANOEUVRE_S].map(|duration| seconds / (seconds + duration));
        let steady = self.probability[STEADY];
        let manoeuvre = 1.0 - steady;
        let mut begun = self.pairs[0].state(STEADY);
        let rest = estimate.without(&begun, manoeuvre);
        // Targets at the start of a manoeuvre, after straight flight or after another manoeuvre.
        let (after_steady, after_other) = (steady * begins, manoeuvre * ends * (1.0 - HOME));
        let begin = after_steady + after_other;
        begun.blend(&rest, after_other / begin);
        let (stays, returns) = (steady * (1.0 - begins), manoeuvre * ends * HOME);
        let turns = if self.is_wide { 0.5 } else { 0.5 / HARDNESS[0] } * (1.0 - motion.agile_share);
        let left = 1.0 - ends;
        let (own, new) = (self.probability[AGILE] * left, begin * motion.agile_share);
        let weight = Two([returns / (stays + returns), new / (own + new)]);
        self.pairs[0].blend(&PlanePair::of(&rest, &begun), weight);
        (self.probability[STEADY], self.probability[AGILE]) = (stays + returns, own + new);
        let begun = PlanePair::both(&begun);
        for pair in 1..running / 2 {
            let own = self.weights(pair) * Two::both(left);
            let new = Two::both(begin * (turns * HARDNESS[pair - 1]));
            let sum = own + new;
            self.pairs[pair].blend(&begun, new / sum);
            [self.probability[2 * pair], self.probability[2 * pair + 1]] = sum.0;
        }
    }

    /// Returns the predicted position, and the covariance (xx, xy, yy).
    #[inline]
    pub(crate) fn position(&self) -> ([f64; 2], [f64; 3]) {
        let (about, _) = self.position_of(STEADY);
        let (mut first, mut second) = ([Two::default(); 2], [Two::default(); 3]);
        for pair in 0..self.running() / 2 {
            let ([x, y], [xx, xy, yy]) = self.pairs[pair].positions();
            let weight = self.weights(pair);
            let (dx, dy) = (x - Two::both(about[0]), y - Two::both(about[1]));
            first[0] += weight * dx;
            first[1] += weight * dy;
            second[0] += weight * (xx + dx * dx);
            second[1] += weight * (xy + dx * dy);
            second[2] += weight * (yy + dy * dy);
        }
        let ([x, y], second) = (first.map(Two::sum), second.map(Two::sum));
        (
            [about[0] + x, about[1] + y],
            [second[0] - x * x, second[1] - x * y, second[2] - y * y],
        )
    }

    /// All models together; `about` is near all of them.
    #[inline]
    pub(crate) fn combined(&self, about: &[f64; 4]) -> Plane {
        let mut sum = Moments::default();
        for pair in 0..self.running() / 2 {
            sum.include(&self.pairs[pair], self.weights(pair), about);
        }
        sum.state(about)
    }

    /// Updates all models with a measured position; `None` if a value is not usable.
    #[inline]
    pub(crate) fn update(&mut self, measured_m: [f64; 2], r: [f64; 3]) -> Option<()> {
        let running = self.running();
        let (mut sum, mut steady) = (0.0, f64::NAN);
        for pair in 0..running / 2 {
            let residuals = self.pairs[pair].update(measured_m, r)?;
            if pair == STEADY / 2 {
                steady = residuals.squared.0[STEADY % 2];
            }
            // Only the ratio to the steady model matters, and must not become infinite.
            let exponents = residuals
                .squared
                .0
                .map(|squared| (0.5 * (steady - squared)).clamp(-EXPONENT_MAX, EXPONENT_MAX));
            let weights = self.weights(pair) * Two(exponents).exp() / residuals.determinant.sqrt();
            [self.probability[2 * pair], self.probability[2 * pair + 1]] = weights.0;
            sum += weights.sum();
        }
        let inverse = 1.0 / sum;
        self.probability[..running]
            .iter_mut()
            .for_each(|value| *value *= inverse);
        self.keep_possible(running);
        self.choose();
        Some(())
    }

    /// No model is excluded for ever.
    fn keep_possible(&mut self, running: usize) {
        let steady = self.probability[STEADY];
        let kept = steady.clamp(PROBABILITY_MIN, 1.0 - PROBABILITY_MIN);
        if kept != steady {
            let others = 1.0 - steady;
            self.probability[STEADY] = kept;
            let manoeuvres = &mut self.probability[AGILE..running];
            if others > 0.0 {
                manoeuvres.iter_mut().for_each(|value| *value *= (1.0 - kept) / others);
            } else {
                manoeuvres.fill((1.0 - kept) / (running - AGILE) as f64);
            }
        }
    }

    /// Lets the turns of unusual hardness join or leave.
    fn choose(&mut self) {
        let manoeuvre = 1.0 - self.probability[STEADY];
        if self.is_wide && manoeuvre < NARROW {
            // After the next mixing, the usual turns contain the information of these models.
            let mut sums = [0.0; 2];
            for pair in self.probability[USUAL..].chunks_exact(2) {
                sums[0] += pair[0];
                sums[1] += pair[1];
            }
            self.probability[USUAL..].fill(0.0);
            self.probability[AGILE + 1] += sums[0];
            self.probability[AGILE + 2] += sums[1];
            self.is_wide = false;
        } else if !self.is_wide && manoeuvre > WIDE {
            self.is_wide = true;
        }
    }
}
