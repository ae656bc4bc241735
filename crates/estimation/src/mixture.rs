//! Mixtures of two states, each with a probability.
//!
//! The mean is the weighted mean; the covariance is the weighted mean of both, plus the spread of the means
//! (Bar-Shalom et al. 2001, section 1.4.16). Interacting multiple models use these mixtures.

use messages::STATE_LEN;

use crate::gaussian::{Gaussian, at};

impl Gaussian {
    /// Mean and covariance of a mixture of two: `a` with probability `1 − weight_of_b`, else `b`.
    pub fn mixture(a: &Self, b: &Self, weight_of_b: f64) -> Self {
        let mut mixture = *a;
        mixture.mix::<STATE_LEN>(a, b, weight_of_b);
        mixture
    }

    /// Sets the first `N` components, with covariances, to the mixture of `a` and `b`; the others are unchanged.
    #[allow(clippy::needless_range_loop)] // Iterators keep these loops from being unrolled.
    pub fn mix<const N: usize>(&mut self, a: &Self, b: &Self, weight_of_b: f64) {
        let difference = a.difference(b);
        for row in 0..N {
            self.mean[row] = weighted((a.mean[row], b.mean[row]), weight_of_b);
            let spread = (1.0 - weight_of_b) * weight_of_b * difference[row];
            for column in row..N {
                let of = (a.covariance.upper[at(row, column)], b.covariance.upper[at(row, column)]);
                self.covariance.upper[at(row, column)] = weighted(of, weight_of_b) + spread * difference[column];
            }
        }
    }

    fn difference(&self, other: &Self) -> [f64; STATE_LEN] {
        std::array::from_fn(|row| self.mean[row] - other.mean[row])
    }
}

/// `a` with weight `1 − weight_of_b`, and `b`.
#[inline]
fn weighted((a, b): (f64, f64), weight_of_b: f64) -> f64 {
    (1.0 - weight_of_b) * a + weight_of_b * b
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::gaussian::{Vector6, packed, unpacked};
    use crate::testing::{any_gaussian, assert_close};

    proptest! {
        #[test]
        fn equals_the_matrix_form(a in any_gaussian(), b in any_gaussian(), weight in 0.0..1.0f64) {
            let (mean_a, mean_b) = (Vector6::from(a.mean), Vector6::from(b.mean));
            let apart = mean_a - mean_b;
            let mixture = Gaussian {
                mean: (mean_a * (1.0 - weight) + mean_b * weight).into(),
                covariance: packed(&(unpacked(&a.covariance) * (1.0 - weight)
                    + unpacked(&b.covariance) * weight
                    + apart * apart.transpose() * (weight * (1.0 - weight)))),
            };
            assert_close(&Gaussian::mixture(&a, &b, weight), &mixture);
        }
    }
}
