//! Unresolved targets, tracked as a group (WA-7).
//!
//! On-board sensors that see four targets alternately as one and as three give tracks that come and go. A group is
//! steadier: a single state for all targets, and the number of targets. The wide-area sensor shows when to use a group:
//! as long as a cluster has fewer tracks than reported targets, the on-board sensors do not resolve the targets.
//! Hypotheses differ in the number of tracks, so the result is a probability.
//!
//! A group track replaces the confirmed tracks of the cluster. The number is the smallest track number. The state is
//! the mean by reliability, with the spread of the positions in the covariance. The number of members is the expected
//! number. The tracker itself continues to track single targets: resolved targets already have tracks.

use super::correction::has_enough;

settings::settings! {
    /// Publication of unresolved targets as a group (WA-7).
    #[derive(Copy)]
    pub struct Groups {
        /// Least probability that the cluster has fewer tracks than there are targets.
        probability_min: f64 = 0.5, in [1e-6, 1];
    }
}

/// Size of a group published as a single track.
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
