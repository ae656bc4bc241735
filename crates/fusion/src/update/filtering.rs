//! Update of a system track's filter with a measurement, and learning from the innovation.

use association::distance;
use messages::{AXES, Counter, TrackState};
use source_models::{CovarianceBasis, FilterInnovation, Measurement, shows_filter, states_velocity};

use crate::engine::Engine;
use crate::explanation::Sink;
use crate::tables::sensor_tracks::SensorSlot;
use crate::tables::system_tracks::SystemSlot;
use crate::update::assumed::assumed_of;
use crate::update::filter_input::FilterInput;
use crate::update::point_errors::COURSE_SPEED_MIN_MPS;
use crate::update::point_leaps::PointMotion;
use crate::update::reference_point::{self, ReferencePoints};

/// Distance between report and estimate, in combined standard deviations, beyond which either must be wrong.
const ASTRAY_SIGMAS: f64 = 30.0;

/// Distance of a report from its track beyond which its position is false: an aircraft flies as far in a second.
const FALSE_M: f64 = 300.0;
/// Share of a source in a filter, and factor of the source's too small covariances, above which the filter starts anew.
/// Otherwise the information from other sources, or from before a restart, outweighs a slight overconfidence.
const OWN_SHARE: f64 = 0.3;
const WRONG_CLAIM: f64 = 2.0;
/// Ratio of a measurement's variance to the filter's above which a source with persistent errors adds nothing.
const KNOWN_BETTER: f64 = 4.0;
/// Share in the estimate from which an only source is compared with the filter.
const LONE_SHARE: f64 = 0.5;
/// Squared distance of the estimate from the statement of the only source, in standard deviations of the source. Beyond
/// this distance the statement is better: in a working filter, one state in a thousand is three standard deviations
/// away.
const CONTRADICTION: f64 = 16.0;

impl Engine {
    /// Copies the state of another centre into the filter while no local source tracks the target. Otherwise the filter
    /// ignores other centres: information sent to a centre must not return from that centre.
    pub(crate) fn follow_centre(&mut self, sensor: SensorSlot) {
        let entry = self.tracks.sensors.get(sensor);
        let is_followed = self
            .tracks
            .contributing_here(entry.system, entry.time_ns)
            .next()
            .is_some();
        if !is_followed {
            self.tracks.restart_filter(sensor);
        }
    }

    /// Returns whether a measurement adds nothing to a target: the errors of the source persist, and the target is
    /// known better and later from other sources.
    pub(crate) fn adds_nothing(&self, sensor: SensorSlot, measurement: &Measurement) -> bool {
        let entry = self.tracks.sensors.get(sensor);
        !self.settings.sources[usize::from(entry.source)].is_registered
            && entry.time_ns <= self.tracks.systems.get(entry.system).filter.time_ns
            && self.is_known_better(entry.system, entry.source, measurement.variance_m2())
    }

    /// Updates the system filter with a measurement, and learns from the innovation.
    pub(crate) fn update_filter(&mut self, sensor: SensorSlot, measurement: &Measurement, sink: &mut impl Sink) {
        let entry = self.tracks.sensors.get(sensor);
        let (is_displaced, is_led_off) = (entry.is_displaced, entry.is_led_off);
        if (is_displaced || is_led_off) && self.is_only_source(sensor) {
            self.begin_anew(sensor, sink);
            return;
        }
        if is_led_off {
            self.count_led_off(sensor, measurement);
        }
        let out = &mut self.outbox.to(sink);
        let mut points = ReferencePoints {
            settings: &self.settings,
            tracks: &mut self.tracks,
        };
        let mut referred = points.refer((sensor, measurement), out);
        let point_motion = points.look_for_leap((sensor, measurement), &referred);
        if point_motion != PointMotion::None {
            let source = self.tracks.sensors.get(sensor).source;
            self.outbox.counts.add(source, Counter::RejectedContradicted);
            if point_motion == PointMotion::Suspected {
                return;
            }
            referred = reference_point::known(&self.tracks, sensor, measurement);
        }
        // The estimate stays with the other sources: a displaced source would cause a motion absent from all reports.
        referred.is_usable &= !(is_displaced || is_led_off);
        let entry = self.tracks.sensors.get(sensor);
        let (system, time_ns, source) = (entry.system, entry.time_ns, entry.source);
        referred.is_usable &= self.settings.sources[usize::from(source)].is_registered
            || !self.is_known_better(system, source, measurement.variance_m2());
        let doubt_m2 = self.tracks.sources.doubt_m2(source);
        if doubt_m2 > 0.0 && self.tracks.systems.get(system).contributors.has_others_than(source) {
            referred.variance_m2 += doubt_m2;
        }
        let mut relative = *measurement;
        relative.refer(referred.point_m, referred.variance_m2);
        let tracks = &mut self.tracks;
        let filter = &mut tracks.systems.get_mut(system).filter;
        let keeps = tracks.kept.is_on();
        let taken = if keeps && time_ns < filter.time_ns && !relative.has_waited {
            self.take_late_or_carry(sensor, &relative, &referred)
        } else {
            if keeps {
                tracks.kept.begin(system, filter);
            }
            let innovation = filter.take(
                &relative,
                time_ns,
                tracks.sources.motion(filter.velocity_mps()),
                referred.is_usable,
            );
            if keeps {
                let entry = tracks.sensors.get(sensor);
                let used = reference_point::used(&referred, entry, &relative);
                tracks.kept.append(system, filter, &used);
            }
            innovation
        };
        let filter = &self.tracks.systems.get(system).filter;
        // A non-finite value shows in the gain.
        let Some(mut innovation) = taken.filter(|innovation| innovation.gain.is_finite()) else {
            if !filter.is_sound() {
                self.restart(sensor, sink);
            }
            return;
        };
        if self.is_astray(sensor, &innovation) {
            self.restart(sensor, sink);
            return;
        }
        if innovation.squared < CONTRADICTION {
            self.tracks.sensors.get_mut(sensor).is_displaced = false;
        }
        let nis = innovation.squared.min(f64::from(f32::MAX));
        let target = self.tracks.systems.get_mut(system);
        target.nis = nis as f32;
        target.contributors.insert(source);
        let velocity = [target.filter.estimate.mean[3], target.filter.estimate.mean[4]];
        let speed = (velocity[0] * velocity[0] + velocity[1] * velocity[1]).sqrt();
        if speed > COURSE_SPEED_MIN_MPS {
            target.course = velocity.map(|part| part / speed);
        }
        let is_confirmed = target.life == TrackState::Confirmed;
        // Among several sources, such a share is rare: most reports cost no further time.
        let has_most = self.tracks.sensors.get(sensor).share >= LONE_SHARE;
        let is_behind = has_most && self.is_behind_only_source(sensor, measurement, &innovation);
        let is_contradicted = has_most && self.contradicts_only_source(sensor);
        // After a contradiction, smoothing starts anew with the report, without the measurement.
        if referred.is_usable && !is_contradicted {
            self.outbox.to(sink).input(|| FilterInput {
                point_m: referred.point_m,
                point_m2: referred.variance_m2,
                assumed: Some(assumed_of(system, &self.tracks, &self.publisher)),
                ..self.tracks.input(sensor, Some(measurement))
            });
        }
        for (residual, point) in innovation.residual_m.iter_mut().zip(referred.point_m) {
            *residual += point;
        }
        let is_misled = self.tracks.sources.has_misled_filters();
        let moves_mps = (is_confirmed && !is_misled).then_some([velocity[0], velocity[1], 0.0]);
        // The shares of all sources in the estimate decay with this contribution.
        self.tracks
            .for_members(system, |member| member.share *= 1.0 - innovation.gain);
        self.tracks.sensors.get_mut(sensor).share += innovation.gain;
        let mut points = ReferencePoints {
            settings: &self.settings,
            tracks: &mut self.tracks,
        };
        points.learn(sensor, &innovation);
        self.learn_of_innovation(sensor, (&innovation, nis, measurement), moves_mps, is_misled);
        if is_contradicted {
            self.begin_anew(sensor, sink);
        }
        if is_contradicted || is_behind {
            self.follow(sensor);
        }
    }

    /// Returns whether the estimate contradicts the velocity in the latest report of the only source.
    ///
    /// A source may correct the position, or the smoothing of a source may be undone wrongly. The positions alone then
    /// imply a motion that contradicts the reported velocity, and no other source supports the estimate.
    fn contradicts_only_source(&self, sensor: SensorSlot) -> bool {
        let entry = self.tracks.sensors.get(sensor);
        let (filter, latest) = (&self.tracks.systems.get(entry.system).filter, &entry.latest);
        if filter.time_ns != entry.time_ns || !states_velocity(latest) {
            return false;
        }
        let stated = |row: usize, column: usize| latest.covariance.get(AXES + row, AXES + column);
        let off_mps = std::array::from_fn(|axis| filter.estimate.mean[axis + AXES] - latest.velocity_mps[axis]);
        let squared = distance::squared2(off_mps, [stated(0, 0), stated(0, 1), stated(1, 1)]);
        squared > CONTRADICTION && self.is_only_source(sensor)
    }

    /// Returns whether the estimate lags behind the only source: the source predicts the measurements better, or the
    /// measurements repeat the output of the source's own filter.
    fn is_behind_only_source(
        &mut self,
        sensor: SensorSlot,
        measurement: &Measurement,
        innovation: &FilterInnovation,
    ) -> bool {
        let entry = self.tracks.sensors.get(sensor);
        let latest = &entry.latest;
        let source_m = std::array::from_fn(|axis| {
            measurement.position_m[axis] - latest.position_m[axis] + f64::from(entry.moved_m[axis])
        });
        let variance_m2 = latest.covariance.get(0, 0) + latest.covariance.get(1, 1);
        let target = self.tracks.systems.get_mut(entry.system);
        let can_follow = states_velocity(latest) && target.filter.time_ns == entry.time_ns;
        let is_better = target
            .foresight
            .source_is_better(innovation.residual_m, source_m, variance_m2);
        can_follow && (is_better || self.only_repeats(sensor)) && self.is_only_source(sensor)
    }

    /// Returns whether the latest report is the output of a filter that cannot be undone.
    fn only_repeats(&self, sensor: SensorSlot) -> bool {
        let entry = self.tracks.sensors.get(sensor);
        let is_filtered = entry.basis == CovarianceBasis::Stated && shows_filter(&entry.latest.covariance);
        is_filtered && self.tracks.sources.cannot_be_undone(entry.source)
    }

    /// Counts an unused report of a source that leads the target off: as a false position if latency does not explain
    /// the distance of the report from the track.
    #[cold]
    fn count_led_off(&mut self, sensor: SensorSlot, measurement: &Measurement) {
        let entry = self.tracks.sensors.get(sensor);
        let place_m = self.tracks.systems.get(entry.system).filter.place_at(entry.time_ns);
        let apart = |axis: usize| measurement.position_m[axis] - place_m[axis];
        let counter = match apart(0).hypot(apart(1)) > FALSE_M {
            true => Counter::RejectedFalsePosition,
            false => Counter::RejectedContradicted,
        };
        self.outbox.counts.add(entry.source, counter);
    }

    /// Returns whether a measurement of this variance per axis, m², by a source with persistent errors adds nothing:
    /// the target is known better from other sources, and persistent errors do not average out.
    #[cold]
    fn is_known_better(&self, system: SystemSlot, source: u16, variance_m2: f64) -> bool {
        let target = self.tracks.systems.get(system);
        target.contributors.has_others_than(source) && KNOWN_BETTER * target.filter.variance_m2() < variance_m2
    }

    /// Returns whether the sensor track is the only contributor to the system track.
    fn is_only_source(&self, sensor: SensorSlot) -> bool {
        self.tracks.is_alone(sensor, self.tracks.sensors.get(sensor).time_ns)
    }

    /// Enlarges the covariance of a filter after too small covariances of a source, detected with this report of the
    /// sensor track.
    #[inline]
    pub(crate) fn corrects_claims(&mut self, sensor: SensorSlot, sink: &mut impl Sink) -> bool {
        let entry = self.tracks.sensors.get_mut(sensor);
        let claimed_too_much = std::mem::replace(&mut entry.claimed_too_much, 1.0);
        if claimed_too_much > WRONG_CLAIM && entry.share > OWN_SHARE {
            self.restart(sensor, sink);
            return true;
        } else if claimed_too_much > 1.0 {
            let factor = 1.0 + entry.share * (claimed_too_much - 1.0);
            let system = entry.system;
            self.tracks.systems.get_mut(system).filter.inflate(factor);
            // Kept states of the filter are equally overconfident.
            self.tracks.kept.forget(system);
        }
        false
    }

    /// Returns whether several consecutive reports, from any source, lie far enough from the estimate to prove the
    /// estimate wrong. Otherwise covariance scaling and the learned noise of the sources would protect a wrong
    /// estimate.
    pub(crate) fn is_astray(&mut self, sensor: SensorSlot, innovation: &FilterInnovation) -> bool {
        let entry = self.tracks.sensors.get(sensor);
        let (system, claimed) = (entry.system, &entry.latest.covariance);
        let entry = self.tracks.systems.get_mut(system);
        let known = &entry.filter.estimate.covariance;
        let variance_m2 = claimed.get(0, 0) + claimed.get(1, 1) + known.get(0, 0) + known.get(1, 1);
        let [east_m, north_m] = innovation.residual_m;
        let is_far = east_m * east_m + north_m * north_m > ASTRAY_SIGMAS * ASTRAY_SIGMAS * variance_m2;
        entry.astray = if is_far { entry.astray + 1 } else { 0 };
        entry.astray >= self.settings.association.split_reports
    }

    /// Restarts the unusable filter of a system track from the latest report of the sensor track.
    #[cold]
    pub(crate) fn restart(&mut self, sensor: SensorSlot, sink: &mut impl Sink) {
        let source = self.tracks.sensors.get(sensor).source;
        self.begin_anew(sensor, sink);
        self.outbox.counts.add(source, Counter::EstimatesRestarted);
    }

    /// Begins the filter of a system track anew with the latest report of the sensor track.
    #[cold]
    fn begin_anew(&mut self, sensor: SensorSlot, sink: &mut impl Sink) {
        self.tracks.restart_filter(sensor);
        self.outbox.to(sink).input(|| self.tracks.input(sensor, None));
        self.stands_alone(sensor);
    }

    /// Continues from position and velocity in the latest report of an only source.
    #[cold]
    fn follow(&mut self, sensor: SensorSlot) {
        let entry = self.tracks.sensors.get(sensor);
        // At such a difference, source and filter both lag behind the motion: the next measurements must count more
        // than either covariance admits. A position that the target itself reports does not lag.
        let is_self_reported = self.settings.sources[usize::from(entry.source)].is_self_reported;
        let factor = match is_self_reported || self.only_repeats(sensor) {
            true => 1.0,
            false => CONTRADICTION,
        };
        let target = self.tracks.systems.get_mut(entry.system);
        // Measurements are kept: after a late report of another source, the filter uses all measurements again.
        target.filter.follow(&entry.latest, factor);
        self.stands_alone(sensor);
    }

    /// Marks the sensor track as the only content of the system track's filter.
    fn stands_alone(&mut self, sensor: SensorSlot) {
        let system = self.tracks.sensors.get(sensor).system;
        self.tracks.for_members(system, |member| member.share = 0.0);
        let entry = self.tracks.sensors.get_mut(sensor);
        (entry.share, entry.is_displaced, entry.is_led_off) = (1.0, false, false);
    }
}
