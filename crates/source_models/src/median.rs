//! A median over all samples, without the samples.
//!
//! Each sample moves the logarithm of the median by a step towards the sample, so that half of the samples lie on
//! either side. Single samples, however wrong, move the median by no more than a step.

use kept::kept;
use serde::{Deserialize, Serialize};

kept! {
    /// A median that follows samples by steps of the logarithm.
    #[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
    pub(crate) struct Median {
        logarithm: f64,
        samples: u32,
    }
}

impl Median {
    pub(crate) fn add(&mut self, sample: f64) {
        let logarithm = sample.max(f64::MIN_POSITIVE).ln();
        if self.samples == 0 {
            self.logarithm = logarithm;
        }
        self.samples = self.samples.saturating_add(1);
        let step = (2.0 / f64::from(self.samples)).clamp(0.02, 0.5);
        self.logarithm += step
            .min((logarithm - self.logarithm).abs())
            .copysign(logarithm - self.logarithm);
    }

    pub(crate) fn samples(&self) -> u32 {
        self.samples
    }

    /// Whether no sample has been added yet.
    pub(crate) fn is_unknown(&self) -> bool {
        self.samples == 0
    }

    pub(crate) fn value(&self) -> f64 {
        self.logarithm.exp()
    }
}
