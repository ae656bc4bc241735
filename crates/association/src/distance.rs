//! Statistical distance, the quantity compared with a gate.
//!
//! 50 m apart is much for two accurate sensors and nothing for two coarse sensors. The statistical (Mahalanobis)
//! distance measures a difference in units of its own standard deviation: d² = Δᵀ S⁻¹ Δ with S the covariance of the
//! difference. If report and track are of the same target, d² follows a chi-square distribution with as many degrees
//! of freedom as Δ has components, so one gate serves all sensors.

/// Symmetric 2×2 matrix: (xx, xy, yy).
pub type Symmetric2 = [f64; 3];

/// d² of a difference in the plane with covariance `s`; infinite if `s` is not positive definite.
#[inline]
pub fn squared2(delta: [f64; 2], s: Symmetric2) -> f64 {
    let [xx, xy, yy] = s;
    let determinant = xx * yy - xy * xy;
    if !(xx > 0.0 && determinant > 0.0) {
        return f64::INFINITY;
    }
    let [dx, dy] = delta;
    (yy * dx * dx - 2.0 * xy * dx * dy + xx * dy * dy) / determinant
}

/// Largest standard deviation of `s` in any direction: the root of the larger eigenvalue.
pub fn largest_sigma2(s: Symmetric2) -> f64 {
    let [xx, xy, yy] = s;
    let (mean, half) = (0.5 * (xx + yy), 0.5 * (xx - yy));
    (mean + (half * half + xy * xy).sqrt()).max(0.0).sqrt()
}

/// Value exceeded by chi-square with two degrees of freedom with probability `tail` (the inverse is elementary).
pub fn gate2(tail: f64) -> f64 {
    -2.0 * tail.ln()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn known_values() {
        assert!((squared2([3.0, 4.0], [1.0, 0.0, 1.0]) - 25.0).abs() < 1e-12);
        assert!((squared2([3.0, 4.0], [9.0, 0.0, 16.0]) - 2.0).abs() < 1e-12);
        assert_eq!(squared2([1.0, 1.0], [1.0, 1.0, 1.0]), f64::INFINITY, "singular");
        assert!((gate2(0.01) - 9.210).abs() < 1e-3, "the tabled 99 % gate");
        assert!((largest_sigma2([4.0, 0.0, 9.0]) - 3.0).abs() < 1e-12);
    }

    proptest! {
        #[test]
        fn turning_everything_changes_nothing(
            delta in prop::array::uniform2(-100.0..100.0f64), a in 0.5..50.0f64, b in 0.5..50.0f64, angle in 0.0..6.3f64,
        ) {
            let (s, c) = angle.sin_cos();
            let turned = [c * delta[0] - s * delta[1], s * delta[0] + c * delta[1]];
            let covariance = [c * c * a + s * s * b, s * c * (a - b), s * s * a + c * c * b];
            let straight = squared2(delta, [a, 0.0, b]);
            prop_assert!((squared2(turned, covariance) - straight).abs() < 1e-6 * (1.0 + straight));
        }
    }
}
