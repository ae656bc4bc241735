//! The measurement behind a report: recovered from the sensor track if the source's filter can be undone, else the
//! report itself.
//!
//! A report of a filter that cannot be undone, not even by its corrections (module `corrections`), repeats earlier
//! information; its errors persist over some reports. Such a report stands for a measurement with three times the
//! report's covariance. A covariance without correlation of position and velocity indicates no filter: the report is
//! used directly.

use estimation::{Gaussian, Recovered, Symmetric3, recovered};
use messages::{AXES, Covariance, SensorTrack, sensor_track_bits};
use nalgebra::Matrix2;
use serde::{Deserialize, Serialize};

use crate::error_shape::Stretch;
use crate::tracker_gain::GainEvidence;

/// Factor on the covariance of reports from a filter that cannot be undone.
const SMOOTHED: f64 = 3.0;
/// Correlation of position and velocity from which a filter is assumed.
const FILTERED: f64 = 0.2;
/// Largest factor between true and stated covariances.
pub const CLAIM_MAX: f64 = 100.0;
/// Relative difference of the regression of velocity on position explained by rounding.
const REGRESSION_TOLERANCE: f64 = 0.1;

/// The state of a report.
#[inline]
pub fn gaussian_of(report: &SensorTrack) -> Gaussian {
    Gaussian::new(report.position_m, report.velocity_mps, &report.covariance)
}

/// Whether the source of a report states a velocity of the target not derived from positions.
#[inline]
pub fn states_velocity(report: &SensorTrack) -> bool {
    report.has(sensor_track_bits::VELOCITY) && !report.has(sensor_track_bits::DERIVED_VELOCITY)
}

/// Known errors of a report.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Correction {
    /// Displacement by the known biases of the source, metres.
    pub shift_m: [f64; AXES],
    /// Factor between the true and the stated covariance.
    pub covariance_scale: f64,
    /// Stretch of the covariance to the shape of the source's errors.
    pub stretch: Stretch,
}

impl Correction {
    /// No error is known.
    pub const NONE: Self = Self {
        shift_m: [0.0; AXES],
        covariance_scale: 1.0,
        stretch: Stretch::NONE,
    };

    /// The corrected state for a state of the source.
    pub fn made(&self, mut state: Gaussian) -> Gaussian {
        for (component, shift) in state.mean.iter_mut().zip(self.shift_m) {
            *component -= shift;
        }
        let upper = &mut state.covariance.upper;
        upper.iter_mut().for_each(|value| *value *= self.covariance_scale);
        self.stretch.apply_to_state(&mut state.covariance);
        state
    }

    /// The uncorrected state for a corrected state.
    #[inline]
    pub fn undone(&self, mut state: Gaussian) -> Gaussian {
        for (component, shift) in state.mean.iter_mut().zip(self.shift_m) {
            *component += shift;
        }
        if self.covariance_scale != 1.0 {
            let upper = &mut state.covariance.upper;
            upper.iter_mut().for_each(|value| *value /= self.covariance_scale);
        }
        if self.stretch != Stretch::NONE {
            self.stretch.inverse().apply_to_state(&mut state.covariance);
        }
        state
    }
}

/// A measured position.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Measurement {
    /// East, north, up, metres.
    pub position_m: [f64; AXES],
    /// Upper triangle of the covariance, row by row, m².
    pub covariance_m2: Symmetric3,
    /// Number of measured axes: 3, or 2 without observed height; the third then has no meaning.
    pub axes: usize,
    /// Whether the measurement's report waited for the end of its scan: such a report is in time even after later
    /// reports were used.
    pub has_waited: bool,
}

impl Measurement {
    /// The absent measurement.
    pub const NONE: Self = Self {
        position_m: [0.0; AXES],
        covariance_m2: [0.0; 6],
        axes: 0,
        has_waited: false,
    };

    /// Removes the known biases of the source, and enlarges the covariance to the right size.
    #[inline]
    pub fn correct(&mut self, correction: &Correction) {
        for (position, shift) in self.position_m.iter_mut().zip(correction.shift_m) {
            *position -= shift;
        }
        if correction.covariance_scale != 1.0 {
            let values = self.covariance_m2.iter_mut();
            values.for_each(|value| *value *= correction.covariance_scale);
        }
        if correction.stretch != Stretch::NONE {
            correction.stretch.apply(&mut self.covariance_m2);
        }
    }

    /// Undoes [`Self::correct`].
    pub fn uncorrect(&mut self, correction: &Correction) {
        if correction.stretch != Stretch::NONE {
            correction.stretch.inverse().apply(&mut self.covariance_m2);
        }
        for (position, shift) in self.position_m.iter_mut().zip(correction.shift_m) {
            *position += shift;
        }
        let values = self.covariance_m2.iter_mut();
        values.for_each(|value| *value /= correction.covariance_scale);
    }

    /// Subtracts the offset of the detection point from the target's reference point, with a variance per axis.
    #[inline]
    pub fn refer(&mut self, point_m: [f64; 2], variance_m2: f64) {
        for (position, point) in self.position_m.iter_mut().zip(point_m) {
            *position -= point;
        }
        self.covariance_m2[0] += variance_m2;
        self.covariance_m2[3] += variance_m2;
    }

    /// Variance per horizontal axis, m².
    #[inline]
    pub fn variance_m2(&self) -> f64 {
        0.5 * (self.covariance_m2[0] + self.covariance_m2[3])
    }
}

/// Returns all position information of a report: the contribution of a newly joined sensor track.
#[inline]
pub fn whole_report(report: &SensorTrack) -> Measurement {
    whole(
        report.position_m,
        &report.covariance,
        report.has(sensor_track_bits::HEIGHT),
    )
}

#[inline]
fn whole(position_m: [f64; AXES], covariance: &Covariance, has_height: bool) -> Measurement {
    let p = |row, column| covariance.get(row, column);
    Measurement {
        position_m,
        covariance_m2: [p(0, 0), p(0, 1), p(0, 2), p(1, 1), p(1, 2), p(2, 2)],
        axes: if has_height { AXES } else { 2 },
        has_waited: false,
    }
}

/// Whether the covariance of a report indicates a filter.
#[inline]
pub fn shows_filter(covariance: &Covariance) -> bool {
    let p = |row, column| covariance.get(row, column);
    let filtered =
        |cross: f64, position: f64, velocity: f64| cross > 0.0 && cross > FILTERED * (position * velocity).sqrt();
    filtered(p(0, 3), p(0, 0), p(3, 3)) || filtered(p(1, 4), p(1, 1), p(4, 4))
}

/// The report in place of a measurement.
#[inline]
pub(crate) fn as_reported(report: &SensorTrack) -> Measurement {
    as_stated(
        report.position_m,
        &report.covariance,
        report.has(sensor_track_bits::HEIGHT),
    )
}

/// A state in place of a measurement.
#[inline]
pub(crate) fn as_stated(position_m: [f64; AXES], covariance: &Covariance, has_height: bool) -> Measurement {
    let mut measurement = whole(position_m, covariance, has_height);
    if shows_filter(covariance) {
        measurement
            .covariance_m2
            .iter_mut()
            .for_each(|value| *value *= SMOOTHED);
    }
    measurement
}

/// Origin of the covariance of a report, in the order of the knowledge of its source.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum CovarianceBasis {
    /// Stated by the source.
    Stated,
    /// Assumed to be as wrong as the covariances of other sources.
    Doubted,
    /// Derived from the gain of the source's tracker.
    Gain,
}

/// Content of a report beside its state.
#[derive(Clone, Copy, Debug)]
pub struct Content {
    /// The measurement behind the report; `None` if there was none.
    pub measurement: Option<Measurement>,
    /// Present if the stated covariance shows no filter.
    pub unfiltered: Option<UnfilteredContent>,
}

impl Content {
    /// Empty content. Not a constant: a constant would be copied as a whole.
    #[inline]
    pub fn none() -> Self {
        Self {
            measurement: None,
            unfiltered: None,
        }
    }
}

/// Content of a report with a covariance without indication of a filter. Separate, so that other reports pay nothing.
#[derive(Clone, Copy, Debug)]
pub struct UnfilteredContent {
    /// The covariance in place of the stated covariance, if any.
    pub covariance: Option<Covariance>,
    /// Origin of the covariance.
    pub basis: CovarianceBasis,
    /// Evidence of the gain of the source's tracker from the reports of the track.
    pub evidence: GainEvidence,
}

impl UnfilteredContent {
    /// With the stated covariance, after such evidence.
    #[inline]
    pub const fn stated(evidence: GainEvidence) -> Self {
        Self {
            covariance: None,
            basis: CovarianceBasis::Stated,
            evidence,
        }
    }
}

/// The measurement between `predicted` and `updated`, the state of a report with or without height.
pub(crate) fn recovered_measurement(predicted: &Gaussian, updated: &Gaussian, has_height: bool) -> Option<Measurement> {
    let (position_m, covariance) = (updated.position_m(), &updated.covariance);
    if !is_one_update(predicted, updated) {
        return Some(as_stated(position_m, covariance, has_height));
    }
    let mut measurement = whole(position_m, covariance, has_height);
    if measurement.axes == AXES
        && let Some(Recovered {
            position_m,
            covariance_m2,
        }) = recovered::<AXES>(predicted, updated)
    {
        measurement.position_m = position_m.into();
        let r = covariance_m2;
        measurement.covariance_m2 = [r[(0, 0)], r[(0, 1)], r[(0, 2)], r[(1, 1)], r[(1, 2)], r[(2, 2)]];
        return Some(measurement);
    }
    let Recovered {
        position_m,
        covariance_m2,
    } = recovered::<2>(predicted, updated)?;
    measurement.axes = 2;
    measurement.position_m[..2].copy_from_slice(position_m.as_slice());
    let r = covariance_m2;
    measurement.covariance_m2 = [r[(0, 0)], r[(0, 1)], 0.0, r[(1, 1)], 0.0, 0.0];
    Some(measurement)
}

/// Returns whether exactly one position measurement can explain the change from `predicted` to `updated`: the
/// regression of velocity on position is then unchanged.
fn is_one_update(predicted: &Gaussian, updated: &Gaussian) -> bool {
    let regression = |of: &Gaussian| {
        let block = |row: usize| Matrix2::from_fn(|i, j| of.covariance.get(row + i, j));
        Some(block(AXES) * block(0).try_inverse()?)
    };
    match (regression(predicted), regression(updated)) {
        (Some(before), Some(after)) => {
            (before - after).norm() <= REGRESSION_TOLERANCE * before.norm().max(after.norm())
        }
        _ => false,
    }
}
