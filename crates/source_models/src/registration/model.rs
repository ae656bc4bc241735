//! Rival models of a source's systematic errors, and the choice among them by evidence.
//!
//! An offset, a misaligned north mark and a range bias move the targets of a small area alike. A joint estimate of all
//! errors would give large errors that compensate each other at the observed targets, and mislead elsewhere. So each
//! source has a single model at a time, with the greatest evidence (the Bayesian information criterion): the fit of the
//! differences, less a penalty for each estimated error. Height and time offset are part of every model. A source
//! without errors has the model of an offset, with an insignificant offset.
//!
//! Comparisons of a target depend on each other: the detection points and the errors of the trackers persist. So a
//! target counts as a single comparison at first, and as a further comparison every five seconds. Otherwise the points
//! of large targets look like a rotation within the first scans.
//!
//! A change to a model with as many errors or more must raise the evidence clearly. At a time, only the source with the
//! greatest gain changes the model: rivals for the same differences are judged again with this error removed.
//!
//! Source: G. Schwarz, *Estimating the dimension of a model*, Annals of Statistics 6 (1978).

use kept::kept;
use serde::{Deserialize, Serialize};

use crate::registration::rows::{AZIMUTH, ERRORS, Errors, NormalMatrix, RANGE};

/// Information that holds an error at 0.
const HELD: f64 = 1e30;
/// Least increase of the evidence for a change to a model with as many errors or more.
const CHANGE_MIN: f64 = 12.0;

kept! {
    /// Set of estimated errors.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
    pub(crate) struct BiasModel {
        offset: bool,
        range: bool,
        azimuth: bool,
    }
}

/// Models without and with the position of the sensor.
const WITHOUT_PLACE: [BiasModel; 2] = [BiasModel::OFFSET, BiasModel::new(true, false, true)];
const WITH_PLACE: [BiasModel; 7] = [
    BiasModel::OFFSET,
    BiasModel::new(false, false, true),
    BiasModel::new(false, true, false),
    BiasModel::new(false, true, true),
    BiasModel::new(true, false, true),
    BiasModel::new(true, true, false),
    BiasModel::new(true, true, true),
];

impl BiasModel {
    /// A constant offset.
    pub(crate) const OFFSET: Self = Self::new(true, false, false);

    /// An offset and an azimuth bias.
    pub(crate) const TURNED: Self = Self::new(true, false, true);

    const fn new(offset: bool, range: bool, azimuth: bool) -> Self {
        Self { offset, range, azimuth }
    }

    /// Returns the model with an offset, and with or without an azimuth bias.
    pub(crate) fn with_offset(self, azimuth: bool) -> Self {
        Self {
            offset: true,
            azimuth,
            ..self
        }
    }

    /// Returns whether the horizontal offset is estimated.
    pub(crate) fn has_offset(self) -> bool {
        self.offset
    }

    /// Returns whether an error is estimated.
    pub(crate) fn estimates(self, row: usize) -> bool {
        match row {
            0 | 1 => self.offset,
            RANGE => self.range,
            AZIMUTH => self.azimuth,
            _ => true,
        }
    }

    /// Returns whether the model is more than an offset.
    pub(crate) fn is_polar(self) -> bool {
        self.range || self.azimuth
    }

    /// Holds all errors outside the model at 0.
    pub(crate) fn hold(self, normal: &mut NormalMatrix) {
        for row in (0..ERRORS).filter(|row| !self.estimates(*row)) {
            normal[(row, row)] += HELD;
        }
    }

    /// Returns `values` for the estimated errors, and `others` for all other errors.
    pub(crate) fn known(self, values: Errors, others: &Errors) -> Errors {
        Errors::from_fn(|row, _| if self.estimates(row) { values[row] } else { others[row] })
    }

    fn parameters(self) -> u8 {
        2 * u8::from(self.offset) + u8::from(self.range) + u8::from(self.azimuth)
    }

    /// Complexity of the model, for the decision whether a model is simpler than another.
    fn complexity(self) -> u8 {
        if self == Self::OFFSET { 0 } else { self.parameters() }
    }

    /// Returns twice the evidence of the model: the decrease of the weighted squares times `scale`, less the penalty
    /// of `samples` samples.
    fn evidence(self, normal: &NormalMatrix, right: &Errors, scale: f64, samples: f64) -> Option<f64> {
        let mut held = *normal;
        self.hold(&mut held);
        let solved = held.cholesky()?.solve(right);
        let evidence = scale * right.dot(&solved) - f64::from(self.parameters()) * samples.max(1.0).ln();
        if self == Self::OFFSET {
            let without = Self::new(false, false, false).evidence(normal, right, scale, samples)?;
            return Some(evidence.max(without));
        }
        Some(evidence)
    }

    /// Returns the best model and the gain of evidence over `self`; `None` if no other model is better. `scale` is the
    /// ratio of the expected squares of the differences to the actual squares.
    pub(crate) fn better(
        self,
        normal: &NormalMatrix,
        right: &Errors,
        scale: f64,
        samples: f64,
        has_place: bool,
    ) -> Option<(f64, Self)> {
        let models: &[Self] = if has_place { &WITH_PLACE } else { &WITHOUT_PLACE };
        let present = self.evidence(normal, right, scale, samples)?;
        let others = models.iter().filter(|model| **model != self);
        others
            .filter_map(|model| Some((model.evidence(normal, right, scale, samples)? - present, *model)))
            .filter(|(gain, model)| *gain > self.least_gain(*model))
            .max_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// Returns the least increase of the evidence for a change to another model.
    fn least_gain(self, other: Self) -> f64 {
        match other.complexity() < self.complexity() {
            true => 0.0,
            false => CHANGE_MIN,
        }
    }
}
