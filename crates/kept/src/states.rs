//! States of filters as words.

use estimation::{Gaussian, NearlyConstantVelocity};
use messages::Covariance;
use nalgebra::SMatrix;

use crate::{Get, Kept, Put, kept};

impl<const R: usize, const C: usize> Kept for SMatrix<f64, R, C> {
    const WORDS: usize = R * C;

    fn put(&self, to: &mut Put<'_>) {
        for value in self {
            value.put(to);
        }
    }

    fn get(from: &mut Get<'_>) -> Option<Self> {
        let mut matrix = Self::zeros();
        for value in &mut matrix {
            *value = f64::get(from)?;
        }
        Some(matrix)
    }
}

kept!(Gaussian {
    mean: [f64; 6],
    covariance: Covariance
});
kept!(NearlyConstantVelocity {
    density_m2ps3: [f64; 3]
});
