//! The Gaussian state in the form of messages: six numbers and the upper triangle of the covariance.
//!
//! A filter that runs for every target at every report spends its time on moving numbers. Half of a covariance matrix
//! repeats the other half; without it a state fits in four lines of the cache, and predicting, mixing and updating are
//! a third of the work. The formulas are those of [`Gaussian`]; only where they leave their results differs.

use messages::{AXES, Covariance, STATE_LEN};

use crate::gaussian::{packed, unpacked};
use crate::{AxisNoise, Gaussian, Vector6};

/// Symmetric 3×3 matrix: (xx, xy, xz, yy, yz, zz).
pub type Symmetric3 = [f64; 6];

/// Mean and covariance of a target's state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PackedGaussian {
    /// (x, y, z, vx, vy, vz) in metres and metres per second.
    pub mean: [f64; STATE_LEN],
    /// Its covariance.
    pub covariance: Covariance,
}

/// By how much a measured position differed from what was expected, and how much it was allowed to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PackedInnovation {
    /// Squared statistical length: chi-square with as many degrees of freedom as axes were measured.
    pub squared_distance: f64,
    /// Logarithm of the determinant of its covariance.
    pub log_determinant: f64,
}

/// Whether a message's covariance is positive definite. Components whose variance is 0 say nothing, and are left out.
pub fn is_usable(covariance: &Covariance) -> bool {
    // L·D·Lᵀ: what is left of each component once the ones before it are known. Without roots, and with one division
    // per component.
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

/// Place of (row, column), row ≤ column, in the upper triangle of a 6×6 matrix.
const fn at(row: usize, column: usize) -> usize {
    row * STATE_LEN - row * (row + 1) / 2 + column
}

impl PackedGaussian {
    /// From the fields of a message.
    pub fn new(position_m: [f64; AXES], velocity_mps: [f64; AXES], covariance: &Covariance) -> Self {
        let [x, y, z] = position_m;
        let [vx, vy, vz] = velocity_mps;
        Self {
            mean: [x, y, z, vx, vy, vz],
            covariance: *covariance,
        }
    }

    /// With a full matrix.
    pub fn unpacked(&self) -> Gaussian {
        Gaussian {
            mean: Vector6::from_column_slice(&self.mean),
            covariance: unpacked(&self.covariance),
        }
    }

    /// From a full matrix.
    pub fn packed(gaussian: &Gaussian) -> Self {
        Self {
            mean: gaussian.mean.into(),
            covariance: packed(&gaussian.covariance),
        }
    }

    /// Position east, north, up, metres.
    pub fn position_m(&self) -> [f64; AXES] {
        [self.mean[0], self.mean[1], self.mean[2]]
    }

    /// Velocity east, north, up, metres per second.
    pub fn velocity_mps(&self) -> [f64; AXES] {
        [self.mean[3], self.mean[4], self.mean[5]]
    }

    /// Covariance of the position, m².
    pub fn position_covariance(&self) -> Symmetric3 {
        let p = &self.covariance.upper;
        [
            p[at(0, 0)],
            p[at(0, 1)],
            p[at(0, 2)],
            p[at(1, 1)],
            p[at(1, 2)],
            p[at(2, 2)],
        ]
    }

    /// Covariance of the velocity, m²/s².
    pub fn velocity_covariance(&self) -> Symmetric3 {
        let p = &self.covariance.upper;
        [
            p[at(3, 3)],
            p[at(3, 4)],
            p[at(3, 5)],
            p[at(4, 4)],
            p[at(4, 5)],
            p[at(5, 5)],
        ]
    }

    /// Moved along its velocity for `duration_s` seconds, with `noise` per axis: as [`Gaussian::moved`].
    #[must_use]
    pub fn moved(&self, duration_s: f64, noise: [AxisNoise; AXES]) -> Self {
        let mut moved = *self;
        moved.advance(duration_s, noise);
        moved
    }

    /// [`Self::moved`] in place.
    pub fn advance(&mut self, duration_s: f64, noise: [AxisNoise; AXES]) {
        let t = duration_s;
        let p = &mut self.covariance.upper;
        for row in 0..AXES {
            self.mean[row] += t * self.mean[row + AXES];
            for column in row..AXES {
                // Each element is read before it is written: a pair of axes touches no other pair's.
                let velocity = p[at(row + AXES, column + AXES)];
                let (cross, mirrored) = (p[at(row, column + AXES)], p[at(column, row + AXES)]);
                p[at(row, column)] = p[at(row, column)] + t * (cross + mirrored) + t * t * velocity;
                p[at(row, column + AXES)] = cross + t * velocity;
                p[at(column, row + AXES)] = mirrored + t * velocity;
            }
        }
        for (axis, noise) in noise.iter().enumerate() {
            p[at(axis, axis)] += noise.position_m2;
            p[at(axis, axis + AXES)] += noise.cross_m2ps;
            p[at(axis + AXES, axis + AXES)] += noise.velocity_m2ps2;
        }
    }

    /// Mean and covariance of a mixture of two: `a` with probability `1 − weight_of_b`, else `b`.
    pub fn mixture(a: &Self, b: &Self, weight_of_b: f64) -> Self {
        let mut mixture = *a;
        mixture.mix::<STATE_LEN>(a, b, weight_of_b);
        mixture
    }

    /// Replaces `a` and `b` by two mixtures of them, in which `b` has the weights given.
    #[allow(clippy::needless_range_loop)] // Iterators keep these loops from being unrolled.
    pub fn exchange(a: &mut Self, b: &mut Self, weights_of_b: [f64; 2]) {
        let difference = a.difference(b);
        for row in 0..STATE_LEN {
            let of = (a.mean[row], b.mean[row]);
            a.mean[row] = weighted(of, weights_of_b[0]);
            b.mean[row] = weighted(of, weights_of_b[1]);
            let spread = weights_of_b.map(|q| (1.0 - q) * q * difference[row]);
            for column in row..STATE_LEN {
                let (p, q) = (
                    &mut a.covariance.upper[at(row, column)],
                    &mut b.covariance.upper[at(row, column)],
                );
                let of = (*p, *q);
                *p = weighted(of, weights_of_b[0]) + spread[0] * difference[column];
                *q = weighted(of, weights_of_b[1]) + spread[1] * difference[column];
            }
        }
    }

    /// Sets the first `N` components, and what is known of them, to the mixture of `a` and `b`; the others are left.
    #[allow(clippy::needless_range_loop)] // As above.
    pub fn mix<const N: usize>(&mut self, a: &Self, b: &Self, weight_of_b: f64) {
        let difference = a.difference(b);
        for row in 0..N {
            self.mean[row] = weighted((a.mean[row], b.mean[row]), weight_of_b);
            let spread = (1.0 - weight_of_b) * weight_of_b * difference[row];
            for column in row..N {
                let of = (a.covariance.upper[at(row, column)], b.covariance.upper[at(row, column)]);
                self.covariance.upper[at(row, column)] = weighted(of, weight_of_b) + spread * difference[column];
            }
        }
    }

    fn difference(&self, other: &Self) -> [f64; STATE_LEN] {
        std::array::from_fn(|row| self.mean[row] - other.mean[row])
    }

    /// Updates with a measured position of covariance `r` in the first `D` axes: as [`Gaussian::update_position`].
    ///
    /// `None`, and no change, if the residual's covariance is not positive definite or a value not finite.
    pub fn update_position<const D: usize>(
        &mut self,
        measured_m: [f64; AXES],
        r: &Symmetric3,
    ) -> Option<PackedInnovation> {
        let root = Root::<D>::of(&self.position_covariance(), r)?;
        let whitened = root.whitened(self.residual(measured_m));
        let squared_distance = dot(&whitened, &whitened);
        if !squared_distance.is_finite() {
            return None;
        }
        // One whitened column of the position's rows per component, all of them axis by axis.
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
        Some(PackedInnovation {
            squared_distance,
            log_determinant: 2.0 * root.determinant().ln(),
        })
    }

    /// Squared statistical length of the difference to a measured position of covariance `r` in the first `D` axes;
    /// `None` if its covariance is not positive definite or a value not finite.
    pub fn squared_distance<const D: usize>(&self, measured_m: [f64; AXES], r: &Symmetric3) -> Option<f64> {
        let root = Root::<D>::of(&self.position_covariance(), r)?;
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

/// L of S = L·Lᵀ, S being the covariance of a residual in two or three axes; with its diagonal inverted, since it is
/// divided by again and again.
struct Root<const D: usize> {
    diagonal: [f64; AXES],
    inverse: [f64; AXES],
    l10: f64,
    l20: f64,
    l21: f64,
}

impl<const D: usize> Root<D> {
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

/// `a` with weight `1 − weight_of_b`, and `b`.
#[inline]
fn weighted((a, b): (f64, f64), weight_of_b: f64) -> f64 {
    (1.0 - weight_of_b) * a + weight_of_b * b
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
    use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};
    use proptest::prelude::*;

    use super::*;
    use crate::NearlyConstantVelocity;
    use crate::testing::{any_gaussian, assert_close};

    proptest! {
        #[test]
        fn everything_equals_the_full_form(
            a in any_gaussian(), b in any_gaussian(), weight in 0.0..1.0f64, seconds in 0.0..20.0f64, density in 0.0..50.0f64,
            sigma in 5.0..500.0f64, shift in -500.0..500.0f64,
        ) {
            let (packed_a, packed_b) = (PackedGaussian::packed(&a), PackedGaussian::packed(&b));
            assert_close(&packed_a.unpacked(), &a);
            let noise = [AxisNoise::white(density, seconds); AXES];
            assert_close(&packed_a.moved(seconds, noise).unpacked(), &a.moved(seconds, noise));
            let apart = a.mean - b.mean;
            let mixture = Gaussian {
                mean: a.mean * (1.0 - weight) + b.mean * weight,
                covariance: a.covariance * (1.0 - weight)
                    + b.covariance * weight
                    + apart * apart.transpose() * (weight * (1.0 - weight)),
            };
            assert_close(&PackedGaussian::mixture(&packed_a, &packed_b, weight).unpacked(), &mixture);

            let (xx, xy, yy) = (sigma * sigma, 0.3 * sigma * sigma, 2.0 * sigma * sigma);
            let z = [a.mean[0] + shift, a.mean[1] - shift, a.mean[2] + 0.5 * shift];
            let mut space = (a, packed_a);
            let full = space.0.update_position(Vector3::from(z), Matrix3::new(xx, xy, 0.0, xy, yy, 0.0, 0.0, 0.0, xx))
                .expect("positive definite");
            let short = space.1.update_position::<3>(z, &[xx, xy, 0.0, yy, 0.0, xx]).expect("positive definite");
            assert_close(&space.1.unpacked(), &space.0);
            prop_assert!((full.squared_distance - short.squared_distance).abs() < 1e-9 * (1.0 + full.squared_distance));
            prop_assert!((full.log_determinant - short.log_determinant).abs() < 1e-9 * full.log_determinant.abs());

            let mut plane = (a, packed_a);
            plane.0.update_position(Vector2::new(z[0], z[1]), Matrix2::new(xx, xy, xy, yy)).expect("positive definite");
            plane.1.update_position::<2>(z, &[xx, xy, 0.0, yy, 0.0, 0.0]).expect("positive definite");
            assert_close(&plane.1.unpacked(), &plane.0);
        }
    }

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
    fn impossible_measurements_change_nothing() {
        let start = PackedGaussian::packed(&NearlyConstantVelocity::new(1.0, 1.0).predicted(
            &Gaussian {
                mean: Vector6::zeros(),
                covariance: crate::Matrix6::identity(),
            },
            1.0,
        ));
        for (z, r) in [
            ([f64::NAN, 0.0, 0.0], [1.0, 0.0, 0.0, 1.0, 0.0, 1.0]),
            ([0.0; 3], [-9.0, 0.0, 0.0, 1.0, 0.0, 1.0]),
            ([0.0; 3], [f64::NAN, 0.0, 0.0, 1.0, 0.0, 1.0]),
        ] {
            let mut state = start;
            assert_eq!(state.update_position::<3>(z, &r), None);
            assert_eq!(state, start);
        }
    }
}
