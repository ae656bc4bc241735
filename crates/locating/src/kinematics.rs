//! State of an emitter that rests or moves straight on: position and, with four components, velocity.

use nalgebra::{Matrix2, SMatrix, SVector};

/// Returns the position `after_s` seconds after the reference time.
pub(crate) fn position<const D: usize>(state: &SVector<f64, D>, after_s: f64) -> [f64; 2] {
    match D {
        4 => [state[0] + after_s * state[2], state[1] + after_s * state[3]],
        _ => [state[0], state[1]],
    }
}

/// Returns the derivative by the state of a bearing `after_s` seconds after the reference time.
pub(crate) fn sensitivity<const D: usize>(gradient: [f64; 2], after_s: f64) -> SVector<f64, D> {
    SVector::from_fn(|axis, _| match axis {
        0 | 1 => gradient[axis],
        _ => gradient[axis - 2] * after_s,
    })
}

/// Returns the matrix that moves a state by `after_s` seconds.
pub(crate) fn transition<const D: usize>(after_s: f64) -> SMatrix<f64, D, D> {
    let mut transition = SMatrix::identity();
    if D == 4 {
        transition[(0, 2)] = after_s;
        transition[(1, 3)] = after_s;
    }
    transition
}

/// Adds white noise in the velocity of a point, or in the acceleration of a straight motion.
pub(crate) fn add_process_noise<const D: usize>(covariance: &mut SMatrix<f64, D, D>, density: f64, after_s: f64) {
    let q = density * after_s;
    for axis in 0..2 {
        if D == 4 {
            covariance[(axis, axis)] += q * after_s * after_s / 3.0;
            covariance[(axis, axis + 2)] += q * after_s / 2.0;
            covariance[(axis + 2, axis)] += q * after_s / 2.0;
            covariance[(axis + 2, axis + 2)] += q;
        } else {
            covariance[(axis, axis)] += q;
        }
    }
}

/// Returns the longest half-axis of the error ellipse.
pub(crate) fn longest_half_axis(covariance: &Matrix2<f64>) -> f64 {
    let mean = 0.5 * (covariance[(0, 0)] + covariance[(1, 1)]);
    let half = 0.5 * (covariance[(0, 0)] - covariance[(1, 1)]);
    (mean + half.hypot(covariance[(0, 1)])).sqrt()
}
