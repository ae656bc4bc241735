//! Errors of the points of a target that its filter does not contain.

use estimation::length;
use messages::AXES;

use crate::tables::system_tracks::{SystemEntry, SystemSlot};
use crate::tables::tracks::Tracks;

/// Speed below which the course is meaningless, m/s.
pub(crate) const COURSE_SPEED_MIN_MPS: f64 = 1.0;

/// Variance of a target's course, rad²; 0 of a target that stands, which does not turn.
pub(crate) fn course_rad2(target: &SystemEntry) -> f64 {
    let filter = &target.filter;
    let speed = length([filter.estimate.mean[AXES], filter.estimate.mean[AXES + 1]]);
    if speed <= COURSE_SPEED_MIN_MPS {
        return 0.0;
    }
    let of = |axis: usize| filter.estimate.covariance.get(axis, axis);
    0.5 * (of(AXES) + of(AXES + 1)) / (speed * speed)
}

/// Variance per axis of a target's reference point that the filter does not contain, m²: the errors of the places of
/// other points persist.
pub(crate) fn unseen_m2(tracks: &Tracks, system: SystemSlot) -> f64 {
    let (points, course_rad2) = (tracks.sources.points(), course_rad2(tracks.systems.get(system)));
    let sigmas_m = tracks.member_entries(system).map(|(_, member)| {
        let is_other = points.follows(&member.point) && !member.point.is_reference;
        let variance_m2 = member.point.variance_m2(member.residual_variance_m2, course_rad2);
        if is_other {
            member.share * variance_m2.sqrt()
        } else {
            0.0
        }
    });
    let sigma_m: f64 = sigmas_m.sum();
    sigma_m * sigma_m
}
