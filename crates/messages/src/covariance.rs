//! Covariance of a six-component state, packed.

use crate::layout::sample;

/// Components of a state: x, y, z, then vx, vy, vz.
pub const STATE_LEN: usize = 6;
/// Axes of the system frame: east, north, up.
pub const AXES: usize = 3;
/// Stored elements of a symmetric 6×6 matrix.
pub const COVARIANCE_LEN: usize = STATE_LEN * (STATE_LEN + 1) / 2;

sample! {
    /// Upper triangle, row by row, of the covariance of (x, y, z, vx, vy, vz): P00, P01, …, P05, P11, …, P55
    /// in m², m²/s and m²/s² (FM-5).
    Covariance, size 168 {
        /// The 21 elements.
        upper: [f64; 21],
    }
}

impl Covariance {
    /// Creates a covariance without correlations, from standard deviations of position (m) and velocity (m/s) per
    /// axis.
    pub fn diagonal(position_sigma_m: [f64; AXES], velocity_sigma_mps: [f64; AXES]) -> Self {
        let mut covariance = Self::default();
        for axis in 0..AXES {
            covariance.set(axis, axis, position_sigma_m[axis] * position_sigma_m[axis]);
            covariance.set(
                axis + AXES,
                axis + AXES,
                velocity_sigma_mps[axis] * velocity_sigma_mps[axis],
            );
        }
        covariance
    }

    /// Returns element (`row`, `column`), in either order.
    pub fn get(&self, row: usize, column: usize) -> f64 {
        self.upper[Self::index(row, column)]
    }

    /// Sets element (`row`, `column`) and its mirror element.
    pub fn set(&mut self, row: usize, column: usize, value: f64) {
        self.upper[Self::index(row, column)] = value;
    }

    /// Adds the error of a time with the variance `time_s2`, s², to the position of a target with this velocity, m/s.
    pub fn widen_along_course(&mut self, velocity_mps: [f64; AXES], time_s2: f64) {
        for row in 0..AXES {
            for column in row..AXES {
                self.upper[Self::index(row, column)] += velocity_mps[row] * velocity_mps[column] * time_s2;
            }
        }
    }

    /// Returns whether no two components are correlated.
    #[inline]
    pub fn is_diagonal(&self) -> bool {
        // The bits of 0 but for its sign, without a branch for each element.
        let mut bits = 0;
        for row in 0..STATE_LEN {
            for column in row + 1..STATE_LEN {
                bits |= self.get(row, column).to_bits();
            }
        }
        bits << 1 == 0
    }

    /// Returns the sum of the diagonal elements in `components`.
    pub fn trace(&self, components: impl IntoIterator<Item = usize>) -> f64 {
        components.into_iter().map(|index| self.get(index, index)).sum()
    }

    /// Returns the storage index of element (`row`, `column`).
    pub const fn index(row: usize, column: usize) -> usize {
        let (row, column) = if row <= column { (row, column) } else { (column, row) };
        row * STATE_LEN - row * (row + 1) / 2 + column
    }
}
