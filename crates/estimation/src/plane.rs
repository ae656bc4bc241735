//! A state of the plane alone: position and velocity east and north.
//!
//! A filter with several models of motion spends most time on the covariances of these models. Without the vertical a
//! covariance has 10 elements instead of 21. A climb then also has no effect on the plane.
//!
//! Motion is a rotation of the velocity by ω·t, with ω = 0 for straight flight (Bar-Shalom et al. 2001, section 11.7).
//! The rotation is computed by half of the tangent, a rational function, because a library's sine differs from machine
//! to machine. The series ends early: the angle is 0.03 % too small at 0.9 rad, 3 % at 2 rad, and does not rise beyond.
//! The matrix is a rotation in any case.

/// Number of components: (x, y, vx, vy).
pub(crate) const COMPONENTS: usize = 4;
/// Number of elements of the covariance's upper triangle.
pub(crate) const ELEMENTS: usize = COMPONENTS * (COMPONENTS + 1) / 2;
/// Largest half angle of a rotation, rad.
const HALF_ANGLE_MAX: f64 = 1.0;

/// Position and velocity east and north at a single time, as far as known.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Plane {
    /// Expected state: (x, y, vx, vy) in metres and metres per second.
    pub mean: [f64; COMPONENTS],
    /// Upper triangle of the covariance, row by row: xx, xy, x·vx, x·vy, yy, y·vx, y·vy, vx·vx, vx·vy, vy·vy.
    pub covariance: [f64; ELEMENTS],
}

/// Residual of a measured position, relative to the residual's covariance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Residual {
    /// Squared statistical length.
    pub squared: f64,
    /// Determinant of the residual's covariance, m⁴.
    pub determinant: f64,
}

/// Rotation of the velocity over a duration, and the way flown meanwhile per unit of velocity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rotation {
    cosine: f64,
    sine: f64,
    /// Along and to the left of the former velocity, s.
    along_s: f64,
    left_s: f64,
}

impl Rotation {
    /// Turn to the left with `rate_radps`, not 0, for `duration_s`; both may be negative.
    pub fn new(rate_radps: f64, duration_s: f64) -> Self {
        let half = (0.5 * rate_radps * duration_s).clamp(-HALF_ANGLE_MAX, HALF_ANGLE_MAX);
        let square = half * half;
        // Series of the tangent.
        let tangent = half * (1.0 + square * (1.0 / 3.0 + square * (2.0 / 15.0)));
        let share = 1.0 / (1.0 + tangent * tangent);
        let (cosine, sine) = ((1.0 - tangent * tangent) * share, 2.0 * tangent * share);
        // Way per angle, with the angle that is covered.
        let seconds = if half == 0.0 {
            duration_s
        } else {
            sine * 0.5 * duration_s / half
        };
        let left_s = if half == 0.0 {
            0.0
        } else {
            (1.0 - cosine) * 0.5 * duration_s / half
        };
        Self {
            cosine,
            sine,
            along_s: seconds,
            left_s,
        }
    }

    /// Transition matrix of the components (x, y, vx, vy), row by row.
    pub fn transition(&self) -> [[f64; COMPONENTS]; COMPONENTS] {
        let (c, s, g, h) = (self.cosine, self.sine, self.along_s, self.left_s);
        [[1.0, 0.0, g, -h], [0.0, 1.0, h, g], [0.0, 0.0, c, -s], [0.0, 0.0, s, c]]
    }

    /// Cosine and sine of the angle, and the way flown per unit of velocity, along and to the left, s.
    #[inline]
    pub(crate) fn parts(&self) -> [f64; 4] {
        [self.cosine, self.sine, self.along_s, self.left_s]
    }

    /// The same turn to the other side.
    #[must_use]
    pub fn mirrored(&self) -> Self {
        Self {
            sine: -self.sine,
            left_s: -self.left_s,
            ..*self
        }
    }
}

impl Plane {
    /// Straight motion for `duration_s` seconds, without noise.
    #[inline]
    pub fn advance(&mut self, duration_s: f64) {
        let t = duration_s;
        let [x, y, vx, vy] = &mut self.mean;
        *x += t * *vx;
        *y += t * *vy;
        let [xx, xy, xu, xv, yy, yu, yv, uu, uv, vv] = &mut self.covariance;
        *xx += t * (2.0 * *xu + t * *uu);
        *xy += t * (*xv + *yu + t * *uv);
        *yy += t * (2.0 * *yv + t * *vv);
        *xu += t * *uu;
        *xv += t * *uv;
        *yu += t * *uv;
        *yv += t * *vv;
    }

    /// Motion along an arc, without noise.
    #[inline]
    pub fn turn(&mut self, by: &Rotation) {
        let (c, s, g, h) = (by.cosine, by.sine, by.along_s, by.left_s);
        let [x, y, vx, vy] = self.mean;
        self.mean = [
            x + g * vx - h * vy,
            y + h * vx + g * vy,
            c * vx - s * vy,
            s * vx + c * vy,
        ];
        let [xx, xy, xu, xv, yy, yu, yv, uu, uv, vv] = self.covariance;
        // W = Ppv + G·Pvv.
        let (wxu, wxv) = (xu + g * uu - h * uv, xv + g * uv - h * vv);
        let (wyu, wyv) = (yu + h * uu + g * uv, yv + h * uv + g * vv);
        // Pvv·Rᵀ.
        let (ru, rv) = (c * uu - s * uv, s * uu + c * uv);
        let (qu, qv) = (c * uv - s * vv, s * uv + c * vv);
        self.covariance = [
            xx + g * (xu + wxu) - h * (xv + wxv),
            xy + h * xu + g * xv + g * wyu - h * wyv,
            c * wxu - s * wxv,
            s * wxu + c * wxv,
            yy + h * (yu + wyu) + g * (yv + wyv),
            c * wyu - s * wyv,
            s * wyu + c * wyv,
            c * ru - s * qu,
            c * rv - s * qv,
            s * rv + c * qv,
        ];
    }

    /// Noise of a white acceleration over `duration_s`, of covariance (xx, xy, yy) per second, m²/s³.
    #[inline]
    pub fn disturb(&mut self, density_m2ps3: [f64; 3], duration_s: f64) {
        let t = duration_s;
        let (first, second) = (t.abs(), 0.5 * t.abs() * t);
        let third = second * t * (2.0 / 3.0);
        let [qxx, qxy, qyy] = density_m2ps3;
        let [xx, xy, xu, xv, yy, yu, yv, uu, uv, vv] = &mut self.covariance;
        *xx += third * qxx;
        *xy += third * qxy;
        *yy += third * qyy;
        *xu += second * qxx;
        *xv += second * qxy;
        *yu += second * qxy;
        *yv += second * qyy;
        *uu += first * qxx;
        *uv += first * qxy;
        *vv += first * qyy;
    }

    /// [`Self::disturb`] by the same density in all directions, m²/s³.
    #[inline]
    pub fn disturb_evenly(&mut self, density_m2ps3: f64, duration_s: f64) {
        let t = duration_s;
        let first = t.abs() * density_m2ps3;
        let second = 0.5 * first * t;
        let third = second * t * (2.0 / 3.0);
        let [xx, _, xu, _, yy, _, yv, uu, _, vv] = &mut self.covariance;
        *xx += third;
        *yy += third;
        *xu += second;
        *yv += second;
        *uu += first;
        *vv += first;
    }

    /// Updates with a measured position of covariance `r` (xx, xy, yy). `None`, and no change, if the residual's
    /// covariance is not positive definite or a value not finite.
    #[inline]
    #[allow(clippy::needless_range_loop)] // Iterators keep these loops from being unrolled.
    pub fn update(&mut self, measured_m: [f64; 2], r: [f64; 3]) -> Option<Residual> {
        let [xx, xy, xu, xv, yy, yu, yv, ..] = self.covariance;
        let (sxx, sxy, syy) = (xx + r[0], xy + r[1], yy + r[2]);
        let determinant = sxx * syy - sxy * sxy;
        let inverse = 1.0 / determinant;
        let (dx, dy) = (measured_m[0] - self.mean[0], measured_m[1] - self.mean[1]);
        let (ixx, ixy, iyy) = (syy * inverse, -sxy * inverse, sxx * inverse);
        let squared = dx * (dx * ixx + 2.0 * dy * ixy) + dy * dy * iyy;
        if !(determinant > 0.0 && sxx > 0.0 && squared.is_finite() && determinant.is_finite()) {
            return None;
        }
        // Rows of position, and the gain K = rows·S⁻¹ of each component.
        let (east, north) = ([xx, xy, xu, xv], [xy, yy, yu, yv]);
        let gain: [[f64; 2]; COMPONENTS] = std::array::from_fn(|row| {
            let (a, b) = (east[row], north[row]);
            [a * ixx + b * ixy, a * ixy + b * iyy]
        });
        let mut element = 0;
        for row in 0..COMPONENTS {
            let [a, b] = gain[row];
            self.mean[row] += a * dx + b * dy;
            for column in row..COMPONENTS {
                self.covariance[element] -= a * east[column] + b * north[column];
                element += 1;
            }
        }
        Some(Residual { squared, determinant })
    }
}

impl Plane {
    /// Replaces the state by a mixture: of itself with weight `1 − weight`, and of another. A single copy of this
    /// function serves all models, since five would fill a twentieth of an instruction cache.
    #[inline(never)]
    #[allow(clippy::needless_range_loop)] // As above.
    pub fn blend(&mut self, other: &Self, weight: f64) {
        let d: [f64; COMPONENTS] = std::array::from_fn(|row| other.mean[row] - self.mean[row]);
        let (own, spread) = (1.0 - weight, weight * (1.0 - weight));
        let mut element = 0;
        for row in 0..COMPONENTS {
            self.mean[row] += weight * d[row];
            let spread = spread * d[row];
            for column in row..COMPONENTS {
                let theirs = weight * other.covariance[element] + spread * d[column];
                self.covariance[element] = own * self.covariance[element] + theirs;
                element += 1;
            }
        }
    }

    /// The rest of a mixture without a single state, which has the weight `1 − rest` in the mixture; `rest` is not 0.
    #[inline]
    #[allow(clippy::needless_range_loop)] // As above.
    #[must_use]
    pub fn without(&self, state: &Self, rest: f64) -> Self {
        let inverse = 1.0 / rest;
        let ratio = (1.0 - rest) * inverse;
        let d: [f64; COMPONENTS] = std::array::from_fn(|row| self.mean[row] - state.mean[row]);
        let mut element = 0;
        let mut covariance = [0.0; ELEMENTS];
        for row in 0..COMPONENTS {
            let spread = ratio * inverse * d[row];
            for column in row..COMPONENTS {
                let taken = ratio * state.covariance[element] + spread * d[column];
                covariance[element] = inverse * self.covariance[element] - taken;
                element += 1;
            }
        }
        Self {
            mean: std::array::from_fn(|row| self.mean[row] + ratio * d[row]),
            covariance,
        }
    }
}

/// [`crate::Moments`] of successive states, for comparison.
#[cfg(test)]
#[derive(Clone, Copy, Debug)]
pub(crate) struct Moments {
    weight: f64,
    first: [f64; COMPONENTS],
    second: [f64; ELEMENTS],
}

#[cfg(test)]
impl Moments {
    /// Moments of a single state with a weight.
    #[allow(clippy::needless_range_loop)] // As above.
    pub(crate) fn of(state: &Plane, weight: f64, about: &[f64; COMPONENTS]) -> Self {
        let d: [f64; COMPONENTS] = std::array::from_fn(|row| state.mean[row] - about[row]);
        let first: [f64; COMPONENTS] = std::array::from_fn(|row| weight * d[row]);
        let mut second = [0.0; ELEMENTS];
        let mut element = 0;
        for row in 0..COMPONENTS {
            for column in row..COMPONENTS {
                second[element] = weight * state.covariance[element] + first[row] * d[column];
                element += 1;
            }
        }
        Self { weight, first, second }
    }

    /// Adds a state with a weight.
    #[allow(clippy::needless_range_loop)] // As above.
    pub(crate) fn include(&mut self, state: &Plane, weight: f64, about: &[f64; COMPONENTS]) {
        let d: [f64; COMPONENTS] = std::array::from_fn(|row| state.mean[row] - about[row]);
        let weighted = d.map(|value| weight * value);
        self.weight += weight;
        let mut element = 0;
        for row in 0..COMPONENTS {
            self.first[row] += weighted[row];
            for column in row..COMPONENTS {
                self.second[element] += weight * state.covariance[element] + weighted[row] * d[column];
                element += 1;
            }
        }
    }

    /// Both sums together.
    pub(crate) fn plus(mut self, other: &Self) -> Self {
        self.weight += other.weight;
        self.first
            .iter_mut()
            .zip(other.first)
            .for_each(|(own, value)| *own += value);
        self.second
            .iter_mut()
            .zip(other.second)
            .for_each(|(own, value)| *own += value);
        self
    }

    /// The state that has these moments; the weight must not be 0.
    #[allow(clippy::needless_range_loop)] // As above.
    pub(crate) fn state(&self, about: &[f64; COMPONENTS]) -> Plane {
        let inverse = 1.0 / self.weight;
        let mean = self.first.map(|value| value * inverse);
        let mut element = 0;
        let mut covariance = [0.0; ELEMENTS];
        for row in 0..COMPONENTS {
            for column in row..COMPONENTS {
                covariance[element] = self.second[element] * inverse - mean[row] * mean[column];
                element += 1;
            }
        }
        Plane {
            mean: std::array::from_fn(|row| about[row] + mean[row]),
            covariance,
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Matrix4, Vector4};
    use proptest::prelude::*;

    use super::*;
    use crate::gaussian::Gaussian;
    use crate::testing::any_gaussian;
    use crate::{AxisNoise, is_usable};

    /// Places of the plane's elements in the covariance of a whole state.
    const PLACES: [usize; ELEMENTS] = [0, 1, 3, 4, 6, 8, 9, 15, 16, 18];

    fn plane_of(gaussian: &Gaussian) -> Plane {
        let [x, y, _, vx, vy, _] = gaussian.mean;
        Plane {
            mean: [x, y, vx, vy],
            covariance: PLACES.map(|place| gaussian.covariance.upper[place]),
        }
    }

    fn full(plane: &Plane) -> Matrix4<f64> {
        let mut matrix = Matrix4::zeros();
        let mut element = 0;
        for row in 0..COMPONENTS {
            for column in row..COMPONENTS {
                matrix[(row, column)] = plane.covariance[element];
                matrix[(column, row)] = plane.covariance[element];
                element += 1;
            }
        }
        matrix
    }

    fn assert_close(a: &Plane, b: &Plane) {
        let (p, q) = (full(a), full(b));
        for row in 0..COMPONENTS {
            assert!(
                (a.mean[row] - b.mean[row]).abs() <= 1e-9 * (1.0 + a.mean[row].abs()),
                "{a:?} {b:?}"
            );
            for column in 0..COMPONENTS {
                let scale = (p[(row, row)] * p[(column, column)]).sqrt();
                assert!(
                    (p[(row, column)] - q[(row, column)]).abs() <= 1e-9 * scale,
                    "{a:?} {b:?}"
                );
            }
        }
    }

    fn is_positive(plane: &Plane) -> bool {
        full(plane).cholesky().is_some()
    }

    #[test]
    fn a_turn_of_five_seconds_by_hand() {
        // 100 m/s east, 0.1 rad/s to the left, 5 s: the circle has a radius of 1,000 m, the angle is 0.5 rad.
        let mut plane = Plane {
            mean: [0.0, 0.0, 100.0, 0.0],
            covariance: [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 1.0],
        };
        plane.turn(&Rotation::new(0.1, 5.0));
        let expected = [479.426, 122.417, 87.758, 47.943];
        for (value, expected) in plane.mean.into_iter().zip(expected) {
            assert!((value - expected).abs() < 0.01, "{:?}", plane.mean);
        }
        // (1,000·sin 0.5 / 100)² + (1,000·(1 − cos 0.5) / 100)², and the velocity's variance, which stays.
        assert!((plane.covariance[0] - (1.0 + 22.985 + 1.499)).abs() < 0.01, "{plane:?}");
        assert!(
            (plane.covariance[7] - 1.0).abs() < 1e-12 && plane.covariance[8].abs() < 1e-12,
            "{plane:?}"
        );
    }

    #[test]
    fn a_turn_beyond_two_radians_goes_no_further() {
        let [two, more] = [2.0, 50.0].map(|angle| Rotation::new(angle / 10.0, 10.0));
        for (a, b) in [
            (two.sine, more.sine),
            (two.along_s, more.along_s),
            (two.left_s, more.left_s),
        ] {
            assert!((a - b).abs() < 1e-12, "{two:?} {more:?}");
        }
        assert!((two.sine.atan2(two.cosine) - 1.945).abs() < 1e-3, "{two:?}");
    }

    proptest! {
        #[test]
        fn a_turn_equals_the_matrix_form(start in any_gaussian(), rate in -0.3..0.3f64, t in 0.1..6.0f64) {
            let start = plane_of(&start);
            let by = Rotation::new(rate, t);
            let mut turned = start;
            turned.turn(&by);
            let (c, s, g, h) = (by.cosine, by.sine, by.along_s, by.left_s);
            let transition = Matrix4::new(1.0, 0.0, g, -h, 0.0, 1.0, h, g, 0.0, 0.0, c, -s, 0.0, 0.0, s, c);
            let mean = transition * Vector4::from(start.mean);
            let covariance = transition * full(&start) * transition.transpose();
            let difference = (full(&turned) - covariance).amax();
            prop_assert!(difference <= 1e-9 * covariance.amax());
            prop_assert!((Vector4::from(turned.mean) - mean).amax() <= 1e-9 * (1.0 + mean.amax()));
            // The rotation is nearly the requested rotation, and is undone by the opposite rotation.
            let angle = (rate * t).clamp(-2.0, 2.0);
            prop_assert!((s.atan2(c) - angle).abs() < 0.03 * angle.abs() + 1e-12);
            prop_assert!((c * c + s * s - 1.0).abs() < 1e-12);
            prop_assert!(is_positive(&turned));
        }

        #[test]
        fn straight_flight_and_noise_equal_those_of_whole_states(
            start in any_gaussian(), q in 0.0..50.0f64, t in -20.0..20.0f64,
        ) {
            let noise = AxisNoise::white(q, t);
            let whole = plane_of(&start.moved(t, [noise, noise, AxisNoise::default()]));
            let mut plane = plane_of(&start);
            let mut turned = plane;
            turned.turn(&Rotation::new(0.0, t));
            plane.advance(t);
            assert_close(&turned, &plane);
            let mut other = plane;
            plane.disturb_evenly(q, t);
            other.disturb([q, 0.0, q], t);
            assert_close(&plane, &whole);
            assert_close(&other, &whole);
        }

        #[test]
        fn an_update_equals_that_of_a_whole_state(
            start in any_gaussian(), sigma in 5.0..500.0f64, shift in -500.0..500.0f64,
        ) {
            let r = [1.0, 0.3, 0.0, 2.0, 0.0, 0.0].map(|factor| factor * sigma * sigma);
            let z = [start.mean[0] + shift, start.mean[1] - shift, 0.0];
            let mut whole = start;
            let found = whole.update_position::<2>(z, &r).expect("positive definite");
            let mut plane = plane_of(&start);
            let residual = plane.update([z[0], z[1]], [r[0], r[1], r[3]]).expect("positive definite");
            assert_close(&plane, &plane_of(&whole));
            prop_assert!((residual.squared - found.squared_distance).abs() < 1e-7 * (1.0 + residual.squared));
            prop_assert!((residual.determinant.ln() - found.log_determinant).abs() < 1e-7);
            prop_assert!(is_usable(&whole.covariance) && is_positive(&plane));
        }

        #[test]
        fn moments_of_two_equal_their_mixture(a in any_gaussian(), b in any_gaussian(), weight in 0.0..1.0f64) {
            let mixture = plane_of(&Gaussian::mixture(&a, &b, weight));
            let (a, b) = (plane_of(&a), plane_of(&b));
            let about = a.mean;
            let mut sum = Moments::of(&a, 2.0 * (1.0 - weight), &about);
            sum.include(&b, 2.0 * weight, &about);
            let state = sum.state(&about);
            let mut blended = a;
            blended.blend(&b, weight);
            assert_close(&blended, &mixture);
            assert_close(&state, &mixture);
            prop_assert!(is_positive(&state));
        }
    }

    proptest! {
        #[test]
        fn a_mixture_without_one_of_its_states_is_the_other(
            a in any_gaussian(), b in any_gaussian(), weight in 0.01..1.0f64,
        ) {
            // Near each other, as are models of the same target: digits are lost otherwise.
            let (a, mut b) = (plane_of(&a), plane_of(&b));
            b.mean = std::array::from_fn(|row| a.mean[row] + b.mean[row] * if row < 2 { 1e-3 } else { 0.1 });
            let mut mixture = a;
            mixture.blend(&b, weight);
            let rest = mixture.without(&a, weight);
            let scale = full(&mixture).diagonal();
            for row in 0..COMPONENTS {
                prop_assert!((rest.mean[row] - b.mean[row]).abs() < 1e-6 * (1.0 + b.mean[row].abs()));
                for column in row..COMPONENTS {
                    let difference = full(&rest)[(row, column)] - full(&b)[(row, column)];
                    prop_assert!(difference.abs() < 1e-9 / weight * (scale[row] * scale[column]).sqrt());
                }
            }
        }
    }

    #[test]
    fn what_is_not_usable_changes_nothing() {
        let start = Plane {
            mean: [1.0, 2.0, 3.0, 4.0],
            covariance: [9.0, 0.0, 1.0, 0.0, 9.0, 0.0, 1.0, 4.0, 0.0, 4.0],
        };
        let mut plane = start;
        assert_eq!(plane.update([f64::NAN, 0.0], [1.0, 0.0, 1.0]), None);
        assert_eq!(plane.update([0.0, 0.0], [-20.0, 0.0, 1.0]), None);
        assert_eq!(plane, start);
    }
}
