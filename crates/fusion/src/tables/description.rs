//! Description of a target by its sources: single or group, and type (WA-7, WA-9).
//!
//! Most sources have no such data, and report *single* without a type. Their silence overrides no statement. A system
//! track is a group if a contribution is a group, with the expected members of the contribution with the largest
//! weight; its type is the type stated with the greatest confidence. Among equals the source with the lowest number
//! decides. Positions are not changed.

use messages::{SensorTrack, TargetType, TrackKind};
use serde::{Deserialize, Serialize};

/// Kind, number of members and type of a target, as stated by its sources.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Description {
    pub(crate) kind: TrackKind,
    /// Expected number of members of a group, else 0.
    pub(crate) members: u16,
    pub(crate) target_type: TargetType,
}

impl Description {
    /// Returns whether a report contains a description.
    pub(crate) fn is_in(report: &SensorTrack) -> bool {
        is_group(report) || report.target_type.is_known()
    }

    /// Returns the description by contributions with weights, in the order of the sources.
    pub(crate) fn of<'a>(contributions: impl Iterator<Item = (&'a SensorTrack, f64)>) -> Self {
        let mut all = Self::default();
        let mut heaviest = f64::NEG_INFINITY;
        for (report, weight) in contributions {
            if is_group(report) && weight > heaviest {
                heaviest = weight;
                (all.kind, all.members) = (TrackKind::Group, report.members);
            }
            let target_type = &report.target_type;
            if target_type.is_known() && target_type.confidence > all.target_type.confidence {
                all.target_type = report.target_type;
            }
        }
        all
    }
}

/// A group without members does not count as a group.
fn is_group(report: &SensorTrack) -> bool {
    report.kind == TrackKind::Group as u8 && report.members > 0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn report(members: u16, confidence: f64) -> SensorTrack {
        let kind = if members > 0 {
            TrackKind::Group
        } else {
            TrackKind::Single
        };
        SensorTrack {
            kind: kind as u8,
            members,
            target_type: TargetType::new(&format!("T{members}"), confidence).unwrap_or_default(),
            ..SensorTrack::default()
        }
    }

    fn of(contributions: &[(u16, f64, f64)]) -> (TrackKind, u16, Option<String>) {
        let reports: Vec<_> = contributions
            .iter()
            .map(|(members, confidence, weight)| (report(*members, *confidence), *weight))
            .collect();
        let all = Description::of(reports.iter().map(|(report, weight)| (report, *weight)));
        (all.kind, all.members, all.target_type.name().map(str::to_owned))
    }

    #[test]
    fn those_who_know_nothing_outvote_nobody() {
        assert_eq!(of(&[]), (TrackKind::Single, 0, None));
        assert_eq!(of(&[(0, 0.0, 0.9)]), (TrackKind::Single, 0, None));
        assert_eq!(
            of(&[(0, 0.0, 0.9), (4, 0.0, 0.1), (3, 0.0, 0.0)]),
            (TrackKind::Group, 4, None)
        );
    }

    #[test]
    fn the_heaviest_group_and_the_surest_type_hold_and_of_equals_the_first() {
        let named = |name: &str| Some(name.to_owned());
        assert_eq!(
            of(&[(2, 0.6, 0.2), (3, 0.9, 0.2), (4, 0.9, 0.1)]),
            (TrackKind::Group, 2, named("T3"))
        );
        assert_eq!(of(&[(2, 0.6, 0.1), (3, 0.5, 0.2)]), (TrackKind::Group, 3, named("T2")));
        // Weights that are no numbers choose nothing.
        assert_eq!(of(&[(2, 0.0, f64::NAN), (3, 0.0, 0.0)]), (TrackKind::Group, 3, None));
    }

    #[test]
    fn a_report_of_a_single_target_of_no_type_says_nothing() {
        assert!(!Description::is_in(&SensorTrack::default()));
        let mut hostile = report(2, 0.9);
        (hostile.members, hostile.target_type.confidence) = (0, 7.0);
        assert!(!Description::is_in(&hostile));
        let of_both = [(&hostile, 0.9), (&report(0, 0.2), 0.1)];
        assert_eq!(Description::of(of_both.into_iter()).target_type.name(), Some("T0"));
        assert!(Description::is_in(&report(2, 0.0)) && Description::is_in(&report(0, 0.3)));
    }
}
