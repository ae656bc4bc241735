//! When a track is believed, and when it is given up (HT-10).
//!
//! A tentative track is confirmed once nearly all of the probability lies with hypotheses that contain it; a track of either
//! kind is deleted once a target that is still there would hardly have been missed for so long.

use crate::track::Track;

/// Conditions of confirmation: a tentative track is confirmed when all of them hold.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Confirmation {
    /// The hypotheses that contain it have at least this reliability together. 1: it is in all remaining ones, which is
    /// the source's rule.
    pub reliability_min: f64,
    /// It has at least so many detections.
    pub detections_min: u32,
    /// Its log-likelihood ratio is at least this: the logarithm of how much likelier its detections are if they are of
    /// one target than if all are false (`None`: not tested).
    pub log_likelihood_ratio_min: Option<f64>,
}

/// Conditions of deletion: a track is deleted when one of them holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Deletion {
    /// It has been missed so often since its last detection that this would happen to a target with this probability.
    /// With a probability of detection of 0.9, 2e-5 is five slow scans; with 0.5, sixteen.
    pub missed_probability: f64,
    /// It had no detection for so long, seen or not, nanoseconds.
    pub silent_ns: i64,
}

impl Confirmation {
    /// Whether a track may be confirmed.
    pub(crate) fn is_met(&self, track: &Track) -> bool {
        let beyond_doubt = track.reliability >= self.reliability_min - 1e-9;
        let seen_enough = track.detections >= self.detections_min;
        let likely = self
            .log_likelihood_ratio_min
            .is_none_or(|least| track.log_likelihood_ratio >= least);
        beyond_doubt && seen_enough && likely
    }
}

impl Deletion {
    /// Whether so long a silence is too unlikely for a target that is still there.
    pub(crate) fn is_missed_too_often(&self, track: &Track) -> bool {
        track.log_silence <= self.missed_probability.ln()
    }

    /// Whether a track is deleted at `time_ns`.
    pub(crate) fn is_met(&self, track: &Track, time_ns: i64) -> bool {
        let silent_ns = time_ns.saturating_sub(track.seen_ns);
        self.is_missed_too_often(track) || silent_ns >= self.silent_ns
    }
}
