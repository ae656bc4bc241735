//! Initiation: the state after one measured position.
//!
//! One position says nothing of the velocity. Waiting for a second position and taking the difference makes the
//! first estimate late, and rough where the two come close after each other. Single-point initiation instead states
//! what is known beforehand: velocity zero, with the standard deviation of the speeds that targets have; the second
//! update then finds the velocity by itself (Bar-Shalom et al. 2001, chapter 5; M. Mallick, B. La Scala, *Comparison of
//! single-point and two-point difference track initiation algorithms using position measurements*, 2008).

use messages::AXES;
use nalgebra::{SMatrix, SVector};

use crate::Gaussian;
use crate::gaussian::{Matrix6, Vector6};

/// What is assumed of a velocity before it was observed: zero, with these standard deviations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FirstVelocity {
    /// Standard deviation east and north, m/s.
    pub horizontal_sigma_mps: f64,
    /// Standard deviation up, m/s.
    pub vertical_sigma_mps: f64,
}

/// Variance of a height that was not observed, m²: any height of an aircraft is within a few of its roots.
const UNOBSERVED_HEIGHT_M2: f64 = 1e4 * 1e4;

impl Gaussian {
    /// The state after a first measured position in the first `D` axes (2: east and north; 3: also up). In two
    /// axes, height is 0 with a variance that says nothing.
    pub fn from_first_position<const D: usize>(
        measured_m: SVector<f64, D>,
        covariance_m2: SMatrix<f64, D, D>,
        velocity: FirstVelocity,
    ) -> Self {
        const { assert!(D == 2 || D == 3, "a position has two or three axes") };
        let horizontal = velocity.horizontal_sigma_mps * velocity.horizontal_sigma_mps;
        let vertical = velocity.vertical_sigma_mps * velocity.vertical_sigma_mps;
        let mut mean = Vector6::zeros();
        mean.fixed_rows_mut::<D>(0).copy_from(&measured_m);
        let mut covariance = Matrix6::zeros();
        covariance[(2, 2)] = UNOBSERVED_HEIGHT_M2;
        covariance.fixed_view_mut::<D, D>(0, 0).copy_from(&covariance_m2);
        covariance[(3, 3)] = horizontal;
        covariance[(4, 4)] = horizontal;
        covariance[(5, 5)] = vertical;
        let mut gaussian = Self { mean, covariance };
        if D < AXES {
            gaussian.forget_height(velocity);
        }
        gaussian.symmetrise();
        gaussian
    }

    /// Makes height and vertical speed as if never observed: 0, uncorrelated, with variances that say nothing. For
    /// tracks of sensors that do not measure height, whose prediction would let these variances grow for ever.
    pub fn forget_height(&mut self, velocity: FirstVelocity) {
        let vertical = velocity.vertical_sigma_mps * velocity.vertical_sigma_mps;
        let variances = [(2, UNOBSERVED_HEIGHT_M2), (5, vertical)];
        for (component, variance) in variances {
            self.mean[component] = 0.0;
            self.covariance.row_mut(component).fill(0.0);
            self.covariance.column_mut(component).fill(0.0);
            self.covariance[(component, component)] = variance;
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};

    use super::*;
    use crate::definite::is_positive_definite;
    use crate::motion::NearlyConstantVelocity;

    const VELOCITY: FirstVelocity = FirstVelocity {
        horizontal_sigma_mps: 150.0,
        vertical_sigma_mps: 15.0,
    };

    #[test]
    fn two_and_three_axes() {
        let plane = Gaussian::from_first_position(Vector2::new(1.0, 2.0), Matrix2::identity() * 9.0, VELOCITY);
        assert_eq!(plane.position_m(), [1.0, 2.0, 0.0]);
        assert_eq!(plane.covariance[(2, 2)], UNOBSERVED_HEIGHT_M2);
        assert!(is_positive_definite(&plane.covariance));
        let space = Gaussian::from_first_position(Vector3::new(1.0, 2.0, 3.0), Matrix3::identity() * 9.0, VELOCITY);
        assert_eq!(space.position_m(), [1.0, 2.0, 3.0]);
        assert_eq!(space.covariance[(2, 2)], 9.0);
        assert_eq!(space.covariance[(5, 5)], 225.0);
    }

    #[test]
    fn second_position_finds_the_velocity() {
        let r = Matrix2::identity() * 100.0;
        let first = Gaussian::from_first_position(Vector2::new(0.0, 0.0), r, VELOCITY);
        let mut second = NearlyConstantVelocity::new(1.0, 0.1).predicted(&first, 4.0);
        second
            .update_position(Vector2::new(800.0, -400.0), r)
            .expect("positive definite");
        let [east, north, up] = second.velocity_mps();
        assert!((east - 200.0).abs() < 1.0 && (north + 100.0).abs() < 1.0 && up == 0.0);
    }
}
