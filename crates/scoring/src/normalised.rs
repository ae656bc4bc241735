//! Consistency of a track's stated covariance.
//!
//! A track states a covariance P with its position. If P is correct, the normalised square d² = eᵀ P⁻¹ e of the
//! position error e is chi-square distributed with three degrees of freedom, with mean 3 (Bar-Shalom, Li and
//! Kirubarajan, *Estimation with Applications to Tracking and Navigation*, section 5.4, NEES). The mean of d²/3
//! over all pairs is therefore 1 for a consistent tracker, above 1 for an overconfident tracker, and below 1 for a
//! tracker that is more accurate than stated.

use messages::{AXES, Covariance};
use nalgebra::{Matrix3, Vector3};

/// Covariance of a position, m².
pub(crate) type PositionCovariance = Matrix3<f64>;

/// Returns the covariance of the position some seconds after the time of `covariance`, under constant velocity.
pub(crate) fn spread_after(covariance: &Covariance, seconds: f64) -> PositionCovariance {
    Matrix3::from_fn(|row, column| {
        let cross = covariance.get(row, column + AXES) + covariance.get(column, row + AXES);
        let velocity = covariance.get(row + AXES, column + AXES);
        covariance.get(row, column) + seconds * cross + seconds * seconds * velocity
    })
}

/// Returns d²/3; `None` if the covariance is not positive definite.
pub(crate) fn normalised_square(error_m: [f64; AXES], spread_m2: &PositionCovariance) -> Option<f64> {
    let error_m = Vector3::from(error_m);
    let solved = spread_m2.cholesky()?.solve(&error_m);
    Some(error_m.dot(&solved) / AXES as f64).filter(|square| square.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_as_large_as_stated_give_one() {
        let covariance = Covariance::diagonal([3.0, 4.0, 12.0], [1.0; 3]);
        let spread = spread_after(&covariance, 0.0);
        assert_eq!(normalised_square([3.0, -4.0, 12.0], &spread), Some(1.0));
        assert_eq!(normalised_square([6.0, 0.0, 0.0], &spread), Some(4.0 / 3.0));
        assert_eq!(normalised_square([1.0; 3], &PositionCovariance::zeros()), None);
    }

    #[test]
    fn what_is_not_known_of_the_velocity_widens_the_position() {
        let mut covariance = Covariance::diagonal([3.0; 3], [2.0; 3]);
        covariance.set(0, 3, 5.0);
        let spread = spread_after(&covariance, 2.0);
        // 9 + 2·2·5 + 2²·4 east; no correlation north.
        assert_eq!((spread[(0, 0)], spread[(1, 1)], spread[(0, 1)]), (45.0, 25.0, 0.0));
    }
}
