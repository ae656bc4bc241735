//! Detection probability of a sensor, estimated during operation.
//!
//! A miss ends a new branch the sooner, the higher the assumed probability; a sensor that detects 0.7 of the targets
//! loses with an assumed 0.9 branches that should have been kept. So the share of scans in which confirmed tracks have
//! a detection is counted, over about [`LOOKS`] looks, from a prior of [`PRIOR`] at [`PRIOR_LOOKS`] looks. The estimate
//! is not above the prior: a few lucky scans must not make misses decisive.
//!
//! Limit: a target that has left is missed, too. After [`MISSES_MAX`] misses in a row a track is not counted.

use crate::track::Track;

/// Detection probability before anything is known.
pub(crate) const PRIOR: f64 = 0.9;
/// Number of looks that the prior is worth.
const PRIOR_LOOKS: f64 = 20.0;
/// Looks over which the share is averaged.
const LOOKS: f64 = 300.0;
/// Least estimate.
const RATE_MIN: f64 = 0.3;
/// Detections of a track that is counted.
const DETECTIONS_MIN: u32 = 4;
/// Most misses in a row of a track that is counted.
const MISSES_MAX: u32 = 3;

/// Estimate of a sensor's detection probability.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct DetectionRate {
    hits: f64,
    looks: f64,
}

impl DetectionRate {
    pub(crate) const NONE: Self = Self {
        hits: PRIOR * PRIOR_LOOKS,
        looks: PRIOR_LOOKS,
    };

    /// Counts the tracks after a scan of the sensor; `in_view` is the probability that a track is in the field of view.
    pub(crate) fn count(&mut self, tracks: &[Track], in_view: impl Fn(&Track) -> f64) {
        for track in tracks {
            let counts = track.is_confirmed() && track.detections >= DETECTIONS_MIN && track.missed <= MISSES_MAX;
            if !counts {
                continue;
            }
            let look = track.reliability * in_view(track);
            self.looks += look;
            if track.missed == 0 {
                self.hits += look;
            }
        }
        if self.looks > LOOKS {
            self.hits *= LOOKS / self.looks;
            self.looks = LOOKS;
        }
    }

    /// The probability of detection in the gate.
    pub(crate) fn probability(&self) -> f64 {
        (self.hits / self.looks).clamp(RATE_MIN, PRIOR)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Tracker;
    use crate::testing::{S, position, settings};

    /// Probability after scans in which a target is missed when `misses` holds.
    fn learned(misses: fn(i64) -> bool, stated: Option<f64>) -> (f64, usize) {
        let mut chosen = settings();
        chosen.sensors[0].model.detection_probability = stated;
        let mut tracker = Tracker::new(chosen).unwrap();
        for second in 0..200 {
            let seen = position(second * S, 15.0 * second as f64, 0.0);
            let scan = [seen];
            tracker
                .scan(1, second * S, &scan[usize::from(misses(second))..])
                .unwrap();
        }
        (tracker.latest().sensors[0].rate.probability(), tracker.tracks().len())
    }

    #[test]
    fn the_share_of_detected_looks_is_learned_and_bounded() {
        let (half, shown) = learned(|second| second % 2 == 1 && second > 5, None);
        assert!((0.45..0.65).contains(&half) && shown == 1, "{half}");
        assert_eq!(learned(|_| false, None).0, PRIOR, "luck proves little");
        let (stated, _) = learned(|second| second % 2 == 1 && second > 5, Some(0.9));
        assert_eq!(stated, PRIOR, "a stated probability is not learned");
    }
}
