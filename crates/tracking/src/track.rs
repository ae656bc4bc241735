//! A track: a sequence of detections that may be of the same target, and the resulting state.
//!
//! The obvious record of a track is a tree of all detections, with branches that share the beginning. But the update
//! needs little of the past: whether two tracks share a detection, or have the same detections, within the last few
//! scans; and whether both have the same first detection. So a track is a flat record with the last [`HISTORY_MAX`]
//! scans and the root. Branching is copying; nothing is ever walked, collected or fragmented.

use kept::kept;
use messages::NS_PER_S;

use crate::identity::TrackIdentity;
use crate::limits::HISTORY_MAX;
use crate::motion::{MotionSettings, TargetMotion};

/// A scan without a detection, in a history.
pub(crate) const NO_DETECTION: u32 = 0;
/// Number of a track that is not confirmed.
pub(crate) const TENTATIVE: u32 = 0;

kept! {
    /// A branch of a first detection.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub(crate) struct Track {
        /// Motion after the last detection or direction, and the time of either, nanoseconds.
        pub(crate) motion: TargetMotion,
        pub(crate) time_ns: i64,
        /// Time of the last detection, or of the last scan of directions with a probable direction of the track,
        /// nanoseconds.
        pub(crate) seen_ns: i64,
        /// Time of the first detection, nanoseconds.
        pub(crate) begun_ns: i64,
        /// Number of the track tree: the same for all branches of a first detection.
        pub(crate) root: u32,
        /// The confirmed ancestor's number, or [`TENTATIVE`].
        pub(crate) number: u32,
        pub(crate) detections: u32,
        /// Detections that lay in a confirmed track's gate (SP-7).
        pub(crate) in_company: u32,
        /// Missed detections: scans with an expected detection since the latest detection.
        pub(crate) missed: u32,
        /// Probability that the target has gone since the latest detection, if the hypothesis is right
        /// ([`crate::existence`]).
        pub(crate) absence: f64,
        /// Log-likelihood ratio of the detections: from a single target against all false.
        pub(crate) log_likelihood_ratio: f64,
        /// Sum over the hypotheses that contain the track.
        pub(crate) reliability: f64,
        pub(crate) identity: TrackIdentity,
        /// Bits of the sensors with a detection of the target in the latest look.
        pub(crate) seen_by: u64,
        /// Serial numbers of the detections by scan, latest first; without scans of fast sensors that had none in the
        /// cluster.
        pub(crate) history: [u32; HISTORY_MAX],
    }
}

impl Track {
    /// Makes a tentative track of the detection with the number `serial` and the motion at `time_ns`.
    pub(crate) fn begun(motion: TargetMotion, time_ns: i64, serial: u32, root: u32) -> Self {
        let mut history = [NO_DETECTION; HISTORY_MAX];
        history[0] = serial;
        Self {
            motion,
            time_ns,
            seen_ns: time_ns,
            begun_ns: time_ns,
            root,
            number: TENTATIVE,
            detections: 1,
            in_company: 0,
            missed: 0,
            absence: 0.0,
            log_likelihood_ratio: 0.0,
            reliability: 0.0,
            identity: TrackIdentity::NONE,
            seen_by: 0,
            history,
        }
    }

    pub(crate) fn is_confirmed(&self) -> bool {
        self.number != TENTATIVE
    }

    /// Probability that the target is still there, if the hypothesis is right.
    pub(crate) fn existence(&self) -> f64 {
        1.0 - self.absence
    }

    /// Probability that the hypothesis is right and the target still there.
    pub(crate) fn presence(&self) -> f64 {
        self.reliability * self.existence()
    }

    /// True if this branch is preferred: higher reliability; ties go to the smaller east coordinate.
    pub(crate) fn is_preferred_to(&self, other: &Self) -> bool {
        let west = || other.motion.estimate().mean[0].total_cmp(&self.motion.estimate().mean[0]);
        self.reliability.total_cmp(&other.reliability).then_with(west).is_gt()
    }

    /// Motion predicted to `time_ns`.
    pub(crate) fn motion_at(&self, time_ns: i64, settings: &MotionSettings) -> TargetMotion {
        if time_ns == self.time_ns {
            return self.motion;
        }
        let seconds = time_ns.saturating_sub(self.time_ns) as f64 / NS_PER_S;
        self.motion.moved(seconds, settings)
    }

    /// SP-7: share of detections in confirmed tracks' gates.
    pub(crate) fn company(&self) -> f64 {
        f64::from(self.in_company) / f64::from(self.detections)
    }

    /// Adds a scan and the detection to the memory.
    pub(crate) fn remember(&mut self, serial: u32) {
        self.history.rotate_right(1);
        self.history[0] = serial;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measurement::DetectionMeasurement;
    use crate::settings::Settings;
    use crate::testing::{position, settings};

    /// d11 lay in C's gate, d21 outside, d32 inside, d33 outside.
    #[test]
    fn the_shares_of_the_worked_check() {
        let company = |in_company, detections| {
            let measurement = DetectionMeasurement::of(&position(0, 0.0, 0.0), None).unwrap();
            let Settings { initiation, motion, .. } = settings();
            let motion = TargetMotion::first(&measurement, &initiation, &motion).unwrap();
            let begun = Track::begun(motion, 0, 1, 1);
            Track {
                in_company,
                detections,
                ..begun
            }
            .company()
        };
        assert_eq!(company(2, 3), 2.0 / 3.0, "P + d32");
        assert_eq!(company(1, 3), 1.0 / 3.0, "P + d33");
        assert_eq!(company(1, 2), 0.5, "memory P");
        let kept = [company(2, 3), company(1, 3), company(1, 2)].map(|share| share >= 0.5);
        assert_eq!(kept, [true, false, true]);
    }
}
