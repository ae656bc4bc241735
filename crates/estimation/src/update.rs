//! Update: a measured position improves a state.
//!
//! The Kalman filter's gain weighs prediction against measurement by their covariances. The textbook form of the
//! new covariance, (I − K·H)·P, is a difference of nearly equal matrices when the measurement is accurate, and loses
//! symmetry to rounding. With S = L·Lᵀ and W = L⁻¹·H·P, the same is P − Wᵀ·W: symmetric by construction, one
//! factorisation for gain, covariance, distance and likelihood, and a third of the work of the Joseph form (Bar-Shalom
//! et al. 2001, chapters 5 and 7).

use messages::STATE_LEN;
use nalgebra::{SMatrix, SVector};

use crate::Gaussian;

/// By how much a measurement differed from what was expected, and how much it was allowed to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Innovation<const D: usize> {
    /// Measured minus predicted position, metres.
    pub residual_m: SVector<f64, D>,
    /// Covariance of the residual, m².
    pub covariance_m2: SMatrix<f64, D, D>,
    /// Squared statistical length of the residual: chi-square with D degrees of freedom if all is as modelled.
    pub squared_distance: f64,
    /// Logarithm of the determinant of the residual's covariance: what a likelihood needs besides.
    pub log_determinant: f64,
}

impl Gaussian {
    /// Updates with a measured position in the first `D` axes (2: east and north; 3: also up) of covariance
    /// `covariance_m2`.
    ///
    /// `None`, and no change, if the residual's covariance is not positive definite or a value not finite.
    pub fn update_position<const D: usize>(
        &mut self,
        measured_m: SVector<f64, D>,
        covariance_m2: SMatrix<f64, D, D>,
    ) -> Option<Innovation<D>> {
        const { assert!(D == 2 || D == 3, "a position has two or three axes") };
        let residual = measured_m - self.mean.fixed_rows::<D>(0);
        let s = self.covariance.fixed_view::<D, D>(0, 0) + covariance_m2;
        let lower = lower_factor(&s)?;
        let whitened = forward(&lower, &residual);
        let squared_distance = whitened.norm_squared();
        if !squared_distance.is_finite() {
            return None;
        }
        let rows: [SVector<f64, D>; STATE_LEN] = std::array::from_fn(|row| {
            let cross = SVector::<f64, D>::from_fn(|axis, _| self.covariance[(row, axis)]);
            forward(&lower, &cross)
        });
        for row in 0..STATE_LEN {
            self.mean[row] += rows[row].dot(&whitened);
            for column in row..STATE_LEN {
                let value = self.covariance[(row, column)] - rows[row].dot(&rows[column]);
                self.covariance[(row, column)] = value;
                self.covariance[(column, row)] = value;
            }
        }
        let root = (0..D).fold(1.0, |product, axis| product * lower[(axis, axis)]);
        Some(Innovation {
            residual_m: residual,
            covariance_m2: s,
            squared_distance,
            log_determinant: 2.0 * root.ln(),
        })
    }
}

/// L of S = L·Lᵀ; `None` if `s` is not positive definite.
fn lower_factor<const D: usize>(s: &SMatrix<f64, D, D>) -> Option<SMatrix<f64, D, D>> {
    let mut lower = SMatrix::<f64, D, D>::zeros();
    for column in 0..D {
        for row in column..D {
            let mut value = s[(row, column)];
            for k in 0..column {
                value -= lower[(row, k)] * lower[(column, k)];
            }
            if row > column {
                lower[(row, column)] = value / lower[(column, column)];
            } else if value > 0.0 {
                lower[(column, column)] = value.sqrt();
            } else {
                // Not a number, too.
                return None;
            }
        }
    }
    Some(lower)
}

/// L⁻¹·b.
fn forward<const D: usize>(lower: &SMatrix<f64, D, D>, b: &SVector<f64, D>) -> SVector<f64, D> {
    let mut x = *b;
    for row in 0..D {
        for k in 0..row {
            x[row] -= lower[(row, k)] * x[k];
        }
        x[row] /= lower[(row, row)];
    }
    x
}

#[cfg(test)]
mod tests {
    use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};
    use proptest::prelude::*;

    use super::*;
    use crate::definite::is_positive_definite;
    use crate::gaussian::Matrix6;
    use crate::motion::{AxisNoise, NearlyConstantVelocity};
    use crate::testing::any_gaussian;

    /// The published steady state at T = 1, R = 1, manoeuvring index 1 holds for piecewise-constant acceleration.
    #[test]
    fn steady_state_of_the_literature() {
        let mut gaussian = Gaussian {
            mean: nalgebra::zero(),
            covariance: Matrix6::identity() * 100.0,
        };
        for _ in 0..200 {
            gaussian = gaussian.moved(1.0, [AxisNoise::piecewise_constant(1.0, 1.0); 3]);
            let before = gaussian.mean;
            // A measurement one metre east of the prediction shows the gain in the change of the mean.
            let measured = Vector2::new(before[0] + 1.0, before[1]);
            gaussian
                .update_position(measured, Matrix2::identity())
                .expect("positive definite");
            let change = gaussian.mean - before;
            gaussian.mean = nalgebra::zero();
            gaussian.mean[0] = change[0];
            gaussian.mean[3] = change[3];
        }
        assert!((gaussian.mean[0] - 0.75).abs() < 1e-9, "gain in position");
        assert!((gaussian.mean[3] - 0.5).abs() < 1e-9, "gain in velocity");
        for ((row, column), expected) in [((0, 0), 0.75), ((0, 3), 0.5), ((3, 3), 1.0)] {
            assert!((gaussian.covariance[(row, column)] - expected).abs() < 1e-9);
            let north = (row + 1, column + 1);
            assert!((gaussian.covariance[north] - expected).abs() < 1e-9);
        }
    }

    /// In steady state, prediction and update undo each other, for the white discretisation too.
    #[test]
    fn white_noise_reaches_a_steady_state() {
        let model = NearlyConstantVelocity::new(1.0, 1.0);
        let mut gaussian = Gaussian {
            mean: nalgebra::zero(),
            covariance: Matrix6::identity() * 1e4,
        };
        let mut before = gaussian.covariance;
        for _ in 0..200 {
            before = gaussian.covariance;
            gaussian = model.predicted(&gaussian, 1.0);
            gaussian
                .update_position(Vector3::zeros(), Matrix3::identity())
                .expect("positive definite");
        }
        assert!((gaussian.covariance - before).amax() < 1e-12);
        // Alpha and beta of a steady filter are tied; for this noise by the Riccati equation of one axis:
        // β² / (1 − α) = q·T³/R, whatever the discretisation's position term.
        let (alpha, beta) = (gaussian.covariance[(0, 0)], gaussian.covariance[(0, 3)]);
        assert!((beta * beta / (1.0 - alpha) - 1.0).abs() < 1e-9);
    }

    #[test]
    fn accurate_measurement_in_the_plane_leaves_height() {
        let mut gaussian = Gaussian {
            mean: nalgebra::zero(),
            covariance: Matrix6::identity() * 100.0,
        };
        let innovation = gaussian
            .update_position(Vector2::new(3.0, 4.0), Matrix2::identity() * 1e-6)
            .expect("positive definite");
        assert!((innovation.squared_distance - 0.25).abs() < 1e-6);
        assert!((gaussian.mean[0] - 3.0).abs() < 1e-6 && (gaussian.mean[1] - 4.0).abs() < 1e-6);
        assert_eq!(gaussian.mean[2], 0.0);
        assert_eq!(gaussian.covariance[(2, 2)], 100.0);
    }

    #[test]
    fn impossible_measurements_change_nothing() {
        let start = Gaussian {
            mean: nalgebra::zero(),
            covariance: Matrix6::identity(),
        };
        for (measured, covariance) in [
            (Vector2::new(f64::NAN, 0.0), Matrix2::identity()),
            (Vector2::zeros(), Matrix2::identity() * -2.0),
            (Vector2::zeros(), Matrix2::identity() * f64::NAN),
        ] {
            let mut gaussian = start;
            assert_eq!(gaussian.update_position(measured, covariance), None);
            assert_eq!(gaussian, start);
        }
    }

    proptest! {
        #[test]
        fn update_shrinks_and_stays_positive_definite(
            start in any_gaussian(), sigma in 1.0..500.0f64, ratio in 0.1..10.0f64, shift in -1e4..1e4f64,
        ) {
            let mut plane = start;
            let covariance = Matrix2::new(sigma * sigma, 0.3 * sigma * sigma * ratio, 0.3 * sigma * sigma * ratio,
                sigma * sigma * ratio * ratio);
            plane.update_position(start.mean.fixed_rows::<2>(0) + Vector2::new(shift, -shift), covariance)
                .expect("positive definite");
            prop_assert!(is_positive_definite(&plane.covariance));
            prop_assert!(plane.covariance.trace() < start.covariance.trace());

            let mut space = start;
            space.update_position(Vector3::new(shift, 0.0, 1.0), Matrix3::identity() * sigma * sigma)
                .expect("positive definite");
            prop_assert!(is_positive_definite(&space.covariance));
            prop_assert!(space.covariance.trace() < start.covariance.trace());
        }
    }
}
