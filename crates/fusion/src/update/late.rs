//! Late reports: used at the time of measurement, or carried forward.
//!
//! A report older than the state of the system track is *late*. Within the window of late reports, the filter uses the
//! report at the time of measurement, see [`kept_measurements`](super::kept_measurements): the state becomes the state
//! in the order of measurement. Associations are not decided again, and applied corrections of sources' errors stay.
//! Learning uses each report once, at arrival: accuracy of sources, motion and existence of targets.
//!
//! A report older than the latest report of the same sensor track was *overtaken*. The measurement in an overtaken
//! report follows from the preceding report. The following report was taken for the successor of the preceding report:
//! the measurement is recovered anew, and replaces the former. Without the preceding report, an overtaken report
//! contains no new information: the later report contains its information.
//!
//! A sensor track that waited for the end of the scan came in time, and is not late.

use messages::{Counter, NS_PER_S, SensorTrack, TrackState, sensor_track_bits};
use source_models::{Fact, FilterInnovation, Measurement, Referred, ReportFact, gaussian_of, place_of};

use crate::engine::Engine;
use crate::explanation::Sink;
use crate::tables::sensor_tracks::{NO_SYSTEM, Role, SensorSlot};
use crate::tables::system_tracks::SystemSlot;
use crate::update::assumed::assumed_of;
use crate::update::filter_input::FilterInput;
use crate::update::kept_measurement::KeptMeasurement;
use crate::update::kept_measurements::{Lateness, Place};
use crate::update::reference_point;

impl Engine {
    /// Learns the lateness of a source's reports.
    #[inline]
    pub(crate) fn learn_lateness(&mut self, report: &SensorTrack, now_ns: i64) {
        let late_ns = now_ns.saturating_sub(report.time_of_measurement_ns);
        // Later reports count for little, and a wrong clock is not late.
        let late_ns = late_ns.clamp(0, self.settings.late_window_ns());
        self.tracks.sources.learn(
            &self.settings,
            Fact::Report(ReportFact::Late {
                source: report.source,
                late_ns,
            }),
        );
    }

    /// Updates the filter with the late measurement in the latest report of a sensor track, at the time of measurement.
    /// If impossible, the measurement is carried forward, and counted.
    #[cold]
    pub(crate) fn take_late_or_carry(
        &mut self,
        sensor: SensorSlot,
        relative: &Measurement,
        referred: &Referred,
    ) -> Option<FilterInnovation> {
        let entry = self.tracks.sensors.get(sensor);
        let system = entry.system;
        let kept = reference_point::used(referred, entry, relative).kept();
        let taken = self.take_late(system, &kept, None);
        if taken.is_some() {
            return taken;
        }
        let filter = &mut self.tracks.systems.get_mut(system).filter;
        let counter = match self.tracks.kept.lateness(system, filter.time_ns, kept.time_ns) {
            Lateness::BeyondWindow => Counter::LateBeyondWindow,
            _ => Counter::LateUnkept,
        };
        self.outbox.counts.add(kept.track.0, counter);
        self.tracks.kept.begin(system, filter);
        let innovation = kept.use_in(filter, |filter| self.tracks.sources.motion(filter.velocity_mps()));
        self.tracks.kept.append_kept(system, filter, &kept);
        innovation
    }

    /// Updates the filter with a late measurement at the time of measurement; `None`, without any change, if
    /// impossible.
    fn take_late(
        &mut self,
        system: SystemSlot,
        kept: &KeptMeasurement,
        successor: Option<(Place, Measurement)>,
    ) -> Option<FilterInnovation> {
        let sources = &self.tracks.sources;
        let filter = &mut self.tracks.systems.get_mut(system).filter;
        let late = &mut self.tracks.kept;
        if late.lateness(system, filter.time_ns, kept.time_ns) != Lateness::Kept {
            return None;
        }
        let innovation = late.insert(system, filter, (kept, successor), |filter| {
            sources.motion(filter.velocity_mps())
        })?;
        self.outbox.counts.add(kept.track.0, Counter::LateUsed);
        // The time since the preceding measurement was learned from the following measurement.
        Some(FilterInnovation {
            straight_s: 0.0,
            begins_turn: false,
            ..innovation
        })
    }

    /// Uses an overtaken report; `false`, without any change, if the report was not overtaken or cannot be used.
    #[inline]
    pub(crate) fn take_overtaken(&mut self, sensor: SensorSlot, report: &SensorTrack, sink: &mut impl Sink) -> bool {
        report.time_of_measurement_ns < self.tracks.sensors.get(sensor).time_ns && self.overtaken(sensor, report, sink)
    }

    #[cold]
    fn overtaken(&mut self, sensor: SensorSlot, report: &SensorTrack, sink: &mut impl Sink) -> bool {
        let entry = self.tracks.sensors.get(sensor);
        let system = entry.system;
        let contributes = system != NO_SYSTEM && entry.role == Role::Primary && !entry.is_foreign;
        if !contributes || report.state == TrackState::Terminated as u8 {
            return false;
        }
        let Some((kept, successor)) = self.recover_overtaken(sensor, report) else {
            return false;
        };
        let Some(innovation) = self.take_late(system, &kept, successor) else {
            return false;
        };
        if !innovation.gain.is_finite() {
            return true;
        }
        self.tracks
            .for_members(system, |member| member.share *= 1.0 - innovation.gain);
        let entry = self.tracks.sensors.get_mut(sensor);
        entry.share += innovation.gain;
        entry.reports = entry.reports.saturating_add(1);
        self.pass_on_overtaken(system, &kept, successor, sink);
        self.count_overtaken(system, report.source);
        let out = &mut self.outbox.to(sink);
        let cause = (system, report);
        self.publisher.refresh(&self.settings, &mut self.tracks, cause, out);
        true
    }

    /// Passes on an overtaken measurement, and the present value of the following measurement.
    fn pass_on_overtaken(
        &mut self,
        system: SystemSlot,
        overtaken: &KeptMeasurement,
        successor: Option<(Place, Measurement)>,
        sink: &mut impl Sink,
    ) {
        let number = self.tracks.systems.get(system).number;
        let assumed = assumed_of(system, &self.tracks, &self.publisher);
        let kept = &self.tracks.kept;
        let mut out = self.outbox.to(sink);
        if overtaken.is_used {
            out.input(|| overtaken.input(number, assumed));
        }
        if let Some(later) = successor.map(|(place, _)| kept.at(place)).filter(|later| later.is_used) {
            out.input(|| FilterInput {
                replaces: true,
                ..later.input(number, assumed)
            });
        }
    }

    /// Counts an overtaken report that a system track has used.
    fn count_overtaken(&mut self, system: SystemSlot, source: u16) {
        let entry = self.tracks.systems.get_mut(system);
        entry.reports = entry.reports.saturating_add(1);
        if entry.life == TrackState::Confirmed {
            self.tracks.sources.learn(
                &self.settings,
                Fact::Scan {
                    source,
                    is_detected: true,
                },
            );
        }
        let [x, y, _] = entry.filter.estimate.position_m();
        self.tracks.systems.grid.place(system, x, y);
    }

    /// Recovers the measurements in an overtaken report and in the following report.
    fn recover_overtaken(
        &self,
        sensor: SensorSlot,
        report: &SensorTrack,
    ) -> Option<(KeptMeasurement, Option<(Place, Measurement)>)> {
        let entry = self.tracks.sensors.get(sensor);
        let (source, time_ns) = (entry.source, report.time_of_measurement_ns);
        let track = (source, entry.track_number);
        let place_m = place_of(&self.settings.sources[usize::from(source)]);
        let shown = (source, &entry.evidence, place_m);
        let kept = &self.tracks.kept;
        let (before, after) = kept.around(entry.system, track, time_ns)?;
        let seconds = |from_ns: i64, to_ns: i64| (to_ns - from_ns) as f64 / NS_PER_S;
        let (own, has_height) = (gaussian_of(report), report.has(sensor_track_bits::HEIGHT));
        let earlier = (
            &before.correction.undone(before.state),
            seconds(before.time_ns, time_ns),
        );
        let mut measurement = self
            .tracks
            .sources
            .measurement_between(shown, earlier, (&own, has_height))?;
        let correction = self.tracks.sources.correction_of(&self.settings.sources, report);
        measurement.correct(&correction);
        let referred = reference_point::known(&self.tracks, sensor, &measurement);
        measurement.refer(referred.point_m, referred.variance_m2);
        let successor = after.and_then(|place| {
            let after = kept.at(place);
            let earlier = (&own, seconds(time_ns, after.time_ns));
            let later = (&after.correction.undone(after.state), after.has_height);
            let mut measurement = self.tracks.sources.measurement_between(shown, earlier, later)?;
            measurement.correct(&after.correction);
            measurement.refer(after.point_m, after.point_m2);
            Some((place, measurement))
        });
        let kept = KeptMeasurement {
            time_ns,
            track,
            measurement,
            is_used: referred.is_usable,
            state: correction.made(own),
            has_height,
            correction,
            point_m: referred.point_m,
            point_m2: referred.variance_m2,
        };
        Some((kept, successor))
    }
}
