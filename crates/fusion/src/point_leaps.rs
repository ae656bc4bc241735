//! Detection points that leap to another place on their target.
//!
//! An aircraft changes from the transponder at its nose to that at its belly when it takes off: to a sensor that
//! locates transponders, the aircraft leaps along its course. No motion of the target explains a leap: the distance is
//! too great for the time since the source's last measurement, which fitted, and the source's own filter is as
//! surprised. Such a measurement is not used. If the next one agrees with it, and measurements of other sources in
//! between show that the target has not moved, the detection point is estimated anew from there on.
//!
//! If most targets of a source leap within a few seconds, the source has changed, not their points: registration
//! estimates that, and for a while no leaps of this source are looked for.

use messages::{NS_PER_S, TrackState};
use serde::{Deserialize, Serialize};

use crate::measurement::Measurement;
use crate::reference_point::{ReferencePoints, Referred, from_body, to_body};
use crate::sensor_tracks::{DetectionPoint, SensorEntry, SensorSlot};
use crate::settings::Settings;
use crate::sources::MEAN_REPORTS_MIN;
use crate::system_tracks::SystemSlot;
use crate::tracks::Tracks;

/// Squared distance of a measurement from where it was expected, in variances per axis, from which its point may have
/// leapt, and up to which the measurement before fitted.
const LEAPS: f64 = 16.0;
const FITS: f64 = 9.2;
/// Acceleration that explains a distance: targets on straight courses do not exceed it, m/s².
const ACCELERATION_MPS2: f64 = 10.0;
/// Share of a leap that the filter of the source itself must have seen.
const OWN_PART: f64 = 0.5;
/// Probability of steady motion below which a filter's predictions prove no leap.
const STEADY_MIN: f64 = 0.25;
/// Logarithm of the likelihood ratio of a target that stayed to one that moved: from which the point has leapt, and
/// below which the target has moved.
const STAYED: f64 = 1.0;
const MOVED: f64 = -4.0;
/// What one measurement can add to it: no single one decides.
const WITNESS_MAX: f64 = 3.0;
/// Measurements in a row that may wait for other sources.
const WAITING_MAX: u8 = 3;

/// Time within which most targets of a source leap together if the source has changed, nanoseconds, and time for which
/// no leaps of this source are looked for then.
const TOGETHER_NS: i64 = 2_000_000_000;
const STEP_NS: i64 = 30_000_000_000;

/// What the measurements of a sensor track show of leaps.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(crate) struct LeapWatch {
    /// Time of the latest measurement, nanoseconds, and how far it was from where it was expected, east and north,
    /// metres.
    latest_ns: i64,
    latest_m: [f32; 2],
    /// Distance of the first measurement that waits, and how many of them wait.
    leap_m: [f32; 2],
    waiting: u8,
    /// Logarithm of the likelihood ratio, from other sources, of a target that has stayed to one that has moved.
    stayed: f32,
}

impl LeapWatch {
    /// Whether measurements wait.
    pub(crate) fn is_waiting(&self) -> bool {
        self.waiting > 0
    }

    /// Takes in where another source's measurement of the target lies.
    fn hear(&mut self, seen: &Seen) {
        let leap_m = self.leap_m.map(f64::from);
        let along_m2 = leap_m[0] * seen.apart_m[0] + leap_m[1] * seen.apart_m[1];
        let ratio = (0.5 * square(leap_m) - along_m2) / seen.variance_m2;
        self.stayed += ratio.clamp(-WITNESS_MAX, WITNESS_MAX) as f32;
        if f64::from(self.stayed) < MOVED {
            self.waiting = 0;
        }
    }
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
    fn add(&mut self, now_ns: i64, targets: usize) {
        if now_ns - self.since_ns > TOGETHER_NS {
            (self.since_ns, self.count) = (now_ns, 0);
        }
        self.count += 1;
        if self.count >= 2 && 5 * self.count >= 3 * targets {
            self.until_ns = now_ns + STEP_NS;
        }
    }

    /// Whether the source has changed, not the points of its targets.
    pub(crate) fn has_changed(&self, now_ns: i64) -> bool {
        now_ns < self.until_ns
    }
}

/// What a measurement shows of its detection point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum PointMotion {
    /// The point is where it was.
    None,
    /// It may have leapt: the measurement cannot be used.
    Suspected,
    /// It has leapt, and is estimated anew.
    Leapt,
}

/// A measurement beside its prediction.
struct Seen {
    /// Distance from where the point was expected, east and north, metres.
    apart_m: [f64; 2],
    /// Variances per axis of the measurement, and of the distance, m².
    noise_m2: f64,
    variance_m2: f64,
}

impl ReferencePoints {
    /// Looks whether the detection point of a sensor track has leapt with its latest measurement.
    #[inline]
    pub(crate) fn look_for_leap(
        &mut self,
        settings: &Settings,
        tracks: &mut Tracks,
        (sensor, measurement): (SensorSlot, &Measurement),
        referred: &Referred,
    ) -> PointMotion {
        let entry = tracks.sensors.get_mut(sensor);
        let system = tracks.systems.get(entry.system);
        let place_m = system.filter.place_at(entry.time_ns);
        let seen = Seen {
            apart_m: std::array::from_fn(|axis| measurement.position_m[axis] - referred.point_m[axis] - place_m[axis]),
            noise_m2: measurement.variance_m2(),
            variance_m2: measurement.variance_m2() + referred.variance_m2 + system.filter.variance_m2(),
        };
        let before = entry.leap_watch;
        (entry.leap_watch.latest_ns, entry.leap_watch.latest_m) = (entry.time_ns, seen.apart_m.map(|way| way as f32));
        if square(seen.apart_m) <= LEAPS * seen.variance_m2 && !system.awaits_leap {
            return PointMotion::None;
        }
        self.judge_leap(settings, tracks, (sensor, measurement), (&seen, &before))
    }

    #[cold]
    fn judge_leap(
        &mut self,
        settings: &Settings,
        tracks: &mut Tracks,
        (sensor, measurement): (SensorSlot, &Measurement),
        (seen, before): (&Seen, &LeapWatch),
    ) -> PointMotion {
        let SensorEntry {
            system,
            source,
            time_ns,
            ..
        } = *tracks.sensors.get(sensor);
        if self.is_witness(tracks.sensors.get(sensor)) {
            tracks.for_members(system, |member| {
                if member.source != source && member.leap_watch.is_waiting() {
                    member.leap_watch.hear(seen);
                }
            });
        }
        let motion = if before.is_waiting() {
            self.confirm_leap(tracks, sensor, (seen, before))
        } else if !self.leaps[usize::from(source)].has_changed(time_ns)
            && self.may_leap(settings, tracks, (sensor, measurement), (seen, before))
        {
            let watch = &mut tracks.sensors.get_mut(sensor).leap_watch;
            (watch.leap_m, watch.waiting, watch.stayed) = (watch.latest_m, 1, 0.0);
            PointMotion::Suspected
        } else {
            PointMotion::None
        };
        let awaits = tracks
            .member_entries(system)
            .any(|(_, member)| member.leap_watch.is_waiting());
        tracks.systems.get_mut(system).awaits_leap = awaits;
        motion
    }

    /// Judges a measurement after one that may have been the first after a leap.
    fn confirm_leap(
        &mut self,
        tracks: &mut Tracks,
        sensor: SensorSlot,
        (seen, before): (&Seen, &LeapWatch),
    ) -> PointMotion {
        let watch = &mut tracks.sensors.get_mut(sensor).leap_watch;
        let leap_m = before.leap_m.map(f64::from);
        let change_m = std::array::from_fn(|axis| seen.apart_m[axis] - leap_m[axis]);
        let agrees = square(change_m) < FITS * 2.0 * seen.variance_m2;
        if !agrees || !watch.is_waiting() {
            watch.waiting = 0;
            return PointMotion::None;
        }
        if f64::from(watch.stayed) > STAYED || watch.waiting == WAITING_MAX {
            self.leap(tracks, sensor, leap_m, seen.noise_m2);
            return PointMotion::Leapt;
        }
        watch.waiting += 1;
        PointMotion::Suspected
    }

    /// Returns whether no motion of the target explains where the measurement lies, and another source still follows
    /// the target.
    fn may_leap(
        &self,
        settings: &Settings,
        tracks: &Tracks,
        (sensor, measurement): (SensorSlot, &Measurement),
        (seen, before): (&Seen, &LeapWatch),
    ) -> bool {
        let entry = tracks.sensors.get(sensor);
        let system = tracks.systems.get(entry.system);
        let seconds = (entry.time_ns - before.latest_ns) as f64 / NS_PER_S;
        let explained_m = 0.5 * ACCELERATION_MPS2 * seconds * seconds;
        let square_m2 = square(seen.apart_m);
        let size_m = settings.target_size.of(&entry.latest.target_type);
        let is_predicted = system.life == TrackState::Confirmed
            && system.filter.steadiness() > STEADY_MIN
            && entry.residuals >= MEAN_REPORTS_MIN
            && self.is_known(&entry.point)
            && square(before.latest_m.map(f64::from)) < LEAPS * seen.variance_m2;
        // Along the way from where the source's own filter expected the measurement.
        let own_part = |axis: usize| {
            let own_m = measurement.position_m[axis] - entry.latest.position_m[axis] + f64::from(entry.moved_m[axis]);
            own_m * seen.apart_m[axis] / square_m2
        };
        is_predicted
            && square_m2 > explained_m * explained_m + LEAPS * seen.variance_m2
            && square_m2 <= size_m * size_m
            && own_part(0) + own_part(1) > OWN_PART
            && self.is_followed_by_another(tracks, (entry.system, entry.source), entry.time_ns)
    }

    /// Whether a sensor track's measurements show where its target is.
    fn is_witness(&self, entry: &SensorEntry) -> bool {
        entry.residuals >= MEAN_REPORTS_MIN
            && !entry.is_led_off
            && !entry.leap_watch.is_waiting()
            && self.is_known(&entry.point)
    }

    fn is_followed_by_another(&self, tracks: &Tracks, (system, source): (SystemSlot, u16), now_ns: i64) -> bool {
        tracks
            .contributing_entries(system, now_ns)
            .any(|(_, other)| other.source != source && self.is_witness(other))
    }

    /// Notes that a detection point has leapt so far, east and north, metres. A point that is the reference point
    /// leaves it. Back among the others' points, with this variance per axis of its measurements, m², it is none.
    fn leap(&mut self, tracks: &mut Tracks, sensor: SensorSlot, by_m: [f64; 2], noise_m2: f64) {
        let entry = tracks.sensors.get_mut(sensor);
        let course = tracks.systems.get(entry.system).course;
        let (source, now_ns) = (entry.source, entry.time_ns);
        let before_m = match self.follows(&entry.point) {
            true => from_body(entry.point.offset_m, course),
            false => [0.0; 2],
        };
        let offset_m = std::array::from_fn(|axis| before_m[axis] + by_m[axis]);
        entry.point = self.unknown();
        if self.keeps_points() || square(offset_m) > FITS * 2.0 * noise_m2 {
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
        self.leaps[usize::from(source)].add(now_ns, tracks.sensors.count_of(source));
    }
}

fn square([east, north]: [f64; 2]) -> f64 {
    east * east + north * north
}
