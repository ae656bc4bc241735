//! Life of a track: confirmation and deletion (HT-10).
//!
//! A tentative track is confirmed once nearly all of the probability lies with hypotheses that contain it; a track of
//! either kind is deleted once a target still present would hardly have been missed for so long.

use messages::NS_PER_S;
use settings::Seconds;

use crate::identity::IdentitySettings;
use crate::track::Track;

settings::settings! {
    /// Conditions of confirmation: a tentative track is confirmed when all of them hold (HT-10).
    #[derive(Copy)]
    pub struct Confirmation {
        /// Least total reliability of the hypotheses with the track. 1: the track is in all remaining hypotheses, the
        /// rule of the source.
        reliability_min: f64 = 0.995, in [0.501, 1];
        /// Least number of detections of the track.
        detections_min: u32 = 2, in [1, 1000];
        /// Least time from the first detection of the track to the latest: several detections of a fast sensor within a
        /// moment may have one cause.
        span_min_s: Option<f64> = None, in [0, 1e4];
        /// Longest mean time between two detections of the track: a few detections over a long time are a coincidence.
        interval_max_s: Option<f64> = None, in [1e-3, 1e4];
        /// Least log-likelihood ratio: logarithm of the likelihood of the track's detections if caused by a target,
        /// divided by their likelihood if all are false.
        log_likelihood_ratio_min: Option<f64> = None, in [-1e3, 1e3];
    }

    /// Conditions of deletion: a track is deleted when one of them holds (HT-10).
    #[derive(Copy)]
    pub struct Deletion {
        /// Threshold: a track is deleted once the probability of all misses since its last detection is at most this
        /// value. With a probability of detection of 0.9, 2e-5 means five slow scans; with 0.5, sixteen.
        missed_probability: f64 = 2e-5, in [1e-300, 0.99];
        /// Time without a detection after which a track is deleted, whether or not the sensors observe its place.
        silent_s: Seconds = Seconds::of(60.0), in [1e-3, 86_400];
    }

    /// Deletion of tracks.
    #[derive(Copy)]
    pub struct DeletionSettings with limits: Deletion {
        /// Time within which a repeated look is not independent: the same detection or miss, with the same error.
        coherence_s: f64 = 1.0, in [1e-3, 1e4];
    }
}

impl Confirmation {
    /// Whether a track may be confirmed.
    pub(crate) fn is_met(&self, track: &Track) -> bool {
        self.is_beyond_doubt(track.reliability) && self.is_seen_enough(track)
    }

    /// Whether hypotheses of so much reliability together suffice.
    pub(crate) fn is_beyond_doubt(&self, reliability: f64) -> bool {
        reliability >= self.reliability_min - 1e-9
    }

    /// Whether a track's detections suffice.
    pub(crate) fn is_seen_enough(&self, track: &Track) -> bool {
        let often = track.detections >= self.detections_min;
        let span_s = track.seen_ns.saturating_sub(track.begun_ns) as f64 / NS_PER_S;
        let intervals = f64::from(track.detections.saturating_sub(1));
        let long = self.span_min_s.is_none_or(|least| span_s >= least);
        let dense = self.interval_max_s.is_none_or(|most| span_s <= most * intervals);
        let likely = self
            .log_likelihood_ratio_min
            .is_none_or(|least| track.log_likelihood_ratio >= least);
        often && long && dense && likely
    }
}

impl DeletionSettings {
    /// The conditions for a track: a track that names a target may be missed more often.
    pub(crate) fn of(&self, track: &Track, identity: &IdentitySettings) -> Deletion {
        let limits = self.limits;
        if !identity.used || !track.identity.names() {
            return limits;
        }
        Deletion {
            missed_probability: limits.missed_probability.min(identity.missed_probability),
            ..limits
        }
    }
}

impl Deletion {
    /// Returns whether the silence is too unlikely for a target that still exists.
    pub(crate) fn is_missed_too_often(&self, track: &Track) -> bool {
        track.log_silence <= self.missed_probability.ln()
    }

    /// Whether a track is deleted at `time_ns`.
    pub(crate) fn is_met(&self, track: &Track, time_ns: i64) -> bool {
        let silent_ns = time_ns.saturating_sub(track.seen_ns);
        self.is_missed_too_often(track) || silent_ns >= self.silent_s.ns()
    }
}
