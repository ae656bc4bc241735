//! Factor found by steps, from samples that only indicate "more" or "less".
//!
//! Each sample moves the logarithm by a bounded step, so that no sample can spoil the factor. The factor settles at
//! equal numbers of samples for more and for less. While nearly all samples ask for the same, which is unlikely by
//! chance, steps are longer.

use kept::kept;
use serde::{Deserialize, Serialize};

/// Step of the logarithm per sample, and extension of the step by agreement of the samples.
const STEP: f64 = 0.03;
const STRIDE: f64 = 0.3;
/// Agreement of the samples above which the step becomes longer: chance seldom reaches this agreement.
const AGREEMENT: f64 = 0.5;

kept! {
    /// The logarithm of the factor, 0 at the start.
    #[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
    pub(crate) struct Seeker {
        logarithm: f64,
        /// Mean of the wishes of the last samples: more (1) or less (−1).
        trend: f64,
    }
}

impl Seeker {
    #[inline]
    pub(crate) fn logarithm(&self) -> f64 {
        self.logarithm
    }

    /// Takes the sign of `wish` as one sample; the logarithm stays within the limits.
    #[inline]
    pub(crate) fn step(&mut self, wish: f64, least: f64, most: f64) {
        let wish = f64::copysign(1.0, wish);
        self.trend += (wish - self.trend) / 16.0;
        let agreement = (self.trend * wish - AGREEMENT).max(0.0);
        let step = wish * (STEP + STRIDE * agreement);
        self.logarithm = (self.logarithm + step).clamp(least, most);
    }
}
