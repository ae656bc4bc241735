//! Splitting: targets of a formation that separate (SP-1 … SP-7).
//!
//! Targets that fly together appear as a single target, and are tracked as such. After a split, one target continues
//! the track and the other is new. Without special treatment, a second detection nearby is most likely clutter, and the
//! new track takes long to be confirmed. The options model the special case: the new target starts in the confirmed
//! track's gate (SP-1) with its motion (SP-2); the number of new targets is limited by the recent surplus of detections
//! (SP-3 to SP-6); and the new target has been near all along (SP-7). The options apply to clusters with a confirmed
//! track; elsewhere nothing can split.
//!
//! Interpretations of the source, where it is ambiguous: computed numbers are rounded up and include the present scan,
//! so that a second detection is allowed in the same scan. A new track in the gates of several confirmed tracks takes
//! the motion of the most reliable track.

use crate::limits::DETECTION_COUNTS;
use crate::motion::TargetMotion;
use crate::population::Cluster;
use crate::settings::{Limit, Splitting};
use crate::track::Track;

/// Numbers for a cluster in a scan.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct SplitLimits {
    /// SP-3: most new tracks.
    pub(crate) new_tracks_max: usize,
    /// SP-5: hypotheses with so many tentative tracks are dropped.
    pub(crate) tentative_tracks: usize,
}

impl SplitLimits {
    pub(crate) const NONE: Self = Self {
        new_tracks_max: usize::MAX,
        tentative_tracks: usize::MAX,
    };

    /// For a cluster with `confirmed` confirmed tracks, branches not counted, and `mean` detections per scan lately.
    pub(crate) fn of(splitting: &Splitting, confirmed: usize, mean: f32) -> Self {
        if confirmed == 0 {
            return Self::NONE;
        }
        // Rounding errors of the mean are not an excess.
        let excess = (mean - confirmed as f32 - 1e-3).ceil().max(0.0) as usize;
        let number = |limit, more| match limit {
            Limit::Off => usize::MAX,
            Limit::Fixed(number) => number,
            Limit::Computed => excess + more,
        };
        Self {
            new_tracks_max: number(splitting.new_tracks_max, 0),
            tentative_tracks: number(splitting.tentative_tracks, 1),
        }
    }

    /// SP-5: whether a hypothesis of so many tentative tracks is dropped.
    pub(crate) fn forbids(&self, tentative: usize) -> bool {
        tentative > 0 && tentative >= self.tentative_tracks
    }
}

/// Detections after which a branch of a split is likely enough with [`Splitting::third_reliability_min`].
const THIRD: u32 = 3;

impl Splitting {
    /// Whether a branch that kept company with a confirmed track is likely enough to be confirmed.
    pub(crate) fn is_beyond_doubt(&self, branch: &Track) -> bool {
        let third = self.third_reliability_min.filter(|_| branch.detections >= THIRD);
        let least = self
            .reliability_min
            .map(|least| third.map_or(least, |third| third.min(least)));
        least.is_some_and(|least| branch.reliability >= least)
    }
}

/// Numbers of detections in a cluster's last scans.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct DetectionCounts {
    pub(crate) detections: [f32; DETECTION_COUNTS],
    pub(crate) scans: u32,
}

impl DetectionCounts {
    pub(crate) const NONE: Self = Self {
        detections: [0.0; DETECTION_COUNTS],
        scans: 0,
    };

    /// Numbers of detections of several clusters together, with another scan of `present` detections.
    pub(crate) fn of<'a>(clusters: impl Iterator<Item = &'a Cluster>, present: usize) -> Self {
        let mut sum = Self::NONE;
        for cluster in clusters {
            sum.scans = sum.scans.max(cluster.scans);
            for (sum, count) in sum.detections.iter_mut().zip(cluster.detections) {
                *sum += count;
            }
        }
        sum.scans = (sum.scans + 1).min(DETECTION_COUNTS as u32);
        sum.detections.rotate_right(1);
        sum.detections[0] = present as f32;
        sum
    }

    pub(crate) fn mean(&self) -> f32 {
        let counted = &self.detections[..self.scans as usize];
        counted.iter().sum::<f32>() / counted.len().max(1) as f32
    }

    /// Numbers that a part of the cluster inherits which has `share` of the detections, `present` in this scan.
    pub(crate) fn part(&self, share: f32, present: usize) -> Self {
        let mut part = *self;
        part.detections.iter_mut().for_each(|count| *count *= share);
        part.detections[0] = present as f32;
        part
    }
}

/// SP-2: weighted mean of several predictions, with the spread of the means in the covariance.
pub(crate) fn mean_motion(branches: impl Iterator<Item = (TargetMotion, f64)>) -> Option<TargetMotion> {
    let weighted = branches.filter(|(_, weight)| *weight > 0.0);
    let sum = weighted.reduce(|(mean, sum), (branch, weight)| {
        let sum_with = sum + weight;
        (TargetMotion::mixture(&mean, &branch, weight / sum_with), sum_with)
    });
    sum.map(|(mean, _)| mean)
}

#[cfg(test)]
mod tests {
    use estimation::Gaussian;
    use messages::Covariance;

    use super::*;

    #[test]
    fn limits_fixed_and_computed() {
        let mut splitting = Splitting::default();
        assert_eq!(SplitLimits::of(&splitting, 1, 9.0), SplitLimits::NONE);
        splitting.new_tracks_max = Limit::Fixed(2);
        splitting.tentative_tracks = Limit::Fixed(3);
        assert_eq!(
            SplitLimits::of(&splitting, 0, 9.0),
            SplitLimits::NONE,
            "nothing is there to split"
        );
        let fixed = SplitLimits::of(&splitting, 1, 9.0);
        assert_eq!((fixed.new_tracks_max, fixed.tentative_tracks), (2, 3));
        assert!(fixed.forbids(3) && !fixed.forbids(2) && !fixed.forbids(0));
        splitting.new_tracks_max = Limit::Computed;
        splitting.tentative_tracks = Limit::Computed;
        for (confirmed, mean, new) in [(1, 0.8, 0), (1, 1.0, 0), (1, 1.2, 1), (1, 3.0, 2), (3, 2.0, 0)] {
            let limits = SplitLimits::of(&splitting, confirmed, mean);
            assert_eq!(
                (limits.new_tracks_max, limits.tentative_tracks),
                (new, new + 1),
                "{mean}"
            );
        }
        assert!(
            !SplitLimits::of(&splitting, 1, 1.0).forbids(0),
            "without tentative tracks nothing is dropped"
        );
    }

    #[test]
    fn detections_are_counted_over_the_last_scans() {
        let mut cluster = Cluster {
            tracks: 0..0,
            hypotheses: 0..0,
            detections: DetectionCounts::NONE.detections,
            scans: 0,
        };
        for (present, mean) in [
            (1, 1.0),
            (1, 1.0),
            (2, 4.0 / 3.0),
            (2, 1.5),
            (2, 1.6),
            (2, 1.8),
            (2, 2.0),
        ] {
            let counts = DetectionCounts::of([&cluster].into_iter(), present);
            assert!((counts.mean() - mean).abs() < 1e-6);
            (cluster.detections, cluster.scans) = (counts.detections, counts.scans);
        }
        let both = DetectionCounts::of([&cluster, &cluster].into_iter(), 4);
        assert_eq!(both.mean(), 4.0);
        assert_eq!(both.part(0.25, 1).mean(), 1.0);
    }

    #[test]
    fn the_parents_motion_has_the_spread_of_the_branches() {
        let settings = crate::Settings::default().motion;
        let branch = |east: f64, variance: f64| {
            let state = Gaussian {
                mean: [east, 0.0, 0.0, 10.0, 0.0, 0.0],
                covariance: Covariance::diagonal([variance.sqrt(); 3], [1.0; 3]),
            };
            TargetMotion::begun(state, &settings)
        };
        let branches = [
            (branch(0.0, 4.0), 0.5),
            (branch(6.0, 1.0), 0.25),
            (branch(9.0, 1.0), 0.0),
        ];
        let mean = mean_motion(branches.into_iter()).unwrap().estimate();
        assert!((mean.mean[0] - 2.0).abs() < 1e-12);
        assert!((mean.covariance.get(0, 0) - (3.0 + 8.0)).abs() < 1e-12);
        assert!((mean.covariance.get(3, 3) - 1.0).abs() < 1e-12);
        assert_eq!(mean_motion([].into_iter()), None);
    }
}
