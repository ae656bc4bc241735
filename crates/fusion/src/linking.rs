//! To which system track a sensor track belongs: joining, leaving, moving (TI-3, QF-3, BF-2).
//!
//! A sensor track stays with its system track, and leaves it only when
//! - its identity says so: an address belongs to exactly one system track, and the other way round;
//! - its innovations keep missing the others' to one side (a wrong join, or the sensor has swapped targets);
//! - it, or the whole system track it is in, keeps agreeing with another one that has none of its sources (one target
//!   that was started twice).

use estimation::PackedGaussian;
use messages::{Counter, SensorTrack, TrackState};

use crate::engine::Engine;
use crate::explanation::{Decision, DecisionKind, Sink};
use crate::filter::Filter;
use crate::sensor_tracks::{NO_SYSTEM, Role, SensorSlot};
use crate::system_tracks::{SystemEntry, SystemSlot};

/// Time between two looks for a twin of one system track, nanoseconds.
const TWIN_EVERY_NS: i64 = 1_000_000_000;

impl Engine {
    /// Finds out to which system track the sensor track belongs now.
    pub(crate) fn relate(&mut self, sensor: SensorSlot, report: &SensorTrack, sink: &mut impl Sink) {
        if self.sensors.get(sensor).system == NO_SYSTEM {
            self.place_new(sensor, sink);
        } else {
            self.reconsider(sensor, report, sink);
        }
    }

    /// An address says at once where a sensor track belongs; the others wait until their scan is complete.
    fn place_new(&mut self, sensor: SensorSlot, sink: &mut impl Sink) {
        let address = self.sensors.get(sensor).latest.identity.unique_number();
        let known = address
            .filter(|_| self.settings.association.use_identity)
            .and_then(|address| self.systems.with_address(address));
        if let Some(system) = known {
            self.join(sensor, system);
            self.decide(sensor, DecisionKind::JoinedByAddress, f64::NAN, f64::NAN, sink);
        } else if self.search().is_established(sensor) {
            self.wait_for_scan(sensor, sink);
        }
    }

    /// Starts a system track from a sensor track.
    pub(crate) fn start_system_track(&mut self, sensor: SensorSlot, sink: &mut impl Sink) {
        let report = self.sensors.get(sensor).latest;
        let has_height = report.has(messages::sensor_track_bits::HEIGHT);
        let state = PackedGaussian::new(report.position_m, report.velocity_mps, &report.covariance);
        let filter = Filter::new(report.time_of_measurement_ns, state, has_height);
        let deadline_ns = report.time_of_measurement_ns + self.shortest_fresh_ns;
        let Some(system) = self.systems.insert(filter, deadline_ns) else {
            self.counts.add(report.source, Counter::DroppedTable);
            return;
        };
        self.counts.add(report.source, Counter::TracksStarted);
        self.join(sensor, system);
        self.sensors.get_mut(sensor).share = 1.0;
        self.decide(sensor, DecisionKind::Started, f64::NAN, f64::NAN, sink);
        self.assign_role(sensor);
        self.contribute(sensor, &report, None, sink);
    }

    /// Links an unlinked sensor track to `system`.
    pub(crate) fn join(&mut self, sensor: SensorSlot, system: SystemSlot) {
        self.systems.link(&mut self.sensors, sensor, system);
        let entry = self.sensors.get_mut(sensor);
        entry.role = Role::Duplicate;
        entry.forget_target();
        let (identity, seen) = (entry.latest.identity, (entry.started_ns, entry.source));
        self.systems.identify(system, &identity);
        let first_seen = &mut self.systems.get_mut(system).first_seen;
        *first_seen = seen.min(*first_seen);
    }

    /// Whether the sensor track may stay where it is, and if not, where it goes.
    fn reconsider(&mut self, sensor: SensorSlot, report: &SensorTrack, sink: &mut impl Sink) {
        let system = self.sensors.get(sensor).system;
        let identity = self.sensors.get(sensor).latest.identity;
        let mine = identity
            .unique_number()
            .filter(|_| self.settings.association.use_identity);
        if let Some(mine) = mine {
            let theirs = self.systems.get(system).identity.unique_number();
            if theirs.is_some_and(|theirs| theirs != mine) {
                self.counts.add(report.source, Counter::IdentityConflicts);
                self.decide(sensor, DecisionKind::IdentityConflict, f64::NAN, f64::NAN, sink);
                self.leave(sensor, sink);
                return;
            }
            if let Some(other) = self.systems.with_address(mine).filter(|other| *other != system) {
                self.move_to(sensor, other, f64::NAN, sink);
                return;
            }
            self.systems.identify(system, &identity);
        }
        let now_ns = report.time_of_measurement_ns;
        if self.search().is_alone(sensor, now_ns) {
            self.wait_for_scan(sensor, sink);
            return;
        }
        if mine.is_none() && self.keeps_missing(sensor, sink) {
            self.counts.add(report.source, Counter::ContributionsSplit);
            self.leave(sensor, sink);
            return;
        }
        self.look_for_twin(system, now_ns, sink);
    }

    /// Takes a sensor track out of its system track; it goes where its scan, or its address, says.
    fn leave(&mut self, sensor: SensorSlot, sink: &mut impl Sink) {
        self.systems.unlink(&mut self.sensors, sensor);
        self.place_new(sensor, sink);
    }

    /// Whether the mean innovation of the sensor track differs from that of the others by more than noise explains,
    /// several reports in a row.
    fn keeps_missing(&mut self, sensor: SensorSlot, sink: &mut impl Sink) -> bool {
        let gate = self.settings.association.keep_gate;
        let entry = self.sensors.get(sensor);
        if entry.role == Role::Duplicate {
            return self.part_has_left(sensor);
        }
        let Some(d2) = self.offset_from_others(sensor) else {
            return false;
        };
        let misfits = if d2 > gate { entry.misfits + 1 } else { 0 };
        self.sensors.get_mut(sensor).misfits = misfits;
        let split = misfits >= self.settings.association.split_reports;
        if split {
            self.decide(sensor, DecisionKind::Split, d2, gate, sink);
        }
        split
    }

    /// Whether a second track of one source has left the target's extent, several reports in a row.
    fn part_has_left(&mut self, sensor: SensorSlot) -> bool {
        let entry = self.sensors.get(sensor);
        let filter = self
            .systems
            .get(entry.system)
            .filter
            .at(entry.latest.time_of_measurement_ns, &self.motion);
        let apart = |axis: usize| entry.latest.position_m[axis] - filter.mean[axis];
        let outside = apart(0).hypot(apart(1)) > 2.0 * self.settings.association.target_extent_m;
        let misfits = if outside { entry.misfits + 1 } else { 0 };
        self.sensors.get_mut(sensor).misfits = misfits;
        misfits >= self.settings.association.split_reports
    }

    /// Counts how often in a row a sensor track that stands alone was assigned to the same system track, and moves it
    /// there when that is often enough.
    pub(crate) fn vote_to_merge(&mut self, sensor: SensorSlot, system: SystemSlot, d2: f64, sink: &mut impl Sink) {
        let number = self.systems.get(system).number;
        let entry = self.sensors.get_mut(sensor);
        let hits = match entry.rival {
            Some((rival, hits)) if rival == number => hits + 1,
            _ => 1,
        };
        entry.rival = Some((number, hits));
        if hits >= self.settings.association.merge_reports {
            self.move_to(sensor, system, d2, sink);
            self.assign_role(sensor);
        }
    }

    /// Looks, once a second, whether the target has a second system track; merges into the older one if it keeps finding
    /// it.
    fn look_for_twin(&mut self, system: SystemSlot, now_ns: i64, sink: &mut impl Sink) {
        let entry = self.systems.get(system);
        let complete = self.settings.sources.len() as u32;
        if now_ns < entry.twin_due_ns || self.search().sources_of(system, now_ns).count_ones() >= complete {
            return;
        }
        let last = entry.twin;
        let found = self.search().twin(system, now_ns);
        let twin = found.map(|(twin, _)| {
            let number = self.systems.get(twin).number;
            match last {
                Some((last, hits)) if last == number => (number, hits + 1),
                _ => (number, 1),
            }
        });
        let entry = self.systems.get_mut(system);
        entry.twin = twin;
        entry.twin_due_ns = now_ns.saturating_add(TWIN_EVERY_NS);
        let (Some((twin, d2)), Some((_, hits))) = (found, twin) else {
            return;
        };
        if hits < self.settings.association.merge_reports {
            return;
        }
        self.merge(system, twin, now_ns, d2, sink);
    }

    /// Moves a sensor track to another system track. If nothing fresh stays behind, the two are merged.
    fn move_to(&mut self, sensor: SensorSlot, target: SystemSlot, d2: f64, sink: &mut impl Sink) {
        let entry = self.sensors.get(sensor);
        let (old, now_ns) = (entry.system, entry.latest.time_of_measurement_ns);
        if self
            .search()
            .fresh_primaries(old, now_ns)
            .all(|member| member == sensor)
        {
            self.merge(old, target, now_ns, d2, sink);
        } else {
            self.systems.unlink(&mut self.sensors, sensor);
            self.join(sensor, target);
        }
    }

    /// Makes one system track of two. The one that is shown lives on, of two that are the older one.
    fn merge(&mut self, a: SystemSlot, b: SystemSlot, now_ns: i64, d2: f64, sink: &mut impl Sink) {
        let rank = |slot: SystemSlot| {
            let entry = self.systems.get(slot);
            (entry.life == TrackState::Tentative, entry.number)
        };
        let (into, from) = if rank(a) < rank(b) { (a, b) } else { (b, a) };
        let SystemEntry {
            reports,
            first_seen,
            filter,
            number: ended,
            ..
        } = *self.systems.get(from);
        let reanchor = first_seen < self.systems.get(into).first_seen;
        while let Some(member) = self.systems.get(from).members {
            let role = self.sensors.get(member).role;
            self.systems.unlink(&mut self.sensors, member);
            self.join(member, into);
            let source = self.sensors.get(member).source;
            if role == Role::Primary && self.search().speaker(into, source, member, now_ns).is_none() {
                self.sensors.get_mut(member).role = Role::Primary;
            }
        }
        if reanchor {
            self.forget_points(into);
        }
        let entry = self.systems.get_mut(into);
        entry.reports = entry.reports.saturating_add(reports);
        if filter.is_surer_than(&entry.filter) {
            entry.filter = filter;
        }
        let number = entry.number;
        sink.decision(&Decision {
            time_ns: now_ns,
            kind: DecisionKind::Merged,
            system_track: ended,
            other_system_track: number,
            source: messages::NO_SOURCE,
            other_source: messages::NO_SOURCE,
            sensor_track: 0,
            value: d2,
            limit: self.settings.association.scan_gate(),
        });
        self.counts.add(messages::NO_SOURCE, Counter::TracksMerged);
        self.end(from, now_ns, number, sink);
    }

    /// The sources that have followed the target longest have only now come together: the reference point is chosen anew.
    fn forget_points(&mut self, system: SystemSlot) {
        let mut at = self.systems.get(system).members;
        while let Some(member) = at {
            let entry = self.sensors.get_mut(member);
            entry.point = Default::default();
            at = entry.next.get();
        }
    }

    /// One sensor track of a source speaks for it; it goes on doing so while it is fresh.
    pub(crate) fn assign_role(&mut self, sensor: SensorSlot) {
        let entry = self.sensors.get(sensor);
        let (system, source, now_ns) = (entry.system, entry.source, entry.time_ns);
        if entry.role == Role::Primary || self.search().speaker(system, source, sensor, now_ns).is_some() {
            return;
        }
        let mut at = self.systems.get(system).members;
        while let Some(member) = at {
            let entry = self.sensors.get_mut(member);
            if entry.source == source {
                entry.role = Role::Duplicate;
            }
            at = entry.next.get();
        }
        self.sensors.get_mut(sensor).role = Role::Primary;
    }

    pub(crate) fn drop_sensor_track(&mut self, sensor: SensorSlot) {
        if self.sensors.get(sensor).system != NO_SYSTEM {
            self.systems.unlink(&mut self.sensors, sensor);
        }
        self.sensors.remove(sensor);
    }
}
