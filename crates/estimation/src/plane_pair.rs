//! Two states of the plane side by side, for filters with several models.
//!
//! Every processor computes with two numbers at once where the same is done to both. Two models of motion take the same
//! steps with the same measurement, so each element of both stands beside the other. Each number is computed as in a
//! [`Plane`] by itself, operation by operation: the results have the same bits.

use std::array::from_fn;
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

use serde::{Deserialize, Serialize};

use crate::plane::{COMPONENTS, ELEMENTS, Plane, Rotation};

/// The numbers of two states, aligned so that the processor takes both from memory within an arithmetic instruction.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[repr(align(16))]
pub struct Two(pub [f64; 2]);

impl Two {
    /// Twice the same.
    #[inline]
    pub const fn both(value: f64) -> Self {
        Self([value; 2])
    }

    /// Sum of both.
    #[inline]
    pub fn sum(self) -> f64 {
        self.0[0] + self.0[1]
    }

    /// Square roots.
    #[inline]
    #[must_use]
    pub fn sqrt(self) -> Self {
        Self([self.0[0].sqrt(), self.0[1].sqrt()])
    }

    /// Exponentials of numbers from -700 to 700, to a relative error of 1e-15. The library's function takes three times
    /// as many instructions, since it computes one number at a time, and its last bit depends on the processor.
    #[inline]
    #[must_use]
    pub fn exp(self) -> Self {
        /// Added to a number below 2³¹, leaves the nearest whole number in the lowest bits.
        const ROUNDING: f64 = 6755399441055744.0;
        /// ln 2 in two parts: multiples of the first, up to 1023, are exact.
        const LN_2: [f64; 2] = [0.6931471803691238, 1.9082149292705877e-10];
        const BIAS: u64 = 1023;
        let shifted = self * Self::both(std::f64::consts::LOG2_E) + Self::both(ROUNDING);
        let whole = shifted - Self::both(ROUNDING);
        let rest = self - whole * Self::both(LN_2[0]) - whole * Self::both(LN_2[1]);
        // Taylor's series: the rest is half of ln 2 at most.
        let series = INVERSE_FACTORIALS
            .iter()
            .rev()
            .fold(Self::both(0.0), |sum, inverse| sum * rest + Self::both(*inverse));
        let powers = shifted
            .0
            .map(|shifted| f64::from_bits((shifted.to_bits().wrapping_add(BIAS)) << 52));
        series * Self(powers)
    }
}

/// 1/n! for n from 0 to 13.
const INVERSE_FACTORIALS: [f64; 14] = {
    let mut values = [1.0; 14];
    let mut n = 1;
    while n < values.len() {
        values[n] = values[n - 1] / n as f64;
        n += 1;
    }
    values
};

impl Add for Two {
    type Output = Self;

    #[inline]
    fn add(self, other: Self) -> Self {
        Self([self.0[0] + other.0[0], self.0[1] + other.0[1]])
    }
}

impl Sub for Two {
    type Output = Self;

    #[inline]
    fn sub(self, other: Self) -> Self {
        Self([self.0[0] - other.0[0], self.0[1] - other.0[1]])
    }
}

impl Mul for Two {
    type Output = Self;

    #[inline]
    fn mul(self, other: Self) -> Self {
        Self([self.0[0] * other.0[0], self.0[1] * other.0[1]])
    }
}

impl Div for Two {
    type Output = Self;

    #[inline]
    fn div(self, other: Self) -> Self {
        Self([self.0[0] / other.0[0], self.0[1] / other.0[1]])
    }
}

impl Neg for Two {
    type Output = Self;

    #[inline]
    fn neg(self) -> Self {
        Self([-self.0[0], -self.0[1]])
    }
}

impl AddAssign for Two {
    #[inline]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl SubAssign for Two {
    #[inline]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

/// Two states of the plane: the components and elements of [`Plane`], of both states.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PlanePair {
    mean: [Two; COMPONENTS],
    covariance: [Two; ELEMENTS],
}

/// Residuals of a measured position, relative to the covariances: see [`crate::Residual`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Residuals {
    /// Squared statistical lengths.
    pub squared: Two,
    /// Determinants of the covariances, m⁴.
    pub determinant: Two,
}

impl PlanePair {
    /// These two states.
    #[inline]
    pub fn of(first: &Plane, second: &Plane) -> Self {
        Self {
            mean: from_fn(|row| Two([first.mean[row], second.mean[row]])),
            covariance: from_fn(|element| Two([first.covariance[element], second.covariance[element]])),
        }
    }

    /// Twice the same state.
    #[inline]
    pub fn both(state: &Plane) -> Self {
        Self::of(state, state)
    }

    /// The first state (0) or the second (1).
    #[inline]
    pub fn state(&self, which: usize) -> Plane {
        Plane {
            mean: self.mean.map(|value| value.0[which]),
            covariance: self.covariance.map(|value| value.0[which]),
        }
    }

    /// Positions of both states, and the covariances (xx, xy, yy).
    #[inline]
    pub fn positions(&self) -> ([Two; 2], [Two; 3]) {
        let ([x, y, ..], [xx, xy, _, _, yy, ..]) = (self.mean, self.covariance);
        ([x, y], [xx, xy, yy])
    }

    /// Position of the first state (0) or of the second (1), and the covariance (xx, xy, yy).
    #[inline]
    pub fn position(&self, which: usize) -> ([f64; 2], [f64; 3]) {
        let ([x, y, ..], [xx, xy, _, _, yy, ..]) = (&self.mean, &self.covariance);
        ([x.0[which], y.0[which]], [xx.0[which], xy.0[which], yy.0[which]])
    }

    /// Velocity of the first state (0) or of the second (1), and the covariance (xx, xy, yy).
    #[inline]
    pub fn velocity(&self, which: usize) -> ([f64; 2], [f64; 3]) {
        let ([.., vx, vy], [.., uu, uv, vv]) = (&self.mean, &self.covariance);
        ([vx.0[which], vy.0[which]], [uu.0[which], uv.0[which], vv.0[which]])
    }

    /// Moves both by so much, east and north.
    pub fn shift(&mut self, by_m: [f64; 2]) {
        for (position, by) in self.mean.iter_mut().zip(by_m) {
            *position += Two::both(by);
        }
    }

    /// Multiplies both covariances by a factor.
    pub fn inflate(&mut self, factor: f64) {
        self.covariance
            .iter_mut()
            .for_each(|value| *value = *value * Two::both(factor));
    }

    /// Adds so much to both variances of both positions, m².
    pub fn blur(&mut self, variance_m2: f64) {
        let [xx, _, _, _, yy, ..] = &mut self.covariance;
        *xx += Two::both(variance_m2);
        *yy += Two::both(variance_m2);
    }

    /// [`Plane::advance`] of both.
    #[inline]
    pub fn advance(&mut self, duration_s: f64) {
        let (t, two) = (Two::both(duration_s), Two::both(2.0));
        let [x, y, vx, vy] = &mut self.mean;
        *x += t * *vx;
        *y += t * *vy;
        let [xx, xy, xu, xv, yy, yu, yv, uu, uv, vv] = &mut self.covariance;
        *xx += t * (two * *xu + t * *uu);
        *xy += t * (*xv + *yu + t * *uv);
        *yy += t * (two * *yv + t * *vv);
        *xu += t * *uu;
        *xv += t * *uv;
        *yu += t * *uv;
        *yv += t * *vv;
    }

    /// [`Plane::turn`] of the first state, and of the second to the other side.
    pub fn turn_apart(&mut self, by: &Rotation) {
        let [cosine, sine, along_s, left_s] = by.parts();
        let (c, g) = (Two::both(cosine), Two::both(along_s));
        let (s, h) = (Two([sine, -sine]), Two([left_s, -left_s]));
        let [x, y, vx, vy] = self.mean;
        self.mean = [
            x + g * vx - h * vy,
            y + h * vx + g * vy,
            c * vx - s * vy,
            s * vx + c * vy,
        ];
        let [xx, xy, xu, xv, yy, yu, yv, uu, uv, vv] = self.covariance;
        let (wxu, wxv) = (xu + g * uu - h * uv, xv + g * uv - h * vv);
        let (wyu, wyv) = (yu + h * uu + g * uv, yv + h * uv + g * vv);
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

    /// [`Plane::disturb`] of a single state of the pair.
    #[inline]
    pub fn disturb_one(&mut self, which: usize, density_m2ps3: [f64; 3], duration_s: f64) {
        let t = duration_s;
        let (first, second) = (t.abs(), 0.5 * t.abs() * t);
        let third = second * t * (2.0 / 3.0);
        let [qxx, qxy, qyy] = density_m2ps3;
        let added = [
            third * qxx,
            third * qxy,
            second * qxx,
            second * qxy,
            third * qyy,
            second * qxy,
            second * qyy,
            first * qxx,
            first * qxy,
            first * qyy,
        ];
        for (element, added) in self.covariance.iter_mut().zip(added) {
            element.0[which] += added;
        }
    }

    /// [`Plane::disturb_evenly`] of a single state of the pair.
    #[inline]
    pub fn disturb_one_evenly(&mut self, which: usize, density_m2ps3: f64, duration_s: f64) {
        let [third, second, first] = even_noise(density_m2ps3, duration_s);
        let [xx, _, xu, _, yy, _, yv, uu, _, vv] = &mut self.covariance;
        for (element, added) in [
            (xx, third),
            (yy, third),
            (xu, second),
            (yv, second),
            (uu, first),
            (vv, first),
        ] {
            element.0[which] += added;
        }
    }

    /// [`Plane::disturb_evenly`] of both.
    #[inline]
    pub fn disturb_evenly(&mut self, density_m2ps3: f64, duration_s: f64) {
        let [third, second, first] = even_noise(density_m2ps3, duration_s).map(Two::both);
        let [xx, _, xu, _, yy, _, yv, uu, _, vv] = &mut self.covariance;
        for (element, added) in [
            (xx, third),
            (yy, third),
            (xu, second),
            (yv, second),
            (uu, first),
            (vv, first),
        ] {
            *element += added;
        }
    }

    /// [`Plane::update`] of both. `None`, and no change, if either cannot be updated.
    #[allow(clippy::needless_range_loop)] // Iterators keep these loops from being unrolled.
    pub fn update(&mut self, measured_m: [f64; 2], r: [f64; 3]) -> Option<Residuals> {
        let [xx, xy, xu, xv, yy, yu, yv, ..] = self.covariance;
        let (sxx, sxy, syy) = (xx + Two::both(r[0]), xy + Two::both(r[1]), yy + Two::both(r[2]));
        let determinant = sxx * syy - sxy * sxy;
        let inverse = Two::both(1.0) / determinant;
        let (dx, dy) = (
            Two::both(measured_m[0]) - self.mean[0],
            Two::both(measured_m[1]) - self.mean[1],
        );
        let (ixx, ixy, iyy) = (syy * inverse, -sxy * inverse, sxx * inverse);
        let squared = dx * (dx * ixx + Two::both(2.0) * dy * ixy) + dy * dy * iyy;
        let is_positive = |value: Two| value.0[0] > 0.0 && value.0[1] > 0.0;
        // 0 times a number that is not finite is NaN.
        let nothing = (squared + determinant) * Two::both(0.0);
        if !(is_positive(determinant) && is_positive(sxx) && nothing.sum() == 0.0) {
            return None;
        }
        let (east, north) = ([xx, xy, xu, xv], [xy, yy, yu, yv]);
        let mut element = 0;
        for row in 0..COMPONENTS {
            let (a, b) = (east[row], north[row]);
            let (a, b) = (a * ixx + b * ixy, a * ixy + b * iyy);
            self.mean[row] += a * dx + b * dy;
            for column in row..COMPONENTS {
                self.covariance[element] -= a * east[column] + b * north[column];
                element += 1;
            }
        }
        Some(Residuals { squared, determinant })
    }

    /// [`Plane::blend`] of both, each with a separate other state and weight.
    #[allow(clippy::needless_range_loop)] // As above.
    pub fn blend(&mut self, other: &Self, weight: Two) {
        let d: [Two; COMPONENTS] = from_fn(|row| other.mean[row] - self.mean[row]);
        let own = Two::both(1.0) - weight;
        let spread = weight * own;
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
}

/// Additions to the variance of a position, the covariance with the velocity, and the variance of the velocity.
#[inline]
fn even_noise(density_m2ps3: f64, duration_s: f64) -> [f64; 3] {
    let first = duration_s.abs() * density_m2ps3;
    let second = 0.5 * first * duration_s;
    [second * duration_s * (2.0 / 3.0), second, first]
}

/// Sum of weighted states, for mixtures of many: each state's mean and second moment about a common point, times the
/// weight (Bar-Shalom et al. 2001, section 1.4.16). The common point should be near all, so that no figure is lost.
/// First states and second states have sums of their own, which are added at the end.
#[derive(Clone, Copy, Debug, Default)]
pub struct Moments {
    weight: Two,
    first: [Two; COMPONENTS],
    second: [Two; ELEMENTS],
}

impl Moments {
    /// Adds two states with weights.
    #[inline]
    #[allow(clippy::needless_range_loop)] // As above.
    pub fn include(&mut self, pair: &PlanePair, weight: Two, about: &[f64; COMPONENTS]) {
        let d: [Two; COMPONENTS] = from_fn(|row| pair.mean[row] - Two::both(about[row]));
        self.weight += weight;
        let mut element = 0;
        for row in 0..COMPONENTS {
            let weighted = weight * d[row];
            self.first[row] += weighted;
            for column in row..COMPONENTS {
                self.second[element] += weight * pair.covariance[element] + weighted * d[column];
                element += 1;
            }
        }
    }

    /// The state that has these moments; the weight must not be 0.
    #[inline]
    #[allow(clippy::needless_range_loop)] // As above.
    pub fn state(&self, about: &[f64; COMPONENTS]) -> Plane {
        let inverse = 1.0 / self.weight.sum();
        let mean = self.first.map(|value| value.sum() * inverse);
        let mut element = 0;
        let mut covariance = [0.0; ELEMENTS];
        for row in 0..COMPONENTS {
            for column in row..COMPONENTS {
                covariance[element] = self.second[element].sum() * inverse - mean[row] * mean[column];
                element += 1;
            }
        }
        Plane {
            mean: from_fn(|row| about[row] + mean[row]),
            covariance,
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::testing::any_gaussian;

    #[test]
    fn the_exponential_of_nothing_is_one() {
        assert_eq!(Two([0.0, -0.0]).exp(), Two([1.0; 2]));
        assert!((Two([-700.0, 700.0]).exp().0[0] / (-700.0f64).exp() - 1.0).abs() < 1e-15);
    }

    fn any_plane() -> impl Strategy<Value = Plane> {
        any_gaussian().prop_map(|gaussian| {
            let ([x, y, _, vx, vy, _], p) = (gaussian.mean, &gaussian.covariance.upper);
            Plane {
                mean: [x, y, vx, vy],
                covariance: [0, 1, 3, 4, 6, 8, 9, 15, 16, 18].map(|place| p[place]),
            }
        })
    }

    proptest! {
        #[test]
        fn exponentials_are_those_of_the_library(values in [-700.0..700.0f64, -1.0..1.0f64]) {
            for (own, value) in Two(values).exp().0.into_iter().zip(values) {
                prop_assert!((own / value.exp() - 1.0).abs() < 1e-15, "{value}: {own} {}", value.exp());
            }
        }

        #[test]
        fn each_state_has_the_bits_that_it_has_alone(
            planes in [any_plane(), any_plane()], others in [any_plane(), any_plane()],
            weights in [0.01..0.99f64, 0.01..0.99f64], seconds in 0.1..10.0f64, measured in [-1e3..1e3f64, -1e3..1e3f64],
            rate in 0.001..0.3f64,
        ) {
            let mut pair = PlanePair::of(&planes[0], &planes[1]);
            let mut alone = planes;
            let left = Rotation::new(rate, seconds);
            pair.advance(seconds);
            pair.disturb_evenly(3.0, seconds);
            pair.disturb_one(0, [1.0, 0.5, 2.0], seconds);
            pair.disturb_one_evenly(1, 0.7, seconds);
            pair.turn_apart(&left);
            pair.blend(&PlanePair::of(&others[0], &others[1]), Two(weights));
            let residuals = pair.update(measured, [100.0, 10.0, 50.0]).expect("positive definite");
            for (index, (plane, turn)) in alone.iter_mut().zip([left, left.mirrored()]).enumerate() {
                plane.advance(seconds);
                plane.disturb_evenly(3.0, seconds);
                match index {
                    0 => plane.disturb([1.0, 0.5, 2.0], seconds),
                    _ => plane.disturb_evenly(0.7, seconds),
                }
                plane.turn(&turn);
                plane.blend(&others[index], weights[index]);
                let residual = plane.update(measured, [100.0, 10.0, 50.0]).expect("positive definite");
                prop_assert_eq!(residuals.squared.0[index], residual.squared);
                prop_assert_eq!(residuals.determinant.0[index], residual.determinant);
                prop_assert_eq!(pair.state(index), *plane);
                let [xx, xy, _, _, yy, ..] = plane.covariance;
                prop_assert_eq!(pair.position(index), ([plane.mean[0], plane.mean[1]], [xx, xy, yy]));
                let [.., uu, uv, vv] = plane.covariance;
                prop_assert_eq!(pair.velocity(index), ([plane.mean[2], plane.mean[3]], [uu, uv, vv]));
            }
            let about = others[0].mean;
            let second = PlanePair::of(&others[0], &others[1]);
            let mut moments = Moments::default();
            moments.include(&pair, Two(weights), &about);
            moments.include(&second, Two([0.3, 0.2]), &about);
            let sum = |which: usize, weight: f64| {
                let mut sum = crate::plane::Moments::of(&alone[which], weights[which], &about);
                sum.include(&others[which], weight, &about);
                sum
            };
            let expected = sum(0, 0.3).plus(&sum(1, 0.2));
            prop_assert_eq!(moments.state(&about), expected.state(&about));
        }
    }
}
