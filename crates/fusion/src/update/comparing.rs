//! Comparison of reports of two sources on the same target, for the estimation of systematic errors.

use messages::{NS_PER_S, TrackState};
use source_models::{ComparedStates, Fact, Measurement, PairFact};

use crate::engine::Engine;
use crate::tables::sensor_tracks::{SensorEntry, SensorSlot};
use crate::tables::tracks::Tracks;

/// Number of samples of a source's systematic errors, and sampling interval beyond that number, in reports.
const REGISTRATION_SETTLED: [(f64, u32); 2] = [(1000.0, 16), (500.0, 8)];

impl Engine {
    /// Compares the report of a sensor track with the latest report of another source: the difference shows systematic
    /// errors.
    pub(crate) fn compare(&mut self, sensor: SensorSlot, measurement: Option<&Measurement>) {
        let (settings, tracks, known) = (&self.settings, &self.tracks, &self.tracks.sources);
        let entry = tracks.sensors.get(sensor);
        let (report, system) = (&entry.latest, entry.system);
        let source = report.source;
        let samples = known.errors(source).samples;
        let settled = REGISTRATION_SETTLED.iter().find(|(least, _)| samples > *least);
        let is_registered = |source: u16| settings.sources[usize::from(source)].is_registered;
        let is_apart = |entry: &SensorEntry| entry.point.stands_apart() || entry.leap_watch.is_waiting();
        if !(settings.registration.enabled && is_registered(source))
            || report.state != TrackState::Confirmed as u8
            || entry.repaired
            || entry.is_foreign
            || is_apart(entry)
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
            if member == sensor || !is_comparable || is_apart(other) {
                continue;
            }
            let key = (!known.is_young(other.source), other.time_ns, other.source);
            if latest.is_none_or(|(greatest, _)| key >= greatest) {
                latest = Some((key, member));
            }
        }
        let Some((_, other)) = latest else {
            return;
        };
        let Tracks {
            sensors,
            systems,
            sources,
            ..
        } = &mut self.tracks;
        let target = systems.get(system);
        let states = ComparedStates {
            own: sensors.get(sensor).stated(),
            measurement,
            other: sensors.get(other).stated(),
            reports: target.reports,
            age_s: (now_ns - target.first_seen_ns) as f64 / NS_PER_S,
        };
        sources.learn(&self.settings, Fact::Pair(PairFact::States(states)));
    }
}
