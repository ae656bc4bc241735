//! Displacement of a source's reports by its errors, as far as differences of reports determine it.
//!
//! If all targets move in the same direction, an offset along this direction and a time offset displace all reports
//! alike. Differences determine only the sum of both errors, and the variance of each is the prior variance. The offset
//! across the direction may be known to a metre. A distance between two sources that adds the variances of all
//! directions is then as uncertain as the worst direction. So the distance is the mean square displacement of the
//! compared reports, θᵀ·(Σ HᵀWH / Σ W)·θ. An error not determined by differences displaces no report, and does not
//! count.

use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};

use crate::registration::errors::PRIOR_SIGMA;
use crate::registration::rows::{Errors, NormalMatrix, TIME};

/// Errors that may displace all reports alike: the horizontal offset, and the time offset.
pub(super) const ROWS: [usize; 3] = [0, 1, TIME];

/// Variance of a time offset relative to the variance at a known place, above which both offsets are confounded.
const CONFOUNDED: f64 = 4.0;

/// Mean square displacement of the reports of a source by [`ROWS`] of the errors.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(super) struct Displacement {
    /// Quadratic form, m² per square of the errors: Σ HᵀWH relative to the mean of Σ W over both axes.
    form: Matrix3<f64>,
    /// Variance per axis of the displacement, m².
    variance_m2: f64,
}

impl Displacement {
    /// Nothing has been compared.
    pub(super) const UNKNOWN: Self = Self {
        form: Matrix3::from_array_storage(nalgebra::ArrayStorage([[0.0; 3]; 3])),
        variance_m2: PRIOR_SIGMA[0] * PRIOR_SIGMA[0],
    };

    /// Returns the displacement of a source with these sums over its differences, per partner. The information from a
    /// step (`seed`) makes the displacement certain, but is no difference: a source that has just changed has no
    /// influence on the common part of all sources.
    pub(super) fn new<'a>(seed: &NormalMatrix, sums: impl Iterator<Item = &'a NormalMatrix>) -> Self {
        let mut form = Matrix3::zeros();
        for sum in sums {
            form += Matrix3::from_fn(|row, column| sum[(ROWS[row], ROWS[column])]);
        }
        let compared = 0.5 * (form[(0, 0)] + form[(1, 1)]);
        let information = compared + 0.5 * (seed[(0, 0)] + seed[(1, 1)]);
        Self {
            form: if compared > 0.0 { form / compared } else { form },
            variance_m2: 1.0 / (information + 1.0 / Self::UNKNOWN.variance_m2),
        }
    }

    /// Returns the variance per axis of the displacement, m².
    pub(super) fn variance_m2(&self) -> f64 {
        self.variance_m2
    }

    /// Returns the displacement by the time offset alone.
    pub(super) fn by_time(&self) -> Self {
        Self {
            form: Matrix3::from_fn(|row, column| if row.min(column) == 2 { self.form[(2, 2)] } else { 0.0 }),
            ..*self
        }
    }

    /// Returns the mean square per axis of the displacement, minus the part explained by chance, m².
    pub(super) fn excess_m2(&self, errors: &Errors) -> f64 {
        0.5 * self.squared_m2(errors) - self.variance_m2
    }

    /// Returns the mean square of the displacement, sum over both axes, m².
    pub(super) fn squared_m2(&self, errors: &Errors) -> f64 {
        let errors = of_rows(errors);
        errors.dot(&(self.form * errors))
    }

    /// Returns the squared statistical length of the displacement; the points of targets add `points_m2` per axis.
    pub(super) fn squared_length(&self, errors: &Errors, points_m2: f64) -> f64 {
        self.squared_m2(errors) / (self.variance_m2 + points_m2)
    }

    /// Returns whether time offset and offset of the place are hardly distinguishable: the variance of the time offset
    /// is far above the variance at a known place.
    pub(super) fn confounds_time(&self, variance_s2: f64) -> bool {
        self.form[(2, 2)] * variance_s2 > CONFOUNDED * self.variance_m2
    }

    /// Returns the weight in the geometric median of all sources: the inverse distance from the median, as far as
    /// known.
    pub(super) fn closeness(&self, errors: &Errors) -> f64 {
        1.0 / (self.squared_m2(errors) + 2.0 * self.variance_m2).sqrt()
    }
}

/// Weighted mean of the errors of several sources, per direction: a source counts only where differences determine the
/// error.
#[derive(Clone, Copy, Debug)]
pub(super) struct MeanErrors {
    normal: Matrix3<f64>,
    right: Vector3<f64>,
}

impl MeanErrors {
    pub(super) fn new() -> Self {
        Self {
            normal: Matrix3::zeros(),
            right: Vector3::zeros(),
        }
    }

    /// Adds the errors of a source.
    pub(super) fn add(&mut self, displacement: &Displacement, errors: &Errors, weight: f64) {
        let weighted = displacement.form * weight;
        self.normal += weighted;
        self.right += weighted * of_rows(errors);
        // The prior decides between errors that displace all reports alike.
        for (place, row) in ROWS.into_iter().enumerate() {
            self.normal[(place, place)] += weight * displacement.variance_m2 / (PRIOR_SIGMA[row] * PRIOR_SIGMA[row]);
        }
    }

    /// Returns the mean; 0 in all other rows, and without sources.
    pub(super) fn mean(&self) -> Errors {
        let mut mean = Errors::zeros();
        if let Some(factor) = self.normal.cholesky() {
            for (row, value) in ROWS.into_iter().zip(&factor.solve(&self.right)) {
                mean[row] = *value;
            }
        }
        mean
    }

    /// The same for a known time offset, seconds.
    pub(super) fn mean_at(&self, time_s: f64) -> Errors {
        let mut mean = Errors::zeros();
        mean[TIME] = time_s;
        let normal = self.normal.fixed_view::<2, 2>(0, 0).into_owned();
        let right = self.right.fixed_rows::<2>(0) - self.normal.fixed_view::<2, 1>(0, 2) * time_s;
        if let Some(factor) = normal.cholesky() {
            mean.fixed_rows_mut::<2>(0).copy_from(&factor.solve(&right));
        }
        mean
    }
}

fn of_rows(errors: &Errors) -> Vector3<f64> {
    Vector3::from(ROWS.map(|row| errors[row]))
}
