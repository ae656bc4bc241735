//! Inverse of a symmetric 3×3 matrix, without loops.

use crate::gaussian::Symmetric3;

/// Returns the columns of the inverse; `None` if the matrix is not positive definite. The elements are equal to the
/// elements of `nalgebra`'s inverse by Cholesky's decomposition, to the bit.
#[inline]
pub fn inverse3([xx, xy, xz, yy, yz, zz]: Symmetric3) -> Option<[[f64; 3]; 3]> {
    // L of L·Lᵀ, column by column. Written so that NaN is refused.
    let root = |variance: f64| (variance > 0.0).then(|| variance.sqrt());
    let a = root(xx)?;
    let (b, c) = (xy / a, xz / a);
    let d = root(yy - b * b)?;
    let e = (yz - b * c) / d;
    let f = root(zz - c * c - e * e)?;
    // Lᵀ·x = y, for the column y of L⁻¹.
    let solved = |[first, second, third]: [f64; 3]| {
        let third = third / f;
        let second = (second - e * third) / d;
        [(first - (b * second + c * third)) / a, second, third]
    };
    let first = 1.0 / a;
    let second = -(first * b) / d;
    let third = (-(first * c) - second * e) / f;
    let (middle, last) = (1.0 / d, 1.0 / f);
    Some([
        solved([first, second, third]),
        solved([0.0, middle, -(middle * e) / f]),
        solved([0.0, 0.0, last]),
    ])
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::Matrix3;

    #[test]
    fn what_is_not_positive_definite_has_no_inverse() {
        for matrix in [
            [0.0; 6],
            [1.0, 2.0, 0.0, 1.0, 0.0, 1.0],
            [f64::NAN, 0.0, 0.0, 1.0, 0.0, 1.0],
        ] {
            assert_eq!(inverse3(matrix), None);
        }
    }

    proptest! {
        #[test]
        fn it_equals_that_of_nalgebra_to_the_bit(
            sigma in prop::array::uniform3(1.0..1e4f64), correlation in prop::array::uniform3(-0.57..0.57f64),
        ) {
            let [x, y, z] = sigma;
            let [p, q, r] = correlation;
            let given = [x * x, p * x * y, q * x * z, y * y, r * y * z, z * z];
            let [xx, xy, xz, yy, yz, zz] = given;
            let expected = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz).cholesky().map(|factor| factor.inverse());
            prop_assert_eq!(inverse3(given), expected.map(|inverse| inverse.data.0));
        }
    }
}
