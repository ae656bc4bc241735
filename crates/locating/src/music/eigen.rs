//! Eigenvalues and eigenvectors of the snapshots' covariance, a Hermitian matrix.
//!
//! The work is nalgebra's: reduction to a tridiagonal matrix, then implicit QR steps. The matrices are on the stack
//! where the size is part of the type, else on the heap. Arrays have few antennas, so there is a copy of the code for
//! each size up to 16, which never allocates, and a copy for all larger sizes, which does.

use nalgebra::allocator::Allocator;
use nalgebra::{Complex, Const, DMatrix, DefaultAllocator, DimDiff, DimSub, OMatrix, SymmetricEigen, U1};

/// QR steps per eigenvalue after which the decomposition is given up; two or three are usual.
const STEPS_PER_VALUE_MAX: usize = 60;

/// Eigenvalues in falling order with eigenvectors.
#[derive(Clone, Debug)]
pub(super) struct EigenSystem {
    values: Vec<f64>,
    /// Column after column, in the order of the values.
    vectors: Vec<Complex<f64>>,
}

impl EigenSystem {
    pub(super) fn new(size: usize) -> Self {
        Self {
            values: vec![0.0; size],
            vectors: vec![Complex::ZERO; size * size],
        }
    }

    /// In falling order.
    pub(super) fn values(&self) -> &[f64] {
        &self.values
    }

    /// The eigenvectors of the greatest `sources` values, in succession.
    pub(super) fn signal(&self, sources: usize) -> impl Iterator<Item = &[Complex<f64>]> {
        self.vectors.chunks_exact(self.values.len()).take(sources)
    }

    /// Eigenvectors of the other values.
    pub(super) fn noise(&self, sources: usize) -> impl Iterator<Item = &[Complex<f64>]> {
        self.vectors.chunks_exact(self.values.len()).skip(sources)
    }

    /// Decomposes a matrix given column by column, of which the lower triangle is read. `false` without convergence.
    pub(super) fn decompose(&mut self, matrix: &[Complex<f64>]) -> bool {
        macro_rules! by_size {
            ($($size:literal)*) => {
                match self.values.len() {
                    $($size => self.decompose_as(OMatrix::<_, Const<$size>, Const<$size>>::from_column_slice(matrix)),)*
                    size => self.decompose_as(DMatrix::from_column_slice(size, size, matrix)),
                }
            };
        }
        by_size!(2 3 4 5 6 7 8 9 10 11 12 13 14 15 16)
    }

    fn decompose_as<D>(&mut self, matrix: OMatrix<Complex<f64>, D, D>) -> bool
    where
        D: DimSub<U1>,
        DefaultAllocator: Allocator<D, D> + Allocator<D> + Allocator<DimDiff<D, U1>>,
    {
        let size = self.values.len();
        let Some(found) = SymmetricEigen::try_new(matrix, f64::EPSILON, STEPS_PER_VALUE_MAX * size) else {
            return false;
        };
        // The index of each value is the number of greater values; among equal values the earlier is first.
        for index in 0..size {
            let value = found.eigenvalues[index];
            let before = |other: usize| {
                let other_value = found.eigenvalues[other];
                other_value > value || (other_value == value && other < index)
            };
            let place = (0..size).filter(|&other| before(other)).count();
            self.values[place] = value;
            for row in 0..size {
                self.vectors[place * size + row] = found.eigenvectors[(row, index)];
            }
        }
        self.values.iter().all(|value| value.is_finite())
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Largest deviation of M·v from λ·v over all pairs, and of the vectors from being orthonormal.
    fn worst(matrix: &[Complex<f64>], found: &EigenSystem) -> f64 {
        let size = found.values.len();
        let element = |row: usize, column: usize| match row >= column {
            true => matrix[column * size + row],
            false => matrix[row * size + column].conj(),
        };
        let mut worst = 0.0f64;
        for (index, vector) in found.signal(size).enumerate() {
            for row in 0..size {
                let product: Complex<f64> = (0..size).map(|column| element(row, column) * vector[column]).sum();
                worst = worst.max((product - vector[row] * found.values[index]).norm());
            }
            for (other, with) in found.signal(size).enumerate() {
                let dot: Complex<f64> = vector.iter().zip(with).map(|(a, b)| a.conj() * b).sum();
                let expected = if other == index { 1.0 } else { 0.0 };
                worst = worst.max((dot - expected).norm());
            }
        }
        worst
    }

    /// [[2, i], [−i, 2]] has the values 3 and 1.
    #[test]
    fn worked_by_hand() {
        let mut found = EigenSystem::new(2);
        let matrix = [2.0.into(), Complex::new(0.0, -1.0), Complex::new(0.0, 1.0), 2.0.into()];
        assert!(found.decompose(&matrix));
        assert!((found.values[0] - 3.0).abs() < 1e-14 && (found.values[1] - 1.0).abs() < 1e-14);
        assert!(worst(&matrix, &found) < 1e-14);
    }

    #[test]
    fn multiple_and_zero_values() {
        for size in [2, 5, 16, 20] {
            let mut found = EigenSystem::new(size);
            let mut matrix = vec![Complex::ZERO; size * size];
            assert!(found.decompose(&matrix));
            assert_eq!(found.values, vec![0.0; size]);
            // Rank 1: the vector (1, i, −1, −i, …) times the vector's conjugate.
            for (column, row) in (0..size).flat_map(|column| (0..size).map(move |row| (column, row))) {
                matrix[column * size + row] = Complex::I.powu((4 + row as u32 - column as u32 % 4) % 4);
            }
            assert!(found.decompose(&matrix));
            assert!((found.values[0] - size as f64).abs() < 1e-12, "{:?}", found.values);
            assert!(worst(&matrix, &found) < 1e-12);
        }
    }

    proptest! {
        #[test]
        fn any_hermitian_matrix((size, parts) in (2usize..20).prop_flat_map(|size| {
            (Just(size), prop::collection::vec((-1.0..1.0, -1.0..1.0), size * size))
        })) {
            let mut matrix: Vec<_> = parts.iter().map(|&(re, im)| Complex::new(re, im)).collect();
            for index in 0..size {
                matrix[index * (size + 1)].im = 0.0;
            }
            let mut found = EigenSystem::new(size);
            prop_assert!(found.decompose(&matrix));
            prop_assert!(found.values.is_sorted_by(|a, b| a >= b));
            prop_assert!(worst(&matrix, &found) < 1e-12);
        }
    }
}
