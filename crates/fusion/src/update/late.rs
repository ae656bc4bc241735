//! Reports that come late: used in their place, or carried forward.
//!
//! A report older than its track's state is *late*. Within the window of late reports it is used where it belongs, see
//! [`kept_measurements`](super::kept_measurements): the state becomes that of the order of measurement. Associations
//! are not decided again, and known errors of sources stay as they were taken off. A later report carries more than its
//! time: what sources are worth, how targets move and whether they exist is learned from each report once, as it comes.
//!
//! A report can be older than the latest of its own sensor track: it was *overtaken*. Its measurement follows from the
//! report before it. The report after it was taken for the successor of the one before: its measurement is recovered
//! anew, and used in place of the former. Without the report before it, an overtaken report has nothing new: the later
//! report contains it.
//!
//! A sensor track that waited for the end of its scan is not late: it came in time.

use messages::{Counter, NS_PER_S, SensorTrack, TrackState, sensor_track_bits};
use source_models::{Fact, FilterInnovation, Measurement, Referred, ReportFact, gaussian_of};

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
    /// Learns how late the reports of a source are.
    #[inline]
    pub(crate) fn learn_lateness(&mut self, report: &SensorTrack, now_ns: i64) {
        let late_ns = now_ns.saturating_sub(report.time_of_measurement_ns);
        // Later ones count for little, and a wrong clock is not late.
        let late_ns = late_ns.clamp(0, self.settings.late_window_ns());
        self.tracks.sources.learn(
            &self.settings,
            Fact::Report(ReportFact::Late {
                source: report.source,
                late_ns,
            }),
        );
    }

    /// Lets the filter use the late measurement in the latest report of a sensor track in its place. A measurement that
    /// cannot be used so is carried forward, and counted.
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

    /// Lets the filter use a late measurement in its place; `None`, and nothing changes, if that cannot be.
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
        // The time since the measurement before was learned from the one after.
        Some(FilterInnovation {
            straight_s: 0.0,
            begins_turn: false,
            ..innovation
        })
    }

    /// Uses a report that a later one of its sensor track has overtaken; `false`, and nothing changes, if the report is
    /// none, or cannot be used.
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

    /// Passes on an overtaken measurement, and the one after it as it is now.
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
        if let Some((place, _)) = successor
            && kept.at(place).is_used
        {
            out.input(|| FilterInput {
                replaces: true,
                ..kept.at(place).input(number, assumed)
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

    /// The measurement in an overtaken report, and that in the report after it.
    fn recover_overtaken(
        &self,
        sensor: SensorSlot,
        report: &SensorTrack,
    ) -> Option<(KeptMeasurement, Option<(Place, Measurement)>)> {
        let entry = self.tracks.sensors.get(sensor);
        let (source, time_ns) = (entry.source, report.time_of_measurement_ns);
        let track = (source, entry.track_number);
        let shown = (source, &entry.evidence);
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
