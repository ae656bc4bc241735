//! The engine's estimates for a source, beside its biases: for health messages, reports and people.
//!
//! Nothing here takes part in fusion; the values are read once per health message from the models used in fusion.

use messages::{Bias, ErrorModel, NS_PER_S};

use crate::registration::SourceErrors;
use crate::source_model::SourceModel;
use crate::sources::Sources;

/// Maximum number of sources in [`Learned::dependent`].
pub(crate) const DEPENDENT_MAX: usize = 4;
/// New tracks of a source before the share of targets among them is stated.
const NEW_TRACKS_MIN: f64 = 8.0;

/// Estimates for a source.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Learned {
    /// Standard deviations of the measurements of a source with an undone tracker, metres: along the long and the short
    /// axis of the error ellipse, and of the height.
    pub measurement_sigma_m: Option<[f64; 2]>,
    /// See `measurement_sigma_m`.
    pub height_sigma_m: Option<f64>,
    /// Ratio of the standard deviations across and along the line of sight, both relative to the stated covariances.
    pub shape_ratio: Option<f64>,
    /// Share of the source's new tracks that turned out to be targets.
    pub target_share: Option<f64>,
    /// Delay of the source's reports, exceeded by a tenth of the reports, seconds.
    pub lateness_s: f64,
    /// Step of which all time stamps are multiples, and the standard deviation of the time offset that the step
    /// implies, seconds; `None` if the stamps are fine.
    pub stamps_s: Option<[f64; 2]>,
    /// Probability that a scan detects a target tracked by the source.
    pub detection_probability: f64,
    /// Model of the systematic error with the best evidence.
    pub error_model: Option<ErrorModel>,
    /// Sources on which the source depends, with the correlation of the errors, in (0, 1], 0 for no source: the first
    /// `DEPENDENT_MAX` by number.
    pub dependent: [(u16, f64); DEPENDENT_MAX],
}

impl Sources {
    /// Returns the estimated systematic errors of `source` (BF-3); `None` if the source does not exist.
    pub fn source_errors(&self, source: u16) -> Option<&SourceErrors> {
        (usize::from(source) < self.models.len()).then(|| self.registration.of(source))
    }

    /// Returns the gross error of `source` found from unassociated tracks. `None` if there is no error or no such
    /// source, or if the error may belong to the partner and a majority decides between the two.
    pub fn gross_error(&self, source: u16) -> Option<Bias> {
        let is_off = |source: u16| self.contradiction(source).is_some_and(|error| error.is_certain);
        (usize::from(source) < self.models.len())
            .then(|| self.alignment.error_of(source))
            .flatten()
            .filter(|error| error.is_certain || !(is_off(source) || is_off(error.partner)))
    }

    /// Returns the error of `source` relative to other sources in agreement, or relative to a single contradicted
    /// source, from jointly observed targets. `None` without an error or for an unknown source.
    pub fn contradiction(&self, source: u16) -> Option<Bias> {
        (usize::from(source) < self.models.len())
            .then(|| self.registration.contradiction(source))
            .flatten()
    }

    /// Returns the first source of the group on which `source` depends (configured or learned). Returns `None` if
    /// `source` is the first of its group, independent, or does not exist.
    pub fn counts_with(&self, source: u16) -> Option<u16> {
        let is_known = usize::from(source) < self.models.len();
        is_known
            .then(|| self.dependence.group_of(source))
            .filter(|first| *first != source)
    }

    /// Returns the covariance scaling factor (BF-5) of `source` for covariances that are too small. The factor is 1 for
    /// consistent covariances; `None` if the source does not exist.
    pub fn covariance_scale(&self, source: u16) -> Option<f64> {
        self.models.get(usize::from(source)).map(SourceModel::covariance_scale)
    }

    /// Returns the learned probability that a scan of `source` detects a tracked target; `None` if the source does not
    /// exist.
    pub fn detection_probability(&self, source: u16) -> Option<f64> {
        self.models.get(usize::from(source)).map(|model| model.detection)
    }

    /// Returns the estimates for `source`; `None` if the source does not exist.
    pub fn learned(&self, source: u16) -> Option<Learned> {
        let model = self.models.get(usize::from(source))?;
        let tally = self.purity.tally(source);
        Some(Learned {
            measurement_sigma_m: model.gain().plane_sigma_m(),
            height_sigma_m: model.gain().height_sigma_m(),
            shape_ratio: model.shape.ratio(),
            target_share: (tally.tries() >= NEW_TRACKS_MIN).then(|| tally.mean()),
            lateness_s: self.lifetimes.late_ns(source) as f64 / NS_PER_S,
            stamps_s: self.stamps_s(source),
            detection_probability: model.detection,
            error_model: self.error_model(source),
            dependent: self.dependence.partners(source),
        })
    }

    fn stamps_s(&self, source: u16) -> Option<[f64; 2]> {
        let error = self.registration.of(source).stamps;
        let step_s = self.stamps[usize::from(source)].step_s();
        error.is_coarse().then(|| [step_s, error.variance_s2.sqrt()])
    }

    /// Model of the source's systematic error in force; `None` if no error is removed.
    fn error_model(&self, source: u16) -> Option<ErrorModel> {
        let known = self.registration.of(source);
        let [east, north, _, time, range, azimuth] = known.removed;
        if range || azimuth {
            Some(ErrorModel::Polar)
        } else if self.models[usize::from(source)].sees_points(1.0) {
            Some(ErrorModel::Body)
        } else if east || north {
            Some(ErrorModel::Offset)
        } else {
            time.then_some(ErrorModel::Time)
        }
    }
}
