//! A start that believes no range before the bearings show the range: a hypothesis for each range.
//!
//! Bearings from a platform that flies straight on do not contain the range of a moving emitter: position and velocity
//! may be scaled together. A search from a single start ends somewhere on this line of states, and a Gaussian about the
//! end is too certain. Here the prior is a sum of Gaussians, a Gaussian for each of several ranges of the first
//! bearing, each √2 times as far as the preceding (N. Peach, *Bearings-only tracking using a set of range-parameterised
//! extended Kalman filters*, IEE Proceedings Control Theory and Applications 142, 1995). Within a hypothesis the range
//! is known to a share, so that a linearisation at the best state is good. The weights are the evidence, by Laplace's
//! approximation; mean and covariance are those of the mixture.
//!
//! A hypothesis without weight is dropped, so that few remain when the bearings are many.

use kept::kept;
use nalgebra::{SMatrix, SVector};

use crate::gauss_newton::{LeastSquaresProblem, StatePrior};
use crate::line_of_bearing::{LineOfBearing, Ray};
use crate::linear::Factor;
use crate::mixture::{Weighted, matched};

/// Hypotheses; the farthest is at half the standard deviation of an unknown emitter's range.
const RANGES: usize = 24;
/// Standard deviation of the range within a hypothesis, as a share of the range: the sum is flat in the logarithm of
/// the range.
const SPREAD: f64 = 0.2;
/// A hypothesis is dropped when the logarithm of the weight is this far below the greatest.
const LOG_WEIGHT_DROPPED: f64 = 9.0;
/// Rounds of the first search, and of the improvement by later lines.
const ROUNDS_FIRST: usize = 20;
const ROUNDS: usize = 2;

/// Hypotheses about the range of the first line.
#[derive(Clone, Debug)]
pub(crate) struct RangeHypotheses<const D: usize> {
    first: Ray,
    /// Best state of each hypothesis; `None` if dropped.
    states: [Option<SVector<f64, D>>; RANGES],
    is_new: bool,
}

/// Mixture of the hypotheses.
pub(crate) struct RangeBelief<const D: usize> {
    pub(crate) mean: SVector<f64, D>,
    pub(crate) covariance: SMatrix<f64, D, D>,
    /// Whether the lines fit together in the best hypothesis.
    pub(crate) is_plausible: bool,
}

impl<const D: usize> RangeHypotheses<D> {
    /// `None` if the first line is no bearing.
    pub(crate) fn new(first: &LineOfBearing, range_sigma_m: f64) -> Option<Self> {
        let first = first.ray()?;
        let states = std::array::from_fn(|place| {
            let range_m = range_sigma_m * 0.5f64.sqrt().powi((RANGES - place) as i32);
            let mut state = SVector::zeros();
            state[0] = first.platform_m[0] + range_m * first.sine;
            state[1] = first.platform_m[1] + range_m * first.cosine;
            Some(state)
        });
        Some(Self {
            first: *first,
            states,
            is_new: true,
        })
    }

    /// Improves all hypotheses by the lines. `prior`: the prior without a range, for the velocity.
    pub(crate) fn search(
        &mut self,
        prior: &StatePrior<D>,
        range_sigma_m: f64,
        lines: &[LineOfBearing],
        reference_ns: i64,
    ) -> Option<RangeBelief<D>> {
        let rounds = if self.is_new { ROUNDS_FIRST } else { ROUNDS };
        self.is_new = false;
        let mut beliefs: [Option<Weighted<D>>; RANGES] = [None; RANGES];
        let mut best = (f64::NEG_INFINITY, false);
        for (place, belief) in beliefs.iter_mut().enumerate() {
            let Some(start) = self.states[place] else { continue };
            let range_m = range_sigma_m * 0.5f64.sqrt().powi((RANGES - place) as i32);
            let prior = self.prior(prior, range_m);
            let problem = LeastSquaresProblem {
                reference_ns,
                prior: &prior,
                lines,
            };
            self.states[place] = None;
            let Some(found) = problem.search(start, rounds) else {
                continue;
            };
            let Some(factor) = Factor::of(&found.covariance) else {
                continue;
            };
            let log_weight = 0.5 * (factor.log_determinant() - found.cost) - 2.0 * range_m.ln();
            if !log_weight.is_finite() {
                continue;
            }
            self.states[place] = Some(found.state);
            *belief = Some(Weighted {
                log_weight,
                mean: found.state,
                covariance: found.covariance,
            });
            if log_weight > best.0 {
                best = (log_weight, found.is_plausible);
            }
        }
        for (state, belief) in self.states.iter_mut().zip(&mut beliefs) {
            if belief.is_some_and(|belief| belief.log_weight < best.0 - LOG_WEIGHT_DROPPED) {
                (*state, *belief) = (None, None);
            }
        }
        let (mean, covariance) = matched(&beliefs)?;
        Some(RangeBelief {
            mean,
            covariance,
            is_plausible: best.1,
        })
    }

    /// The prior with a range, along the first line; across, the line itself determines the position.
    fn prior(&self, of_velocity: &StatePrior<D>, range_m: f64) -> StatePrior<D> {
        let mut prior = of_velocity.clone();
        let (sine, cosine) = (self.first.sine, self.first.cosine);
        let [along, across] = [SPREAD * range_m, range_m].map(|sigma_m| 1.0 / (sigma_m * sigma_m));
        prior.mean[0] = self.first.platform_m[0] + range_m * sine;
        prior.mean[1] = self.first.platform_m[1] + range_m * cosine;
        prior.information[(0, 0)] = along * sine * sine + across * cosine * cosine;
        prior.information[(1, 1)] = along * cosine * cosine + across * sine * sine;
        prior.information[(0, 1)] = (along - across) * sine * cosine;
        prior.information[(1, 0)] = prior.information[(0, 1)];
        prior
    }
}

kept!(RangeHypotheses<2> {
    first: Ray,
    states: [Option<SVector<f64, 2>>; RANGES],
    is_new: bool,
});
kept!(RangeHypotheses<4> {
    first: Ray,
    states: [Option<SVector<f64, 4>>; RANGES],
    is_new: bool,
});
