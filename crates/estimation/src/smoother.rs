//! Smoothing over an interval: the states of a target that switches among several models of motion, from all
//! measurements, later ones included.
//!
//! A filter uses only earlier measurements. Afterwards the measurements of both sides are known, and most assumptions
//! of a filter about manoeuvres become observable. With a single model the Rauch-Tung-Striebel recursion is exact: the
//! recursion goes back from the last state, and corrects each filtered state by the difference of the following
//! smoothed state from the prediction. With several models the path through the models is unknown as well. An exact
//! solution would follow every path.
//!
//! Forwards, a single filter per model runs, mixed before each step (interacting multiple models). Backwards, each pair
//! of a model before a step and a model after the step has a separate recursion:
//!
//! - The smoothed state after the step contains the past, as remembered by the mixed filter. This part is taken out; a
//!   likelihood of the future remains. The obvious recursion goes back from the smoothed state itself. That recursion
//!   loses the information lost by the mixing, again in each step: errors of position would grow towards the middle of
//!   an interval.
//! - The pair meets this likelihood with the pair's prediction, and goes back from there.
//! - The pair's weight is the smoothed probability of the model after the step, divided among the models before the
//!   step by filtered probabilities, the probabilities of the switches, and the mean likelihoods. The division by model
//!   keeps a model with an absurd state at a small weight.
//! - The pairs that begin with the same model are merged into a single state, by moments.
//!
//! All matrices have a few rows, and are arrays in loops of constant length (module `rows`). The backward step meets a
//! likelihood in square-root form (module `backward`).
//!
//! With a single model, both parts reduce to the exact filter and smoother. Memory is bounded by [`Smoother::smooth`],
//! which gives up the first steps: states that lie a few minutes before the last measurement do not change any more.
//!
//! Source: H. E. Rauch, F. Tung, C. T. Striebel, *Maximum likelihood estimates of linear dynamic systems*, AIAA Journal
//! 3 (1965); C.-J. Kim, *Dynamic linear models with Markov-switching*, Journal of Econometrics 60 (1994), for pairs; D.
//! Barber, *Expectation correction for smoothed inference in switching linear dynamical systems*, Journal of Machine
//! Learning Research 7 (2006), for the weights; N. Nadarajah, R. Tharmarasa, M. McDonald, T. Kirubarajan, *IMM forward
//! filtering and backward smoothing for maneuvering target tracking*, IEEE Transactions on Aerospace and Electronic
//! Systems 48 (2012), for the use in tracking.

use std::collections::VecDeque;

use nalgebra::{SMatrix, SVector};

use crate::backward::corrected;
use crate::filtered_step::{FilteredStep, LinearModel, Moment, Switching};
use crate::rows::{Pivots, Rows, add_rows, add_scaled, add_square, symmetric, times};

/// Smallest probability of a model: each must be able to come back.
const PROBABILITY_MIN: f64 = 1e-6;

impl<const N: usize> Moment<N> {
    fn moved(&self, by: &LinearModel<N>) -> Self {
        // The rows of the array are the columns of the matrix.
        let columns = &by.transition.data.0;
        let right = times(&self.covariance.data.0, columns);
        let mut covariance = by.noise.data.0;
        for (row, sum) in covariance.iter_mut().enumerate() {
            for (column, right) in columns.iter().zip(&right) {
                add_scaled(sum, right, column[row]);
            }
        }
        symmetric(&mut covariance);
        let mut mean = [0.0; N];
        for (column, value) in columns.iter().zip(self.mean.iter()) {
            add_scaled(&mut mean, column, *value);
        }
        Self {
            mean: mean.into(),
            covariance: covariance.into(),
        }
    }
}

/// Moments of the models about the mean of all of them: a mixture with any weights is then a single sum.
struct Spread<const N: usize, const M: usize> {
    centre: [f64; N],
    /// Mean of each model relative to the centre, and its mean square there.
    away: [[f64; N]; M],
    square: [Rows<N>; M],
}

impl<const N: usize, const M: usize> Spread<N, M> {
    fn new(probability: &[f64; M], models: &[Moment<N>; M]) -> Self {
        let centre = mean_of(probability, models);
        let mut spread = Self {
            centre,
            away: [[0.0; N]; M],
            square: [[[0.0; N]; N]; M],
        };
        for ((away, square), model) in spread.away.iter_mut().zip(&mut spread.square).zip(models) {
            *away = std::array::from_fn(|component| model.mean[component] - centre[component]);
            *square = model.covariance.data.0;
            add_square(square, away, 1.0);
        }
        spread
    }

    /// Mixture with weights that sum to 1.
    fn mixed(&self, weights: &[f64; M]) -> Moment<N> {
        let (mut away, mut covariance) = ([0.0; N], [[0.0; N]; N]);
        for ((weight, of_model), square) in weights.iter().zip(&self.away).zip(&self.square) {
            add_scaled(&mut away, of_model, *weight);
            add_rows(&mut covariance, square, *weight);
        }
        add_square(&mut covariance, &away, -1.0);
        add_scaled(&mut away, &self.centre, 1.0);
        Moment {
            mean: away.into(),
            covariance: covariance.into(),
        }
    }
}

/// Mean of a mixture with weights that sum to 1.
fn mean_of<const N: usize, const M: usize>(weights: &[f64; M], models: &[Moment<N>; M]) -> [f64; N] {
    let mut mean = [0.0; N];
    for (weight, model) in weights.iter().zip(models) {
        add_scaled(&mut mean, &model.mean.data.0[0], *weight);
    }
    mean
}

/// Mixture with weights that sum to 1.
fn mixture<const N: usize, const M: usize>(weights: &[f64; M], models: &[Moment<N>; M]) -> Moment<N> {
    Spread::new(weights, models).mixed(weights)
}

/// State at a single step from all measurements.
#[derive(Clone, Copy, Debug)]
pub struct Smoothed<const N: usize, const M: usize> {
    /// All models together.
    pub state: Moment<N>,
    /// Probabilities of the models.
    pub probability: [f64; M],
}

/// Filter with a memory: `N` components, of which the first `K` are measured, and `M` models.
#[derive(Clone, Debug)]
pub struct Smoother<const N: usize, const M: usize, const K: usize> {
    steps: VecDeque<FilteredStep<N, M>>,
    /// Logarithm of the likelihood of all measurements so far.
    evidence: f64,
}

impl<const N: usize, const M: usize, const K: usize> Smoother<N, M, K> {
    /// Begins with a state, and the probabilities of the models.
    pub fn new(state: Moment<N>, probability: [f64; M]) -> Self {
        let standing = LinearModel {
            transition: SMatrix::identity(),
            noise: SMatrix::zeros(),
        };
        let first = FilteredStep {
            motion: Switching {
                models: [standing; M],
                switches: SMatrix::identity(),
            },
            predicted: [state; M],
            predicted_probability: probability,
            models: [state; M],
            probability,
        };
        Self {
            steps: VecDeque::from([first]),
            evidence: 0.0,
        }
    }

    /// The last step alone: the prediction does not depend on earlier steps.
    pub fn last_alone(&self) -> Self {
        Self {
            steps: VecDeque::from([*self.last()]),
            evidence: self.evidence,
        }
    }

    /// Gives up all steps but the last: predictions do not depend on them.
    pub fn forget(&mut self) {
        self.steps.drain(..self.steps.len() - 1);
    }

    /// Logarithm of the likelihood of all measurements so far, but for a constant: the share explained by the models
    /// and the noise. Of several assumptions, the likeliest has the greatest.
    pub fn evidence(&self) -> f64 {
        self.evidence
    }

    /// Number of steps in memory, at least 1.
    #[allow(clippy::len_without_is_empty)] // It is never empty.
    pub fn len(&self) -> usize {
        self.steps.len()
    }

    /// The filtered state of the last step, all models together.
    pub fn filtered(&self) -> Moment<N> {
        let step = self.last();
        mixture(&step.probability, &step.models)
    }

    /// The mean of [`Self::filtered`].
    pub fn mean(&self) -> SVector<f64, N> {
        let step = self.last();
        mean_of(&step.probability, &step.models).into()
    }

    /// The expected measurement at the last step and the covariance, without the measurement's covariance.
    pub fn expected(&self) -> (SVector<f64, K>, SMatrix<f64, K, K>) {
        let step = self.last();
        let mean: [f64; N] = mean_of(&step.probability, &step.models);
        let mut spread = SMatrix::<f64, K, K>::zeros();
        for (weight, model) in step.probability.iter().zip(&step.models) {
            let away: [f64; K] = std::array::from_fn(|axis| model.mean[axis] - mean[axis]);
            for row in 0..K {
                for column in 0..K {
                    spread[(row, column)] += weight * (model.covariance[(row, column)] + away[row] * away[column]);
                }
            }
        }
        (SVector::from_fn(|axis, _| mean[axis]), spread)
    }

    fn last(&self) -> &FilteredStep<N, M> {
        &self.steps[self.steps.len() - 1]
    }

    /// Goes on to the next step.
    pub fn advance(&mut self, motion: Switching<N, M>) {
        let before = self.last();
        let spread = Spread::new(&before.probability, &before.models);
        let mut probability = [0.0; M];
        let models = std::array::from_fn(|after| {
            let joint: [f64; M] = std::array::from_fn(|from| before.probability[from] * motion.switches[(from, after)]);
            let sum: f64 = joint.iter().sum();
            probability[after] = sum;
            let weights = joint.map(|value| if sum > 0.0 { value / sum } else { 1.0 / M as f64 });
            spread.mixed(&weights).moved(&motion.models[after])
        });
        self.steps.push_back(FilteredStep {
            motion,
            predicted: models,
            predicted_probability: probability,
            models,
            probability,
        });
    }

    /// Updates the last step with a measurement of covariance `r`. `None`, and no change, if the measurement is
    /// unusable.
    pub fn update(&mut self, measured: &SVector<f64, K>, r: &SMatrix<f64, K, K>) -> Option<()> {
        let step = self.steps.back_mut()?;
        let mut models = step.models;
        let (mut squares, mut densities) = ([0.0; M], [0.0; M]);
        for ((model, squared), density) in models.iter_mut().zip(&mut squares).zip(&mut densities) {
            let covariance = &mut model.covariance.data.0;
            let cross: [[f64; N]; K] = std::array::from_fn(|row| covariance[row]);
            let spread = std::array::from_fn(|row| std::array::from_fn(|column| cross[row][column] + r[(row, column)]));
            let pivots = Pivots::of(spread)?;
            let residual = pivots.eliminated(std::array::from_fn(|axis| measured[axis] - model.mean[axis]));
            (*squared, *density) = (pivots.squared(&residual), 1.0 / pivots.determinant.sqrt());
            if !(squared.is_finite() && density.is_finite()) {
                return None;
            }
            let (white, residual) = pivots.whitened(cross, residual);
            for (row, value) in white.iter().zip(residual) {
                add_square(covariance, row, -1.0);
                add_scaled(&mut model.mean.data.0[0], row, value);
            }
        }
        let (probability, gained) = weighed(&step.probability, &squares, &densities);
        (step.models, step.probability) = (models, probability);
        self.evidence += gained;
        Some(())
    }

    /// Smooths all steps in memory with all measurements so far, and gives up all but the last `keep`. Returns the
    /// states of the steps given up, in order.
    pub fn smooth(&mut self, keep: usize) -> Vec<Smoothed<N, M>> {
        let given_up = self.steps.len().saturating_sub(keep);
        let mut smoothed = Vec::with_capacity(given_up);
        let last = self.last();
        let (mut models, mut probability) = (last.models, last.probability);
        for place in (0..self.steps.len()).rev() {
            if place + 1 < self.steps.len() {
                let after = &self.steps[place + 1];
                (models, probability) = corrected(&self.steps[place], after, (&models, &probability));
            }
            if place < given_up {
                smoothed.push(Smoothed {
                    state: mixture(&probability, &models),
                    probability,
                });
            }
        }
        smoothed.reverse();
        self.steps.drain(..given_up);
        smoothed
    }
}

/// Probabilities after a measurement with these squared innovations of the models, and densities without the
/// exponential; and the logarithm of the likelihood of all models together.
fn weighed<const M: usize>(probability: &[f64; M], squares: &[f64; M], densities: &[f64; M]) -> ([f64; M], f64) {
    let nearest = squares.iter().copied().fold(f64::INFINITY, f64::min);
    let mut weighed: [f64; M] =
        std::array::from_fn(|model| probability[model] * densities[model] * (0.5 * (nearest - squares[model])).exp());
    let sum: f64 = weighed.iter().sum();
    let mut possible = 0.0;
    for value in &mut weighed {
        *value = (*value / sum).max(PROBABILITY_MIN);
        possible += *value;
    }
    (weighed.map(|value| value / possible), sum.ln() - 0.5 * nearest)
}
