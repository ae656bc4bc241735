//! Mean and covariance of a target's state.
//!
//! A filter that runs for every target at every report spends most time on moving numbers. Half of a covariance matrix
//! repeats the other half; without the repetition, in the form of messages, a state fits in four lines of the cache,
//! and predicting, mixing and updating are a third of the work.

use messages::{AXES, Covariance, STATE_LEN};
use nalgebra::{SMatrix, SVector};
use serde::{Deserialize, Serialize};

/// (x, y, z, vx, vy, vz) in metres and metres per second.
pub type Vector6 = SVector<f64, STATE_LEN>;
/// Covariance of a [`Vector6`]: m², m²/s and m²/s².
pub type Matrix6 = SMatrix<f64, STATE_LEN, STATE_LEN>;
/// Covariance of a position, m².
pub type Matrix3 = SMatrix<f64, AXES, AXES>;
/// Symmetric 3×3 matrix: (xx, xy, xz, yy, yz, zz).
pub type Symmetric3 = [f64; 6];

/// A target's position and velocity at a single time, as far as known.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Gaussian {
    /// Expected state: (x, y, z, vx, vy, vz) in metres and metres per second.
    pub mean: [f64; STATE_LEN],
    /// Covariance of the state.
    pub covariance: Covariance,
}

/// Place of (row, column), row ≤ column, in the upper triangle of a 6×6 matrix.
pub(crate) const fn at(row: usize, column: usize) -> usize {
    row * STATE_LEN - row * (row + 1) / 2 + column
}

impl Gaussian {
    /// From the fields of a message.
    pub fn new(position_m: [f64; AXES], velocity_mps: [f64; AXES], covariance: &Covariance) -> Self {
        let [x, y, z] = position_m;
        let [vx, vy, vz] = velocity_mps;
        Self {
            mean: [x, y, z, vx, vy, vz],
            covariance: *covariance,
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

    /// Sum of the position variances over east and north, square metres (the trace that TI-16 compares).
    pub fn horizontal_trace_m2(&self) -> f64 {
        self.covariance.get(0, 0) + self.covariance.get(1, 1)
    }
}

/// The full matrix of a covariance.
pub fn unpacked(covariance: &Covariance) -> Matrix6 {
    Matrix6::from_fn(|row, column| covariance.get(row, column))
}

/// The covariance of a full matrix; of a not quite symmetric matrix, the mean of mirrored elements.
pub fn packed(matrix: &Matrix6) -> Covariance {
    let mut covariance = Covariance::default();
    for row in 0..STATE_LEN {
        for column in row..STATE_LEN {
            covariance.set(row, column, 0.5 * (matrix[(row, column)] + matrix[(column, row)]));
        }
    }
    covariance
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_and_back() {
        let mut covariance = Covariance::diagonal([1.0, 2.0, 3.0], [4.0, 5.0, 6.0]);
        covariance.set(0, 4, 0.25);
        covariance.set(2, 5, -0.5);
        let gaussian = Gaussian::new([10.0, 20.0, 30.0], [-1.0, -2.0, -3.0], &covariance);
        assert_eq!(gaussian.position_m(), [10.0, 20.0, 30.0]);
        assert_eq!(gaussian.velocity_mps(), [-1.0, -2.0, -3.0]);
        assert_eq!(gaussian.position_covariance(), [1.0, 0.0, 0.0, 4.0, 0.0, 9.0]);
        assert_eq!(gaussian.velocity_covariance(), [16.0, 0.0, 0.0, 25.0, 0.0, 36.0]);
        assert_eq!(gaussian.horizontal_trace_m2(), 1.0 + 4.0);
        let full = unpacked(&covariance);
        assert_eq!((full[(4, 0)], full[(2, 5)]), (0.25, -0.5));
        assert_eq!(packed(&full), covariance);
    }
}
