//! Positive definiteness of covariances, and the nearest usable covariance otherwise.
//!
//! Covariances from outside can be rounded to a few digits, filled in by hand, or wrong; a filter with a negative
//! eigenvalue in the covariance divides by that eigenvalue sooner or later. [`repaired`] keeps the variances (the most
//! reliable part of a source's covariance) and reduces the correlations as far as needed. The function scales to a
//! correlation matrix, which also makes metres and metres per second comparable, raises eigenvalues that are too small,
//! and scales back. Clipping eigenvalues gives the nearest positive matrix in the Frobenius norm (N. J. Higham,
//! *Computing a nearest symmetric positive semidefinite matrix*, 1988); restoring the unit diagonal afterwards is a
//! scaling, so the matrix stays positive.

use messages::{Covariance, STATE_LEN};

use crate::gaussian::{Matrix6, Vector6, at};

/// Smallest eigenvalue that [`repaired`] leaves in the correlation matrix.
const EIGENVALUE_MIN: f64 = 1e-9;
/// Most iterations of the eigenvalue search; a 6×6 matrix needs a dozen or two.
const EIGEN_ITERATIONS_MAX: usize = 200;
/// Asymmetry that rounding explains, relative to the standard deviations of the two components.
const ASYMMETRY_MAX: f64 = 1e-9;

/// Returns whether a message's covariance is positive definite. Components of variance 0 are unknown, and are left
/// out.
pub fn is_usable(covariance: &Covariance) -> bool {
    // L·D·Lᵀ: D is the remaining variance of each component, given the components before. Needs no roots, and a single
    // division per component.
    let mut rest = covariance.upper;
    for known in 0..STATE_LEN {
        let variance = rest[at(known, known)];
        if covariance.upper[at(known, known)] == 0.0 {
            continue;
        }
        if variance <= 0.0 || variance.is_nan() {
            return false;
        }
        let inverse = 1.0 / variance;
        for row in known + 1..STATE_LEN {
            let slope = rest[at(known, row)] * inverse;
            for column in row..STATE_LEN {
                rest[at(row, column)] -= slope * rest[at(known, column)];
            }
        }
    }
    true
}

/// Whether `covariance` is finite, symmetric up to rounding, and positive definite.
pub fn is_positive_definite(covariance: &Matrix6) -> bool {
    covariance.iter().all(|value| value.is_finite()) && is_symmetric(covariance) && covariance.cholesky().is_some()
}

fn is_symmetric(covariance: &Matrix6) -> bool {
    (0..STATE_LEN).all(|row| {
        (0..row).all(|column| {
            let scale = (covariance[(row, row)] * covariance[(column, column)]).abs().sqrt();
            (covariance[(row, column)] - covariance[(column, row)]).abs() <= ASYMMETRY_MAX * scale
        })
    })
}

/// `covariance` itself if it is positive definite, otherwise the repaired matrix: same variances, symmetric, and
/// correlations reduced as far as needed. `None` if there is nothing to keep: a value that is not finite, or a variance
/// that is not positive.
pub fn repaired(covariance: &Matrix6) -> Option<Matrix6> {
    if is_positive_definite(covariance) {
        return Some(*covariance);
    }
    let usable = covariance.iter().all(|value| value.is_finite())
        && covariance.diagonal().iter().all(|variance| *variance > 0.0);
    if !usable {
        return None;
    }
    let sigma = covariance.diagonal().map(f64::sqrt);
    let symmetric = (covariance + covariance.transpose()) * 0.5;
    let correlation = scaled(&symmetric, &sigma.map(f64::recip));
    let clipped = with_eigenvalues_raised(&correlation)?;
    let unit = scaled(&clipped, &clipped.diagonal().map(|value| value.sqrt().recip()));
    let result = scaled(&unit, &sigma);
    is_positive_definite(&result).then_some(result)
}

/// D·A·D with D the diagonal matrix of `factors`, exactly symmetric if A is.
fn scaled(matrix: &Matrix6, factors: &Vector6) -> Matrix6 {
    Matrix6::from_fn(|row, column| matrix[(row, column)] * (factors[row] * factors[column]))
}

fn with_eigenvalues_raised(correlation: &Matrix6) -> Option<Matrix6> {
    let mut eigen = correlation.try_symmetric_eigen(f64::EPSILON, EIGEN_ITERATIONS_MAX)?;
    eigen.eigenvalues = eigen.eigenvalues.map(|value| value.max(EIGENVALUE_MIN));
    let raised = eigen.recompose();
    Some((raised + raised.transpose()) * 0.5)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::gaussian::unpacked;
    use crate::testing::any_gaussian;

    #[test]
    fn usable_is_what_is_positive_definite_where_something_is_said() {
        let mut covariance = Covariance::diagonal([10.0, 10.0, 0.0], [2.0, 2.0, 0.0]);
        assert!(is_usable(&covariance), "nothing is said of height");
        covariance.set(0, 1, 101.0);
        assert!(!is_usable(&covariance));
        covariance.set(0, 1, f64::NAN);
        assert!(!is_usable(&covariance));
    }

    #[test]
    fn good_ones_are_left_alone() {
        let good = Matrix6::from_diagonal(&Vector6::from_column_slice(&[2500.0, 2500.0, 1e6, 4.0, 4.0, 0.25]));
        assert!(is_positive_definite(&good));
        assert_eq!(repaired(&good), Some(good));
    }

    #[test]
    fn too_strong_correlations_are_pulled_in() {
        let mut bad = Matrix6::identity() * 4.0;
        bad[(0, 3)] = 5.0;
        bad[(3, 0)] = 5.0;
        assert!(!is_positive_definite(&bad));
        let repaired = repaired(&bad).expect("variances are usable");
        assert!(is_positive_definite(&repaired));
        assert!((repaired[(0, 0)] - 4.0).abs() < 1e-9 && (repaired[(3, 3)] - 4.0).abs() < 1e-9);
        assert!(repaired[(0, 3)] > 3.9 && repaired[(0, 3)] < 4.0);
        assert_eq!(repaired[(1, 1)], 4.0);
    }

    #[test]
    fn asymmetry_is_averaged() {
        let mut lopsided = Matrix6::identity();
        lopsided[(0, 1)] = 0.5;
        assert!(!is_positive_definite(&lopsided));
        let repaired = repaired(&lopsided).expect("variances are usable");
        assert!((repaired[(0, 1)] - 0.25).abs() < 1e-12);
        assert_eq!(repaired[(0, 1)], repaired[(1, 0)]);
    }

    #[test]
    fn nothing_to_keep() {
        let mut matrix = Matrix6::identity();
        matrix[(2, 2)] = 0.0;
        assert_eq!(repaired(&matrix), None);
        matrix[(2, 2)] = f64::NAN;
        assert_eq!(repaired(&matrix), None);
        assert!(!is_positive_definite(&matrix));
    }

    proptest! {
        #[test]
        fn any_symmetric_matrix_with_variances_is_made_usable(
            gaussian in any_gaussian(), row in 0usize..6, column in 0usize..6, factor in -3.0..3.0f64,
        ) {
            let mut matrix = unpacked(&gaussian.covariance);
            if row != column {
                let scale = (matrix[(row, row)] * matrix[(column, column)]).sqrt();
                matrix[(row, column)] = factor * scale;
                matrix[(column, row)] = factor * scale;
            }
            let repaired = repaired(&matrix).expect("variances are positive");
            prop_assert!(is_positive_definite(&repaired));
            for axis in 0..STATE_LEN {
                prop_assert!((repaired[(axis, axis)] / matrix[(axis, axis)] - 1.0).abs() < 1e-9);
            }
        }
    }
}
