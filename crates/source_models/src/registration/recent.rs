//! Systematic errors that change: drifts and steps, from the latest differences of a source.
//!
//! Registration averages over a minute. After a change of a source's errors, the latest differences from the other
//! sources deviate from the estimate in a common direction. Sums of the differences over some seconds show the change:
//! the squared statistical length of the sums follows chi-square while nothing changes.
//! - A *drift* is a significant length. Older differences are then forgotten quickly, until the estimate has caught up.
//! - A *step* is a length far beyond chance, found by a generalised likelihood ratio. Each source is tested for a
//!   change of this source alone as the cause of the latest differences. The changed source takes part in all
//!   differences with a change, any other source only in some. Sources of equal likelihood count as changed together.
//!   All differences of the source before the step are dropped.
//!
//! Far differences count with the length of the gate, so that scattered absurd reports make no step.
//!
//! Source: A. Willsky, H. Jones, *A generalized likelihood ratio approach to the detection and estimation of jumps in
//! linear systems*, IEEE Transactions on Automatic Control 21 (1976).

use messages::AXES;
use serde::{Deserialize, Serialize};

use crate::registration::model::BiasModel;
use crate::registration::rows::{AZIMUTH, Errors, NormalMatrix, RANGE};
use crate::registration::sensitivity::{Sensitivity, Weighted, add_vector};

/// Number of solutions of a new estimate before the latest differences are tested.
pub(crate) const SOLUTIONS_MIN: u8 = 5;
/// Memory of the latest differences, and of drifting sources, seconds.
pub(crate) const RECENT_S: f64 = 7.0;
/// Threshold of chi-square with two degrees of freedom for a drift.
const DRIFT_2: f64 = 9.2;
/// Chi-square above which a step is found, and margin below the largest chi-square for a source to count as unchanged.
const STEP: f64 = 40.0;
const STEP_MARGIN: f64 = 10.0;

/// Latest residual differences of a source: 0 on the average without a change.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(crate) struct Recent {
    /// Σ HᵀWH.
    normal: NormalMatrix,
    /// Σ HᵀW·rest.
    right: Errors,
    /// Σ W (xx, xy, yy; 1/m²) and Σ W·rest (1/m), with the weights of the estimate.
    information: [f64; 3],
    sum: [f64; 2],
    /// Whether the latest test showed a drift.
    is_drift: bool,
    /// Chi-square of a change of the offset, the range bias or the azimuth bias in the latest test.
    step: f64,
}

impl Default for Recent {
    fn default() -> Self {
        Self {
            normal: NormalMatrix::zeros(),
            right: Errors::zeros(),
            information: [0.0; 3],
            sum: [0.0; 2],
            is_drift: false,
            step: 0.0,
        }
    }
}

impl Recent {
    /// Adds a difference: HᵀWH and HᵀW·rest, given H and HᵀW.
    pub(crate) fn add(&mut self, of: &Sensitivity, weighted: &Weighted, rest: &[f64; AXES]) {
        of.add_product(weighted, &mut self.normal);
        add_vector(weighted, rest, &mut self.right);
    }

    /// Adds a difference used by the estimate: inverse covariance, and rest east and north, metres.
    pub(crate) fn add_used(&mut self, weight: &[[f64; AXES]; AXES], [east, north]: [f64; 2]) {
        let [[xx, ..], [xy, yy, _], _] = *weight;
        for (sum, value) in self.information.iter_mut().zip([xx, xy, yy]) {
            *sum += value;
        }
        self.sum[0] += xx * east + xy * north;
        self.sum[1] += xy * east + yy * north;
    }

    /// Returns whether the latest test showed a drift.
    pub(crate) fn is_drift(&self) -> bool {
        self.is_drift
    }

    /// Returns the mean square per axis of the drift, m²; 0 without one.
    pub(crate) fn drift_m2(&self) -> f64 {
        let [xx, xy, yy] = self.information;
        let [east, north] = self.sum;
        let determinant = xx * yy - xy * xy;
        if !self.is_drift {
            return 0.0;
        }
        let mean = [
            (yy * east - xy * north) / determinant,
            (xx * north - xy * east) / determinant,
        ];
        0.5 * (mean[0] * mean[0] + mean[1] * mean[1])
    }

    /// Tests the sums for a change of the errors in `model`, and fades the sums by a tick. Deviations in other errors
    /// are no changes: the model does not contain these errors yet.
    pub(crate) fn look(&mut self, keep: f64, model: BiasModel) {
        let [xx, xy, yy] = [(0, 0), (0, 1), (1, 1)].map(|place| self.normal[place]);
        let offset = association::distance::squared2([self.right[0], self.right[1]], [xx, xy, yy]);
        let of_row = |row: usize| match self.normal[(row, row)] {
            information if information > 0.0 => self.right[row] * self.right[row] / information,
            _ => 0.0,
        };
        // Weight of the mean of fading numbers: squares fade twice as fast.
        let squared = |value: f64| if value.is_finite() { 2.0 * value } else { 0.0 };
        self.is_drift = squared(association::distance::squared2(self.sum, self.information)) > DRIFT_2;
        let rows = [(0, offset), (RANGE, of_row(RANGE)), (AZIMUTH, of_row(AZIMUTH))];
        let changes = rows.into_iter().filter(|(row, _)| model.estimates(*row));
        self.step = changes.map(|(_, value)| squared(value)).fold(0.0, f64::max);
        self.normal *= keep;
        self.right *= keep;
        let values = self.information.iter_mut().chain(&mut self.sum);
        values.for_each(|value| *value *= keep);
    }

    /// Returns whether the source changed by a step, given the [`step_limit`].
    pub(crate) fn is_step(&self, limit: f64) -> bool {
        self.step > limit
    }
}

/// Returns the chi-square beyond which a source has changed by a step; infinite without a step. `sought` are the
/// sources with unknown errors.
pub(crate) fn step_limit<'a>(sought: impl Iterator<Item = &'a Recent>) -> f64 {
    let largest = sought.map(|recent| recent.step).fold(0.0, f64::max);
    let is_step = largest > STEP;
    if is_step { largest - STEP_MARGIN } else { f64::INFINITY }
}
