//! Comparison of reports of two sources on one target, from which systematic errors are estimated.

use estimation::AxisNoise;
use messages::{NS_PER_S, TrackState, sensor_track_bits};

use crate::measurement::Measurement;
use crate::registration::TargetView;
use crate::sensor_tracks::{SensorEntry, SensorSlot};
use crate::settings::{Settings, SourceSettings};
use crate::sources::{Sources, place_of};
use crate::tracks::Tracks;

/// Samples of a source's systematic errors after which only every few reports one is taken, and how many are few.
const REGISTRATION_SETTLED: [(f64, u32); 2] = [(1000.0, 16), (500.0, 8)];

impl Sources {
    /// Compares the report of a sensor track with the latest one of another source: systematic errors show in the
    /// difference.
    pub(crate) fn compare(
        &mut self,
        settings: &Settings,
        tracks: &Tracks,
        (sensor, measurement): (SensorSlot, Option<&Measurement>),
    ) {
        let entry = tracks.sensors.get(sensor);
        let (report, system) = (&entry.latest, entry.system);
        let source = report.source;
        let samples = self.registration.of(source).samples;
        let settled = REGISTRATION_SETTLED.iter().find(|(least, _)| samples > *least);
        let is_registered = |source: u16| settings.sources[usize::from(source)].is_registered;
        let has_leapt = |entry: &SensorEntry| entry.point.has_leapt || entry.leap_watch.is_waiting();
        if !(settings.registration.enabled && is_registered(source))
            || report.state != TrackState::Confirmed as u8
            || entry.repaired
            || entry.is_foreign
            || has_leapt(entry)
            || tracks.systems.get(system).life != TrackState::Confirmed
            || settled.is_some_and(|(_, every)| !entry.reports.is_multiple_of(*every))
        {
            return;
        }
        let now_ns = report.time_of_measurement_ns;
        let mut latest = None;
        for (member, other) in tracks.contributing_entries(system, now_ns) {
            let is_comparable =
                other.latest.state == TrackState::Confirmed as u8 && !other.is_foreign && is_registered(other.source);
            if member == sensor || !is_comparable || has_leapt(other) {
                continue;
            }
            let key = (!self.registration.is_young(other.source), other.time_ns, other.source);
            if latest.is_none_or(|(greatest, _)| key >= greatest) {
                latest = Some((key, member));
            }
        }
        let Some((_, other)) = latest else {
            return;
        };
        let view = |sensor| self.view(&settings.sources, tracks.sensors.get(sensor), now_ns);
        let (mut own, other) = (view(sensor), view(other));
        if self.registration.is_young(source)
            && let Some(measurement) = measurement
        {
            own.take_measurement(measurement, tracks.sensors.get(sensor).correction());
        } else if self.registration.is_young(other.source) && !self.registration.is_young(source) {
            return;
        }
        let extent_m = settings.association.extent_sigma_m;
        let points_m2 = self.possible_points_m2(extent_m * extent_m);
        let entry = tracks.systems.get(system);
        let reports = f64::from(entry.reports) / self.models.len() as f64;
        let age_s = (now_ns - entry.first_seen_ns) as f64 / NS_PER_S;
        self.registration.learn(&own, &other, points_m2, (reports, age_s));
    }

    /// A sensor track as its source gives it, at `time_ns`.
    fn view(&self, sources: &[SourceSettings], entry: &SensorEntry, time_ns: i64) -> TargetView {
        let source = entry.latest.source;
        let seconds = (time_ns - entry.latest.time_of_measurement_ns) as f64 / NS_PER_S;
        let mut state = entry.as_reported();
        if seconds != 0.0 {
            let motion = self.manoeuvres.motion(entry.latest.velocity_mps);
            let noise = motion.turns.density_m2ps3;
            state.advance(seconds, noise.map(|density| AxisNoise::white(density, seconds)));
        }
        TargetView {
            source,
            position_m: state.position_m(),
            covariance_m2: state.position_covariance(),
            velocity_mps: state.velocity_mps(),
            has_velocity: entry.latest.has(sensor_track_bits::VELOCITY),
            has_height: entry.latest.has(sensor_track_bits::HEIGHT),
            place_m: place_of(&sources[usize::from(source)]),
        }
    }
}
