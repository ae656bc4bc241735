//! What a contribution does: it improves the system filter, and teaches what its source is worth.
//!
//! Where the sources see different points of large targets (each sensor its own antenna, edge or echo centre), mixing
//! them makes the fused position creep as the mixture changes. Then one point is kept per target: that of the source
//! which has followed it longest. The others' points are estimated relative to it, in a frame that turns with the
//! target's course, and taken off their measurements; so all of them go on improving the position, and when the first
//! source falls silent the point stays where it was.

use estimation::{AxisNoise, Matrix3, PackedGaussian};
use messages::{NS_PER_S, SensorTrack, TrackState, sensor_track_bits};

use crate::engine::Engine;
use crate::explanation::{DecisionKind, Sink};
use crate::filter::{Filter, Innovation};
use crate::measurement::Measurement;
use crate::registration::View;
use crate::sensor_tracks::{Role, SensorSlot};
use crate::source_model::{MEAN_GAIN, MEAN_VARIANCE};
use crate::system_tracks::SystemSlot;

/// Innovations of one sensor track before their mean is used.
const MEAN_REPORTS_MIN: u32 = 4;
/// Every how many innovations of a sensor track its mean teaches where detection points lie: in between it hardly changes.
const SPREAD_EVERY: u32 = 4;
/// Innovations before a detection point is known well enough to be taken off.
const POINT_REPORTS_MIN: u32 = 4;
/// Smallest weight of a new innovation in the estimate of a detection point.
const POINT_GAIN_MIN: f64 = 0.05;
/// Below this speed a course says nothing, m/s.
const COURSE_SPEED_MIN_MPS: f64 = 1.0;
/// Samples of a source's systematic errors after which only every few reports one is taken.
const REGISTRATION_SETTLED: f64 = 500.0;
const REGISTRATION_EVERY: u32 = 8;

impl Engine {
    /// Takes the contribution of a speaker whose `report` has just been stored; what it said is taken from there, without its
    /// source's known errors. `measurement` is what it says that is new.
    pub(crate) fn contribute(
        &mut self,
        sensor: SensorSlot,
        report: &SensorTrack,
        measurement: Option<&Measurement>,
        sink: &mut impl Sink,
    ) {
        let system = self.sensors.get(sensor).system;
        if let Some(measurement) = measurement {
            self.feed(sensor, measurement, sink);
        }
        self.keep_alive(sensor, system, report);
        self.compare_sources(sensor);
        self.judge_existence(system, report, sink);
        self.refresh(system, report, sink);
    }

    fn feed(&mut self, sensor: SensorSlot, measurement: &Measurement, sink: &mut impl Sink) {
        let (use_it, point_m, extra_m2) = self.reference_point(sensor, measurement, sink);
        let entry = self.sensors.get(sensor);
        let (system, time_ns) = (entry.system, entry.time_ns);
        let mut relative = *measurement;
        for (position, point) in relative.position_m.iter_mut().zip(point_m) {
            *position -= point;
        }
        relative.covariance_m2[0] += extra_m2;
        relative.covariance_m2[3] += extra_m2;
        let filter = &mut self.systems.get_mut(system).filter;
        let Some(mut innovation) = filter.take(&relative, time_ns, &self.motion, use_it) else {
            return;
        };
        let velocity = [filter.estimate.mean[3], filter.estimate.mean[4]];
        let speed = velocity[0].hypot(velocity[1]);
        if speed > COURSE_SPEED_MIN_MPS {
            self.systems.get_mut(system).course = velocity.map(|part| part / speed);
        }
        for (residual, point) in innovation.residual_m.iter_mut().zip(point_m) {
            *residual += point;
        }
        self.share_out(sensor, system, innovation.gain);
        self.learn_point(sensor, system, &innovation);
        self.learn_of_source(sensor, system, &innovation, measurement);
    }

    /// Every source's share of the estimate decays as this one contributes.
    fn share_out(&mut self, sensor: SensorSlot, system: SystemSlot, gain: f64) {
        let mut at = self.systems.get(system).members;
        while let Some(member) = at {
            let entry = self.sensors.get_mut(member);
            entry.share *= 1.0 - gain;
            at = entry.next.get();
        }
        self.sensors.get_mut(sensor).share += gain;
    }

    /// Whether the measurement may be used, by how much its detection point is off the target's reference point, and how
    /// uncertain that is (variance per axis).
    fn reference_point(
        &mut self,
        sensor: SensorSlot,
        measurement: &Measurement,
        sink: &mut impl Sink,
    ) -> (bool, [f64; 2], f64) {
        if !self.keeps_points {
            return (true, [0.0; 2], 0.0);
        }
        let epoch = self.points_epoch;
        let entry = self.sensors.get_mut(sensor);
        if entry.point.epoch != epoch {
            entry.point = Default::default();
            entry.point.epoch = epoch;
        }
        let (system, now_ns) = (entry.system, entry.time_ns);
        if !self.is_anchored(system, now_ns)
            && let Some(senior) = self.senior(system, now_ns)
        {
            let point = &mut self.sensors.get_mut(senior).point;
            *point = Default::default();
            point.epoch = epoch;
            point.is_reference = true;
            self.begin_at(senior, system);
            self.decide(senior, DecisionKind::ReferencePoint, f64::NAN, f64::NAN, sink);
        }
        let point = self.sensors.get(sensor).point;
        if point.is_reference {
            (true, [0.0; 2], 0.0)
        } else if point.reports >= POINT_REPORTS_MIN {
            let variance = measurement.variance_m2();
            let course = self.systems.get(system).course;
            (
                true,
                from_body(point.offset_m, course),
                variance / f64::from(point.reports),
            )
        } else {
            (false, [0.0; 2], 0.0)
        }
    }

    /// Lets the system filter begin anew from a sensor track: what it was before is a mixture of points.
    fn begin_at(&mut self, sensor: SensorSlot, system: SystemSlot) {
        let report = self.sensors.get(sensor).latest;
        let has_height = report.has(sensor_track_bits::HEIGHT);
        let state = PackedGaussian::new(report.position_m, report.velocity_mps, &report.covariance);
        self.systems.get_mut(system).filter = Filter::new(report.time_of_measurement_ns, state, has_height);
    }

    /// Whether some contributing sensor track carries the target's reference point.
    fn is_anchored(&self, system: SystemSlot, now_ns: i64) -> bool {
        self.search().fresh_primaries(system, now_ns).any(|member| {
            let point = &self.sensors.get(member).point;
            point.epoch == self.points_epoch && (point.is_reference || point.reports >= POINT_REPORTS_MIN)
        })
    }

    /// The contributing sensor track of the source that has followed the target longest.
    fn senior(&self, system: SystemSlot, now_ns: i64) -> Option<SensorSlot> {
        let (_, first_source) = self.systems.get(system).first_seen;
        self.search().fresh_primaries(system, now_ns).min_by_key(|member| {
            let entry = self.sensors.get(*member);
            let source = entry.source;
            (source != first_source, entry.started_ns, source)
        })
    }

    /// Learns where this sensor track's detection point lies on the target.
    fn learn_point(&mut self, sensor: SensorSlot, system: SystemSlot, innovation: &Innovation) {
        if !self.keeps_points {
            return;
        }
        let course = self.systems.get(system).course;
        let point = &mut self.sensors.get_mut(sensor).point;
        if point.is_reference {
            return;
        }
        let seen = to_body(innovation.residual_m, course);
        point.reports = point.reports.saturating_add(1);
        let gain = (1.0 / f64::from(point.reports)).max(POINT_GAIN_MIN);
        for (offset, seen) in point.offset_m.iter_mut().zip(seen) {
            *offset += gain * (seen - *offset);
        }
    }

    /// Learns from an innovation how true its source's covariances are and where its detection points lie.
    fn learn_of_source(
        &mut self,
        sensor: SensorSlot,
        system: SystemSlot,
        innovation: &Innovation,
        measurement: &Measurement,
    ) {
        let entry = self.sensors.get_mut(sensor);
        let source = usize::from(entry.source);
        let [xx, _, yy] = innovation.covariance_m2;
        let before = entry.residual_mean_m;
        let known = entry.residuals >= MEAN_REPORTS_MIN;
        entry.residuals = entry.residuals.saturating_add(1);
        let gain = (1.0 / f64::from(entry.residuals)).max(MEAN_GAIN);
        for (mean, residual) in entry.residual_mean_m.iter_mut().zip(innovation.residual_m) {
            *mean += gain * (residual - *mean);
        }
        entry.residual_variance_m2 += gain * (0.5 * (xx + yy) - entry.residual_variance_m2);
        if !known || entry.repaired {
            return;
        }
        let about_mean = std::array::from_fn(|axis| innovation.residual_m[axis] - before[axis]);
        let squared = association::distance::squared2(about_mean, innovation.covariance_m2);
        if self.settings.consistency && squared.is_finite() {
            self.models[source].learn_consistency(squared / (1.0 + MEAN_VARIANCE));
        }
        let looks =
            !self.models[source].knows_spread_well() || self.sensors.get(sensor).residuals.is_multiple_of(SPREAD_EVERY);
        if looks
            && self.systems.get(system).life == TrackState::Confirmed
            && let Some((offset, noise_m2)) = self.offset(sensor)
        {
            let squared = offset[0] * offset[0] + offset[1] * offset[1];
            self.models[source].learn_spread(squared, 2.0 * noise_m2, measurement.variance_m2());
        }
    }

    /// By how much the mean innovation of a sensor track differs from that of the others of its system track, and the
    /// variance per axis that noise explains. A turn moves all of them to the same side, a wrong join does not.
    fn offset(&self, sensor: SensorSlot) -> Option<([f64; 2], f64)> {
        let entry = self.sensors.get(sensor);
        let (system, now_ns) = (entry.system, entry.time_ns);
        let suspected = |source: u16| self.registration.suspected_shift(source);
        let (mut sum, mut count, mut variance) = ([0.0; 2], 0.0, 0.0);
        for member in self.search().fresh_primaries(system, now_ns) {
            let other = self.sensors.get(member);
            if member != sensor && other.residuals >= MEAN_REPORTS_MIN {
                let shift = suspected(other.source);
                for axis in 0..2 {
                    sum[axis] += other.residual_mean_m[axis] - shift[axis];
                }
                variance += other.residual_variance_m2;
                count += 1.0;
            }
        }
        if count == 0.0 || entry.residuals < MEAN_REPORTS_MIN {
            return None;
        }
        let shift = suspected(entry.source);
        let offset = std::array::from_fn(|axis| entry.residual_mean_m[axis] - shift[axis] - sum[axis] / count);
        let variance_m2 = MEAN_VARIANCE * (entry.residual_variance_m2 + variance / (count * count));
        Some((offset, variance_m2))
    }

    /// d² of a sensor track's offset from the others, in view of noise and of how far detection points lie apart.
    pub(crate) fn offset_from_others(&self, sensor: SensorSlot) -> Option<f64> {
        // Of two that differ, one is at least half as far from the filter as they are from each other.
        let entry = self.sensors.get(sensor);
        let [east, north] = entry.residual_mean_m;
        let gate = self.settings.association.keep_gate;
        if 4.0 * (east * east + north * north) < gate * MEAN_VARIANCE * entry.residual_variance_m2 {
            return Some(0.0);
        }
        let (offset, noise_m2) = self.offset(sensor)?;
        let spread_m2 = self.search().spread_m2(None);
        Some((offset[0] * offset[0] + offset[1] * offset[1]) / (noise_m2 + 2.0 * spread_m2))
    }

    /// The system track has a fresh report.
    fn keep_alive(&mut self, sensor: SensorSlot, system: SystemSlot, report: &SensorTrack) {
        let fresh_until_ns = self.fresh_until(system);
        let entry = self.systems.get_mut(system);
        if entry.life == TrackState::Confirmed {
            self.models[usize::from(report.source)].learn_detection(true);
        }
        entry.last_report_ns = entry.last_report_ns.max(report.time_of_measurement_ns);
        entry.fresh_until_ns = fresh_until_ns;
        entry.reports = entry.reports.saturating_add(1);
        entry.absence = 0.0;
        let [x, y] = [entry.filter.estimate.mean[0], entry.filter.estimate.mean[1]];
        self.systems.grid.place(system, x, y);
        self.systems.identify(system, &self.sensors.get(sensor).latest.identity);
    }

    /// Compares the report with the latest one of another source: systematic errors show in the difference.
    fn compare_sources(&mut self, sensor: SensorSlot) {
        let entry = self.sensors.get(sensor);
        let (report, system) = (&entry.latest, entry.system);
        let source = report.source;
        let settled = self.registration.of(source).samples > REGISTRATION_SETTLED;
        if !self.settings.registration.enabled
            || report.state != TrackState::Confirmed as u8
            || entry.repaired
            || self.systems.get(system).life != TrackState::Confirmed
            || (settled && !entry.reports.is_multiple_of(REGISTRATION_EVERY))
        {
            return;
        }
        let now_ns = report.time_of_measurement_ns;
        let latest = self
            .search()
            .fresh_primaries(system, now_ns)
            .filter(|member| *member != sensor && self.sensors.get(*member).latest.state == TrackState::Confirmed as u8)
            .max_by_key(|member| {
                let latest = &self.sensors.get(*member).latest;
                (latest.time_of_measurement_ns, latest.source)
            });
        let Some(other) = latest else {
            return;
        };
        let (mut own, other) = (self.view(sensor, now_ns), self.view(other, now_ns));
        let points_m2 = self.target_points_m2(system);
        own.covariance_m2[(0, 0)] += points_m2;
        own.covariance_m2[(1, 1)] += points_m2;
        self.registration.learn(&own, &other);
    }

    /// Variance per axis that a further comparison on one target has because the sources see different points of it. The
    /// points stay where they are, so that however often a target is compared, it says no more than one pair of points:
    /// an aircraft at its stand must not outweigh all that pass.
    fn target_points_m2(&self, system: SystemSlot) -> f64 {
        let sources = self.settings.sources.len() as f64;
        let times = 1.0 + f64::from(self.systems.get(system).reports) / sources;
        self.search().spread_m2(None) * times
    }

    /// A sensor track as its source gives it, at `time_ns`.
    fn view(&self, sensor: SensorSlot, time_ns: i64) -> View {
        let entry = self.sensors.get(sensor);
        let source = entry.latest.source;
        let seconds = (time_ns - entry.latest.time_of_measurement_ns) as f64 / NS_PER_S;
        let mut state = entry.as_reported();
        let noise = self
            .motion
            .density_m2ps3
            .map(|density| AxisNoise::white(density, seconds));
        state.advance(seconds, noise);
        let [xx, xy, xz, yy, yz, zz] = state.position_covariance();
        View {
            source,
            position_m: state.position_m(),
            covariance_m2: Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz),
            velocity_mps: state.velocity_mps(),
            has_height: entry.latest.has(sensor_track_bits::HEIGHT),
            place_m: self.place_of(source),
        }
    }

    /// When the last of the present contributions ceases to be fresh.
    fn fresh_until(&self, system: SystemSlot) -> i64 {
        self.systems
            .members(&self.sensors, system)
            .map(|member| {
                let entry = self.sensors.get(member);
                entry.time_ns + self.settings.sources[usize::from(entry.source)].fresh_ns
            })
            .max()
            .unwrap_or(i64::MIN)
    }

    /// The source has seen nothing where it expected a target.
    pub(crate) fn miss(&mut self, report: &SensorTrack, sink: &mut impl Sink) {
        let Some(sensor) = self.sensors.find(report.source, report.track_number) else {
            return;
        };
        let entry = self.sensors.get_mut(sensor);
        entry.misses = entry.misses.saturating_add(1);
        let (system, role, misses) = (entry.system, entry.role, entry.misses);
        if system != crate::sensor_tracks::NO_SYSTEM && role == Role::Primary {
            self.count_miss(system, report, misses, sink);
        }
    }

    /// The source says that its track has ended.
    pub(crate) fn end_sensor_track(&mut self, sensor: SensorSlot, now_ns: i64, sink: &mut impl Sink) {
        let system = self.sensors.get(sensor).system;
        self.drop_sensor_track(sensor);
        if system != crate::sensor_tracks::NO_SYSTEM && self.systems.get(system).members.is_none() {
            self.withhold(system, now_ns, sink);
        }
    }
}

/// A horizontal vector in the frame of a course: along, across to the right.
fn to_body([east, north]: [f64; 2], [sin, cos]: [f64; 2]) -> [f64; 2] {
    [east * sin + north * cos, east * cos - north * sin]
}

/// The inverse of [`to_body`].
fn from_body([along, across]: [f64; 2], [sin, cos]: [f64; 2]) -> [f64; 2] {
    [along * sin + across * cos, along * cos - across * sin]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn body_frame_and_back() {
        let course = [0.6, 0.8];
        let [along, across] = to_body([6.0, 8.0], course);
        assert!((along - 10.0).abs() < 1e-12 && across.abs() < 1e-12);
        let back = from_body(to_body([3.0, -7.0], course), course);
        assert!((back[0] - 3.0).abs() < 1e-12 && (back[1] + 7.0).abs() < 1e-12);
    }
}
