//! What is new in a scan, assigned as a whole (BF-2).
//!
//! A sensor track that belongs to a system track stays there; its reports need no search. The others, those that belong
//! nowhere yet and those that are alone on a system track of their own, compete: two aircraft in formation are reported
//! by a coarse sensor nearer to each other than its errors, and taking the nearest system track for one after the other
//! gives the second one what is left. So they wait until the scan they came in is complete, a fraction of the source's
//! period, and are then assigned together so that the sum of their statistical distances is smallest.

use association::assignment::{Assignment, Pair};
use messages::{Counter, TrackState};

use crate::engine::Engine;
use crate::explanation::{Decision, DecisionKind, Sink};
use crate::measurement::whole_report;
use crate::sensor_tracks::{NO_SYSTEM, Role, SensorSlot};
use crate::system_tracks::SystemSlot;

/// Most sensor tracks of one source that are assigned at a time; a larger scan is assigned in parts.
const WAITING_MAX: usize = 4096;
/// Most admissible pairs of one scan.
const PAIRS_MAX: usize = 4 * WAITING_MAX;

/// Sensor tracks that wait for the end of their scan, per source, and room to assign them.
#[derive(Debug)]
pub(crate) struct Scans {
    waiting: Vec<Waiting>,
    /// When the first scan that waits is complete, nanoseconds; never (`i64::MAX`) if none waits.
    due_ns: i64,
    /// Taken out while a scan is being assigned.
    room: Option<Room>,
}

#[derive(Debug)]
struct Room {
    pairs: Vec<Pair>,
    /// System tracks of the scan being assigned, by column.
    columns: Vec<SystemSlot>,
    assignment: Assignment,
    /// (row, column, d²) of the pairs chosen.
    chosen: Vec<(u32, u32, f64)>,
}

#[derive(Debug)]
struct Waiting {
    sensors: Vec<SensorSlot>,
    first_ns: i64,
}

impl Scans {
    pub(crate) fn new(sources: usize) -> Self {
        let waiting = || Waiting {
            sensors: Vec::with_capacity(WAITING_MAX),
            first_ns: i64::MAX,
        };
        Self {
            waiting: (0..sources).map(|_| waiting()).collect(),
            due_ns: i64::MAX,
            room: Some(Room {
                pairs: Vec::with_capacity(PAIRS_MAX),
                columns: Vec::with_capacity(PAIRS_MAX),
                assignment: Assignment::new(WAITING_MAX, PAIRS_MAX, PAIRS_MAX),
                chosen: Vec::with_capacity(WAITING_MAX),
            }),
        }
    }

    pub(crate) fn due_ns(&self) -> i64 {
        self.due_ns
    }
}

impl Engine {
    /// Lets a sensor track wait for the end of its scan.
    pub(crate) fn wait_for_scan(&mut self, sensor: SensorSlot, sink: &mut impl Sink) {
        let entry = self.sensors.get_mut(sensor);
        let (source, time_ns) = (entry.source, entry.time_ns);
        if std::mem::replace(&mut entry.waits, true) {
            return;
        }
        if self.scans.waiting[usize::from(source)].sensors.len() == WAITING_MAX {
            self.assign_scan(usize::from(source), sink);
        }
        let waiting = &mut self.scans.waiting[usize::from(source)];
        waiting.sensors.push(sensor);
        waiting.first_ns = waiting.first_ns.min(time_ns);
        let complete_ns = self.complete_ns(usize::from(source));
        self.scans.due_ns = self.scans.due_ns.min(complete_ns);
    }

    /// When the scan of a source that waits is complete.
    fn complete_ns(&self, source: usize) -> i64 {
        let wait_ns = self.settings.sources[source].period_ns as f64 * self.settings.association.scan_wait;
        self.scans.waiting[source].first_ns.saturating_add(wait_ns as i64)
    }

    /// Assigns the scans that are complete at `time_ns`.
    pub(crate) fn finish_scans(&mut self, time_ns: i64, sink: &mut impl Sink) {
        for source in 0..self.scans.waiting.len() {
            if !self.scans.waiting[source].sensors.is_empty() && self.complete_ns(source) <= time_ns {
                self.assign_scan(source, sink);
            }
        }
        let due_ns = (0..self.scans.waiting.len())
            .map(|source| self.complete_ns(source))
            .min();
        self.scans.due_ns = due_ns.unwrap_or(i64::MAX);
    }

    fn assign_scan(&mut self, source: usize, sink: &mut impl Sink) {
        let Some(mut room) = self.scans.room.take() else {
            return;
        };
        let waiting = &mut self.scans.waiting[source];
        waiting.first_ns = i64::MAX;
        let mut sensors = std::mem::take(&mut waiting.sensors);
        self.find_pairs(&sensors, &mut room);
        room.chosen.clear();
        let (gate, chosen) = (self.settings.association.scan_gate(), &mut room.chosen);
        room.assignment.solve(&room.pairs, gate, |row, column, d2| {
            chosen.push((row, column, d2));
        });
        let mut next = room.chosen.iter().copied().peekable();
        for (row, sensor) in sensors.iter().copied().enumerate() {
            let best = next.next_if(|(of, ..)| *of == row as u32);
            if std::mem::take(&mut self.sensors.get_mut(sensor).waits) {
                let best = best.map(|(_, column, d2)| (room.columns[column as usize], d2));
                self.place_assigned(sensor, best, sink);
            }
        }
        sensors.clear();
        self.scans.waiting[source].sensors = sensors;
        self.scans.room = Some(room);
    }

    /// All pairs of a waiting sensor track and a system track that it could join.
    fn find_pairs(&mut self, sensors: &[SensorSlot], room: &mut Room) {
        room.pairs.clear();
        room.columns.clear();
        for (row, sensor) in sensors.iter().enumerate() {
            if !self.sensors.get(*sensor).waits {
                continue;
            }
            self.search().admissible(*sensor, |system, d2| {
                if room.pairs.len() < PAIRS_MAX {
                    room.pairs.push(Pair {
                        row: row as u32,
                        column: system,
                        cost: d2,
                    });
                }
            });
        }
        // Columns are numbered in the order in which they occur.
        for pair in &mut room.pairs {
            let entry = self.systems.get_mut(pair.column);
            if room.columns.get(entry.column as usize) != Some(&pair.column) {
                entry.column = room.columns.len() as u32;
                room.columns.push(pair.column);
            }
            pair.column = entry.column;
        }
    }

    /// Puts a sensor track where the assignment says.
    fn place_assigned(&mut self, sensor: SensorSlot, best: Option<(SystemSlot, f64)>, sink: &mut impl Sink) {
        let entry = self.sensors.get(sensor);
        let unlinked = entry.system == NO_SYSTEM;
        // It may have ended meanwhile, merged by another sensor track of this scan.
        match best.filter(|(system, _)| self.systems.get(*system).life != TrackState::Terminated) {
            Some((system, d2)) if unlinked => {
                self.join(sensor, system);
                self.decide(
                    sensor,
                    DecisionKind::Joined,
                    d2,
                    self.settings.association.scan_gate(),
                    sink,
                );
                self.assign_role(sensor);
                if self.sensors.get(sensor).role == Role::Primary {
                    let report = self.sensors.get(sensor).latest;
                    self.contribute(sensor, &report, Some(&whole_report(&report)), sink);
                }
            }
            Some((system, d2)) => self.vote_to_merge(sensor, system, d2, sink),
            None if unlinked => self.place_alone(sensor, sink),
            None => self.sensors.get_mut(sensor).rival = None,
        }
    }

    /// A sensor track that fits no system track that could take it: another part of a target that its source already
    /// follows, or the first sight of a new one.
    fn place_alone(&mut self, sensor: SensorSlot, sink: &mut impl Sink) {
        if let Some((system, metres)) = self.search().other_part(sensor) {
            self.join(sensor, system);
            let limit = self.settings.association.target_extent_m;
            self.decide(sensor, DecisionKind::Duplicate, metres, limit, sink);
            self.counts
                .add(self.sensors.get(sensor).source, Counter::RejectedDuplicate);
            return;
        }
        self.start_system_track(sensor, sink);
    }

    pub(crate) fn decide(&self, sensor: SensorSlot, kind: DecisionKind, value: f64, limit: f64, sink: &mut impl Sink) {
        let entry = self.sensors.get(sensor);
        let number = match entry.system {
            NO_SYSTEM => 0,
            system => self.systems.get(system).number,
        };
        sink.decision(&Decision {
            time_ns: entry.time_ns,
            kind,
            system_track: number,
            other_system_track: 0,
            source: entry.source,
            other_source: messages::NO_SOURCE,
            sensor_track: entry.track_number,
            value,
            limit,
        });
    }
}
