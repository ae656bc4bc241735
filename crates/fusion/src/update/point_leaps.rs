//! Detection points that leap to another place on the target.
//!
//! At take-off, an aircraft changes from the transponder at the nose to the transponder at the belly: for a sensor that
//! locates transponders, the aircraft leaps along the course. No motion of the target explains a leap: the distance is
//! too great for the time since the source's last, fitting measurements, and the source's own filter shows a similar
//! innovation. Such a measurement is not used. If the next measurement agrees, and measurements of other sources in
//! between show an unmoved target, the detection point is estimated anew from there on.
//!
//! A position reported by the target itself is the position of a single antenna, without leaps. If most targets of a
//! source leap within a few seconds, the source has changed, not the points: registration estimates the change, and
//! leap detection pauses for this source.

use messages::{NS_PER_S, TrackState};
use source_models::{DetectionPoint, Fact, InnovationFact, Measurement, Referred, from_body, to_body};

use crate::tables::sensor_tracks::{LeapWatch, SensorEntry, SensorSlot};
use crate::tables::system_tracks::SystemSlot;
use crate::update::mean_errors::MEAN_REPORTS_MIN;
use crate::update::reference_point::ReferencePoints;

/// Squared distances, in variances per axis: least distance from the prediction at a possible leap; least difference
/// from the latest measurements; largest difference of two measurements in agreement.
const LEAPS: f64 = 16.0;
const CHANGES: f64 = 6.0;
const FITS: f64 = 9.2;
/// Acceleration assumed to explain a distance, m/s²: the limit of targets on straight courses.
const ACCELERATION_MPS2: f64 = 10.0;
/// Innovations of a sensor track before a leap can be proved, and between two leaps: more frequent leaps are no leaps
/// of a point.
const REPORTS_MIN: u32 = 12;
/// Share of a leap required in the innovation of the source's own filter.
const OWN_PART: f64 = 0.5;
/// Minimum ratio of a leap's parts along and across the course: in a turn, points move across the course.
const ALONG: f64 = 2.0;
/// Share of a leap required in the next measurements: an outlier does not stay.
const STAYS_PART: f64 = 0.5;
/// Probability of steady motion below which a filter's predictions prove no leap.
const STEADY_MIN: f64 = 0.25;
/// Logarithm of the likelihood ratio of a target that stayed to a target that moved: above the first value the point
/// has leapt, and below the second the target has moved.
const STAYED: f64 = 1.0;
const MOVED: f64 = -4.0;
/// Largest part of the logarithm from a measurement: no single measurement decides.
const WITNESS_MAX: f64 = 3.0;
/// Measurements in a row that may wait for other sources.
const WAITING_MAX: u8 = 3;

/// Motion of a detection point on the target, as shown by a measurement.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum PointMotion {
    /// The point has not moved.
    None,
    /// The point may have leapt: the measurement cannot be used.
    Suspected,
    /// The point has leapt, and is estimated anew.
    Leapt,
}

/// A measurement beside the prediction.
struct Seen {
    /// Distance from the expected position of the point, east and north, metres.
    apart_m: [f64; 2],
    /// Offset of the point from the target's reference point, east and north, metres.
    point_m: [f64; 2],
    /// Variances per axis of the measurement, and of the distance, m².
    noise_m2: f64,
    variance_m2: f64,
}

/// Updates the likelihood ratio of a waiting sensor track with another source's measurement of the target.
fn take_witness(watch: &mut LeapWatch, seen: &Seen) {
    let leap_m = watch.leap_m.map(f64::from);
    let along_m2 = leap_m[0] * seen.apart_m[0] + leap_m[1] * seen.apart_m[1];
    let ratio = (0.5 * square(leap_m) - along_m2) / seen.variance_m2;
    watch.stayed += ratio.clamp(-WITNESS_MAX, WITNESS_MAX) as f32;
    if f64::from(watch.stayed) < MOVED {
        watch.waiting = 0;
    }
}

impl ReferencePoints<'_> {
    /// Checks whether the detection point of a sensor track has leapt with the latest measurement.
    #[inline]
    pub(crate) fn look_for_leap(
        &mut self,
        (sensor, measurement): (SensorSlot, &Measurement),
        referred: &Referred,
    ) -> PointMotion {
        let entry = self.tracks.sensors.get(sensor);
        let system = self.tracks.systems.get(entry.system);
        let place_m = system.filter.place_at(entry.time_ns);
        let apart_m = std::array::from_fn(|axis| measurement.position_m[axis] - referred.point_m[axis] - place_m[axis]);
        let noise_m2 = measurement.variance_m2();
        // Few measurements lie far enough for the further tests. At the time of an older measurement, later
        // measurements show more than a prediction.
        if square(apart_m) <= LEAPS * noise_m2 && !system.awaits_leap || entry.time_ns < system.filter.time_ns {
            return PointMotion::None;
        }
        self.judge_leap((sensor, measurement), (apart_m, referred))
    }

    #[cold]
    fn judge_leap(
        &mut self,
        (sensor, measurement): (SensorSlot, &Measurement),
        (apart_m, referred): ([f64; 2], &Referred),
    ) -> PointMotion {
        let SensorEntry {
            system,
            source,
            time_ns,
            leap_watch,
            ..
        } = *self.tracks.sensors.get(sensor);
        let noise_m2 = measurement.variance_m2();
        let filter_m2 = self.tracks.systems.get(system).filter.variance_m2();
        let seen = &Seen {
            apart_m,
            point_m: referred.point_m,
            noise_m2,
            variance_m2: noise_m2 + referred.variance_m2 + filter_m2,
        };
        if self.is_witness(self.tracks.sensors.get(sensor)) {
            self.tracks.for_members(system, |member| {
                if member.source != source && member.leap_watch.is_waiting() {
                    take_witness(&mut member.leap_watch, seen);
                }
            });
        }
        let motion = if leap_watch.is_waiting() {
            self.confirm_leap(sensor, seen)
        } else if !self.tracks.sources.points().has_changed(source, time_ns)
            && self.may_leap((sensor, measurement), seen)
        {
            let watch = &mut self.tracks.sensors.get_mut(sensor).leap_watch;
            (watch.leap_m, watch.waiting, watch.stayed) = (apart_m.map(|way| way as f32), 1, 0.0);
            PointMotion::Suspected
        } else {
            PointMotion::None
        };
        let awaits = self
            .tracks
            .member_entries(system)
            .any(|(_, member)| member.leap_watch.is_waiting());
        self.tracks.systems.get_mut(system).awaits_leap = awaits;
        motion
    }

    /// Judges a measurement after a suspected leap.
    fn confirm_leap(&mut self, sensor: SensorSlot, seen: &Seen) -> PointMotion {
        let watch = &mut self.tracks.sensors.get_mut(sensor).leap_watch;
        let leap_m = watch.leap_m.map(f64::from);
        let change_m = std::array::from_fn(|axis| seen.apart_m[axis] - leap_m[axis]);
        let stays_part = (seen.apart_m[0] * leap_m[0] + seen.apart_m[1] * leap_m[1]) / square(leap_m);
        let agrees = square(change_m) < FITS * 2.0 * seen.variance_m2 && stays_part > STAYS_PART;
        if !agrees {
            watch.waiting = 0;
            return PointMotion::None;
        }
        if f64::from(watch.stayed) > STAYED || watch.waiting == WAITING_MAX {
            self.leap(sensor, leap_m, seen.noise_m2);
            return PointMotion::Leapt;
        }
        watch.waiting += 1;
        PointMotion::Suspected
    }

    /// Returns whether no motion of the target explains the position of the measurement, and another source still
    /// follows the target.
    fn may_leap(&self, (sensor, measurement): (SensorSlot, &Measurement), seen: &Seen) -> bool {
        let (settings, tracks) = (self.settings, &*self.tracks);
        let entry = tracks.sensors.get(sensor);
        let system = tracks.systems.get(entry.system);
        let source = &settings.sources[usize::from(entry.source)];
        if source.is_self_reported {
            return false;
        }
        let seconds = source.period_ns as f64 / NS_PER_S;
        let explained_m = 0.5 * ACCELERATION_MPS2 * seconds * seconds;
        let square_m2 = square(seen.apart_m);
        let [along_m, across_m] = to_body(seen.apart_m, system.course);
        let size_m = entry.size_m(&settings.target_size);
        let before_m = self.offset_m(entry, system.course);
        let offset_m = std::array::from_fn(|axis| before_m[axis] + seen.apart_m[axis]);
        let mean_m = std::array::from_fn(|axis| entry.residual_mean_m[axis] - seen.point_m[axis]);
        let change_m = std::array::from_fn(|axis| seen.apart_m[axis] - mean_m[axis]);
        let is_predicted = system.life == TrackState::Confirmed
            && system.filter.steadiness() > STEADY_MIN
            && entry.residuals >= REPORTS_MIN
            && self.tracks.sources.points().is_known(&entry.point)
            && square(mean_m) < LEAPS * seen.variance_m2
            && square(change_m) > CHANGES * (seen.variance_m2 + seen.noise_m2);
        // Share of the leap in the innovation of the source's own filter.
        let own_part = |axis: usize| {
            let own_m = measurement.position_m[axis] - entry.latest.position_m[axis] + f64::from(entry.moved_m[axis]);
            own_m * seen.apart_m[axis] / square_m2
        };
        is_predicted
            && square_m2 > explained_m * explained_m + LEAPS * seen.variance_m2
            && square_m2.max(square(offset_m)) <= size_m * size_m
            && own_part(0) + own_part(1) > OWN_PART
            && along_m.abs() > ALONG * across_m.abs()
            && self.is_followed_by_another((entry.system, entry.source), entry.time_ns)
    }

    /// Returns whether measurements of a sensor track show the position of the target.
    fn is_witness(&self, entry: &SensorEntry) -> bool {
        entry.residuals >= MEAN_REPORTS_MIN
            && !entry.is_led_off
            && !entry.leap_watch.is_waiting()
            && self.tracks.sources.points().is_known(&entry.point)
    }

    fn is_followed_by_another(&self, (system, source): (SystemSlot, u16), now_ns: i64) -> bool {
        self.tracks
            .contributing_entries(system, now_ns)
            .any(|(_, other)| other.source != source && self.is_witness(other))
    }

    /// Returns the offset of a sensor track's detection point from the target's reference point, east and north,
    /// metres; 0 if both are the same point.
    fn offset_m(&self, entry: &SensorEntry, course: [f64; 2]) -> [f64; 2] {
        match self.tracks.sources.points().follows(&entry.point) {
            true => from_body(entry.point.offset_m, course),
            false => [0.0; 2],
        }
    }

    /// Notes a leap of a detection point by this distance, east and north, metres. After a leap, the point is no longer
    /// the reference point. Back at the points of the others, within the variance per axis of the measurements, m², the
    /// point counts as not leapt.
    fn leap(&mut self, sensor: SensorSlot, by_m: [f64; 2], noise_m2: f64) {
        let entry = self.tracks.sensors.get(sensor);
        let course = self.tracks.systems.get(entry.system).course;
        let (source, now_ns) = (entry.source, entry.time_ns);
        let before_m = self.offset_m(entry, course);
        let offset_m = std::array::from_fn(|axis| before_m[axis] + by_m[axis]);
        let entry = self.tracks.sensors.get_mut(sensor);
        entry.point = self.tracks.sources.points().unknown();
        if self.tracks.sources.points().keeps_points() || square(offset_m) > FITS * 2.0 * noise_m2 {
            entry.point = DetectionPoint {
                offset_m: to_body(offset_m, course),
                reports: 1,
                has_leapt: true,
                ..entry.point
            };
        }
        entry.leap_watch.waiting = 0;
        // The previous mean innovation belongs to another point.
        entry.residuals = 0;
        let targets = self.tracks.sensors.count_of(source);
        self.tracks.sources.learn(
            self.settings,
            Fact::Innovation(InnovationFact::Leapt {
                source,
                time_ns: now_ns,
                targets,
            }),
        );
    }
}

fn square([east, north]: [f64; 2]) -> f64 {
    east * east + north * north
}
