//! Systematic errors of a source, and their effect on its reports.
//!
//! The errors are an offset of the place, an offset of the time, a range bias and an azimuth bias. To first order, a
//! report is linear in the errors: [`TargetView::sensitivity`] is the matrix of derivatives at the place and velocity
//! of the target. `registration` estimates the errors from differences of reports by several sources.

use estimation::Symmetric3;
use kept::kept;
use messages::AXES;
use nalgebra::SMatrix;
use serde::{Deserialize, Serialize};

use crate::measurement::{Correction, Measurement};
use crate::registration::model::BiasModel;
use crate::registration::rows::{ERRORS, Errors, TIME};
use crate::registration::sensitivity::Sensitivity;
use crate::stamps::StampError;

/// Prior standard deviations of the errors.
pub(crate) const PRIOR_SIGMA: [f64; ERRORS] = [1000.0, 1000.0, 1000.0, 1.0, 1000.0, 0.1];
/// Least number of samples of a source for the removal of errors.
pub(crate) const SAMPLES_MIN: f64 = 20.0;
/// Largest possible error, in prior standard deviations: reports farther apart belong to different targets.
pub(crate) const ERROR_MAX_SIGMA: f64 = 10.0;

/// Standard deviations of the time offset of a clock that deviates from the times of receipt, seconds: of a fast clock,
/// and of a slow clock. Slow transmission looks like a slow clock.
const CLOCK_SIGMA_S: [f64; 2] = [0.3, 1.0];

/// Error of a source's clock according to the times of receipt.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(crate) struct ClockError {
    /// Offset against sound clocks, seconds; positive if ahead.
    pub(crate) offset_s: f64,
    /// Part of the size of the offset not explained by the data path, seconds; 0 for a sound, unknown or corrected
    /// clock.
    pub(crate) excess_s: f64,
    /// Part subtracted from the times of the source's reports, seconds.
    pub(crate) removed_s: f64,
}

impl ClockError {
    /// Inverse variance and mean of the source's time offset before any comparison.
    pub(crate) fn prior(self) -> (f64, f64) {
        let (sigma_s, offset_s) = match self.excess_s > 0.0 {
            true => (CLOCK_SIGMA_S[usize::from(self.offset_s < 0.0)], self.offset_s),
            false => (PRIOR_SIGMA[TIME], 0.0),
        };
        (1.0 / (sigma_s * sigma_s), offset_s)
    }
}

pub(crate) fn clock_of(clocks: &[ClockError], source: usize) -> ClockError {
    clocks.get(source).copied().unwrap_or_default()
}

/// View of a target by a source.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TargetView {
    pub(crate) source: u16,
    /// Position as reported, without corrections, metres.
    pub(crate) position_m: [f64; AXES],
    pub(crate) covariance_m2: Symmetric3,
    pub(crate) velocity_mps: [f64; AXES],
    /// Whether the source states the horizontal velocity.
    pub(crate) has_velocity: bool,
    pub(crate) has_height: bool,
    /// Position of the sensor, if known.
    pub(crate) place_m: Option<[f64; 2]>,
}

impl TargetView {
    /// Returns the velocity of the target; if the source states none, the velocity of the other view.
    pub(crate) fn velocity_beside(&self, other: &Self) -> [f64; AXES] {
        if self.has_velocity {
            self.velocity_mps
        } else {
            other.velocity_mps
        }
    }

    /// Returns the derivatives of the report by the source's biases, for a target with this velocity.
    pub(crate) fn sensitivity(&self, velocity_mps: [f64; AXES]) -> Sensitivity {
        Sensitivity::new(self.position_m, velocity_mps, self.place_m)
    }

    /// Replaces the state by the underlying measurement; `correction`, subtracted before, is added back.
    pub(crate) fn take_measurement(&mut self, measurement: &Measurement, correction: &Correction) {
        let mut measurement = *measurement;
        measurement.uncorrect(correction);
        self.position_m = measurement.position_m;
        self.covariance_m2 = measurement.covariance_m2;
        self.has_height &= measurement.axes == AXES;
    }
}

/// [`Sensitivity`] as a matrix.
pub(crate) fn sensitivity(
    position: [f64; AXES],
    velocity: [f64; AXES],
    place: Option<[f64; 2]>,
) -> SMatrix<f64, AXES, ERRORS> {
    Sensitivity::new(position, velocity, place).matrix()
}

kept! {
    /// Biases of a source, as far as known.
    #[derive(Clone, Copy, Debug, Serialize, Deserialize)]
    pub struct SourceErrors {
        /// The estimate.
        pub errors: Errors,
        /// Variances of the estimate, same units squared.
        pub variances: Errors,
        /// Number of samples in the estimate, after forgetting.
        pub samples: f64,
        /// Errors removed from the source's reports.
        pub removed: [bool; ERRORS],
        /// Model of the biases: the estimated kinds; all other biases are 0.
        pub(crate) model: BiasModel,
        /// Time offset that the source's stamps imply.
        pub(crate) stamps: StampError,
    }
}

/// Returns the prior variances of the errors.
pub(crate) fn prior_variances() -> Errors {
    Errors::from_fn(|row, _| PRIOR_SIGMA[row] * PRIOR_SIGMA[row])
}

impl SourceErrors {
    /// Errors of a source without any information.
    pub(crate) fn unknown() -> Self {
        Self {
            errors: Errors::zeros(),
            variances: prior_variances(),
            samples: 0.0,
            removed: [false; ERRORS],
            model: BiasModel::OFFSET,
            stamps: StampError::default(),
        }
    }

    /// The displacement of a report by the removed errors, metres. Where no time offset is removed, the mean offset of
    /// the stamps is.
    #[inline]
    pub fn shift(&self, position_m: [f64; AXES], velocity_mps: [f64; AXES], place_m: Option<[f64; 2]>) -> [f64; AXES] {
        if self.removed == [false; ERRORS] && self.stamps.mean_s == 0.0 {
            return [0.0; AXES];
        }
        let mut removed = Errors::from_fn(|row, _| if self.removed[row] { self.errors[row] } else { 0.0 });
        removed[TIME] = self.time_offset_s();
        (sensitivity(position_m, velocity_mps, place_m) * removed).into()
    }

    /// The removed time offset, seconds.
    pub(crate) fn time_offset_s(&self) -> f64 {
        if self.removed[TIME] {
            self.errors[TIME]
        } else {
            self.stamps.mean_s
        }
    }

    /// The errors apart from what the stamps explain.
    pub(crate) fn beside_stamps(&self) -> Errors {
        let mut errors = self.errors;
        if self.stamps.is_coarse() {
            errors[TIME] = 0.0;
        }
        errors
    }

    /// Variance of the time offset that remains in the reports, beside the offset that all sources have in common, s².
    pub(crate) fn time_left_s2(&self) -> f64 {
        let variance_s2 = self.variances[TIME];
        let apart_s = self.errors[TIME] - self.time_offset_s();
        (apart_s * apart_s + variance_s2).min(self.stamps.variance_s2)
    }

    /// Mean square of the horizontal offset per axis, minus the part explained by chance, m².
    pub(crate) fn excess_m2(&self) -> f64 {
        let excess = |axis: usize| self.errors[axis] * self.errors[axis] - self.variances[axis];
        0.5 * (excess(0) + excess(1))
    }

    /// Whether the errors are within the possible range; false for NaN.
    pub(crate) fn are_possible(&self) -> bool {
        let limits = PRIOR_SIGMA.iter().map(|sigma| ERROR_MAX_SIGMA * sigma);
        self.errors
            .iter()
            .zip(limits)
            .all(|(error, limit)| error.abs() <= limit)
    }
}
