//! Update: a measured position improves a state.
//!
//! The Kalman filter's gain weighs prediction against measurement by the covariances. The textbook form of the new
//! covariance, (I − K·H)·P, is a difference of nearly equal matrices when the measurement is accurate, and loses
//! symmetry to rounding. With S = L·Lᵀ and W = L⁻¹·H·P, the same is P − Wᵀ·W: symmetric by construction, a single
//! factorisation for gain, covariance, distance and likelihood, and a third of the work of the Joseph form (Bar-Shalom
//! et al. 2001, chapters 5 and 7).

use messages::{AXES, STATE_LEN};

use crate::gaussian::{Gaussian, Symmetric3, at};

/// Innovation of a measured position, and the covariance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Innovation {
    /// Squared statistical length: chi-square with as many degrees of freedom as axes were measured.
    pub squared_distance: f64,
    /// Logarithm of the determinant of the innovation's covariance.
    pub log_determinant: f64,
}

impl Gaussian {
    /// Updates with a measured position of covariance `r` in the first `D` axes (2: east and north; 3: also up).
    ///
    /// `None`, and no change, if the residual's covariance is not positive definite or a value not finite.
    pub fn update_position<const D: usize>(&mut self, measured_m: [f64; AXES], r: &Symmetric3) -> Option<Innovation> {
        let root = CholeskyFactor::<D>::of(&self.position_covariance(), r)?;
        let whitened = root.whitened(self.residual(measured_m));
        let squared_distance = dot(&whitened, &whitened);
        if !squared_distance.is_finite() {
            return None;
        }
        // A single whitened column of the position's rows per component, all components axis by axis.
        let p = &mut self.covariance.upper;
        let mut whitened_rows = [
            [p[0], p[1], p[2], p[3], p[4], p[5]],
            [p[1], p[6], p[7], p[8], p[9], p[10]],
            [p[2], p[7], p[11], p[12], p[13], p[14]],
        ];
        let [x, y, z] = &mut whitened_rows;
        for column in 0..STATE_LEN {
            [x[column], y[column], z[column]] = root.whitened([x[column], y[column], z[column]]);
        }
        for row in 0..STATE_LEN {
            let own = [x[row], y[row], z[row]];
            self.mean[row] += dot(&own, &whitened);
            for column in row..STATE_LEN {
                p[at(row, column)] -= dot(&own, &[x[column], y[column], z[column]]);
            }
        }
        Some(Innovation {
            squared_distance,
            log_determinant: 2.0 * root.determinant().ln(),
        })
    }

    /// Squared statistical length of the difference to a measured position of covariance `r` in the first `D` axes;
    /// `None` if the covariance is not positive definite or a value not finite.
    pub fn squared_distance<const D: usize>(&self, measured_m: [f64; AXES], r: &Symmetric3) -> Option<f64> {
        let root = CholeskyFactor::<D>::of(&self.position_covariance(), r)?;
        let whitened = root.whitened(self.residual(measured_m));
        let squared = dot(&whitened, &whitened);
        squared.is_finite().then_some(squared)
    }

    fn residual(&self, measured_m: [f64; AXES]) -> [f64; AXES] {
        [
            measured_m[0] - self.mean[0],
            measured_m[1] - self.mean[1],
            measured_m[2] - self.mean[2],
        ]
    }
}

/// L of S = L·Lᵀ, S being the covariance of a residual in two or three axes; with the diagonal inverted, because of
/// frequent divisions.
struct CholeskyFactor<const D: usize> {
    diagonal: [f64; AXES],
    inverse: [f64; AXES],
    l10: f64,
    l20: f64,
    l21: f64,
}

impl<const D: usize> CholeskyFactor<D> {
    #[inline]
    fn of(p: &Symmetric3, r: &Symmetric3) -> Option<Self> {
        const { assert!(D == 2 || D == 3, "a position has two or three axes") };
        let s = |place: usize| p[place] + r[place];
        let l00 = root(s(0))?;
        let l10 = s(1) / l00;
        let l11 = root(s(3) - l10 * l10)?;
        if D == 2 {
            // Nothing of the third axis.
            return Some(Self {
                diagonal: [l00, l11, 1.0],
                inverse: [1.0 / l00, 1.0 / l11, 0.0],
                l10,
                l20: 0.0,
                l21: 0.0,
            });
        }
        let l20 = s(2) / l00;
        let l21 = (s(4) - l20 * l10) / l11;
        let l22 = root(s(5) - l20 * l20 - l21 * l21)?;
        Some(Self {
            diagonal: [l00, l11, l22],
            inverse: [1.0 / l00, 1.0 / l11, 1.0 / l22],
            l10,
            l20,
            l21,
        })
    }

    /// L⁻¹·b.
    #[inline]
    fn whitened(&self, b: [f64; AXES]) -> [f64; AXES] {
        let x = b[0] * self.inverse[0];
        let y = (b[1] - self.l10 * x) * self.inverse[1];
        [x, y, (b[2] - self.l20 * x - self.l21 * y) * self.inverse[2]]
    }

    fn determinant(&self) -> f64 {
        self.diagonal[0] * self.diagonal[1] * self.diagonal[2]
    }
}

#[inline]
fn dot(a: &[f64; AXES], b: &[f64; AXES]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// √x of a positive number.
fn root(x: f64) -> Option<f64> {
    // Written so that NaN is refused.
    if x > 0.0 { Some(x.sqrt()) } else { None }
}

#[cfg(test)]
mod tests {
    use messages::Covariance;
    use nalgebra::{SMatrix, SVector};
    use proptest::prelude::*;

    use super::*;
    use crate::definite::is_usable;
    use crate::gaussian::{Vector6, packed, unpacked};
    use crate::motion::{AxisNoise, NearlyConstantVelocity};
    use crate::testing::{any_gaussian, assert_close};

    /// No correlation, variances of 1 m².
    const UNIT: Symmetric3 = [1.0, 0.0, 0.0, 1.0, 0.0, 1.0];

    fn uncertain(sigma: f64) -> Gaussian {
        Gaussian::new([0.0; 3], [0.0; 3], &Covariance::diagonal([sigma; 3], [sigma; 3]))
    }

    /// The published steady state at T = 1, R = 1, manoeuvring index 1 holds for piecewise-constant acceleration.
    #[test]
    fn steady_state_of_the_literature() {
        let mut gaussian = uncertain(10.0);
        for _ in 0..200 {
            gaussian = gaussian.moved(1.0, [AxisNoise::piecewise_constant(1.0, 1.0); 3]);
            let before = gaussian.mean;
            // A measurement 1 m east of the prediction shows the gain in the change of the mean.
            gaussian
                .update_position::<2>([before[0] + 1.0, before[1], 0.0], &UNIT)
                .expect("positive definite");
            let change: [f64; STATE_LEN] = std::array::from_fn(|row| gaussian.mean[row] - before[row]);
            gaussian.mean = [change[0], 0.0, 0.0, change[3], 0.0, 0.0];
        }
        assert!((gaussian.mean[0] - 0.75).abs() < 1e-9, "gain in position");
        assert!((gaussian.mean[3] - 0.5).abs() < 1e-9, "gain in velocity");
        for ((row, column), expected) in [((0, 0), 0.75), ((0, 3), 0.5), ((3, 3), 1.0)] {
            assert!((gaussian.covariance.get(row, column) - expected).abs() < 1e-9);
            assert!((gaussian.covariance.get(row + 1, column + 1) - expected).abs() < 1e-9);
        }
    }

    /// In steady state, prediction and update undo each other, for the white discretisation too.
    #[test]
    fn white_noise_reaches_a_steady_state() {
        let model = NearlyConstantVelocity::new(1.0, 1.0);
        let mut gaussian = uncertain(100.0);
        let mut before = gaussian.covariance;
        for _ in 0..200 {
            before = gaussian.covariance;
            gaussian = model.predicted(&gaussian, 1.0);
            gaussian
                .update_position::<3>([0.0; 3], &UNIT)
                .expect("positive definite");
        }
        assert!((unpacked(&gaussian.covariance) - unpacked(&before)).amax() < 1e-12);
        // Alpha and beta of a steady filter are tied; for this noise by the Riccati equation of a single axis: β² / (1
        // − α) = q·T³/R, for any position term of the discretisation.
        let (alpha, beta) = (gaussian.covariance.get(0, 0), gaussian.covariance.get(0, 3));
        assert!((beta * beta / (1.0 - alpha) - 1.0).abs() < 1e-9);
    }

    #[test]
    fn accurate_measurement_in_the_plane_leaves_height() {
        let mut gaussian = uncertain(10.0);
        let innovation = gaussian
            .update_position::<2>([3.0, 4.0, 0.0], &[1e-6, 0.0, 0.0, 1e-6, 0.0, 0.0])
            .expect("positive definite");
        assert!((innovation.squared_distance - 0.25).abs() < 1e-6);
        assert!((gaussian.mean[0] - 3.0).abs() < 1e-6 && (gaussian.mean[1] - 4.0).abs() < 1e-6);
        assert_eq!((gaussian.mean[2], gaussian.covariance.get(2, 2)), (0.0, 100.0));
    }

    #[test]
    fn impossible_measurements_change_nothing() {
        let start = NearlyConstantVelocity::new(1.0, 1.0).predicted(&uncertain(1.0), 1.0);
        for (z, r) in [
            ([f64::NAN, 0.0, 0.0], UNIT),
            ([0.0; 3], [-9.0, 0.0, 0.0, 1.0, 0.0, 1.0]),
            ([0.0; 3], [f64::NAN, 0.0, 0.0, 1.0, 0.0, 1.0]),
        ] {
            let (mut plane, mut space) = (start, start);
            assert_eq!(plane.update_position::<2>(z, &r), None);
            assert_eq!(space.update_position::<3>(z, &r), None);
            assert_eq!((plane, space), (start, start));
        }
    }

    /// The textbook's update, x + K·ν and (I − K·H)·P, with the squared distance and log determinant.
    fn textbook<const D: usize>(state: &Gaussian, z: [f64; AXES], r: &Symmetric3) -> (Gaussian, f64, f64) {
        let r = SMatrix::<f64, 3, 3>::new(r[0], r[1], r[2], r[1], r[3], r[4], r[2], r[4], r[5]);
        let (mean, p) = (Vector6::from(state.mean), unpacked(&state.covariance));
        let s = p.fixed_view::<D, D>(0, 0) + r.fixed_view::<D, D>(0, 0);
        let factor = s.cholesky().expect("positive definite");
        let inverse = factor.inverse();
        let residual = SVector::<f64, D>::from_fn(|axis, _| z[axis] - mean[axis]);
        let gain = p.fixed_view::<6, D>(0, 0) * inverse;
        let updated = Gaussian {
            mean: (mean + gain * residual).into(),
            covariance: packed(&(p - gain * p.fixed_view::<D, 6>(0, 0))),
        };
        (
            updated,
            (residual.transpose() * inverse * residual)[0],
            2.0 * factor.l().diagonal().iter().map(|root| root.ln()).sum::<f64>(),
        )
    }

    proptest! {
        #[test]
        fn equals_the_textbooks_update_and_stays_positive_definite(
            start in any_gaussian(), sigma in 5.0..500.0f64, shift in -500.0..500.0f64,
        ) {
            let r = [1.0, 0.3, 0.0, 2.0, 0.0, 1.0].map(|factor| factor * sigma * sigma);
            let z = [start.mean[0] + shift, start.mean[1] - shift, start.mean[2] + 0.5 * shift];
            let (mut plane, mut space) = (start, start);
            let found = [
                plane.update_position::<2>(z, &r).expect("positive definite"),
                space.update_position::<3>(z, &r).expect("positive definite"),
            ];
            let expected = [textbook::<2>(&start, z, &r), textbook::<3>(&start, z, &r)];
            for ((updated, found), (expected, squared, log_determinant)) in [plane, space].iter().zip(found).zip(expected) {
                assert_close(updated, &expected);
                prop_assert!((found.squared_distance - squared).abs() < 1e-9 * (1.0 + squared));
                prop_assert!((found.log_determinant - log_determinant).abs() < 1e-9 * log_determinant.abs());
                prop_assert!(is_usable(&updated.covariance));
                let whole = |state: &Gaussian| state.covariance.trace(0..STATE_LEN);
                prop_assert!(whole(updated) < whole(&start));
            }
        }
    }
}
