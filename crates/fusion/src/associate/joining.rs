//! Joining of a sensor track to its system track: at once, with its scan, or as a new target.

use messages::{Counter, DecisionKind, SensorTrack, TrackState};
use source_models::whole_report;

use crate::associate::association_step::Search;
use crate::associate::linking::{Linking, Next};
use crate::associate::scan::ScanAssignment;
use crate::engine::Engine;
use crate::explanation::Sink;
use crate::judge::life;
use crate::tables::sensor_tracks::{NO_SYSTEM, Role, SensorSlot};
use crate::tables::system_tracks::SystemSlot;

impl Engine {
    /// Associates a sensor track, whose `report` has just been stored, with a system track.
    pub(crate) fn associate(&mut self, sensor: SensorSlot, report: &SensorTrack, sink: &mut impl Sink) {
        let out = &mut self.outbox.to(sink);
        let mut linking = Linking {
            settings: &self.settings,
            tracks: &mut self.tracks,
        };
        let next = linking.associate(sensor, report, out);
        self.follow_up(sensor, next, sink);
    }

    /// Executes the step that linking leaves to the engine: none, a wait for the scan, or the end of a merged track.
    pub(crate) fn follow_up(&mut self, sensor: SensorSlot, next: Next, sink: &mut impl Sink) {
        match next {
            Next::Done => {}
            Next::Wait => self.wait_for_scan(sensor, sink),
            Next::End(merged) => {
                let out = &mut self.outbox.to(sink);
                let (ended, into) = (merged.ended, merged.into);
                life::end(&self.settings, &mut self.tracks, ended, merged.time_ns, into, out);
            }
        }
    }

    /// Queues a sensor track until its scan is complete.
    pub(crate) fn wait_for_scan(&mut self, sensor: SensorSlot, sink: &mut impl Sink) {
        let entry = self.tracks.sensors.get_mut(sensor);
        // A clock that is ahead must not delay the scan; the reports of a late scan arrive late as well.
        let late_ns = self.tracks.sources.late_ns(entry.source);
        let time_ns = entry.time_ns.saturating_add(late_ns).min(self.schedule.now_ns());
        let source = entry.source;
        if std::mem::replace(&mut entry.waits, true) {
            return;
        }
        if self.scans.is_full(source) {
            self.assign_scan(source, sink);
        }
        self.scans.wait(sensor, source, time_ns);
    }

    /// Assigns the scans that are complete at `time_ns`.
    pub(crate) fn finish_scans(&mut self, time_ns: i64, sink: &mut impl Sink) {
        while let Some(source) = self.scans.complete_at(time_ns) {
            self.assign_scan(source, sink);
        }
    }

    pub(crate) fn assign_scan(&mut self, source: u16, sink: &mut impl Sink) {
        let rows = self.scans.assign(source, &self.settings, &mut self.tracks);
        for row in 0..rows {
            let assigned = self.scans.assigned(row);
            // The sensor track may have ended while queued.
            if std::mem::take(&mut self.tracks.sensors.get_mut(assigned.sensor).waits) {
                self.place_assigned(assigned, sink);
            }
        }
    }

    /// Places a sensor track as the assignment of its scan decides.
    pub(crate) fn place_assigned(&mut self, ScanAssignment { sensor, best }: ScanAssignment, sink: &mut impl Sink) {
        let is_unlinked = self.tracks.sensors.get(sensor).system == NO_SYSTEM;
        // The system track may have ended since, merged by another sensor track of this scan.
        let lives = |system: SystemSlot| self.tracks.systems.get(system).life != TrackState::Terminated;
        match best.filter(|(system, _)| lives(*system)) {
            Some((system, d2)) if is_unlinked => self.join_assigned(sensor, system, d2, sink),
            Some((system, d2)) => self.vote_to_merge(sensor, system, d2, sink),
            None if is_unlinked => self.place_alone(sensor, sink),
            None => self.stay_alone(sensor, sink),
        }
    }

    pub(crate) fn join_assigned(&mut self, sensor: SensorSlot, system: SystemSlot, d2: f64, sink: &mut impl Sink) {
        self.tracks.join(sensor, system);
        let gate = self.settings.association.scan_gate();
        sink.decision(&self.tracks.decision(sensor, DecisionKind::Joined, d2, gate));
        self.tracks.assign_role(sensor);
        let entry = self.tracks.sensors.get(sensor);
        if entry.role == Role::Primary {
            let report = entry.latest;
            let mut whole = whole_report(&report);
            whole.has_waited = true;
            self.update(sensor, &report, Some(&whole), sink);
        }
    }

    pub(crate) fn vote_to_merge(&mut self, sensor: SensorSlot, system: SystemSlot, d2: f64, sink: &mut impl Sink) {
        let out = &mut self.outbox.to(sink);
        let mut linking = Linking {
            settings: &self.settings,
            tracks: &mut self.tracks,
        };
        if let Some(next) = linking.vote_to_merge(sensor, system, d2, out) {
            self.follow_up(sensor, next, sink);
            self.tracks.assign_role(sensor);
        }
    }

    /// Keeps a sensor track that fits no other system track where it is alone, unless another system track is of its
    /// target.
    fn stay_alone(&mut self, sensor: SensorSlot, sink: &mut impl Sink) {
        let entry = self.tracks.sensors.get_mut(sensor);
        entry.competing = None;
        let (system, now_ns) = (entry.system, entry.time_ns);
        let out = &mut self.outbox.to(sink);
        let mut linking = Linking {
            settings: &self.settings,
            tracks: &mut self.tracks,
        };
        let next = linking.look_for_other_point(system, now_ns, out);
        if next != Next::Done {
            self.follow_up(sensor, next, sink);
            self.tracks.assign_role(sensor);
        }
    }

    /// The resting, never shown system track of a former sensor track with this number, if it may still be the same.
    fn former_tentative(&mut self, sensor: SensorSlot) -> Option<SystemSlot> {
        let mut linking = Linking {
            settings: &self.settings,
            tracks: &mut self.tracks,
        };
        let (system, _) = linking.recall(sensor, true)?;
        (self.tracks.systems.get(system).life == TrackState::Suspended).then_some(system)
    }

    /// Places a sensor track that fits no available system track. The track is either a further part of a target that
    /// its source already tracks, or a new target.
    pub(crate) fn place_alone(&mut self, sensor: SensorSlot, sink: &mut impl Sink) {
        let search = Search {
            settings: &self.settings,
            tracks: &self.tracks,
        };
        if let Some((system, metres)) = search.other_part(sensor) {
            self.tracks.join(sensor, system);
            let limit = self.settings.association.target_extent_m;
            sink.decision(&self.tracks.decision(sensor, DecisionKind::Duplicate, metres, limit));
            let source = self.tracks.sensors.get(sensor).source;
            self.outbox.counts.add(source, Counter::RejectedDuplicate);
            return;
        }
        if !self.tracks.is_established(sensor) {
            // A first report alone may join a target, but does not start a target.
            return;
        }
        let report = self.tracks.sensors.get(sensor).latest;
        if let Some(system) = self.former_tentative(sensor) {
            self.tracks.join(sensor, system);
            self.resume_number(sensor, &report, sink);
            return;
        }
        if !self.tracks.systems.has_room(report.source) {
            self.make_room(report.source, sink);
        }
        let out = &mut self.outbox.to(sink);
        let mut linking = Linking {
            settings: &self.settings,
            tracks: &mut self.tracks,
        };
        let deadline_ns = self.life.first_deadline_ns(report.time_of_measurement_ns);
        if linking.start(sensor, deadline_ns, out) {
            out.input(|| self.tracks.input(sensor, None));
            self.update(sensor, &report, None, sink);
        }
    }
}
