//! Mean and covariance of a target's state, and their form in messages.

use messages::{AXES, Covariance, STATE_LEN};
use nalgebra::{SMatrix, SVector};

/// (x, y, z, vx, vy, vz) in metres and metres per second.
pub type Vector6 = SVector<f64, STATE_LEN>;
/// Covariance of a [`Vector6`]: m², m²/s and m²/s².
pub type Matrix6 = SMatrix<f64, STATE_LEN, STATE_LEN>;
/// Covariance of a position, m².
pub type Matrix3 = SMatrix<f64, AXES, AXES>;

/// What is known of a target's position and velocity at one time.
///
/// The covariance is symmetric; every operation of this crate keeps it so exactly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gaussian {
    /// Expected state.
    pub mean: Vector6,
    /// Covariance of the state.
    pub covariance: Matrix6,
}

impl Gaussian {
    /// From the fields of a message.
    pub fn from_message(position_m: [f64; AXES], velocity_mps: [f64; AXES], covariance: &Covariance) -> Self {
        Self {
            mean: Vector6::from_fn(|row, _| {
                if row < AXES {
                    position_m[row]
                } else {
                    velocity_mps[row - AXES]
                }
            }),
            covariance: unpacked(covariance),
        }
    }

    /// Position east, north, up, metres.
    pub fn position_m(&self) -> [f64; AXES] {
        std::array::from_fn(|axis| self.mean[axis])
    }

    /// Velocity east, north, up, metres per second.
    pub fn velocity_mps(&self) -> [f64; AXES] {
        std::array::from_fn(|axis| self.mean[axis + AXES])
    }

    /// The covariance as messages carry it.
    pub fn packed_covariance(&self) -> Covariance {
        packed(&self.covariance)
    }

    /// Sum of the position variances over east and north, square metres (the trace that TI-16 compares).
    pub fn horizontal_trace_m2(&self) -> f64 {
        self.covariance[(0, 0)] + self.covariance[(1, 1)]
    }

    /// Makes the covariance exactly symmetric, by the mean of mirrored elements.
    pub(crate) fn symmetrise(&mut self) {
        self.covariance = (self.covariance + self.covariance.transpose()) * 0.5;
    }
}

/// The full matrix of a message's covariance.
pub fn unpacked(covariance: &Covariance) -> Matrix6 {
    Matrix6::from_fn(|row, column| covariance.get(row, column))
}

/// A message's covariance; of a matrix that is not quite symmetric, the mean of mirrored elements.
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
        let gaussian = Gaussian::from_message([10.0, 20.0, 30.0], [-1.0, -2.0, -3.0], &covariance);
        assert_eq!(gaussian.position_m(), [10.0, 20.0, 30.0]);
        assert_eq!(gaussian.velocity_mps(), [-1.0, -2.0, -3.0]);
        assert_eq!(gaussian.covariance[(4, 0)], 0.25);
        assert_eq!(gaussian.covariance[(2, 5)], -0.5);
        assert_eq!(gaussian.packed_covariance(), covariance);
        assert_eq!(gaussian.horizontal_trace_m2(), 1.0 + 4.0);
    }
}
