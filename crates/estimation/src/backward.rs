//! The backward step of the smoother: the states of the models at a step, from the smoothed states at the next step.
//!
//! The obvious form of the recursion inverts two covariances for each pair of models: of the prediction, and of the
//! prediction together with the future. With ten models there are a hundred pairs at each step.
//!
//! Here the future of each model after the step is a measurement: the likelihood that makes the smoothed state of the
//! predicted state is exp(−½·|Lᵀ·(x − origin) − y|²), with as many columns of L as the future has information. A pair
//! is then a Kalman update of the state before the step, by a measurement with unit covariance of Lᵀ·F·x: without an
//! inverse, with one decomposition. The mixture of the pairs is summed relative to the filtered state, so that each
//! covariance enters once.
//!
//! Limits: a pair that no filter expects (below [`WEIGHT_MIN`]) is left out. A pair that the measurements make
//! improbable is not: a model without its future would be wrong when it becomes probable again, by tens of metres.
//!
//! Sources: those of [`crate::smoother`]; for the measurement that stands for the future, M. Briers, A. Doucet,
//! S. Maskell, *Smoothing algorithms for state–space models*, Annals of the Institute of Statistical Mathematics 62
//! (2010).

#![expect(clippy::needless_range_loop, reason = "rows and columns, as in the formulas")]

use crate::filtered_step::{FilteredStep, LinearModel, Moment};
use crate::rows::{Pivots, Rows, add_scaled, add_square, dot, root, symmetric, times};

/// Weight of a pair of models, relative to the model after the step, below which the pair is not looked at.
const WEIGHT_MIN: f64 = 1e-9;
/// Probability of a pair below which sums over pairs have no digits left.
const PAIR_MIN: f64 = 1e-200;
/// Information relative to that of the filter below which there is none.
const INFORMATION_MIN: f64 = 1e-9;

/// The smoothed states of the models at a step, from the smoothed states at the following step.
pub(crate) fn corrected<const N: usize, const M: usize>(
    step: &FilteredStep<N, M>,
    after: &FilteredStep<N, M>,
    (smoothed, smoothed_probability): (&[Moment<N>; M], &[f64; M]),
) -> ([Moment<N>; M], [f64; M]) {
    let mut sums: [PairSum<N>; M] = [PairSum::default(); M];
    // In one place for all models after the step: clearing them takes longer than a pair.
    let mut pairs: [Option<Pair<N>>; M] = [None; M];
    for (to, share) in smoothed_probability.iter().enumerate() {
        let future = Future::new(&after.predicted[to], &smoothed[to]);
        let Some(future) = future.filter(|_| *share > WEIGHT_MIN) else {
            continue;
        };
        let measured = future.before(&after.motion.models[to]);
        let mut weights = [0.0; M];
        let mut squares = [f64::INFINITY; M];
        for from in 0..M {
            let prior = step.probability[from] * after.motion.switches[(from, to)];
            if prior < WEIGHT_MIN * after.predicted_probability[to] {
                continue;
            }
            pairs[from] = measured.pair(&step.models[from]);
            if let Some(pair) = &pairs[from] {
                (squares[from], weights[from]) = (pair.squared, prior / pair.pivots.determinant.sqrt());
            }
        }
        let nearest = squares.iter().copied().fold(f64::INFINITY, f64::min);
        for (weight, squared) in weights.iter_mut().zip(squares).filter(|(weight, _)| **weight > 0.0) {
            *weight *= (0.5 * (nearest - squared)).exp();
        }
        let all: f64 = weights.iter().sum();
        if !(all > 0.0 && all.is_finite()) {
            continue;
        }
        for ((pair, weight), sum) in pairs.iter().zip(weights).zip(&mut sums) {
            let weight = share * weight / all;
            sum.probability += weight;
            // However small: a model without its future would be wrong when it comes back.
            if let Some(pair) = pair.as_ref().filter(|_| weight > PAIR_MIN) {
                sum.add(pair, weight);
            }
        }
    }
    let all: f64 = sums.iter().map(|sum| sum.probability).sum();
    if all <= 0.0 {
        return (step.models, step.probability);
    }
    let mut models = step.models;
    for (model, sum) in models.iter_mut().zip(&sums) {
        sum.correct(model);
    }
    (models, sums.map(|sum| sum.probability / all))
}

/// Information of the measurements of a step and of later steps on the state at this step, if a model holds there: a
/// likelihood in the form of a measurement with unit covariance.
struct Future<const N: usize> {
    /// Columns of L, as rows; a column without information is zero.
    columns: Rows<N>,
    /// Measured Lᵀ·x.
    measured: [f64; N],
}

impl<const N: usize> Future<N> {
    /// The likelihood that makes `smoothed` of `predicted`. `None` if a covariance has no inverse.
    fn new(predicted: &Moment<N>, smoothed: &Moment<N>) -> Option<Self> {
        let lower = root(&predicted.covariance.data.0)?;
        let smoothed_lower = root(&smoothed.covariance.data.0)?;
        // In coordinates in which the prediction has a covariance of 1, the information is TᵀT with T below, and the
        // information beyond the prediction is TᵀT − 1.
        let mut relative = lower;
        let mut along: [f64; N] = (smoothed.mean - predicted.mean).into();
        for row in 0..N {
            for before in 0..row {
                let earlier = relative[before];
                add_scaled(&mut relative[row], &earlier, -smoothed_lower[row][before]);
                along[row] -= smoothed_lower[row][before] * along[before];
            }
            let inverse = 1.0 / smoothed_lower[row][row];
            relative[row].iter_mut().for_each(|value| *value *= inverse);
            along[row] *= inverse;
        }
        let (mut gained, mut vector) = ([[0.0; N]; N], [0.0; N]);
        for (row, value) in relative.iter().zip(along) {
            add_square(&mut gained, row, 1.0);
            add_scaled(&mut vector, row, value);
        }
        for (place, row) in gained.iter_mut().enumerate() {
            row[place] -= 1.0;
        }
        let (mut columns, mut measured) = positive_part(gained, vector);
        // Back to metres: Lᵀ = Cᵀ·(lower)⁻¹ for the columns C, and relative to zero.
        for (column, value) in columns.iter_mut().zip(&mut measured) {
            for place in (0..N).rev() {
                for below in place + 1..N {
                    column[place] -= lower[below][place] * column[below];
                }
                column[place] /= lower[place][place];
            }
            *value += dot(column, &predicted.mean.into());
        }
        Some(Self { columns, measured })
    }

    /// The same measurement of the state before a motion.
    fn before(&self, motion: &LinearModel<N>) -> MeasuredBefore<N> {
        let transition = &motion.transition.data.0;
        let mut of_state = [[0.0; N]; N];
        let mut transposed = [[0.0; N]; N];
        for (row, column) in self.columns.iter().enumerate() {
            for component in 0..N {
                let value = dot(column, &transition[component]);
                of_state[row][component] = value;
                transposed[component][row] = value;
            }
        }
        let noisy = times(&self.columns, &motion.noise.data.0);
        let mut noise = [[0.0; N]; N];
        for row in 0..N {
            for column in 0..N {
                noise[row][column] = dot(&noisy[row], &self.columns[column]);
            }
            noise[row][row] += 1.0;
        }
        MeasuredBefore {
            of_state,
            transposed,
            noise,
            measured: self.measured,
        }
    }
}

/// The future as a measurement of the state before a step.
struct MeasuredBefore<const N: usize> {
    of_state: Rows<N>,
    transposed: Rows<N>,
    noise: Rows<N>,
    measured: [f64; N],
}

/// A model before a step that meets the future of a model after the step.
#[derive(Clone, Copy)]
struct Pair<const N: usize> {
    pivots: Pivots<N>,
    cross: Rows<N>,
    eliminated: [f64; N],
    /// Squared length of the innovation.
    squared: f64,
}

impl<const N: usize> MeasuredBefore<N> {
    /// Meets a state; `None` if the innovation has no covariance.
    #[inline(always)]
    fn pair(&self, before: &Moment<N>) -> Option<Pair<N>> {
        let mean = &before.mean.data.0[0];
        let cross = times(&self.of_state, &before.covariance.data.0);
        let spread = std::array::from_fn(|row| {
            let mut sum = self.noise[row];
            for (value, transposed) in cross[row].iter().zip(&self.transposed) {
                add_scaled(&mut sum, transposed, *value);
            }
            sum
        });
        let pivots = Pivots::of(spread)?;
        let eliminated = pivots.eliminated(std::array::from_fn(|row| {
            self.measured[row] - dot(&self.of_state[row], mean)
        }));
        let squared = pivots.squared(&eliminated);
        squared.is_finite().then_some(Pair {
            pivots,
            cross,
            eliminated,
            squared,
        })
    }
}

/// Weighted sum over the pairs of a model before a step, relative to the filtered state of that model.
#[derive(Clone, Copy)]
struct PairSum<const N: usize> {
    probability: f64,
    away: [f64; N],
    square: Rows<N>,
}

impl<const N: usize> Default for PairSum<N> {
    fn default() -> Self {
        Self {
            probability: 0.0,
            away: [0.0; N],
            square: [[0.0; N]; N],
        }
    }
}

impl<const N: usize> PairSum<N> {
    fn add(&mut self, pair: &Pair<N>, weight: f64) {
        let (white, residual) = pair.pivots.whitened(pair.cross, pair.eliminated);
        let mut away = [0.0; N];
        for (row, value) in white.iter().zip(residual) {
            add_scaled(&mut away, row, value);
            add_square(&mut self.square, row, -weight);
        }
        add_square(&mut self.square, &away, weight);
        add_scaled(&mut self.away, &away, weight);
    }

    /// Moves the filtered state to the mean of the pairs.
    fn correct(&self, model: &mut Moment<N>) {
        if self.probability <= PAIR_MIN {
            return;
        }
        let share = 1.0 / self.probability;
        let away = self.away.map(|value| share * value);
        let covariance = &mut model.covariance.data.0;
        for (row, square) in covariance.iter_mut().zip(&self.square) {
            add_scaled(row, square, share);
        }
        add_square(covariance, &away, -1.0);
        symmetric(covariance);
        for (mean, away) in model.mean.iter_mut().zip(away) {
            *mean += away;
        }
    }
}

/// The part of an information matrix and vector that is positive, as columns and the measured value of each. Merged
/// states may contradict each other a little: where the future would take information away, the future has none.
#[inline(always)]
fn positive_part<const N: usize>(mut matrix: Rows<N>, mut vector: [f64; N]) -> (Rows<N>, [f64; N]) {
    let (mut columns, mut measured) = ([[0.0; N]; N], [0.0; N]);
    for (column, measured) in columns.iter_mut().zip(&mut measured) {
        let mut place = 0;
        for other in 1..N {
            if matrix[other][other] > matrix[place][place] {
                place = other;
            }
        }
        let pivot = matrix[place][place];
        if pivot.is_nan() || pivot < INFORMATION_MIN {
            break;
        }
        let scale = 1.0 / pivot.sqrt();
        *column = matrix[place].map(|value| scale * value);
        *measured = scale * vector[place];
        add_square(&mut matrix, column, -1.0);
        add_scaled(&mut vector, column, -*measured);
    }
    (columns, measured)
}
