//! Selection of the detections to use, by age, accuracy and priority (WA-1).
//!
//! Old, inaccurate or redundant detections seldom improve a track, and cost as much as others. They may be rejected by
//! age, by accuracy, or by the priority of the sensor if several sensors look at the same time. Alternatively such
//! detections are kept with a smaller weight: with a weight of 0 no hypothesis takes them for a target; with a small
//! weight, hypotheses with such detections are less reliable and are dropped first.
//!
//! Age counts against the latest scan. Live, a detection is also refused after the arrival of a detection newer by more
//! than that (crate `sources`); otherwise only a late scan as a whole would be refused.
//!
//! An outranked scan with rejected detections does not count as a look: no track counts as missed.

use settings::Seconds;

use crate::measurement::DetectionMeasurement;

settings::settings! {
    /// Detections that are not used, all off by default (WA-1). Priorities are keys of the sensors.
    #[derive(Copy)]
    pub struct Selection {
        /// Greatest age of a detection, relative to the latest scan; older detections are rejected.
        age_max_s: Option<Seconds> = None, in [0, 86_400];
        /// Largest standard deviation of a detection's position in any direction; other detections are rejected.
        /// Detections without a position (directions) are not affected.
        sigma_max_m: Option<f64> = None, in [1e-3, 1e7];
        /// Greatest difference of time between scans that count as simultaneous: of such scans only those of the
        /// sensor with the highest priority are used. Open scans are compared.
        same_time_s: Seconds = Seconds::default(), in [0, 86_400];
        /// Weight with which refused detections are used, instead of not at all.
        kept_weight: Option<f64> = None, in [0, 0.999_999];
    }
}

impl Selection {
    /// Whether a detection is rejected by age or accuracy.
    pub(crate) fn rejects(&self, measurement: &DetectionMeasurement, age_ns: i64) -> bool {
        let too_old = self.age_max_s.is_some_and(|age_max| age_ns > age_max.ns());
        let sigma_m = measurement.place().map(|(_, sigma_m)| sigma_m);
        let too_coarse = sigma_m
            .zip(self.sigma_max_m)
            .is_some_and(|(sigma_m, most_m)| sigma_m > most_m);
        too_old || too_coarse
    }

    /// Logarithm of the weight of rejected detections; `None` if not kept.
    pub(crate) fn log_kept_weight(&self) -> Option<f64> {
        self.kept_weight.map(f64::ln)
    }
}
