//! Drift: systematic errors that change faster than registration forgets.
//!
//! Registration averages over minutes. Of a source whose error grows, the latest differences from the others all lie
//! to one side of what the estimate explains. Their weighted mean over some seconds shows it: its squared statistical
//! length follows chi-square while nothing drifts. Then older differences are forgotten quickly until the estimate has
//! caught up.

use serde::{Deserialize, Serialize};

/// Memory of sources whose errors change, seconds.
pub(crate) const DRIFT_S: f64 = 7.0;
/// Chi-square with two degrees of freedom beyond which what the estimates leave over is a drift.
const DRIFT_2: f64 = 9.2;

/// Latest differences of a source that its estimate leaves over: without a drift they are 0 on the average.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Residuals {
    /// Σ W (xx, xy, yy), 1/m².
    information: [f64; 3],
    /// Σ W·rest, 1/m.
    sum: [f64; 2],
    /// Whether they were not, when last looked at.
    is_drift: bool,
}

impl Residuals {
    /// Adds a difference, east and north, metres, whose inverse covariance is given.
    pub(crate) fn add(&mut self, weight: &estimation::Matrix3, [east, north]: [f64; 2]) {
        let (xx, xy, yy) = (weight[(0, 0)], weight[(0, 1)], weight[(1, 1)]);
        for (sum, value) in self.information.iter_mut().zip([xx, xy, yy]) {
            *sum += value;
        }
        self.sum[0] += xx * east + xy * north;
        self.sum[1] += xy * east + yy * north;
    }

    /// Whether they were not 0 on the average, when last looked at.
    pub(crate) fn is_drift(&self) -> bool {
        self.is_drift
    }

    /// Mean square per axis of what they are on the average, if that is a drift, m².
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

    /// Lets them fade by one tick, and looks at them.
    pub(crate) fn look(&mut self, keep: f64) {
        // The weight of the mean of numbers that fade: their squares fade twice as fast.
        let squared = 2.0 * association::distance::squared2(self.sum, self.information);
        self.is_drift = squared.is_finite() && squared > DRIFT_2;
        let values = self.information.iter_mut().chain(&mut self.sum);
        values.for_each(|value| *value *= keep);
    }
}
