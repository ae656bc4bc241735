//! Cross-covariance of two trackers of the same target, caused by the target's manoeuvres.
//!
//! Each tracker lags behind the same manoeuvre, so the errors of all trackers contain the same process noise. For
//! filters in steady state the cross-covariance X solves X = B₁·(F·X·Fᵀ + Q)·B₂ᵀ with Bⱼ = I − Kⱼ·H (Y. Bar-Shalom, L.
//! Campo, 1986): a linear equation in four unknowns per axis. A source reports the covariance but not the gain. For a
//! steady filter of nearly constant velocity the covariance determines the gain. With p the variance of the position, q
//! the density of the noise and T the period, u = √(1 − α) is the only root of 4·(1 − u)³ = (q·T³/p)·u²·(1 + u) in (0,
//! 1), and β = 2·(1 − u)² (from Kalata's relations; piecewise-constant acceleration of variance q/T).
//!
//! Limits: steady state, the same period for all trackers, the same q in all trackers, measurement noises independent.
//! At short periods (q·T³ ≪ p) the correlations of equal trackers tend to 1/4 in position and 3/4 in velocity; at
//! manoeuvring index 1 the correlations are 1/9 and 2/3.

use nalgebra::{Matrix2, Matrix4, Vector2, Vector4};

use crate::motion::AxisNoise;

/// Distinguished range of q·T³/p; beyond, the filter practically ignores, or copies, the measurements.
const INDEX_SQUARED_RANGE: (f64, f64) = (1e-12, 1e12);
/// Halvings that find u to the last bit.
const BISECTIONS: usize = 60;

/// A steady filter of a single axis (position, velocity).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SteadyFilter {
    /// √(1 − α).
    u: f64,
    position_variance_m2: f64,
    density_m2ps3: f64,
    period_s: f64,
}

impl SteadyFilter {
    /// Makes the filter with the given variance of the updated position, under a noise of density q and with period
    /// T.
    ///
    /// All three must be above 0.
    pub fn new(position_variance_m2: f64, density_m2ps3: f64, period_s: f64) -> Self {
        let index = density_m2ps3 * (period_s * (period_s * period_s)) / position_variance_m2;
        let index = index.clamp(INDEX_SQUARED_RANGE.0, INDEX_SQUARED_RANGE.1);
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..BISECTIONS {
            let u: f64 = 0.5 * (low + high);
            if 4.0 * ((1.0 - u) * ((1.0 - u) * (1.0 - u))) > index * u * u * (1.0 + u) {
                low = u;
            } else {
                high = u;
            }
        }
        Self {
            u: 0.5 * (low + high),
            position_variance_m2,
            density_m2ps3,
            period_s,
        }
    }

    /// The gain: position per metre, velocity per metre.
    pub fn gain(&self) -> Vector2<f64> {
        let u = self.u;
        Vector2::new(1.0 - u * u, 2.0 * (1.0 - u) * (1.0 - u) / self.period_s)
    }

    /// The covariance of position and velocity after an update.
    pub fn covariance(&self) -> Matrix2<f64> {
        let (u, t) = (self.u, self.period_s);
        let gain = self.gain();
        let noise = self.position_variance_m2 / gain[0];
        // (β/T²)·(α − β/2)/(1 − α)·R, written without differences of near numbers.
        let velocity = gain[1] / t * 2.0 * (1.0 - u) / u * noise;
        Matrix2::new(self.position_variance_m2, gain[1] * noise, gain[1] * noise, velocity)
    }

    /// E[e·e'ᵀ] with `other`'s error, after updates of both. Both must have the same density and period.
    ///
    /// `None` if rounding leaves the equation without solution.
    pub fn cross_covariance(&self, other: &Self) -> Option<Matrix2<f64>> {
        let t = self.period_s;
        let transition = Matrix2::new(1.0, t, 0.0, 1.0);
        let kept = |filter: &Self| Matrix2::identity() - Matrix2::from_columns(&[filter.gain(), Vector2::zeros()]);
        let (left, right) = (kept(self) * transition, kept(other) * transition);
        let noise = AxisNoise::piecewise_constant((self.density_m2ps3 / t).sqrt(), t);
        let noise = Matrix2::new(
            noise.position_m2,
            noise.cross_m2ps,
            noise.cross_m2ps,
            noise.velocity_m2ps2,
        );
        let driven = kept(self) * noise * kept(other).transpose();
        // X − left·X·rightᵀ = driven, the elements of X column by column.
        let equation = Matrix4::identity() - right.kronecker(&left);
        let solved = equation.lu().solve(&Vector4::from_column_slice(driven.as_slice()))?;
        Some(Matrix2::from_column_slice(solved.as_slice()))
    }

    /// The cross-covariance in units of both standard deviations: L⁻¹·X·L'⁻ᵀ with covariance = L·Lᵀ. `None` as in
    /// [`cross_covariance`](Self::cross_covariance).
    ///
    /// Applied to any other roots of covariances, these correlations leave a joint covariance positive definite.
    pub fn correlation(&self, other: &Self) -> Option<Matrix2<f64>> {
        let cross = self.cross_covariance(other)?;
        let (mine, theirs) = (self.covariance().cholesky()?, other.covariance().cholesky()?);
        let left = mine.l().solve_lower_triangular(&cross)?;
        Some(theirs.l().solve_lower_triangular(&left.transpose())?.transpose())
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::combination::{Estimate, correlated_combination};

    #[test]
    fn the_published_steady_state_at_index_1() {
        let filter = SteadyFilter::new(0.75, 1.0, 1.0);
        assert!((filter.gain() - Vector2::new(0.75, 0.5)).amax() < 1e-12);
        assert!((filter.covariance() - Matrix2::new(0.75, 0.5, 0.5, 1.0)).amax() < 1e-12);
        let cross = filter.cross_covariance(&filter).expect("solvable");
        let expected = Matrix2::new(1.0 / 12.0, 1.0 / 6.0, 1.0 / 6.0, 2.0 / 3.0);
        assert!((cross - expected).amax() < 1e-12, "{cross}");
    }

    /// Fused over single-sensor area of the error ellipse, as published for four manoeuvring indices.
    #[test]
    fn the_published_gains_of_a_second_sensor() {
        for (index, expected) in [(0.1, 0.715), (0.5, 0.698), (1.0, 0.687), (2.0, 0.674)] {
            // The position variance that belongs to R = 1: α from Kalata's relation.
            let r: f64 = (4.0 + index - f64::sqrt(8.0 * index + index * index)) / 4.0;
            let filter = SteadyFilter::new(1.0 - r * r, index * index, 1.0);
            let cross = filter.cross_covariance(&filter).expect("solvable");
            let input = Estimate {
                mean: Vector2::zeros(),
                covariance: filter.covariance(),
            };
            let fused = correlated_combination(&[input; 2], |_, _| cross, &mut [0.0; 2]).expect("positive definite");
            let area = (fused.covariance.determinant() / input.covariance.determinant()).sqrt();
            assert!((area - expected).abs() < 2e-3, "index {index}: {area}");
        }
    }

    proptest! {
        #[test]
        fn the_joint_covariance_is_positive_definite(
            first in -1.0..4.0f64, second in -1.0..4.0f64, density in -2.0..3.0f64, period_s in 0.1..12.0f64,
        ) {
            let filter = |exponent: f64| SteadyFilter::new(10f64.powf(exponent), 10f64.powf(density), period_s);
            let (a, b) = (filter(first), filter(second));
            let correlation = a.correlation(&b).expect("solvable");
            let largest = (correlation * correlation.transpose()).symmetric_eigenvalues().max();
            prop_assert!(largest < 1.0, "{largest}");
            // The result solves the equation for either order of the two.
            let (x, y) = (a.cross_covariance(&b).expect("solvable"), b.cross_covariance(&a).expect("solvable"));
            prop_assert!((x - y.transpose()).amax() <= 1e-6 * x.amax());
        }
    }
}
