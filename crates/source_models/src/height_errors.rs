//! Slow errors of a source's heights: rounding, wrong settings, errors of single targets.
//!
//! Problem: the heights of a level target are rounded alike for minutes, and errors of altimeters and of geometric
//! heights last as long. A filter that takes such errors for noise becomes more certain with each report, and states
//! centimetres where it errs by metres.
//!
//! Method: the mean difference of a sensor track's heights from the filter is compared with the means of the other
//! sensor tracks of the target. Noise explains a known variance of this difference; the excess, by the median over all
//! targets, is the variance of the slow errors. A state contains the slow errors of each source by the source's weight.
//!
//! Limits: an error that all sources have in common shows in no difference; neither does the error of an only source.
//!
//! Source: the same test as for detection points in the plane, see [`crate::Points`].

use kept::kept;
use serde::{Deserialize, Serialize};

use crate::median::Median;

/// Median of chi-square with one degree of freedom.
const CHI2_MEDIAN_1: f64 = 0.454_936_423_119_572_8;
/// Least number of comparisons.
const SAMPLES_MIN: u32 = 30;
/// Least excess over noise: chance alone, and slow noise of trackers, reach as much.
const EXCESS_MIN: f64 = 1.0;
/// Weight of a comparison in the error that all targets of the source have in common.
const COMMON_GAIN: f64 = 1.0 / 64.0;

/// Difference of a sensor track's mean height from the mean heights of the other sensor tracks of a target.
#[derive(Clone, Copy, Debug)]
pub struct HeightApart {
    /// Metres.
    pub offset_m: f64,
    /// Variance that noise explains, m².
    pub noise_m2: f64,
    /// Number of the other sensor tracks, at least 1.
    pub others: f64,
}

kept! {
    /// Slow errors of the heights of a source.
    #[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
    pub(crate) struct HeightErrors {
        /// Mean difference over all targets, metres.
        mean_m: f64,
        /// Squared difference relative to noise, and the part of noise that belongs to this source, m².
        ratio: Median,
        noise_m2: Median,
        /// Resulting variance, m².
        variance_m2: f64,
    }
}

impl HeightErrors {
    /// Learns from a comparison.
    pub(crate) fn learn(&mut self, apart: &HeightApart) {
        let beside_m = apart.offset_m - self.mean_m;
        self.mean_m += COMMON_GAIN * beside_m;
        // The errors of the others add their share to the difference.
        let own = apart.others / (apart.others + 1.0);
        self.ratio.add(beside_m * beside_m / apart.noise_m2);
        self.noise_m2.add(own * apart.noise_m2);
        let excess = self.ratio.value() / CHI2_MEDIAN_1 - 1.0;
        let is_known = self.ratio.samples() >= SAMPLES_MIN && excess > EXCESS_MIN;
        self.variance_m2 = if is_known { excess * self.noise_m2.value() } else { 0.0 };
    }

    /// Variance of the slow errors of a target's height, m²; 0 while unknown, or within chance.
    #[inline]
    pub(crate) fn variance_m2(&self) -> f64 {
        self.variance_m2
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Learns from differences of normal noise of variance 4 m² and slow errors of `slow_m2`.
    fn learned(slow_m2: f64, offset_m: f64) -> HeightErrors {
        let mut errors = HeightErrors::default();
        let mut random = test_support::Random::new(11);
        for _ in 0..2000 {
            let normal = (0..12).map(|_| random.unit() - 0.5).sum::<f64>();
            errors.learn(&HeightApart {
                offset_m: offset_m + normal * (4.0f64 + 1.5 * slow_m2).sqrt(),
                noise_m2: 4.0,
                others: 2.0,
            });
        }
        errors
    }

    #[test]
    fn slow_errors_are_told_from_noise_and_from_an_error_of_all_targets() {
        assert_eq!(learned(0.0, 0.0).variance_m2(), 0.0);
        assert_eq!(learned(0.0, 90.0).variance_m2(), 0.0);
        for slow_m2 in [25.0, 2500.0] {
            let found = learned(slow_m2, 90.0).variance_m2() / slow_m2;
            assert!((0.8..1.25).contains(&found), "{slow_m2}: {found}");
        }
    }
}
