//! Shape of a source's errors: elongation in a horizontal direction, relative to the stated covariances.
//!
//! A radar with less accurate azimuth than range has errors in the form of long ellipses, but many trackers state a
//! constant variance for both axes. Fusion would then weigh the long axis as much as the short axis. A single factor on
//! the covariance does not help: the short axis becomes as bad.
//!
//! Innovations whitened by the expected covariance point in all directions alike. If the innovations prefer a
//! direction, the covariance is stretched along this direction, and shrunk across, by a small step of the logarithm per
//! innovation. The length of the innovation has no influence, so no single report can spoil the shape (the fixed point
//! is Tyler's estimator of shape). The size follows from the factor of covariance scaling.
//!
//! The shape is relative to the line of sight, so the position of the sensor must be known. Only a clear shape is used,
//! so that the covariances of consistent sources stay as they are.
//!
//! Source: D. E. Tyler, *A distribution-free M-estimator of multivariate scatter*, Annals of Statistics 15 (1987).

use estimation::Symmetric3;
use kept::kept;
use messages::{AXES, Covariance};
use serde::{Deserialize, Serialize};

/// Largest and smallest step of the logarithm per innovation.
const STEP_MAX: f64 = 0.05;
const STEP_MIN: f64 = 0.01;
/// Innovations before a shape is used.
const INNOVATIONS_MIN: u32 = 100;
/// Logarithm of a standard deviation's ratio from which on a shape is clear: chance reaches a third.
const CLEAR: f64 = 0.6;
/// Largest logarithm.
const LOGARITHM_MAX: f64 = 3.0;

kept! {
    /// Learned shape of a source's errors.
    #[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
    pub(crate) struct ErrorShape {
        /// Logarithm of the stretch along the first axis, and along the diagonal between the axes.
        logarithm: [f64; 2],
        innovations: u32,
    }
}

/// A direction as the double of its angle: cosine and sine, of the angle between the first axis and east.
type Doubled = [f64; 2];

/// Returns the doubled angle of the line of sight from a sensor to a target.
fn line_of_sight(target_m: [f64; AXES], [east, north]: [f64; 2]) -> Doubled {
    let (dx, dy) = (target_m[0] - east, target_m[1] - north);
    let squared = dx * dx + dy * dy;
    match squared > 1.0 {
        true => [(dx * dx - dy * dy) / squared, 2.0 * dx * dy / squared],
        false => [1.0, 0.0],
    }
}

impl ErrorShape {
    /// Learns from an innovation (m) with its covariance (xx, xy, yy; m²), for a target and a sensor at these
    /// positions.
    pub(crate) fn learn(
        &mut self,
        [east, north]: [f64; 2],
        [xx, xy, yy]: [f64; 3],
        (target_m, place_m): ([f64; AXES], [f64; 2]),
    ) {
        let [cos, sin] = line_of_sight(target_m, place_m);
        // The inverse of the symmetric root of the covariance, up to a factor.
        let root = (xx * yy - xy * xy).sqrt();
        let (u, v) = ((yy + root) * east - xy * north, (xx + root) * north - xy * east);
        let squared = u * u + v * v;
        if !(squared > 0.0 && squared.is_finite()) {
            return;
        }
        let (along, diagonal) = ((u * u - v * v) / squared, 2.0 * u * v / squared);
        self.innovations = self.innovations.saturating_add(1);
        let step = (3.0 / f64::from(self.innovations)).clamp(STEP_MIN, STEP_MAX);
        let turned = [along * cos + diagonal * sin, diagonal * cos - along * sin];
        for (logarithm, turned) in self.logarithm.iter_mut().zip(turned) {
            *logarithm += step * turned;
        }
        let length = self.length();
        if length > LOGARITHM_MAX {
            self.logarithm = self.logarithm.map(|value| value * LOGARITHM_MAX / length);
        }
    }

    fn length(&self) -> f64 {
        self.logarithm[0].hypot(self.logarithm[1])
    }

    /// Returns the ratio of the standard deviations across and along the line of sight, relative to the covariances;
    /// `None` while no shape is clear.
    pub(crate) fn ratio(&self) -> Option<f64> {
        let is_used = self.innovations >= INNOVATIONS_MIN && self.length() >= CLEAR;
        is_used.then(|| (-self.logarithm[0]).exp())
    }

    /// Returns the stretch of the source's errors for a target and a sensor at these positions.
    #[inline]
    pub(crate) fn stretch(&self, target_m: [f64; AXES], place_m: [f64; 2]) -> Stretch {
        let length = self.length();
        if self.innovations < INNOVATIONS_MIN || length < CLEAR {
            return Stretch::NONE;
        }
        let [cos, sin] = line_of_sight(target_m, place_m);
        let [along, diagonal] = self.logarithm;
        let turned = [along * cos - diagonal * sin, along * sin + diagonal * cos];
        // The exponential of half the symmetric matrix (a, b; b, −a).
        let (cosh, sinh) = ((0.5 * length).cosh(), (0.5 * length).sinh() / length);
        Stretch {
            east: cosh + sinh * turned[0],
            cross: sinh * turned[1],
            north: cosh - sinh * turned[0],
        }
    }
}

/// A symmetric matrix of determinant 1 that stretches horizontal errors.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Stretch {
    east: f64,
    cross: f64,
    north: f64,
}

impl Stretch {
    /// Stretch without effect.
    pub const NONE: Self = Self {
        east: 1.0,
        cross: 0.0,
        north: 1.0,
    };

    /// The elements: east, cross, north.
    pub fn elements(&self) -> [f64; 3] {
        [self.east, self.cross, self.north]
    }

    /// The stretch of these [`Self::elements`].
    pub fn of_elements([east, cross, north]: [f64; 3]) -> Self {
        Self { east, cross, north }
    }

    /// Returns the reverse stretch.
    pub fn inverse(self) -> Self {
        Self {
            east: self.north,
            cross: -self.cross,
            north: self.east,
        }
    }

    /// Stretches horizontal components of a vector.
    fn of(&self, [east, north]: [f64; 2]) -> [f64; 2] {
        [
            self.east * east + self.cross * north,
            self.cross * east + self.north * north,
        ]
    }

    /// Stretches the covariance of a position.
    #[inline]
    pub fn apply(&self, covariance_m2: &mut Symmetric3) {
        let [xx, xy, xz, yy, yz, zz] = *covariance_m2;
        let (first, second) = (self.of([xx, xy]), self.of([xy, yy]));
        let [xx, xy] = self.of([first[0], second[0]]);
        let [_, yy] = self.of([first[1], second[1]]);
        let [xz, yz] = self.of([xz, yz]);
        *covariance_m2 = [xx, xy, xz, yy, yz, zz];
    }

    /// Stretches the covariance of a state: positions and velocities alike.
    #[inline]
    pub fn apply_to_state(&self, covariance: &mut Covariance) {
        let stated = *covariance;
        let stretched = |row: usize, value: &dyn Fn(usize) -> f64| {
            let pair = self.of([value(row / AXES * AXES), value(row / AXES * AXES + 1)]);
            pair.get(row % AXES).copied().unwrap_or_else(|| value(row))
        };
        for row in 0..2 * AXES {
            for column in row..2 * AXES {
                let of_column = |row: usize| stretched(column, &|column| stated.get(row, column));
                covariance.set(row, column, stretched(row, &of_column));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PLACE_M: [f64; 2] = [1000.0, -2000.0];

    /// Position of a target in the direction of this angle, counter-clockwise from east.
    fn target_m(angle: f64) -> [f64; AXES] {
        let (sin, cos) = angle.sin_cos();
        [PLACE_M[0] + 5e4 * cos, PLACE_M[1] + 5e4 * sin, 0.0]
    }

    /// Learns from errors with standard deviations of `along` and `across` the line of sight to targets all around.
    fn learned(along: f64, across: f64) -> ErrorShape {
        let mut shape = ErrorShape::default();
        for step in 0..4000u32 {
            let angle = f64::from(step) * 2.399_963;
            let length = (-2.0 * (1.0 - (f64::from(step * 617 % 4000) + 0.5) / 4000.0).ln()).sqrt();
            let (a, b) = (along * length * angle.sin(), across * length * angle.cos());
            let direction = f64::from(step / 7 % 5) * 0.8;
            let (sin, cos) = direction.sin_cos();
            let mut expected = [1.0, 0.0, 0.0, 1.0, 0.0, 1.0];
            shape.stretch(target_m(direction), PLACE_M).apply(&mut expected);
            let [xx, xy, _, yy, ..] = expected;
            let error = [a * cos - b * sin, a * sin + b * cos];
            shape.learn(error, [xx, xy, yy], (target_m(direction), PLACE_M));
        }
        shape
    }

    #[test]
    fn long_ellipses_are_found_across_the_line_of_sight() {
        let shape = learned(1.0, 6.0);
        let stated = shape.ratio().unwrap();
        assert!((4.5..8.0).contains(&stated), "{stated}");
        for (angle, long) in [(0.0, 3), (std::f64::consts::FRAC_PI_2, 0)] {
            let mut covariance = [1.0, 0.0, 0.0, 1.0, 0.0, 1.0];
            shape.stretch(target_m(angle), PLACE_M).apply(&mut covariance);
            let ratio = (covariance[long] / covariance[3 - long]).sqrt();
            assert!((4.5..8.0).contains(&ratio), "{ratio}");
            assert!((covariance[0] * covariance[3] - covariance[1] * covariance[1] - 1.0).abs() < 1e-9);
        }
    }

    #[test]
    fn round_errors_are_left_alone() {
        assert_eq!(learned(2.0, 2.0).stretch(target_m(1.0), PLACE_M), Stretch::NONE);
    }

    #[test]
    fn a_stretch_is_reversed_by_its_inverse() {
        let stretch = learned(1.0, 3.0).stretch(target_m(0.4), PLACE_M);
        assert_ne!(stretch, Stretch::NONE);
        let mut covariance = Covariance::diagonal([1.0, 2.0, 3.0], [4.0, 5.0, 6.0]);
        covariance.set(0, 3, 0.5);
        covariance.set(1, 5, -0.25);
        covariance.set(2, 4, 0.125);
        let mut stretched = covariance;
        stretch.apply_to_state(&mut stretched);
        let mut position = [1.0, 0.0, 0.0, 4.0, 0.0, 9.0];
        stretch.apply(&mut position);
        for (place, (row, column)) in [(0, (0, 0)), (1, (0, 1)), (3, (1, 1))] {
            assert!((stretched.get(row, column) - position[place]).abs() < 1e-12);
        }
        stretch.inverse().apply_to_state(&mut stretched);
        for (got, expected) in stretched.upper.iter().zip(covariance.upper) {
            assert!((got - expected).abs() < 1e-12, "{stretched:?}");
        }
    }
}
