//! Statistical (Mahalanobis) distance of two states.
//!
//! 100 m apart is much for two accurate sensors and nothing for two coarse sensors. d² = Δᵀ·S⁻¹·Δ measures the
//! difference Δ in units of the difference's covariance S; for two estimates of the same target with independent
//! errors, S = P₁ + P₂, and d² follows a chi-square distribution with as many degrees of freedom as components
//! compared: 99 % lie below 9.210, 13.277 and 16.812 for 2, 4 and 6 components.
//!
//! Limit: the errors of two tracks of the same target are *not* independent, since both lag behind the same manoeuvre.
//! The true S is P₁ + P₂ − P₁₂ − P₂₁, so d² is too small (on average 1.1 instead of 2 for a single axis at manoeuvring
//! index 0.3): a gate set from the table admits slightly more than the table's probability.

use nalgebra::{SMatrix, SVector};

use crate::Gaussian;

/// Which components of two states are compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ComparedComponents {
    /// x, y.
    HorizontalPosition,
    /// x, y, z.
    Position,
    /// x, y, vx, vy.
    HorizontalPositionAndVelocity,
    /// x, y, z, vx, vy, vz.
    PositionAndVelocity,
}

impl ComparedComponents {
    /// How many components are compared: the degrees of freedom of the squared distance.
    pub fn degrees_of_freedom(self) -> usize {
        match self {
            Self::HorizontalPosition => 2,
            Self::Position => 3,
            Self::HorizontalPositionAndVelocity => 4,
            Self::PositionAndVelocity => 6,
        }
    }
}

/// Length of a vector in the plane. `f64::hypot` takes five times as many instructions for values whose squares
/// overflow or vanish, such as no metres do.
#[inline]
pub fn length([x, y]: [f64; 2]) -> f64 {
    (x * x + y * y).sqrt()
}

/// Squared statistical distance d² of two states of the same time, the errors taken as independent; infinite if the sum
/// of the covariances is not positive definite or a value not finite.
pub fn statistical_distance(a: &Gaussian, b: &Gaussian, components: ComparedComponents) -> f64 {
    match components {
        ComparedComponents::HorizontalPosition => over(a, b, [0, 1]),
        ComparedComponents::Position => over(a, b, [0, 1, 2]),
        ComparedComponents::HorizontalPositionAndVelocity => over(a, b, [0, 1, 3, 4]),
        ComparedComponents::PositionAndVelocity => over(a, b, [0, 1, 2, 3, 4, 5]),
    }
}

fn over<const D: usize>(a: &Gaussian, b: &Gaussian, components: [usize; D]) -> f64 {
    let difference = SVector::<f64, D>::from_fn(|row, _| a.mean[components[row]] - b.mean[components[row]]);
    let covariance = SMatrix::<f64, D, D>::from_fn(|row, column| {
        let (row, column) = (components[row], components[column]);
        a.covariance.get(row, column) + b.covariance.get(row, column)
    });
    squared_length(&difference, &covariance)
}

/// Δᵀ·S⁻¹·Δ; infinite if `covariance` is not positive definite or a value not finite.
///
/// Reads only the lower triangle of `covariance`.
pub fn squared_length<const D: usize>(difference: &SVector<f64, D>, covariance: &SMatrix<f64, D, D>) -> f64 {
    let Some(factor) = covariance.cholesky() else {
        return f64::INFINITY;
    };
    // S = L·Lᵀ, so d² is the squared length of L⁻¹·Δ.
    match factor.l().solve_lower_triangular(difference) {
        Some(whitened) if whitened.iter().all(|value| value.is_finite()) => whitened.norm_squared(),
        _ => f64::INFINITY,
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Matrix2, Rotation3, Vector2, Vector3};
    use proptest::prelude::*;

    use super::*;
    use crate::gaussian::{Matrix6, Vector6, packed, unpacked};
    use crate::testing::any_gaussian;
    use ComparedComponents::*;

    const ALL: [ComparedComponents; 4] = [
        HorizontalPosition,
        Position,
        HorizontalPositionAndVelocity,
        PositionAndVelocity,
    ];

    #[test]
    fn known_values() {
        let a = Gaussian {
            mean: [3.0, 4.0, 12.0, 1.0, 2.0, 2.0],
            covariance: packed(&(Matrix6::identity() * 0.5)),
        };
        let b = Gaussian { mean: [0.0; 6], ..a };
        for (components, expected) in ALL.into_iter().zip([25.0, 169.0, 30.0, 178.0]) {
            assert!((statistical_distance(&a, &b, components) - expected).abs() < 1e-9);
        }
        let s = Matrix2::new(4.0, 1.0, 1.0, 2.0);
        let expected = (2.0 + 4.0 - 2.0) / 7.0;
        assert!((squared_length(&Vector2::new(1.0, 1.0), &s) - expected).abs() < 1e-12);
    }

    #[test]
    fn unusable_covariances_are_infinitely_far() {
        let singular = Matrix2::new(1.0, 1.0, 1.0, 1.0);
        assert_eq!(squared_length(&Vector2::new(1.0, 0.0), &singular), f64::INFINITY);
        let unknown = Vector2::new(f64::NAN, 0.0);
        assert_eq!(squared_length(&unknown, &Matrix2::identity()), f64::INFINITY);
        assert_eq!(
            squared_length(&Vector2::zeros(), &(Matrix2::identity() * f64::NAN)),
            f64::INFINITY
        );
    }

    /// `gaussian` in a frame that is turned and moved.
    fn carried(gaussian: &Gaussian, turn: &Rotation3<f64>, shift: &Vector3<f64>) -> Gaussian {
        let mut both = Matrix6::zeros();
        both.fixed_view_mut::<3, 3>(0, 0).copy_from(turn.matrix());
        both.fixed_view_mut::<3, 3>(3, 3).copy_from(turn.matrix());
        let mut mean = both * Vector6::from(gaussian.mean);
        let mut position = mean.fixed_rows_mut::<3>(0);
        position += shift;
        Gaussian {
            mean: mean.into(),
            covariance: packed(&(both * unpacked(&gaussian.covariance) * both.transpose())),
        }
    }

    proptest! {
        #[test]
        fn frame_does_not_matter(
            a in any_gaussian(), b in any_gaussian(), angle in -3.1..3.1f64, tilt in -1.0..1.0f64,
            shift in prop::array::uniform3(-1e5..1e5f64),
        ) {
            let shift = Vector3::from(shift);
            for components in ALL {
                let horizontal = components.degrees_of_freedom() % 2 == 0 && components != PositionAndVelocity;
                let turn = Rotation3::from_euler_angles(if horizontal { 0.0 } else { tilt }, 0.0, angle);
                let there = statistical_distance(&a, &b, components);
                let here = statistical_distance(&carried(&a, &turn, &shift), &carried(&b, &turn, &shift), components);
                prop_assert!((there - here).abs() <= 1e-6 * (1.0 + there), "{there} {here}");
                prop_assert!(there >= 0.0);
                prop_assert_eq!(there, statistical_distance(&b, &a, components));
            }
        }
    }
}
