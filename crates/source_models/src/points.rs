//! Detection points of targets by source: whether the points differ, and whether a single point is kept.
//!
//! The evidence of a target stays with its sensor tracks, each with a [`DetectionPoint`]; see `reference_point` and
//! `point_leaps` for the use.

use serde::{Deserialize, Serialize};

use crate::body_frame::{from_body, to_body};
use crate::source_model::SourceModel;

/// Innovations before a detection point is known well enough to be taken off.
const REPORTS_MIN: u32 = 4;
/// Variance of a position above which the distance between points matters little, in variances between points.
const UNCERTAIN: f64 = 4.0;
/// Smallest weight of a new innovation in the estimate of a detection point.
const GAIN_MIN: f64 = 0.05;

/// Time within which most targets of a changed source leap together, nanoseconds, and time without a further search for
/// leaps of this source.
const TOGETHER_NS: i64 = 2_000_000_000;
const STEP_NS: i64 = 30_000_000_000;

/// Place of a sensor track's detection point on its target.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct DetectionPoint {
    /// Along and across the target's course, from its reference point, metres.
    pub offset_m: [f64; 2],
    /// Reports used for the estimate.
    pub reports: u32,
    /// Whether the detection point is the reference point itself.
    pub is_reference: bool,
    /// Whether the detection point has leapt to another place on the target: see `point_leaps`.
    pub has_leapt: bool,
    /// Whether this target shows the point apart from others, whatever other targets show: the source had a track of
    /// its own there.
    pub is_apart: bool,
    /// Epoch of the estimate: see [`Points::follows`].
    pub epoch: u32,
}

/// Whether the sources see different points, and whether a single point is kept.
#[derive(Debug, Default, Serialize, Deserialize)]
pub struct Points {
    /// Whether the sources see different points of the targets.
    sees_points: bool,
    /// Whether sources observe different points, and the rule keeps a single point per target.
    keeps_points: bool,
    /// Variance per axis of the point followed by a filter (one point or the mean of all) about the target's middle,
    /// m².
    spread_m2: f64,
    /// How far the points of two sources lie apart, as a variance per axis, m².
    apart_m2: f64,
    /// Number of changes of `keeps_points`: estimates before the last change are void.
    epoch: u32,
    /// Leaps of detection points, by source.
    leaps: Vec<SourceLeaps>,
}

/// Leaps of one source's targets.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
struct SourceLeaps {
    since_ns: i64,
    count: usize,
    /// Until when none are looked for, nanoseconds.
    until_ns: i64,
}

impl SourceLeaps {
    /// Counts a leap of one target out of `targets`.
    #[inline]
    fn add(&mut self, now_ns: i64, targets: usize) {
        if now_ns - self.since_ns > TOGETHER_NS {
            (self.since_ns, self.count) = (now_ns, 0);
        }
        self.count += 1;
        if self.count >= 2 && 5 * self.count >= 3 * targets {
            self.until_ns = now_ns + STEP_NS;
        }
    }

    /// Returns whether the leaps of the targets come from a step of the source, not of the detection points.
    #[inline]
    fn has_changed(&self, now_ns: i64) -> bool {
        now_ns < self.until_ns
    }
}

/// A measurement's relation to the target's reference point.
#[derive(Clone, Copy, Debug)]
pub struct Referred {
    /// Whether the measurement may be used.
    pub is_usable: bool,
    /// The detection point relative to the reference point, east and north, metres.
    pub point_m: [f64; 2],
    /// Variance per axis of `point_m`, m².
    pub variance_m2: f64,
}

impl Referred {
    /// The detection point is the reference point.
    pub const ITSELF: Self = Self {
        is_usable: true,
        point_m: [0.0; 2],
        variance_m2: 0.0,
    };
}

impl Points {
    pub(crate) fn new(sources: usize) -> Self {
        Self {
            leaps: vec![SourceLeaps::default(); sources],
            ..Self::default()
        }
    }

    /// Whether the sources see different points of the targets.
    #[inline]
    pub fn sees_points(&self) -> bool {
        self.sees_points
    }

    /// Whether a single point of each target is kept.
    #[inline]
    pub fn keeps_points(&self) -> bool {
        self.keeps_points
    }

    /// Variance per axis of the points followed by filters about the targets' middles, m².
    #[inline]
    pub fn spread_m2(&self) -> f64 {
        self.spread_m2
    }

    /// Checks whether some source's detection points lie well apart from the others', and keeps a single point if the
    /// rule `may_keep`.
    pub(crate) fn look(&mut self, models: &[SourceModel], followed_m2: [f64; 2], (may_keep, apart_m2): (bool, f64)) {
        const BEGIN: f64 = 2.0;
        const END: f64 = 1.0;
        let ratio = if self.sees_points { END } else { BEGIN };
        self.sees_points = models.iter().any(|model| model.sees_points(ratio));
        let keep = self.sees_points && may_keep;
        self.spread_m2 = followed_m2[usize::from(keep)];
        self.apart_m2 = apart_m2;
        if keep != self.keeps_points {
            self.keeps_points = keep;
            self.epoch = self.epoch.wrapping_add(1);
        }
    }

    /// How far the points of two sources lie apart, as a variance per axis, m².
    #[inline]
    pub fn apart_m2(&self) -> f64 {
        self.apart_m2
    }

    /// Known place of a detection point on a target with this course, and the variance of the course, rad². The
    /// variances per axis are the variances of the measurement and of the target's place, m².
    #[inline]
    pub fn known(
        &self,
        point: &DetectionPoint,
        (course, course_rad2): ([f64; 2], f64),
        (measured_m2, place_m2): (f64, f64),
    ) -> Referred {
        if !self.follows(point) || (point.epoch == self.epoch && point.is_reference) {
            return Referred::ITSELF;
        }
        if !self.is_known(point) {
            let is_usable = !point.has_leapt && self.is_uncertain(place_m2);
            return Referred {
                is_usable,
                point_m: [0.0; 2],
                variance_m2: if is_usable { self.apart_m2 } else { 0.0 },
            };
        }
        Referred {
            is_usable: true,
            point_m: from_body(point.offset_m, course),
            variance_m2: point.variance_m2(measured_m2, course_rad2),
        }
    }

    /// Returns whether a position with this variance per axis, m², is uncertain: points matter little then.
    #[inline]
    pub fn is_uncertain(&self, variance_m2: f64) -> bool {
        variance_m2 > UNCERTAIN * self.apart_m2
    }

    /// Returns whether a detection point and the target's reference point are two points.
    #[inline]
    pub fn follows(&self, point: &DetectionPoint) -> bool {
        self.keeps_points || (point.stands_apart() && point.epoch == self.epoch)
    }

    /// Whether the place of a detection point is known.
    #[inline]
    pub fn is_known(&self, point: &DetectionPoint) -> bool {
        !self.follows(point)
            || (point.epoch == self.epoch && (point.is_reference || point.is_apart || point.reports >= REPORTS_MIN))
    }

    /// Discards estimates of a detection point from before the latest change of `keeps_points`, unless the target shows
    /// the point apart.
    #[inline]
    pub fn refresh(&self, point: &mut DetectionPoint) {
        if point.is_apart {
            point.epoch = self.epoch;
        } else if point.epoch != self.epoch {
            *point = self.unknown();
        }
    }

    /// A detection point apart from others, first seen at an offset along and across the target's course, metres.
    #[inline]
    pub fn apart(&self, offset_m: [f64; 2]) -> DetectionPoint {
        DetectionPoint {
            offset_m,
            reports: 1,
            is_apart: true,
            ..self.unknown()
        }
    }

    /// A detection point without knowledge.
    #[inline]
    pub fn unknown(&self) -> DetectionPoint {
        DetectionPoint {
            epoch: self.epoch,
            ..DetectionPoint::default()
        }
    }

    /// Whether the source of a detection point, not the points of its targets, has changed at `now_ns`.
    #[inline]
    pub fn has_changed(&self, source: u16, now_ns: i64) -> bool {
        self.leaps[usize::from(source)].has_changed(now_ns)
    }

    /// Learns from a leap of the detection point of one target out of a source's `targets`.
    pub(crate) fn learn_leap(&mut self, source: u16, now_ns: i64, targets: usize) {
        self.leaps[usize::from(source)].add(now_ns, targets);
    }
}

impl DetectionPoint {
    /// Whether the target itself shows that the point is not that of other sources.
    #[inline]
    pub fn stands_apart(&self) -> bool {
        self.has_leapt || self.is_apart
    }

    /// Variance per axis of the place, m², learned from measurements with a variance per axis, on a target whose course
    /// has a variance, rad²: with the course, a point far off turns about the reference point.
    #[inline]
    pub fn variance_m2(&self, measured_m2: f64, course_rad2: f64) -> f64 {
        if !self.is_apart {
            return measured_m2 / f64::from(self.reports);
        }
        let [along_m, across_m] = self.offset_m;
        let turned_m2 = 0.5 * (along_m * along_m + across_m * across_m) * course_rad2;
        measured_m2 * (1.0 / f64::from(self.reports.max(1))).max(GAIN_MIN) + turned_m2
    }

    /// Moves towards the place shown by an innovation, east and north, metres, on a target with this course.
    #[inline]
    pub fn add(&mut self, residual_m: [f64; 2], course: [f64; 2]) {
        let seen = to_body(residual_m, course);
        self.reports = self.reports.saturating_add(1);
        let gain = (1.0 / f64::from(self.reports)).max(GAIN_MIN);
        for (offset, seen) in self.offset_m.iter_mut().zip(seen) {
            *offset += gain * (seen - *offset);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_apart_stays_when_other_targets_show_points_and_turns_with_the_course() {
        let mut points = Points::new(2);
        let mut point = points.apart([200.0, 0.0]);
        assert!(points.is_known(&point) && points.follows(&point));
        points.epoch += 1;
        assert!(!points.follows(&point));
        points.refresh(&mut point);
        let known = |course, course_rad2| points.known(&point, (course, course_rad2), (100.0, 1.0));
        assert_eq!(known([0.0, 1.0], 0.0).point_m, [0.0, 200.0]);
        assert_eq!(known([1.0, 0.0], 0.0).point_m, [200.0, 0.0]);
        // A course that is known to 0.1 rad leaves 20 m across, on average over both axes.
        let turned_m2 = known([0.0, 1.0], 0.01).variance_m2 - known([0.0, 1.0], 0.0).variance_m2;
        assert!((turned_m2 - 200.0).abs() < 1e-9, "{turned_m2}");
    }

    #[test]
    fn the_place_of_a_point_apart_is_never_known_exactly() {
        let points = Points::new(2);
        let mut point = points.apart([200.0, 0.0]);
        for _ in 0..1000 {
            point.add([200.0, 0.0], [1.0, 0.0]);
        }
        assert_eq!(point.variance_m2(100.0, 0.0), 100.0 * GAIN_MIN);
    }
}
