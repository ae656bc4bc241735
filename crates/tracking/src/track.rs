//! A track: one sequence of detections that may be one target's, and what it says of the target.
//!
//! The obvious record of a track is a tree of all its detections, of which branches share the beginning. But what is
//! ever asked of the past is little: whether two tracks share a detection, or have the same ones, within the last few
//! scans; and whether they sprang from the same first detection. So a track is a flat record with the last
//! [`HISTORY_MAX`] scans and its root. Branching is copying; nothing is ever walked, collected or fragmented.

use kept::kept;
use messages::NS_PER_S;

use crate::limits::HISTORY_MAX;
use crate::motion::{Motion, MotionSettings};

/// A scan without a detection, in a history.
pub(crate) const NO_DETECTION: u32 = 0;
/// Number of a track that is not confirmed.
pub(crate) const TENTATIVE: u32 = 0;

kept! {
    /// One branch of what one first detection became.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub(crate) struct Track {
        /// Motion as the last detection or direction left it, and the time of that, nanoseconds.
        pub(crate) motion: Motion,
        pub(crate) time_ns: i64,
        /// Time of the last detection, or of the last scan of directions with one that was probably its own,
        /// nanoseconds.
        pub(crate) seen_ns: i64,
        /// Number of the track tree: the same for all branches of one first detection.
        pub(crate) root: u32,
        /// The confirmed ancestor's number, or [`TENTATIVE`].
        pub(crate) number: u32,
        pub(crate) detections: u32,
        /// Detections that lay in a confirmed track's gate (SP-7).
        pub(crate) in_company: u32,
        /// Scans since then.
        pub(crate) missed: u32,
        /// Logarithm of the probability of having missed it so often since the last detection, if it is there.
        pub(crate) log_silence: f64,
        /// Logarithm of how much likelier its detections are if they are of one target than if all are false.
        pub(crate) log_likelihood_ratio: f64,
        /// Sum over the hypotheses that contain it.
        pub(crate) reliability: f64,
        /// Serial numbers of its detections by scan, latest first; without scans of quick sensors that had none in its
        /// cluster.
        pub(crate) history: [u32; HISTORY_MAX],
    }
}

impl Track {
    /// A tentative track of one detection with the number `serial`, whose motion at `time_ns` that detection tells.
    pub(crate) fn begun(motion: Motion, time_ns: i64, serial: u32, root: u32) -> Self {
        let mut history = [NO_DETECTION; HISTORY_MAX];
        history[0] = serial;
        Self {
            motion,
            time_ns,
            seen_ns: time_ns,
            root,
            number: TENTATIVE,
            detections: 1,
            in_company: 0,
            missed: 0,
            log_silence: 0.0,
            log_likelihood_ratio: 0.0,
            reliability: 0.0,
            history,
        }
    }

    pub(crate) fn is_confirmed(&self) -> bool {
        self.number != TENTATIVE
    }

    /// True if this branch is preferred: higher reliability; ties go to the smaller east coordinate.
    pub(crate) fn is_preferred_to(&self, other: &Self) -> bool {
        let west = || other.motion.estimate().mean[0].total_cmp(&self.motion.estimate().mean[0]);
        self.reliability.total_cmp(&other.reliability).then_with(west).is_gt()
    }

    /// Motion predicted to `time_ns`.
    pub(crate) fn motion_at(&self, time_ns: i64, settings: &MotionSettings) -> Motion {
        if time_ns == self.time_ns {
            return self.motion;
        }
        let seconds = time_ns.saturating_sub(self.time_ns) as f64 / NS_PER_S;
        self.motion.moved(seconds, settings)
    }

    /// SP-7: share of its detections that lay in confirmed tracks' gates.
    pub(crate) fn company(&self) -> f64 {
        f64::from(self.in_company) / f64::from(self.detections)
    }

    /// One scan later, with that scan's detection.
    pub(crate) fn remember(&mut self, serial: u32) {
        self.history.rotate_right(1);
        self.history[0] = serial;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measurement::Measurement;
    use crate::settings::Settings;
    use crate::testing::{position, settings};

    /// d11 lay in C's gate, d21 outside, d32 inside, d33 outside.
    #[test]
    fn the_shares_of_the_worked_check() {
        let company = |in_company, detections| {
            let measurement = Measurement::of(&position(0, 0.0, 0.0), None).unwrap();
            let Settings { initiation, motion, .. } = settings();
            let motion = Motion::first(&measurement, &initiation, &motion).unwrap();
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
