//! Parts of a filter with several linear models: a moment, a motion, and a step with both, as the smoother keeps them.
//!
//! Sources: those of [`crate::smoother`].

use nalgebra::{SMatrix, SVector};

/// Mean and covariance of `N` components.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment<const N: usize> {
    /// Expected value.
    pub mean: SVector<f64, N>,
    /// Covariance.
    pub covariance: SMatrix<f64, N, N>,
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

/// States and probabilities of the models at a step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FilteredStep<const N: usize, const M: usize> {
    /// Motion since the step before.
    pub(crate) motion: Switching<N, M>,
    /// Before the measurements of this step, and after these measurements.
    pub(crate) predicted: [Moment<N>; M],
    pub(crate) predicted_probability: [f64; M],
    pub(crate) models: [Moment<N>; M],
    pub(crate) probability: [f64; M],
}
