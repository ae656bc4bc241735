//! Principal axes of a symmetric matrix in the plane.

use estimation::length;

/// A symmetric matrix in the plane by its axes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Principal {
    /// Direction of the first axis.
    axis: [f64; 2],
    /// Smaller value along the first axis, and larger value along the second.
    pub(crate) values: [f64; 2],
}

impl Principal {
    pub(crate) fn of([xx, xy, yy]: [f64; 3]) -> Self {
        let (middle, half) = (0.5 * (xx + yy), 0.5 * (xx - yy));
        let radius = length([half, xy]);
        // The direction of the larger value has the doubled angle (half, xy).
        let (cos, sin) = if radius > 0.0 {
            (half / radius, xy / radius)
        } else {
            (1.0, 0.0)
        };
        let large = if cos >= 0.0 {
            let c = (0.5 * (1.0 + cos)).sqrt();
            [c, 0.5 * sin / c]
        } else {
            let s = (0.5 * (1.0 - cos)).sqrt();
            [0.5 * sin / s, s]
        };
        Self {
            axis: [-large[1], large[0]],
            values: [middle - radius, middle + radius],
        }
    }

    /// Returns the difference of the values relative to the sum.
    pub(crate) fn contrast(&self) -> f64 {
        let [small, large] = self.values;
        (large - small) / (large + small).max(f64::MIN_POSITIVE)
    }

    /// Returns the components of a vector along both axes.
    pub(crate) fn along(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let [a, b] = self.axis;
        [a * x + b * y, a * y - b * x]
    }

    /// Returns the vector with these components along the axes.
    pub(crate) fn vector(&self, [first, second]: [f64; 2]) -> [f64; 2] {
        let [a, b] = self.axis;
        [a * first - b * second, b * first + a * second]
    }

    /// Returns the matrix (xx, xy, yy) with these values along the axes.
    pub(crate) fn matrix(&self, [first, second]: [f64; 2]) -> [f64; 3] {
        let [a, b] = self.axis;
        [
            first * a * a + second * b * b,
            (first - second) * a * b,
            first * b * b + second * a * a,
        ]
    }
}
