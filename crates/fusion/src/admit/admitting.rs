//! Selection of reports that may move a track: not contradicted by other reports of the target (module `credibility`).

use messages::{Counter, TrackState};
use source_models::{
    AGREES, CONTRADICTS, Fact, InnovationFact, Measurement, Nearness, PairFact, apart, distance_from, from_body,
};

use crate::engine::Engine;
use crate::tables::sensor_tracks::{Role, SensorEntry, SensorSlot};
use crate::tables::tracks::Tracks;

/// d² in the plane of a report from a fitting track: beyond in 5 % by chance.
const FITS: f64 = 6.0;
/// Share in a filter of a source set aside, from which the filter restarts.
const MISLEADS_FROM: f64 = 0.05;

impl Engine {
    /// Excludes a sensor track contradicted by other sources from the estimate. The reports are still compared with the
    /// reports of the other sources.
    #[cold]
    pub(crate) fn set_aside(&mut self, sensor: SensorSlot, measurement: Option<&Measurement>) {
        let entry = self.tracks.sensors.get_mut(sensor);
        entry.role = Role::SetAside;
        let source = entry.source;
        self.outbox.counts.add(source, Counter::RejectedContradicted);
        if let Some(measurement) = measurement {
            self.learn_of_contradiction(sensor, measurement);
        }
        self.compare(sensor, measurement);
    }

    /// Lets the models learn from an unused measurement, contradicted by other sources.
    fn learn_of_contradiction(&mut self, sensor: SensorSlot, measurement: &Measurement) {
        let entry = self.tracks.sensors.get(sensor);
        let target = self.tracks.systems.get(entry.system);
        if !self.settings.registration.enabled || target.life != TrackState::Confirmed {
            return;
        }
        let [x, y, _] = target.filter.place_at(entry.time_ns);
        let residual_m = [measurement.position_m[0] - x, measurement.position_m[1] - y];
        let known = &target.filter.estimate.covariance;
        let [xx, xy, _, yy, ..] = measurement.covariance_m2;
        let covariance_m2 = [xx + known.get(0, 0), xy + known.get(0, 1), yy + known.get(1, 1)];
        self.tracks.sources.learn(
            &self.settings,
            Fact::Innovation(InnovationFact::Contradicted {
                source: entry.source,
                target: entry.system,
                place_m: [x, y],
                velocity_mps: entry.latest.velocity_mps,
                residual: (residual_m, covariance_m2),
            }),
        );
    }

    /// Whether the latest report of a sensor track may be used.
    #[inline]
    pub(crate) fn admits(&mut self, sensor: SensorSlot) -> bool {
        let Tracks {
            sensors,
            systems,
            sources,
            ..
        } = &mut self.tracks;
        let entry = sensors.get(sensor);
        let target = systems.get(entry.system);
        let [mut x, mut y, _] = target.filter.place_at(entry.time_ns);
        if entry.point.stands_apart() {
            let [east_m, north_m] = from_body(entry.point.offset_m, target.course);
            (x, y) = (x + east_m, y + north_m);
        }
        match sources.nearness(&self.settings.association, (&entry.latest, [x, y])) {
            Nearness::Exempt => true,
            Nearness::Near => {
                let source = entry.source;
                sources.learn(&self.settings, Fact::Pair(PairFact::Near { source }));
                true
            }
            Nearness::Far { spread_m2 } => self.admits_beside_others(sensor, spread_m2),
        }
    }

    /// The same by comparison with the other sources of its target.
    #[cold]
    fn admits_beside_others(&mut self, sensor: SensorSlot, spread_m2: f64) -> bool {
        let (tracks, entry) = (&self.tracks, self.tracks.sensors.get(sensor));
        let others = || {
            let others = tracks.contributing_entries(entry.system, entry.time_ns);
            let of_others =
                |other: &&SensorEntry| !other.is_foreign && other.source != entry.source && !other.point.stands_apart();
            others
                .map(|(_, other)| other)
                .filter(of_others)
                .map(|other| &other.latest)
        };
        let judgement = tracks.sources.judge(&entry.latest, spread_m2, others);
        if judgement.is_open() && tracks.sources.others_can_decide() && yields(tracks, sensor, spread_m2) {
            return false;
        }
        let sources = &mut self.tracks.sources;
        sources.learn(&self.settings, Fact::Pair(PairFact::Judged(&judgement)));
        sources.admits(&judgement)
    }

    /// Whether a filter was misled by a source now set aside, or leads the target off, and must restart. If the report
    /// fits the filter, the source's share dates from before the source's error.
    #[inline]
    pub(crate) fn is_misled(&self, sensor: SensorSlot) -> bool {
        let (tracks, sources) = (&self.tracks, &self.tracks.sources);
        let entry = tracks.sensors.get(sensor);
        (sources.sets_aside() || tracks.systems.get(entry.system).has_led_off) && {
            let is_off = |entry: &SensorEntry| sources.is_set_aside(entry.source) || entry.is_led_off;
            let misleads = |entry: &SensorEntry| is_off(entry) && entry.share > MISLEADS_FROM;
            !is_off(entry)
                && distance_from(expected_m(tracks, entry), &entry.latest, 0.0) > FITS
                && tracks.member_entries(entry.system).any(|(_, member)| misleads(member))
        }
    }
}

/// Expected place of the target of a sensor track at the time of the latest report, metres.
#[inline]
fn expected_m(tracks: &Tracks, entry: &SensorEntry) -> [f64; 2] {
    let [x, y, _] = tracks.systems.get(entry.system).filter.place_at(entry.time_ns);
    [x, y]
}

/// Whether to omit the report of a sensor track joined to its system track by name alone. Such a report contradicts
/// another report with a larger share in the estimate, and no report agrees. Between two places separated by a bias,
/// the estimate would jump to and fro.
fn yields(tracks: &Tracks, sensor: SensorSlot, spread_m2: f64) -> bool {
    let entry = tracks.sensors.get(sensor);
    let mut contradicts_stronger = false;
    for (member, other) in tracks.member_entries(entry.system) {
        let is_fresh = tracks.is_fresh(other, entry.time_ns);
        if member == sensor || other.is_foreign || other.source == entry.source || !is_fresh {
            continue;
        }
        let d2 = apart(&entry.latest, &other.latest, spread_m2);
        if d2 <= AGREES {
            return false;
        }
        let is_stronger = other.role == Role::Primary && other.share > entry.share;
        contradicts_stronger |= d2 > CONTRADICTS && is_stronger && entry.names.meet(&other.names);
    }
    contradicts_stronger
}
