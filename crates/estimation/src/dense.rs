//! Symmetric positive definite systems with a size known only at run time, in arrays on the stack.

/// Replaces the lower triangle of the first `n` rows of `matrix` by the Cholesky factor L, matrix = L·Lᵀ. `false` if
/// the matrix is not positive definite; then the contents are of no use.
pub(crate) fn factorise<const N: usize>(matrix: &mut [[f64; N]; N], n: usize) -> bool {
    for row in 0..n {
        for column in 0..=row {
            let dot: f64 = (0..column).map(|k| matrix[row][k] * matrix[column][k]).sum();
            let rest = matrix[row][column] - dot;
            if row == column {
                // Written so that NaN is refused.
                if !(rest > 0.0 && rest.is_finite()) {
                    return false;
                }
                matrix[row][row] = rest.sqrt();
            } else {
                matrix[row][column] = rest / matrix[column][column];
            }
        }
    }
    true
}

/// Solves L·Lᵀ·x = b in place; `factor` is the result of [`factorise`].
pub(crate) fn solve<const N: usize>(factor: &[[f64; N]; N], n: usize, b: &mut [f64; N]) {
    for row in 0..n {
        let dot: f64 = (0..row).map(|k| factor[row][k] * b[k]).sum();
        b[row] = (b[row] - dot) / factor[row][row];
    }
    for row in (0..n).rev() {
        let dot: f64 = (row + 1..n).map(|k| factor[k][row] * b[k]).sum();
        b[row] = (b[row] - dot) / factor[row][row];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_system_is_solved_and_an_indefinite_one_refused() {
        let mut matrix = [[4.0, 2.0, 0.0], [2.0, 5.0, 1.0], [0.0, 1.0, 3.0]];
        let mut b = [8.0, 15.0, 11.0];
        assert!(factorise(&mut matrix, 3));
        solve(&matrix, 3, &mut b);
        for (found, expected) in b.iter().zip([1.0, 2.0, 3.0]) {
            assert!((found - expected).abs() < 1e-12);
        }
        assert!(!factorise(&mut [[1.0, 2.0], [2.0, 1.0]], 2));
        assert!(!factorise(&mut [[f64::NAN]], 1));
    }
}
