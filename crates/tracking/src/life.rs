//! Life of a track: confirmation, output and deletion (HT-10).
//!
//! A tentative track is confirmed once nearly all of the probability lies with hypotheses that contain it and with its
//! existence. A confirmed track is output while its existence is likely ([`crate::existence`]). A track of either kind
//! is deleted once its target has almost surely gone.

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
        /// Least probability that the target is still there, else the track is deleted. With a probability of
        /// detection of 0.9, the default means six slow scans; with 0.5, seventeen. 0: misses end no track.
        existence_min: f64 = 1e-3, in [0, 0.99];
        /// Time without a detection after which a track is deleted, whether or not the sensors observe its place.
        silent_s: Seconds = Seconds::of(60.0), in [1e-3, 86_400];
    }

    /// Deletion of tracks.
    #[derive(Copy)]
    pub struct DeletionSettings with limits: Deletion {
        /// Mean time for which a target stays. Without the key, learned from the confirmed tracks that end.
        mean_life_s: Option<f64> = None, in [1e-3, 1e9], usually "learned";
        /// Mean time until a target outside every field of view is gone for good.
        exit_s: f64 = 3.0, in [1e-3, 1e9];
        /// Least probability that the target is still there for the output of its track. A less probable track is kept
        /// with its number, and is output again once its target is detected.
        shown_min: f64 = 0.3, in [0, 0.99];
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
            existence_min: limits.existence_min.min(identity.existence_min),
            ..limits
        }
    }
}

impl Deletion {
    /// Returns whether the target has probably gone.
    pub(crate) fn is_missed_too_often(&self, track: &Track) -> bool {
        track.existence() < self.existence_min
    }

    /// Whether a track is deleted at `time_ns`.
    pub(crate) fn is_met(&self, track: &Track, time_ns: i64) -> bool {
        let silent_ns = time_ns.saturating_sub(track.seen_ns);
        self.is_missed_too_often(track) || silent_ns >= self.silent_s.ns()
    }
}
