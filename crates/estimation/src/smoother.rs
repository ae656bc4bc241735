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

use nalgebra::{Cholesky, Const, SMatrix, SVector};

/// Weight of a pair of models, relative to all, below which the pair is left out.
const WEIGHT_MIN: f64 = 1e-9;
/// Information relative to that of the filter below which there is none.
const INFORMATION_MIN: f64 = 1e-9;
/// Smallest probability of a model: each must be able to come back.
const PROBABILITY_MIN: f64 = 1e-6;
/// Largest logarithm of a ratio of likelihoods.
const EXPONENT_MAX: f64 = 200.0;

/// Mean and covariance of `N` components.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment<const N: usize> {
    /// Expected value.
    pub mean: SVector<f64, N>,
    /// Covariance.
    pub covariance: SMatrix<f64, N, N>,
}

impl<const N: usize> Moment<N> {
    fn zero() -> Self {
        Self {
            mean: SVector::zeros(),
            covariance: SMatrix::zeros(),
        }
    }

    /// Mixture of states with weights that sum to 1.
    fn mixture<'a>(states: impl Iterator<Item = (f64, &'a Self)> + Clone) -> Self {
        let mut mixed = Self::zero();
        for (weight, state) in states.clone() {
            mixed.mean += state.mean * weight;
        }
        for (weight, state) in states {
            let from_mean = state.mean - mixed.mean;
            mixed.covariance += (state.covariance + from_mean * from_mean.transpose()) * weight;
        }
        mixed
    }

    fn moved(&self, by: &LinearModel<N>) -> Self {
        let covariance = by.transition * self.covariance * by.transition.transpose() + by.noise;
        Self {
            mean: by.transition * self.mean,
            covariance: symmetric(&covariance),
        }
    }
}

/// Motion over one step: x ← transition · x + noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinearModel<const N: usize> {
    /// Transition matrix.
    pub transition: SMatrix<f64, N, N>,
    /// Covariance of the noise.
    pub noise: SMatrix<f64, N, N>,
}

/// How a target moves between two times, under each of `M` models, and switches among the models.
#[derive(Clone, Copy, Debug)]
pub struct Switching<const N: usize, const M: usize> {
    /// The models.
    pub models: [LinearModel<N>; M],
    /// Probability that the model of the row is followed by the model of the column; each row sums to 1.
    pub switches: SMatrix<f64, M, M>,
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

#[derive(Clone, Copy, Debug)]
struct FilteredStep<const N: usize, const M: usize> {
    /// Motion since the step before.
    motion: Switching<N, M>,
    /// States and probabilities of the models before the measurements of this step, and after these measurements.
    predicted: [Moment<N>; M],
    predicted_probability: [f64; M],
    models: [Moment<N>; M],
    probability: [f64; M],
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
        Moment::mixture(step.probability.iter().copied().zip(&step.models))
    }

    /// The expected measurement at the last step and the covariance, without the measurement's covariance.
    pub fn expected(&self) -> (SVector<f64, K>, SMatrix<f64, K, K>) {
        let state = self.filtered();
        (
            state.mean.fixed_rows::<K>(0).into_owned(),
            state.covariance.fixed_view::<K, K>(0, 0).into_owned(),
        )
    }

    fn last(&self) -> &FilteredStep<N, M> {
        &self.steps[self.steps.len() - 1]
    }

    /// Goes on to the next step.
    pub fn advance(&mut self, motion: Switching<N, M>) {
        let before = self.last();
        let mut probability = [0.0; M];
        let mut models = [Moment::zero(); M];
        for (after, moment) in models.iter_mut().enumerate() {
            let joint: [f64; M] = std::array::from_fn(|from| before.probability[from] * motion.switches[(from, after)]);
            let sum: f64 = joint.iter().sum();
            probability[after] = sum;
            let weights = joint.map(|value| if sum > 0.0 { value / sum } else { 1.0 / M as f64 });
            let mixed = Moment::mixture(
                weights
                    .into_iter()
                    .zip(&before.models)
                    .filter(|(weight, _)| *weight > 0.0),
            );
            *moment = mixed.moved(&motion.models[after]);
        }
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
        let mut updated = *self.last();
        let mut logarithms = [0.0; M];
        for (model, logarithm) in updated.models.iter_mut().zip(&mut logarithms) {
            let s = model.covariance.fixed_view::<K, K>(0, 0) + r;
            let factored = Cholesky::<f64, Const<K>>::new(s)?;
            let residual = measured - model.mean.fixed_rows::<K>(0);
            let cross = model.covariance.fixed_rows::<K>(0).into_owned();
            let gain = factored.solve(&cross).transpose();
            let squared = residual.dot(&factored.solve(&residual));
            *logarithm = -0.5 * (squared + logarithm_of_determinant(&factored));
            if !logarithm.is_finite() {
                return None;
            }
            model.mean += gain * residual;
            model.covariance = symmetric(&(model.covariance - gain * cross));
        }
        let gained;
        (updated.probability, gained) = weighed(&updated.probability, &logarithms);
        *self.steps.back_mut()? = updated;
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
                    state: Moment::mixture(probability.iter().copied().zip(&models)),
                    probability,
                });
            }
        }
        smoothed.reverse();
        self.steps.drain(..given_up);
        smoothed
    }
}

/// The smoothed states of the models at a step, from the smoothed states at the following step.
fn corrected<const N: usize, const M: usize>(
    step: &FilteredStep<N, M>,
    after: &FilteredStep<N, M>,
    (smoothed, smoothed_probability): (&[Moment<N>; M], &[f64; M]),
) -> ([Moment<N>; M], [f64; M]) {
    let mut pairs = [[Moment::zero(); M]; M];
    let mut weights = [[0.0; M]; M];
    for (to, share) in smoothed_probability.iter().enumerate() {
        let future = Future::new(&after.predicted[to], &smoothed[to]);
        let Some(future) = future.filter(|_| *share > WEIGHT_MIN) else {
            continue;
        };
        let mut logarithms = [f64::NEG_INFINITY; M];
        for (from, model) in step.models.iter().enumerate() {
            let prior = step.probability[from] * after.motion.switches[(from, to)];
            if prior < WEIGHT_MIN * after.predicted_probability[to] {
                continue;
            }
            if let Some((pair, met)) = future.pair(model, &after.motion.models[to]) {
                (pairs[from][to], logarithms[from]) = (pair, prior.ln() + met);
            }
        }
        let best = logarithms.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        if best > f64::NEG_INFINITY {
            let likelihoods = logarithms.map(|logarithm| (logarithm - best).exp());
            let sum: f64 = likelihoods.iter().sum();
            for (from, likelihood) in likelihoods.into_iter().enumerate() {
                weights[from][to] = share * likelihood / sum;
            }
        }
    }
    let probability = weights.map(|of_model| of_model.iter().sum::<f64>());
    let all: f64 = probability.iter().sum();
    if all <= 0.0 {
        return (step.models, step.probability);
    }
    let mut models = step.models;
    for (from, model) in models.iter_mut().enumerate() {
        let sum = probability[from];
        if sum > 0.0 {
            let parts = weights[from].iter().map(|weight| weight / sum).zip(&pairs[from]);
            *model = Moment::mixture(parts.filter(|(weight, _)| *weight > 0.0));
        }
    }
    (models, probability.map(|value| value / all))
}

/// Information of the measurements of a step and of later steps on the state at this step, if a model holds there: a
/// likelihood in the form of a Gaussian. Coordinates are relative to the state that the filter predicted.
struct Future<const N: usize> {
    origin: SVector<f64, N>,
    information: SMatrix<f64, N, N>,
    vector: SVector<f64, N>,
}

impl<const N: usize> Future<N> {
    /// The likelihood that makes `smoothed` of `predicted`. `None` if a covariance has no inverse.
    fn new(predicted: &Moment<N>, smoothed: &Moment<N>) -> Option<Self> {
        let root = Cholesky::<f64, Const<N>>::new(predicted.covariance)?.l();
        let unroot = root.solve_lower_triangular(&SMatrix::identity())?;
        let inverse = Cholesky::<f64, Const<N>>::new(smoothed.covariance)?.inverse();
        // In coordinates in which the prediction has a covariance of 1.
        let gained = root.transpose() * inverse * root - SMatrix::identity();
        let vector = root.transpose() * (inverse * (smoothed.mean - predicted.mean));
        let (gained, vector) = positive_part(symmetric(&gained), vector);
        Some(Self {
            origin: predicted.mean,
            information: symmetric(&(unroot.transpose() * gained * unroot)),
            vector: unroot.transpose() * vector,
        })
    }

    /// A model before a step and this model after the step: the smoothed state before the step, and the logarithm of
    /// the mean likelihood under the prediction of the pair. `None` if a covariance has no inverse.
    fn pair(&self, before: &Moment<N>, motion: &LinearModel<N>) -> Option<(Moment<N>, f64)> {
        let predicted = before.moved(motion);
        let factored = Cholesky::<f64, Const<N>>::new(predicted.covariance)?;
        let away = predicted.mean - self.origin;
        let prior = factored.solve(&away);
        let sum = prior + self.vector;
        let together = Cholesky::<f64, Const<N>>::new(symmetric(&(factored.inverse() + self.information)))?;
        let (there, covariance) = (together.solve(&sum), together.inverse());
        // The recursion of Rauch, Tung and Striebel.
        let gain = factored.solve(&(motion.transition * before.covariance)).transpose();
        let smoothed = Moment {
            mean: before.mean + gain * (there - away),
            covariance: symmetric(&(before.covariance + gain * (covariance - predicted.covariance) * gain.transpose())),
        };
        let determinants = logarithm_of_determinant(&factored) + logarithm_of_determinant(&together);
        let met = 0.5 * (there.dot(&sum) - away.dot(&prior) - determinants);
        met.is_finite().then_some((smoothed, met))
    }
}

/// The part of an information matrix and vector that is positive. Merged states may contradict each other a little:
/// where the future would take information away, the future has none.
fn positive_part<const N: usize>(
    mut matrix: SMatrix<f64, N, N>,
    mut vector: SVector<f64, N>,
) -> (SMatrix<f64, N, N>, SVector<f64, N>) {
    let (mut kept, mut kept_vector) = (SMatrix::zeros(), SVector::zeros());
    for _ in 0..N {
        let diagonal = matrix.diagonal();
        let (place, pivot) = diagonal.argmax();
        if pivot < INFORMATION_MIN {
            break;
        }
        let direction = matrix.column(place) / pivot;
        let (square, along) = (direction * direction.transpose() * pivot, direction * vector[place]);
        kept += square;
        kept_vector += along;
        matrix -= square;
        vector -= along;
    }
    (kept, kept_vector)
}

fn logarithm_of_determinant<const N: usize>(factored: &Cholesky<f64, Const<N>>) -> f64 {
    2.0 * factored
        .l_dirty()
        .diagonal()
        .iter()
        .map(|value| value.ln())
        .sum::<f64>()
}

/// Probabilities after a measurement with these logarithms of likelihoods, and that of all models together.
fn weighed<const M: usize>(probability: &[f64; M], logarithms: &[f64; M]) -> ([f64; M], f64) {
    let best = logarithms.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let mut weighed: [f64; M] = std::array::from_fn(|model| {
        let likelihood = (logarithms[model] - best).max(-EXPONENT_MAX).exp();
        probability[model] * likelihood
    });
    let sum: f64 = weighed.iter().sum();
    let mut possible = 0.0;
    for value in &mut weighed {
        *value = (*value / sum).max(PROBABILITY_MIN);
        possible += *value;
    }
    (weighed.map(|value| value / possible), best + sum.ln())
}

fn symmetric<const N: usize>(matrix: &SMatrix<f64, N, N>) -> SMatrix<f64, N, N> {
    (matrix + matrix.transpose()) * 0.5
}
