//! Targets that cannot be told apart, followed as one group (WA-7).
//!
//! On-board sensors that see four targets now as one and now as three give tracks that come and go. Whoever needs one
//! steady answer is better served by a group: one state for all of them, and how many they are. Whether that is so, the
//! wide-area sensor tells: as long as a cluster has fewer tracks than reported targets, the on-board sensors do not
//! resolve them. Hypotheses differ in that, so the answer is a probability.
//!
//! A group track takes the place of its cluster's confirmed tracks. It has the smallest of their numbers, the mean of
//! their states by reliability with the spread of their positions in its covariance, and the expected number of
//! members. The tracker itself goes on following single targets: when they are resolved, their tracks are there.

use super::correction::has_enough;

settings::settings! {
    /// Following of targets as a group (WA-7).
    #[derive(Copy)]
    pub struct Groups {
        /// Least probability that the cluster has fewer tracks than there are targets.
        probability_min: f64 = 0.5, in [1e-6, 1];
    }
}

/// Size of a group that is given out as one track.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Group {
    /// Expected number of members, at least 2.
    pub members: u32,
    /// Probability that the cluster has fewer tracks than members.
    pub probability: f64,
}

/// Probability that there are fewer tracks than `targets`, of hypotheses with (reliability, number of tracks) that sum
/// to 1.
pub fn probability_of_fewer(hypotheses: impl Iterator<Item = (f64, usize)>, targets: f64) -> f64 {
    let fewer = hypotheses.filter(|(_, tracks)| !has_enough(*tracks, targets));
    fewer.map(|(reliability, _)| reliability).sum::<f64>().min(1.0)
}

impl Groups {
    /// Whether a cluster with these hypotheses is better followed as a group, if `targets` were reported.
    pub fn decide(&self, hypotheses: impl Iterator<Item = (f64, usize)>, targets: f64) -> Option<Group> {
        let probability = probability_of_fewer(hypotheses, targets);
        let members = targets.round() as u32;
        (members > 1 && probability >= self.probability_min).then_some(Group { members, probability })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fewer_tracks_than_targets_favour_a_group() {
        let groups = Groups { probability_min: 0.5 };
        let hypotheses = [(0.5, 1), (0.2, 2), (0.3, 3)];
        let decide = |targets| groups.decide(hypotheses.into_iter(), targets);
        assert_eq!(decide(1.0), None);
        assert_eq!(
            decide(2.0),
            Some(Group {
                members: 2,
                probability: 0.5
            })
        );
        let four = decide(4.0).unwrap();
        assert!(four.members == 4 && (four.probability - 1.0).abs() < 1e-12);
        let sure = Groups { probability_min: 0.9 };
        assert_eq!(sure.decide(hypotheses.into_iter(), 2.0), None);
    }
}
