//! The system filter: one Kalman filter per target, fed with the measurements behind all sensor tracks.
//!
//! Every system track has one, whatever rule makes its output: reports are compared with it, and what the sources are
//! worth shows in its innovations. Measurements have independent errors, so it needs no assumption about how the sources'
//! errors are correlated; it carries what each source contributed to its present estimate as a share, which decays as
//! others contribute.
//!
//! A single innovation far outside what the covariances explain (a blunder, a sharp turn) is weighed down, not refused:
//! refusing would lose a target that really turned.
//!
//! Source: Y. Bar-Shalom, X. R. Li, T. Kirubarajan, *Estimation with Applications to Tracking and Navigation* (Wiley,
//! 2001), chapters 5 and 6; P. J. Huber, *Robust Statistics* (Wiley, 1981), for the weighing down.

use estimation::{Gaussian, Matrix3, NearlyConstantVelocity};
use messages::{AXES, NS_PER_S};
use nalgebra::{SMatrix, SVector};

use crate::source_model::Measurement;
use crate::state::State;

/// Normalised innovation squared beyond which a measurement is weighed down.
const BLUNDER: f64 = 30.0;

/// State of one target's filter at one time.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Filter {
    pub(crate) time_ns: i64,
    pub(crate) estimate: Gaussian,
    pub(crate) has_height: bool,
}

/// How a measurement differed from what the filter expected.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Innovation {
    /// East and north, metres.
    pub(crate) residual_m: [f64; 2],
    /// Its covariance (xx, xy, yy), m².
    pub(crate) covariance_m2: [f64; 3],
    /// Weight of the measurement in the new horizontal position, in [0, 1]; 0 if it was not used.
    pub(crate) gain: f64,
}

impl Filter {
    pub(crate) fn new(time_ns: i64, estimate: Gaussian, has_height: bool) -> Self {
        Self {
            time_ns,
            estimate,
            has_height,
        }
    }

    /// The estimate as rules and messages know states.
    pub(crate) fn state(&self) -> State {
        State::of_gaussian(self.time_ns, &self.estimate, self.has_height)
    }

    /// [`Self::at`], as rules and messages know states.
    pub(crate) fn state_at(&self, time_ns: i64, noise: &NearlyConstantVelocity) -> State {
        State::of_gaussian(time_ns, &self.at(time_ns, noise), self.has_height)
    }

    /// The estimate at `time_ns`, later or earlier.
    pub(crate) fn at(&self, time_ns: i64, noise: &NearlyConstantVelocity) -> Gaussian {
        let ns = time_ns - self.time_ns;
        if ns == 0 {
            return self.estimate;
        }
        noise.predicted(&self.estimate, ns as f64 / NS_PER_S)
    }

    /// Brings the filter forward to `time_ns`; never back.
    pub(crate) fn advance(&mut self, time_ns: i64, noise: &NearlyConstantVelocity) {
        if time_ns > self.time_ns {
            self.estimate = self.at(time_ns, noise);
            self.time_ns = time_ns;
        }
    }

    /// Compares the measurement of `time_ns` with the estimate and, if `use_it`, updates the estimate. A measurement older
    /// than the filter is carried forward along the estimated velocity, whose uncertainty it takes on.
    pub(crate) fn take(
        &mut self,
        measurement: &Measurement,
        time_ns: i64,
        noise: &NearlyConstantVelocity,
        use_it: bool,
    ) -> Option<Innovation> {
        self.advance(time_ns, noise);
        let late_s = (self.time_ns - time_ns) as f64 / NS_PER_S;
        let mut z = SVector::<f64, AXES>::from(measurement.position_m);
        let mut r = measurement.covariance_m2;
        if late_s > 0.0 {
            z += self.estimate.mean.fixed_rows::<AXES>(AXES) * late_s;
            r += self.estimate.covariance.fixed_view::<AXES, AXES>(AXES, AXES) * (late_s * late_s);
        }
        if measurement.has_height && !self.has_height {
            self.begin_height(z[2], r[(2, 2)]);
        }
        if measurement.has_height {
            self.update::<AXES>(z, r, use_it)
        } else {
            let r = r.fixed_view::<2, 2>(0, 0).into_owned();
            self.update::<2>(z.fixed_rows::<2>(0).into_owned(), r, use_it)
        }
    }

    fn update<const D: usize>(
        &mut self,
        z: SVector<f64, D>,
        mut r: SMatrix<f64, D, D>,
        use_it: bool,
    ) -> Option<Innovation> {
        let residual = z - self.estimate.mean.fixed_rows::<D>(0);
        let before = self.estimate.covariance.fixed_view::<D, D>(0, 0).into_owned();
        let s = before + r;
        let squared = estimation::squared_length(&residual, &s);
        if !squared.is_finite() {
            return None;
        }
        let mut innovation = Innovation {
            residual_m: [residual[0], residual[1]],
            covariance_m2: [s[(0, 0)], s[(0, 1)], s[(1, 1)]],
            gain: 0.0,
        };
        if use_it {
            if squared > BLUNDER {
                r *= squared / BLUNDER;
            }
            self.estimate.update_position(z, r)?;
            let after = self.estimate.covariance.fixed_view::<D, D>(0, 0);
            let kept = (after[(0, 0)] + after[(1, 1)]) / (before[(0, 0)] + before[(1, 1)]);
            innovation.gain = (1.0_f64 - kept).clamp(0.0, 1.0);
        }
        Some(innovation)
    }

    /// The first source that observes height has come.
    fn begin_height(&mut self, height_m: f64, variance_m2: f64) {
        const VERTICAL_SPEED_M2PS2: f64 = 400.0;
        self.has_height = true;
        let estimate = &mut self.estimate;
        for (component, value, variance) in [(2, height_m, variance_m2), (5, 0.0, VERTICAL_SPEED_M2PS2)] {
            estimate.mean[component] = value;
            estimate.covariance.row_mut(component).fill(0.0);
            estimate.covariance.column_mut(component).fill(0.0);
            estimate.covariance[(component, component)] = variance;
        }
    }
}

/// Position block of a covariance.
pub(crate) fn position_block(estimate: &Gaussian) -> Matrix3 {
    estimate.covariance.fixed_view::<AXES, AXES>(0, 0).into_owned()
}
