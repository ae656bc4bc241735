//! Symmetric matrices of a few rows, as arrays of rows in loops of constant length.
//!
//! A general product or decomposition of matrices spends more on its loops and branches than on four rows of four
//! numbers. Here the compiler knows every length: loops unroll, and a row is two additions of two numbers each. An
//! update by independent measurements needs no inverse: with S = L·D·Lᵀ (no roots), the rows of the gain's factor
//! W = D^(−½)·L⁻¹·H·P give the mean P ← P − Wᵀ·W, and the determinant of S is that of D.
//!
//! Limits: `R` measurements and `N` components are small; matrices that are not positive definite are refused.
//!
//! Source: G. H. Golub, C. F. Van Loan, *Matrix Computations* (Johns Hopkins, 2013), sections 4.1 and 4.2.

#![expect(clippy::needless_range_loop, reason = "rows and columns, as in the formulas")]

/// Rows of a square matrix.
pub(crate) type Rows<const N: usize> = [[f64; N]; N];

/// Adds a multiple of a row.
#[inline(always)]
pub(crate) fn add_scaled<const N: usize>(sum: &mut [f64; N], row: &[f64; N], factor: f64) {
    for (sum, value) in sum.iter_mut().zip(row) {
        *sum += factor * value;
    }
}

/// Adds a multiple of row·rowᵀ.
#[inline(always)]
pub(crate) fn add_square<const N: usize>(sum: &mut Rows<N>, row: &[f64; N], factor: f64) {
    for (sum, value) in sum.iter_mut().zip(row) {
        add_scaled(sum, row, factor * value);
    }
}

/// Adds a multiple of a matrix.
#[inline(always)]
pub(crate) fn add_rows<const N: usize>(sum: &mut Rows<N>, rows: &Rows<N>, factor: f64) {
    for (sum, row) in sum.iter_mut().zip(rows) {
        add_scaled(sum, row, factor);
    }
}

/// Scalar product.
#[inline(always)]
pub(crate) fn dot<const N: usize>(one: &[f64; N], other: &[f64; N]) -> f64 {
    one.iter().zip(other).map(|(one, other)| one * other).sum()
}

/// Product of `R` rows of `N` numbers with the `N` rows of a matrix.
#[inline(always)]
pub(crate) fn times<const R: usize, const N: usize, const C: usize>(
    left: &[[f64; N]; R],
    right: &[[f64; C]; N],
) -> [[f64; C]; R] {
    let mut product = [[0.0; C]; R];
    for (product, left) in product.iter_mut().zip(left) {
        // A sum apart stays in registers.
        let mut sum = [0.0; C];
        for (value, right) in left.iter().zip(right) {
            add_scaled(&mut sum, right, *value);
        }
        *product = sum;
    }
    product
}

/// Makes a matrix that is symmetric up to rounding exactly symmetric.
#[inline(always)]
pub(crate) fn symmetric<const N: usize>(matrix: &mut Rows<N>) {
    for row in 0..N {
        for column in 0..row {
            let mean = 0.5 * (matrix[row][column] + matrix[column][row]);
            matrix[row][column] = mean;
            matrix[column][row] = mean;
        }
    }
}

/// Factors L and D of S = L·D·Lᵀ, with the diagonal of L left out.
#[derive(Clone, Copy)]
pub(crate) struct Pivots<const R: usize> {
    lower: Rows<R>,
    /// Inverse of each element of D.
    inverse: [f64; R],
    /// Determinant of S.
    pub(crate) determinant: f64,
}

impl<const R: usize> Pivots<R> {
    /// Factors a matrix by its lower triangle; `None` if the matrix is not positive definite.
    #[inline(always)]
    pub(crate) fn of(mut rest: Rows<R>) -> Option<Self> {
        let (mut lower, mut inverse, mut determinant) = ([[0.0; R]; R], [0.0; R], 1.0);
        for place in 0..R {
            let pivot = rest[place][place];
            if pivot.is_nan() || pivot <= 0.0 {
                return None;
            }
            inverse[place] = 1.0 / pivot;
            determinant *= pivot;
            for row in place + 1..R {
                let share = rest[row][place] * inverse[place];
                lower[row][place] = share;
                for column in place + 1..=row {
                    rest[row][column] -= share * rest[column][place];
                }
            }
        }
        determinant.is_finite().then_some(Self {
            lower,
            inverse,
            determinant,
        })
    }

    /// L⁻¹ times a column.
    #[inline(always)]
    pub(crate) fn eliminated(&self, mut column: [f64; R]) -> [f64; R] {
        for row in 1..R {
            for before in 0..row {
                column[row] -= self.lower[row][before] * column[before];
            }
        }
        column
    }

    /// Squared length of a column behind [`Self::eliminated`], relative to S.
    #[inline(always)]
    pub(crate) fn squared(&self, eliminated: &[f64; R]) -> f64 {
        let squares = eliminated.iter().zip(&self.inverse);
        squares.map(|(value, inverse)| value * value * inverse).sum()
    }

    /// The rows D^(−½)·L⁻¹·(given rows), and D^(−½) times the column behind [`Self::eliminated`].
    #[inline(always)]
    pub(crate) fn whitened<const N: usize>(
        &self,
        mut rows: [[f64; N]; R],
        mut eliminated: [f64; R],
    ) -> ([[f64; N]; R], [f64; R]) {
        for row in 1..R {
            for before in 0..row {
                let earlier = rows[before];
                add_scaled(&mut rows[row], &earlier, -self.lower[row][before]);
            }
        }
        for ((row, value), inverse) in rows.iter_mut().zip(&mut eliminated).zip(&self.inverse) {
            let root = inverse.sqrt();
            row.iter_mut().for_each(|element| *element *= root);
            *value *= root;
        }
        (rows, eliminated)
    }
}

/// Returns L of S = L·Lᵀ; `None` if the matrix is not positive definite.
#[inline(always)]
pub(crate) fn root<const N: usize>(matrix: &Rows<N>) -> Option<Rows<N>> {
    let mut lower = [[0.0; N]; N];
    for row in 0..N {
        for column in 0..=row {
            let mut rest = matrix[row][column];
            for before in 0..column {
                rest -= lower[row][before] * lower[column][before];
            }
            if column < row {
                lower[row][column] = rest / lower[column][column];
            } else if rest > 0.0 && rest.is_finite() {
                lower[row][row] = rest.sqrt();
            } else {
                return None;
            }
        }
    }
    Some(lower)
}

#[cfg(test)]
mod tests {
    use nalgebra::{Matrix4, SMatrix, Vector4};
    use proptest::prelude::*;

    use super::*;

    /// A positive definite matrix with standard deviations of any size.
    fn any_matrix() -> impl Strategy<Value = Matrix4<f64>> {
        let sigma = prop::array::uniform4(-2.0..4.0f64);
        let rows = prop::array::uniform4(prop::array::uniform4(-1.0..1.0f64));
        (sigma, rows).prop_map(|(sigma, rows)| {
            let factor = Matrix4::from_fn(|row, column| rows[row][column]);
            let correlated = factor * factor.transpose() + Matrix4::identity() * 0.1;
            let scale = Matrix4::from_diagonal(&Vector4::from(sigma.map(|power| 10f64.powf(power))));
            scale * correlated * scale
        })
    }

    fn rows_of<const R: usize, const C: usize>(matrix: &SMatrix<f64, R, C>) -> [[f64; C]; R] {
        std::array::from_fn(|row| std::array::from_fn(|column| matrix[(row, column)]))
    }

    proptest! {
        #[test]
        fn factors_are_those_of_nalgebra(matrix in any_matrix()) {
            let expected = matrix.cholesky().unwrap();
            let lower = root(&rows_of(&matrix)).unwrap();
            let pivots = Pivots::of(rows_of(&matrix)).unwrap();
            for row in 0..4 {
                let sigma = matrix[(row, row)].sqrt();
                for column in 0..=row {
                    prop_assert!((lower[row][column] - expected.l()[(row, column)]).abs() < 1e-12 * sigma);
                }
            }
            prop_assert!((pivots.determinant / expected.determinant() - 1.0).abs() < 1e-9);
        }

        #[test]
        fn whitened_rows_are_the_update_by_the_inverse(
            matrix in any_matrix(), column in prop::array::uniform4(-1e3..1e3f64),
            other in prop::array::uniform4(prop::array::uniform4(-10.0..10.0f64)),
        ) {
            let inverse = matrix.cholesky().unwrap().inverse();
            let given = SMatrix::<f64, 4, 4>::from_fn(|row, column| other[row][column]);
            let along = Vector4::from(column);
            let pivots = Pivots::of(rows_of(&matrix)).unwrap();
            let eliminated = pivots.eliminated(column);
            let (white, residual) = pivots.whitened(other, eliminated);
            let squared = along.dot(&(inverse * along));
            prop_assert!((pivots.squared(&eliminated) - squared).abs() < 1e-9 * squared);
            let (expected, mean) = (given.transpose() * inverse * given, given.transpose() * inverse * along);
            let mut found = [[0.0; 4]; 4];
            let mut moved = [0.0; 4];
            for (row, value) in white.iter().zip(residual) {
                add_square(&mut found, row, 1.0);
                add_scaled(&mut moved, row, value);
            }
            for row in 0..4 {
                let scale = expected[(row, row)];
                prop_assert!((moved[row] - mean[row]).abs() < 1e-9 * (scale * squared).sqrt());
                for column in 0..4 {
                    let scale = (scale * expected[(column, column)]).sqrt();
                    prop_assert!((found[row][column] - expected[(row, column)]).abs() < 1e-9 * scale);
                    prop_assert_eq!(found[row][column], found[column][row]);
                }
            }
        }

        #[test]
        fn products_are_those_of_nalgebra(
            one in prop::array::uniform4(prop::array::uniform4(-10.0..10.0f64)),
            other in prop::array::uniform4(prop::array::uniform4(-10.0..10.0f64)),
        ) {
            let of = |rows: Rows<4>| Matrix4::from_fn(|row, column| rows[row][column]);
            let found = of(times(&one, &other));
            prop_assert!((found - of(one) * of(other)).amax() < 1e-12);
            prop_assert!((dot(&one[0], &other[0]) - of(one).row(0).dot(&of(other).row(0))).abs() < 1e-12);
        }
    }

    #[test]
    fn what_is_not_positive_definite_has_no_factor() {
        for matrix in [
            [[1.0, 2.0], [2.0, 1.0]],
            [[0.0; 2]; 2],
            [[f64::NAN; 2]; 2],
            [[f64::INFINITY; 2]; 2],
        ] {
            assert!(root(&matrix).is_none() && Pivots::of(matrix).is_none(), "{matrix:?}");
        }
    }
}
