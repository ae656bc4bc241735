//! One point per target, where the sources see different points of large targets.
//!
//! Each sensor observes its own antenna, edge or echo centre; mixing these points moves the fused position with the
//! mixture. If sources observe different points, a single reference point is kept per target: that of the first
//! source by priority, so that all targets show the same point, if possible. The points of other sources are
//! estimated relative to it, in a frame that turns with the target's course, and subtracted from their measurements;
//! all sources thus continue to improve the position, and the point remains when the first source falls silent. When
//! a source of higher priority has tracked the target for a while, its point is used instead.
//!
//! A filter begins anew with the first source's state, unless this state is much less certain than the points are
//! apart: the filter then keeps its state, with the variance between points added. Measurements of points that are not
//! estimated yet improve a filter of such uncertainty only.

use messages::{AXES, DecisionKind, NS_PER_S, SensorTrack};
use serde::{Deserialize, Serialize};

use crate::body_frame::{from_body, to_body};
use crate::explanation::Sink;
use crate::innovation::FilterInnovation;
use crate::kept_measurement::UsedMeasurement;
use crate::measurement::Measurement;
use crate::outlet::Outlet;
use crate::sensor_tracks::{DetectionPoint, SensorEntry, SensorSlot};
use crate::settings::Settings;
use crate::source_model::SourceModel;
use crate::sources::Sources;
use crate::system_tracks::SystemSlot;
use crate::tracks::Tracks;

/// Innovations before a detection point is known well enough to be taken off.
const REPORTS_MIN: u32 = 4;
/// Variance of a position above which the distance between points matters little, in variances between points.
const UNCERTAIN: f64 = 4.0;
/// Innovations before the filter may go over to a detection point.
const CHANGE_REPORTS_MIN: u32 = 12;
/// Smallest weight of a new innovation in the estimate of a detection point.
const GAIN_MIN: f64 = 0.05;

/// Time within which most targets of a source leap together if the source has changed, nanoseconds, and time for which
/// no leaps of this source are looked for then.
const TOGETHER_NS: i64 = 2_000_000_000;
const STEP_NS: i64 = 30_000_000_000;

/// Whether the sources see different points, and whether one is kept.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(crate) struct ReferencePoints {
    /// Whether the sources see different points of the targets.
    sees_points: bool,
    /// Whether sources observe different points, and the rule keeps a single point per target.
    keeps_points: bool,
    /// How far the point that a filter follows, one or the mean of all, lies from the target's middle, as a variance
    /// per axis, m².
    spread_m2: f64,
    /// How far the points of two sources lie apart, as a variance per axis, m².
    apart_m2: f64,
    /// Number of changes of `keeps_points`: estimates before the last change are void.
    epoch: u32,
    /// Leaps of detection points, by source.
    pub(crate) leaps: Vec<SourceLeaps>,
}

/// Leaps of one source's targets.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(crate) struct SourceLeaps {
    since_ns: i64,
    count: usize,
    /// Until when none are looked for, nanoseconds.
    until_ns: i64,
}

impl SourceLeaps {
    /// Counts a leap of one of `targets`.
    pub(crate) fn add(&mut self, now_ns: i64, targets: usize) {
        if now_ns - self.since_ns > TOGETHER_NS {
            (self.since_ns, self.count) = (now_ns, 0);
        }
        self.count += 1;
        if self.count >= 2 && 5 * self.count >= 3 * targets {
            self.until_ns = now_ns + STEP_NS;
        }
    }

    /// Returns whether a step of the source, not of the points of its targets, explains its leaps.
    pub(crate) fn has_changed(&self, now_ns: i64) -> bool {
        now_ns < self.until_ns
    }
}

/// A measurement's relation to the target's reference point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Referred {
    /// Whether the measurement may be used.
    pub(crate) is_usable: bool,
    /// The detection point relative to the reference point, east and north, metres.
    pub(crate) point_m: [f64; 2],
    /// Variance per axis of that, m².
    pub(crate) variance_m2: f64,
}

impl Referred {
    /// The detection point is the reference point.
    const ITSELF: Self = Self {
        is_usable: true,
        point_m: [0.0; 2],
        variance_m2: 0.0,
    };

    /// The measurement in the latest report of a sensor track, which is `relative` to the reference point.
    #[inline]
    pub(crate) fn used<'a>(&self, entry: &'a SensorEntry, relative: &'a Measurement) -> UsedMeasurement<'a> {
        UsedMeasurement {
            measurement: relative,
            report: &entry.latest,
            correction: entry.correction(),
            is_used: self.is_usable,
            point_m: self.point_m,
            point_m2: self.variance_m2,
        }
    }
}

impl ReferencePoints {
    pub(crate) fn new(sources: usize) -> Self {
        Self {
            leaps: vec![SourceLeaps::default(); sources],
            ..Self::default()
        }
    }

    pub(crate) fn sees_points(&self) -> bool {
        self.sees_points
    }

    pub(crate) fn keeps_points(&self) -> bool {
        self.keeps_points
    }

    /// Variance per axis of the points that filters follow about the targets' middles, m².
    pub(crate) fn spread_m2(&self) -> f64 {
        self.spread_m2
    }

    /// Looks whether some source's detection points lie well apart from the others', and keeps one if the rule
    /// `may_keep`.
    pub(crate) fn look(&mut self, sources: &Sources, may_keep: bool) {
        const BEGIN: f64 = 2.0;
        const END: f64 = 1.0;
        let ratio = if self.sees_points { END } else { BEGIN };
        self.sees_points = sources
            .models
            .iter()
            .any(|model: &SourceModel| model.sees_points(ratio));
        let keep = self.sees_points && may_keep;
        self.spread_m2 = sources.followed_point_m2(keep);
        self.apart_m2 = sources.possible_points_m2(0.0);
        if keep != self.keeps_points {
            self.keeps_points = keep;
            self.epoch = self.epoch.wrapping_add(1);
        }
    }

    /// Where the detection point of a sensor track lies. Chooses the target's reference point where it has none.
    pub(crate) fn refer<S: Sink>(
        &self,
        settings: &Settings,
        tracks: &mut Tracks,
        (sensor, measurement): (SensorSlot, &Measurement),
        out: &mut Outlet<'_, S>,
    ) -> Referred {
        let entry = tracks.sensors.get_mut(sensor);
        if !self.keeps_points && !entry.point.has_leapt {
            return Referred::ITSELF;
        }
        self.refresh(&mut entry.point);
        if entry.point.has_leapt && self.leaps[usize::from(entry.source)].has_changed(entry.time_ns) {
            entry.point = self.unknown();
        }
        if !self.keeps_points {
            return self.known(tracks, sensor, measurement);
        }
        let (system, now_ns) = (entry.system, entry.time_ns);
        if !self.is_anchored(tracks, system, now_ns)
            && let Some(foremost) = foremost(settings, tracks, system, now_ns)
        {
            tracks.sensors.get_mut(foremost).point = DetectionPoint {
                is_reference: true,
                ..self.unknown()
            };
            // What the filter was before is a mixture of points.
            let entry = tracks.sensors.get(foremost);
            if self.is_uncertain(variance_at(&entry.latest, now_ns)) {
                tracks.systems.get_mut(system).filter.blur(self.apart_m2);
                tracks.kept.forget(system);
            } else {
                tracks.restart_filter(foremost);
            }
            tracks.systems.get_mut(system).point_source = tracks.sensors.get(foremost).source;
            out.input(|| tracks.input(foremost, None));
            out.decision(&tracks.decision(foremost, DecisionKind::ReferencePoint, f64::NAN, f64::NAN));
        }
        let point = tracks.sensors.get(sensor).point;
        if point.is_reference {
            return Referred::ITSELF;
        }
        if point.reports >= CHANGE_REPORTS_MIN && comes_first(settings, tracks, sensor) {
            change_to(tracks, sensor);
            out.input(|| tracks.input(sensor, None));
            out.decision(&tracks.decision(sensor, DecisionKind::ReferencePoint, f64::NAN, f64::NAN));
            return Referred::ITSELF;
        }
        self.known(tracks, sensor, measurement)
    }

    /// Where the detection point of a sensor track lies, as far as it is known; chooses nothing.
    pub(crate) fn known(&self, tracks: &Tracks, sensor: SensorSlot, measurement: &Measurement) -> Referred {
        let entry = tracks.sensors.get(sensor);
        let point = &entry.point;
        if !self.follows(point) || (point.epoch == self.epoch && point.is_reference) {
            return Referred::ITSELF;
        }
        if !self.is_known(point) {
            let is_usable =
                !point.has_leapt && self.is_uncertain(tracks.systems.get(entry.system).filter.variance_m2());
            return Referred {
                is_usable,
                point_m: [0.0; 2],
                variance_m2: if is_usable { self.apart_m2 } else { 0.0 },
            };
        }
        Referred {
            is_usable: true,
            point_m: from_body(point.offset_m, tracks.systems.get(entry.system).course),
            variance_m2: measurement.variance_m2() / f64::from(point.reports),
        }
    }

    /// Returns whether a position with this variance per axis, m², is uncertain: see [`UNCERTAIN`].
    fn is_uncertain(&self, variance_m2: f64) -> bool {
        variance_m2 > UNCERTAIN * self.apart_m2
    }

    /// Returns whether a detection point and the target's reference point are two points.
    pub(crate) fn follows(&self, point: &DetectionPoint) -> bool {
        self.keeps_points || (point.has_leapt && point.epoch == self.epoch)
    }

    /// Whether it is known where a detection point lies.
    pub(crate) fn is_known(&self, point: &DetectionPoint) -> bool {
        !self.follows(point) || (point.epoch == self.epoch && (point.is_reference || point.reports >= REPORTS_MIN))
    }

    /// Forgets what was known of a detection point before points were last kept, or not.
    fn refresh(&self, point: &mut DetectionPoint) {
        if point.epoch != self.epoch {
            *point = self.unknown();
        }
    }

    pub(crate) fn unknown(&self) -> DetectionPoint {
        DetectionPoint {
            epoch: self.epoch,
            ..DetectionPoint::default()
        }
    }

    /// Whether some contributing sensor track carries the target's reference point.
    fn is_anchored(&self, tracks: &Tracks, system: SystemSlot, now_ns: i64) -> bool {
        tracks
            .contributing(system, now_ns)
            .any(|member| self.is_known(&tracks.sensors.get(member).point))
    }

    /// Learns where a sensor track's detection point lies on the target.
    pub(crate) fn learn(&self, tracks: &mut Tracks, sensor: SensorSlot, innovation: &FilterInnovation) {
        let entry = tracks.sensors.get_mut(sensor);
        if !self.follows(&entry.point) {
            return;
        }
        let course = tracks.systems.get(entry.system).course;
        let point = &mut entry.point;
        if point.is_reference {
            return;
        }
        let seen = to_body(innovation.residual_m, course);
        point.reports = point.reports.saturating_add(1);
        let gain = (1.0 / f64::from(point.reports)).max(GAIN_MIN);
        for (offset, seen) in point.offset_m.iter_mut().zip(seen) {
            *offset += gain * (seen - *offset);
        }
    }
}

/// The contributing sensor track of the source that comes first.
fn foremost(settings: &Settings, tracks: &Tracks, system: SystemSlot, now_ns: i64) -> Option<SensorSlot> {
    tracks.contributing(system, now_ns).min_by_key(|member| {
        let entry = tracks.sensors.get(*member);
        (settings.rank(entry.source), entry.started_ns)
    })
}

/// Returns whether the source of a sensor track precedes the source of the filter's reference point.
fn comes_first(settings: &Settings, tracks: &Tracks, sensor: SensorSlot) -> bool {
    let entry = tracks.sensors.get(sensor);
    settings.comes_before(entry.source, tracks.systems.get(entry.system).point_source)
}

/// Makes the detection point of a sensor track the reference point of its target.
fn change_to(tracks: &mut Tracks, sensor: SensorSlot) {
    let SensorEntry {
        system, source, point, ..
    } = *tracks.sensors.get(sensor);
    let entry = tracks.systems.get_mut(system);
    let by_m = from_body(point.offset_m, entry.course);
    entry.filter.shift(by_m);
    entry.point_source = source;
    tracks.kept.shift(system, by_m);
    tracks.for_members(system, |member| {
        let other = &mut member.point;
        for (offset, by) in other.offset_m.iter_mut().zip(point.offset_m) {
            *offset -= by;
        }
        if other.is_reference {
            (other.is_reference, other.reports) = (false, point.reports);
        }
    });
    tracks.sensors.get_mut(sensor).point = DetectionPoint {
        offset_m: [0.0; 2],
        is_reference: true,
        ..point
    };
}

/// Variance per axis of the position in a report at a later time, with constant velocity, m².
fn variance_at(report: &SensorTrack, time_ns: i64) -> f64 {
    let seconds = (time_ns - report.time_of_measurement_ns) as f64 / NS_PER_S;
    let of = |axis: usize| report.covariance.get(axis, axis);
    let (position_m2, velocity_m2ps2) = (of(0) + of(1), of(AXES) + of(AXES + 1));
    0.5 * (position_m2 + seconds * seconds * velocity_m2ps2)
}
