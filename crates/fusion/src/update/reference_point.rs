//! A single point per target, for sources that see different points of large targets.
//!
//! Each sensor observes its own antenna, edge or echo centre; mixing these points moves the fused position with the
//! mixture. If sources observe different points, a single reference point is kept per target: the point of the first
//! source by priority, so that all targets show the same point, if possible. The points of other sources are estimated
//! relative to the reference point, in a frame that turns with the target's course, and subtracted from the
//! measurements. All sources thus continue to improve the position, and the point remains when the first source falls
//! silent. The point of a source of higher priority replaces the reference point after a while of tracking.
//!
//! A long ship shows its points by itself, whatever other targets show: each source has a track of its own there until
//! the tracks are merged (module `linking`). The merge places the points. Such points are learned relative to the
//! innovations of the reference point, because the filter follows all points together: a common error of the filter
//! and of all points would show in no difference. What is not known of the points, and of the course about which they
//! turn, is added to the published covariance.
//!
//! A filter begins anew with the first source's state, unless the uncertainty of this state far exceeds the distance
//! between points. The filter then keeps the previous state, with the variance between points added. Measurements of
//! points not yet estimated improve only a filter of such uncertainty.

use messages::{AXES, DecisionKind, NS_PER_S, SensorTrack};
use source_models::{DetectionPoint, FilterInnovation, Measurement, Referred, from_body};

use crate::explanation::Sink;
use crate::publish::outlet::Outlet;
use crate::settings::Settings;
use crate::tables::sensor_tracks::{SensorEntry, SensorSlot};
use crate::tables::system_tracks::SystemSlot;
use crate::tables::tracks::Tracks;
use crate::update::kept_measurement::UsedMeasurement;
use crate::update::mean_errors::MEAN_REPORTS_MIN;
use crate::update::point_errors::course_rad2;

/// Innovations before the filter may go over to a detection point.
const CHANGE_REPORTS_MIN: u32 = 12;

/// Returns the measurement in the latest report of a sensor track, `relative` to the reference point.
#[inline]
pub(crate) fn used<'a>(referred: &Referred, entry: &'a SensorEntry, relative: &'a Measurement) -> UsedMeasurement<'a> {
    UsedMeasurement {
        measurement: relative,
        report: &entry.latest,
        correction: entry.correction(),
        is_used: referred.is_usable,
        point_m: referred.point_m,
        point_m2: referred.variance_m2,
    }
}

/// The points of the targets, with the settings.
pub(crate) struct ReferencePoints<'a> {
    pub(crate) settings: &'a Settings,
    pub(crate) tracks: &'a mut Tracks,
}

impl ReferencePoints<'_> {
    /// Returns the position of a sensor track's detection point. Chooses the target's reference point if none exists.
    pub(crate) fn refer<S: Sink>(
        &mut self,
        (sensor, measurement): (SensorSlot, &Measurement),
        out: &mut Outlet<'_, S>,
    ) -> Referred {
        let Self { settings, tracks } = self;
        let (points, entry) = (tracks.sources.points(), tracks.sensors.get_mut(sensor));
        if !points.keeps_points() && !entry.point.stands_apart() {
            return Referred::ITSELF;
        }
        points.refresh(&mut entry.point);
        if entry.point.has_leapt && points.has_changed(entry.source, entry.time_ns) {
            entry.point = points.unknown();
        }
        if !points.keeps_points() {
            return known(tracks, sensor, measurement);
        }
        let (system, now_ns) = (entry.system, entry.time_ns);
        if !is_anchored(tracks, system, now_ns)
            && let Some(foremost) = foremost(settings, tracks, system, now_ns)
        {
            tracks.sensors.get_mut(foremost).point = DetectionPoint {
                is_reference: true,
                ..tracks.sources.points().unknown()
            };
            // The previous state of the filter is a mixture of points.
            let entry = tracks.sensors.get(foremost);
            let points = tracks.sources.points();
            if points.is_uncertain(variance_at(&entry.latest, now_ns)) {
                tracks.systems.get_mut(system).filter.blur(points.apart_m2());
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
        known(tracks, sensor, measurement)
    }

    /// Learns the position of a sensor track's detection point on the target. The filter drifts with points that it
    /// follows far off, so their innovations count relative to that of the reference point.
    pub(crate) fn learn(&mut self, sensor: SensorSlot, innovation: &FilterInnovation) {
        let entry = self.tracks.sensors.get(sensor);
        if self.tracks.sources.points().follows(&entry.point) && !entry.point.is_reference {
            let system = entry.system;
            let course = self.tracks.systems.get(system).course;
            let is_known = |member: &SensorEntry| member.point.is_reference && member.residuals >= MEAN_REPORTS_MIN;
            let mut members = self.tracks.member_entries(system);
            let reference = members.find(|(_, member)| entry.point.is_apart && is_known(member));
            let drift_m = reference.map_or([0.0; 2], |(_, member)| member.residual_mean_m);
            let residual_m = std::array::from_fn(|axis| innovation.residual_m[axis] - drift_m[axis]);
            self.tracks.sensors.get_mut(sensor).point.add(residual_m, course);
        }
    }
}

/// Returns the position of a sensor track's detection point, as far as known; chooses no reference point.
pub(crate) fn known(tracks: &Tracks, sensor: SensorSlot, measurement: &Measurement) -> Referred {
    let entry = tracks.sensors.get(sensor);
    let target = tracks.systems.get(entry.system);
    let variances_m2 = (measurement.variance_m2(), target.filter.variance_m2());
    let course = (target.course, course_rad2(target));
    tracks.sources.points().known(&entry.point, course, variances_m2)
}

/// Whether some contributing sensor track carries the target's reference point.
fn is_anchored(tracks: &Tracks, system: SystemSlot, now_ns: i64) -> bool {
    tracks
        .contributing_entries(system, now_ns)
        .any(|(_, entry)| tracks.sources.points().is_known(&entry.point))
}

/// Returns the contributing sensor track of the source with the highest priority.
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
pub(crate) fn change_to(tracks: &mut Tracks, sensor: SensorSlot) {
    let SensorEntry {
        system, source, point, ..
    } = *tracks.sensors.get(sensor);
    let entry = tracks.systems.get_mut(system);
    let by_m = from_body(point.offset_m, entry.course);
    entry.filter.shift(by_m);
    entry.point_source = source;
    tracks.kept.shift(system, by_m);
    let Tracks {
        sensors,
        systems,
        sources,
        ..
    } = tracks;
    sensors.for_members_from(systems.get(system).members, |member| {
        let other = &mut member.point;
        if point.is_apart && !sources.points().follows(other) {
            *other = sources.points().apart([0.0; 2]);
        }
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
