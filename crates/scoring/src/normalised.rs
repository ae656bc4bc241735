//! Consistency of a track's stated covariance.
//!
//! A track states a covariance P with its position and velocity. If P is correct, the normalised square
//! d² = eᵀ P⁻¹ e of the error e in n components is chi-square distributed with n degrees of freedom, with mean n
//! (Bar-Shalom, Li and Kirubarajan, *Estimation with Applications to Tracking and Navigation*, section 5.4, NEES).
//! The mean of d²/n over all pairs is therefore 1 for a consistent tracker, above 1 for an overconfident tracker,
//! and below 1 for a tracker that is more accurate than stated.

use messages::{AXES, Covariance};
use nalgebra::{SMatrix, SVector};

/// Returns the covariance some seconds later, under constant velocity.
pub(crate) fn covariance_after(covariance: &Covariance, seconds: f64) -> Covariance {
    let mut later = *covariance;
    for row in 0..AXES {
        for column in 0..AXES {
            let velocity = covariance.get(row + AXES, column + AXES);
            if row <= column {
                let cross = covariance.get(row, column + AXES) + covariance.get(column, row + AXES);
                let position = covariance.get(row, column) + seconds * cross + seconds * seconds * velocity;
                later.set(row, column, position);
            }
            later.set(
                row,
                column + AXES,
                covariance.get(row, column + AXES) + seconds * velocity,
            );
        }
    }
    later
}

/// Returns d²/n of an error in these components of position and velocity; `None` if their covariance is not positive
/// definite.
pub(crate) fn normalised_square<const N: usize>(
    error: [f64; N],
    covariance: &Covariance,
    components: [usize; N],
) -> Option<f64> {
    let error = SVector::from(error);
    let spread = SMatrix::<f64, N, N>::from_fn(|row, column| covariance.get(components[row], components[column]));
    let solved = spread.cholesky()?.solve(&error);
    Some(error.dot(&solved) / N as f64).filter(|square| square.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_as_large_as_stated_give_one() {
        let covariance = Covariance::diagonal([3.0, 4.0, 12.0], [1.0, 2.0, 0.5]);
        let square = |error| normalised_square(error, &covariance, [0, 1, 2]);
        assert_eq!(square([3.0, -4.0, 12.0]), Some(1.0));
        assert_eq!(square([6.0, 0.0, 0.0]), Some(4.0 / 3.0));
        assert_eq!(normalised_square([2.0, 4.0], &covariance, [3, 4]), Some(4.0));
        assert_eq!(normalised_square([1.0], &covariance, [5]), Some(4.0));
        assert_eq!(normalised_square([1.0; 3], &Covariance::default(), [0, 1, 2]), None);
    }

    #[test]
    fn what_is_not_known_of_the_velocity_widens_the_position() {
        let mut covariance = Covariance::diagonal([3.0; 3], [2.0; 3]);
        covariance.set(0, 3, 5.0);
        let later = covariance_after(&covariance, 2.0);
        // 9 + 2·2·5 + 2²·4 east; 5 + 2·4 between position and velocity east; no correlation north.
        assert_eq!((later.get(0, 0), later.get(1, 1), later.get(0, 1)), (45.0, 25.0, 0.0));
        assert_eq!((later.get(0, 3), later.get(1, 4), later.get(0, 4)), (13.0, 8.0, 0.0));
        assert_eq!(later.get(3, 3), 4.0);
    }
}
