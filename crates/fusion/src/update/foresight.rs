//! Comparison of a target's only source with the system filter, by predictions of the measurements.
//!
//! The tracker of a source may follow targets more closely than the system filter: the source's motion models may fit
//! the targets better, and the recovered measurements may be wrong. Without other sources, only the next measurement
//! shows this. The distance of the measurement from the prediction of the source's latest report is compared with the
//! distance from the prediction of the filter. Both distances contain the error of the measurement, and chance must be
//! excluded.

use serde::{Deserialize, Serialize};

/// Share of the sums kept with each measurement: about five measurements count.
const KEPT: f32 = 0.8;
/// Required excess of the filter's sum over the source's: as a factor, and in variances of a report.
const WORSE: f32 = 1.2;
const VARIANCES: f32 = 5.0;

/// Squared distances of measurements from predictions.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Foresight {
    filter_m2: f32,
    source_m2: f32,
}

impl Foresight {
    /// Takes the distances of a measurement from the predictions of the filter and of the source's latest report, east
    /// and north, metres. Returns whether the source predicts better. The variance of the source's position is for both
    /// axes together, m².
    #[inline]
    pub(crate) fn source_is_better(&mut self, filter_m: [f64; 2], source_m: [f64; 2], variance_m2: f64) -> bool {
        let add = |sum: &mut f32, [east_m, north_m]: [f64; 2]| {
            *sum = KEPT * *sum + (east_m * east_m + north_m * north_m) as f32;
        };
        add(&mut self.filter_m2, filter_m);
        add(&mut self.source_m2, source_m);
        self.filter_m2 > WORSE * self.source_m2 + VARIANCES * variance_m2 as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_source_is_better_once_chance_is_excluded() {
        let mut foresight = Foresight::default();
        // A distance of two standard deviations is chance the first time, but not the second time.
        let mut take = |filter_m: f64, source_m: f64| foresight.source_is_better([filter_m, 0.0], [0.0, source_m], 1.0);
        assert!(!take(2.1, 0.5));
        assert!(take(2.1, 0.5));
        // A filter as good as the source makes up for the difference.
        assert!((0..5).any(|_| !take(1.0, 1.0)));
    }

    #[test]
    fn filters_as_good_as_the_source_are_never_replaced() {
        let mut foresight = Foresight::default();
        for number in 0..1000 {
            let off_m = f64::from(number % 17);
            assert!(!foresight.source_is_better([off_m, 0.0], [0.0, off_m], 1.0));
        }
    }
}
