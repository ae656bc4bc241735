//! Detection points that leap to another place on their target.
//!
//! An aircraft changes from the transponder at its nose to that at its belly when it takes off: to a sensor that
//! locates transponders, the aircraft leaps along its course. No motion of the target explains a leap: the distance is
//! too great for the time since the source's last measurements, which fitted, and the source's own filter is as
//! surprised. Such a measurement is not used. If the next one agrees with it, and measurements of other sources in
//! between show that the target has not moved, the detection point is estimated anew from there on.
//!
//! The position that a target itself reports is that of one antenna, which does not leap. If most targets of a source
//! leap within a few seconds, the source has changed, not their points: registration estimates that, and for a while no
//! leaps of this source are looked for.

use messages::{NS_PER_S, TrackState};
use source_models::{DetectionPoint, Fact, InnovationFact, Measurement, Referred, from_body, to_body};

use crate::tables::sensor_tracks::{LeapWatch, SensorEntry, SensorSlot};
use crate::tables::system_tracks::SystemSlot;
use crate::update::mean_errors::MEAN_REPORTS_MIN;
use crate::update::reference_point::ReferencePoints;

/// Squared distance of a measurement from where it was expected, in variances per axis, from which its point may have
/// leapt; that by which it must differ from the latest ones; and that within which two agree.
const LEAPS: f64 = 16.0;
const CHANGES: f64 = 6.0;
const FITS: f64 = 9.2;
/// Acceleration that explains a distance: targets on straight courses do not exceed it, m/s².
const ACCELERATION_MPS2: f64 = 10.0;
/// Innovations of a sensor track before its measurements prove a leap, and between two leaps: what leaps more often is
/// no point.
const REPORTS_MIN: u32 = 12;
/// Share of a leap that the filter of the source itself must have seen.
const OWN_PART: f64 = 0.5;
/// How many times as far a point leaps along the course as across it: in a turn, points move across it.
const ALONG: f64 = 2.0;
/// Share of a leap that the next measurements must show: an outlier does not stay.
const STAYS_PART: f64 = 0.5;
/// Probability of steady motion below which a filter's predictions prove no leap.
const STEADY_MIN: f64 = 0.25;
/// Logarithm of the likelihood ratio of a target that stayed to one that moved: from which the point has leapt, and
/// below which the target has moved.
const STAYED: f64 = 1.0;
const MOVED: f64 = -4.0;
/// Largest part of the logarithm from one measurement: no single measurement decides.
const WITNESS_MAX: f64 = 3.0;
/// Measurements in a row that may wait for other sources.
const WAITING_MAX: u8 = 3;

/// Motion of a detection point on its target, as a measurement shows the motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum PointMotion {
    /// The point is where it was.
    None,
    /// The point may have leapt: the measurement cannot be used.
    Suspected,
    /// The point has leapt, and is estimated anew.
    Leapt,
}

/// A measurement beside its prediction.
struct Seen {
    /// Distance from where the point was expected, east and north, metres.
    apart_m: [f64; 2],
    /// The point from the target's reference point, east and north, metres.
    point_m: [f64; 2],
    /// Variances per axis of the measurement, and of the distance, m².
    noise_m2: f64,
    variance_m2: f64,
}

/// Lets a sensor track whose measurements wait take in where another source's measurement of the target lies.
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
    /// Looks whether the detection point of a sensor track has leapt with its latest measurement.
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
        // Few are so far away that the rest matters. Of the time of an older measurement, those that came after it show
        // more than a prediction.
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

    /// Judges a measurement after one that may have been the first after a leap.
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

    /// Returns whether no motion of the target explains where the measurement lies, and another source still follows
    /// the target.
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
        let size_m = settings.target_size.of(&entry.latest.target_type);
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
        // Along the way from where the source's own filter expected the measurement.
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

    /// Returns whether measurements of a sensor track show where its target is.
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

    /// Where the detection point of a sensor track lies from the target's reference point, east and north, metres, as
    /// far as the two are told apart.
    fn offset_m(&self, entry: &SensorEntry, course: [f64; 2]) -> [f64; 2] {
        match self.tracks.sources.points().follows(&entry.point) {
            true => from_body(entry.point.offset_m, course),
            false => [0.0; 2],
        }
    }

    /// Notes that a detection point has leapt so far, east and north, metres. A point that is the reference point
    /// leaves it. Back among the others' points, with this variance per axis of its measurements, m², it is none.
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
        // The mean innovation of before is that of another point.
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
