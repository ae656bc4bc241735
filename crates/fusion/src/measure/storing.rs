//! Reports into their sensor tracks, each with the measurement behind the report.

use messages::{Counter, NS_PER_S, SensorTrack, TrackState};
use source_models::{Content, Correction, Fact, Measurement, ReportFact, place_of};

use crate::admit::inlet;
use crate::associate::association_step::Search;
use crate::engine::Engine;
use crate::tables::sensor_tracks::{NO_SYSTEM, SensorSlot};

impl Engine {
    /// Stores a report, free of the source's known errors, as the latest of its sensor track. Returns the sensor track
    /// and the new measurement in the report; `None` if the report is out of order or the table is full.
    pub(crate) fn store(
        &mut self,
        report: &SensorTrack,
        known: Option<SensorSlot>,
        repaired: bool,
    ) -> Option<(SensorSlot, Option<Measurement>)> {
        let (identity, conflict) = if self.settings.association.use_identity {
            inlet::believed_identity(report, &self.tracks.systems)
        } else {
            (report.identity, None)
        };
        if let Some(counter) = conflict {
            self.outbox.counts.add(report.source, counter);
        }
        let earlier = self.earlier(report, known)?;
        let before = earlier.map(|(sensor, seconds)| (self.tracks.sensors.get(sensor).earlier(), seconds));
        let before = before.as_ref().map(|(before, seconds)| (before, *seconds));
        let is_foreign = self.settings.sources[usize::from(report.source)].is_centre;
        // The state is the only content of a centre's report, and the newest state replaces the previous state.
        let (mut content, mut correction) = (Content::none(), Correction::NONE);
        if !is_foreign {
            let goes_on = before.is_none() && self.tracks.goes_on(report.source, report.track_number);
            let place_m = place_of(&self.settings.sources[usize::from(report.source)]);
            self.tracks
                .sources
                .read_content(report, (before, goes_on), (repaired, place_m), &mut content);
            correction = self.tracks.sources.correction_of(&self.settings.sources, report);
        }
        let sensors = &mut self.tracks.sensors;
        let place = earlier.map(|(sensor, _)| sensor).or_else(|| sensors.insert(report));
        let Some(sensor) = place else {
            self.outbox.counts.add(report.source, Counter::DroppedTable);
            return None;
        };
        let identity = match self.settings.association.use_identity {
            true => sensors.believe(sensor, report, identity),
            false => identity,
        };
        let entry = sensors.get_mut(sensor);
        entry.take(report, identity, &correction, &content);
        entry.repaired = repaired;
        entry.is_foreign = is_foreign;
        entry.epoch = self.tracks.sources.epoch_of(report.source);
        sensors.note(sensor, self.settings.sources[usize::from(report.source)].period_ns);
        if let Some(measurement) = &mut content.measurement {
            measurement.correct(&correction);
        }
        Some((sensor, content.measurement))
    }

    /// Returns the entry of the report's sensor track and the seconds since the latest report; `Some(None)` if there is
    /// no entry yet; `None` if the report is older.
    fn earlier(&mut self, report: &SensorTrack, known: Option<SensorSlot>) -> Option<Option<(SensorSlot, f64)>> {
        let time_ns = report.time_of_measurement_ns;
        if known.is_none() && self.is_outdated(report) {
            self.outbox.counts.add(report.source, Counter::RejectedClock);
            return None;
        }
        let source = (
            report.source,
            self.settings.sources[usize::from(report.source)].period_ns,
        );
        self.tracks.sources.learn(
            &self.settings,
            Fact::Report(ReportFact::Timed {
                source,
                time_ns,
                is_first: known.is_none(),
            }),
        );
        let Some(sensor) = known else {
            self.tracks.sources.learn(
                &self.settings,
                Fact::Report(ReportFact::Follows {
                    source: report.source,
                    time_ns,
                    since_ns: None,
                }),
            );
            return Some(None);
        };
        let age_ns = time_ns - self.tracks.sensors.get(sensor).time_ns;
        let ends = report.state == TrackState::Terminated as u8;
        if age_ns < 0 || (age_ns == 0 && !ends) {
            self.outbox.counts.add(report.source, Counter::RejectedOutOfOrder);
            return None;
        }
        let is_over = age_ns > self.tracks.sources.silence_ns(report.source) && age_ns > self.tracks.silence_ns(sensor);
        if is_over || self.is_reused(sensor, report, age_ns) {
            // The source has reused the number for another target.
            self.tracks.drop_sensor_track(sensor);
            return Some(None);
        }
        self.tracks.sources.learn(
            &self.settings,
            Fact::Report(ReportFact::Follows {
                source: report.source,
                time_ns,
                since_ns: Some(age_ns),
            }),
        );
        let system = self.tracks.sensors.get(sensor).system;
        // The gaps of a slow target are no property of the source.
        if system == NO_SYSTEM || !self.tracks.systems.get(system).rhythm.is_slow() {
            self.tracks.sources.learn(
                &self.settings,
                Fact::Report(ReportFact::Gap {
                    source: report.source,
                    gap_ns: age_ns,
                }),
            );
        }
        Some(Some((sensor, age_ns as f64 / NS_PER_S)))
    }

    /// Returns whether a report is older than the lifetime of a track without further reports. Extrapolated to the
    /// present, such a report would fit any target.
    #[inline]
    fn is_outdated(&self, report: &SensorTrack) -> bool {
        let sources = &self.tracks.sources;
        let longest_ns = sources.silence_ns(report.source) + sources.fresh_ns(report.source);
        self.schedule.now_ns().saturating_sub(report.time_of_measurement_ns) > longest_ns
    }

    /// Returns whether a sensor that has begun anew gave the number of a sensor track to another target.
    #[inline]
    fn is_reused(&self, sensor: SensorSlot, report: &SensorTrack, age_ns: i64) -> bool {
        let period_ns = self.settings.sources[usize::from(report.source)].period_ns;
        let search = Search {
            settings: &self.settings,
            tracks: &self.tracks,
        };
        2 * age_ns > 3 * period_ns && search.is_of_another(sensor, report)
    }
}
