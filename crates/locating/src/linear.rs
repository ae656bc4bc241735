//! Small symmetric positive definite systems, factored once for all solutions.

use nalgebra::{SMatrix, SVector};

/// L of A = L·Lᵀ.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Factor<const D: usize>(SMatrix<f64, D, D>);

impl<const D: usize> Factor<D> {
    /// `None` if the matrix is not positive definite, or a value no number.
    pub(crate) fn of(matrix: &SMatrix<f64, D, D>) -> Option<Self> {
        let mut lower = SMatrix::<f64, D, D>::zeros();
        for column in 0..D {
            for row in column..D {
                let mut value = matrix[(row, column)];
                for k in 0..column {
                    value -= lower[(row, k)] * lower[(column, k)];
                }
                if row > column {
                    lower[(row, column)] = value / lower[(column, column)];
                } else if value > 0.0 && value.is_finite() {
                    lower[(column, column)] = value.sqrt();
                } else {
                    return None;
                }
            }
        }
        Some(Self(lower))
    }

    /// A⁻¹·b.
    pub(crate) fn solve(&self, b: &SVector<f64, D>) -> SVector<f64, D> {
        let (lower, mut x) = (&self.0, *b);
        for row in 0..D {
            for k in 0..row {
                x[row] -= lower[(row, k)] * x[k];
            }
            x[row] /= lower[(row, row)];
        }
        for row in (0..D).rev() {
            for k in row + 1..D {
                x[row] -= lower[(k, row)] * x[k];
            }
            x[row] /= lower[(row, row)];
        }
        x
    }

    /// A⁻¹, exactly symmetric.
    pub(crate) fn inverse(&self) -> SMatrix<f64, D, D> {
        let mut inverse = SMatrix::<f64, D, D>::zeros();
        for column in 0..D {
            let mut unit = SVector::<f64, D>::zeros();
            unit[column] = 1.0;
            let x = self.solve(&unit);
            for row in 0..=column {
                inverse[(row, column)] = x[row];
                inverse[(column, row)] = x[row];
            }
        }
        inverse
    }

    /// Logarithm of the determinant of A.
    pub(crate) fn log_determinant(&self) -> f64 {
        (0..D).map(|axis| 2.0 * self.0[(axis, axis)].ln()).sum()
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Matrix3, Vector3};

    use super::*;

    #[test]
    fn factor_solves_inverts_and_knows_the_determinant() {
        let matrix = Matrix3::new(4.0, 1.0, 0.5, 1.0, 3.0, -0.2, 0.5, -0.2, 2.0);
        let factor = Factor::of(&matrix).unwrap();
        let b = Vector3::new(1.0, -2.0, 3.0);
        assert!((matrix * factor.solve(&b) - b).amax() < 1e-12);
        assert!((matrix * factor.inverse() - Matrix3::identity()).amax() < 1e-12);
        assert!((factor.log_determinant() - matrix.determinant().ln()).abs() < 1e-12);
        assert!(Factor::of(&-matrix).is_none());
        assert!(Factor::of(&(matrix * f64::NAN)).is_none());
    }
}
