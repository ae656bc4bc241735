//! The sensor tracks and the system tracks, and which sensor track belongs to which system track.

use messages::{Decision, DecisionKind, TrackState};

use crate::filter::Filter;
use crate::sensor_tracks::{Link, NO_SYSTEM, Role, SensorEntry, SensorSlot, SensorTracks};
use crate::system_tracks::{SystemSlot, SystemTracks};

/// Both tables, linked with each other.
#[derive(Debug)]
pub(crate) struct Tracks {
    pub(crate) sensors: SensorTracks,
    pub(crate) systems: SystemTracks,
    /// Age up to which a report counts, per source, nanoseconds.
    fresh_ns: Vec<i64>,
}

impl Tracks {
    pub(crate) fn new(sensors: SensorTracks, systems: SystemTracks, fresh_ns: Vec<i64>) -> Self {
        Self {
            sensors,
            systems,
            fresh_ns,
        }
    }

    /// The sensor tracks of a system track, newest link first.
    pub(crate) fn members(&self, system: SystemSlot) -> impl Iterator<Item = SensorSlot> {
        let next = |slot: &SensorSlot| self.sensors.get(*slot).next.get();
        std::iter::successors(self.systems.get(system).members, next)
    }

    /// Calls `change` with every sensor track of a system track, which may not link it elsewhere.
    pub(crate) fn for_members(&mut self, system: SystemSlot, mut change: impl FnMut(&mut SensorEntry)) {
        let mut at = self.systems.get(system).members;
        while let Some(member) = at {
            let entry = self.sensors.get_mut(member);
            change(entry);
            at = entry.next.get();
        }
    }

    /// The sensor tracks that contribute to `system` at `now_ns`: the fresh primary ones.
    pub(crate) fn contributing(&self, system: SystemSlot, now_ns: i64) -> impl Iterator<Item = SensorSlot> {
        self.members(system).filter(move |member| {
            let entry = self.sensors.get(*member);
            entry.role == Role::Primary && now_ns - entry.time_ns <= self.fresh_ns[usize::from(entry.source)]
        })
    }

    /// The sensor track of `source` that contributes to `system`, other than `own`.
    pub(crate) fn primary_of(
        &self,
        system: SystemSlot,
        source: u16,
        own: SensorSlot,
        now_ns: i64,
    ) -> Option<SensorSlot> {
        self.contributing(system, now_ns)
            .find(|member| *member != own && self.sensors.get(*member).source == source)
    }

    /// The sources that contribute to a system track, as bits.
    pub(crate) fn sources_of(&self, system: SystemSlot, now_ns: i64) -> u64 {
        self.contributing(system, now_ns)
            .fold(0, |bits, member| bits | 1 << self.sensors.get(member).source)
    }

    /// Whether nothing but `own` contributes to its system track.
    pub(crate) fn is_alone(&self, own: SensorSlot, now_ns: i64) -> bool {
        let system = self.sensors.get(own).system;
        self.contributing(system, now_ns).all(|member| member == own)
    }

    /// Whether at most one source contributes to `system`.
    pub(crate) fn has_one_source(&self, system: SystemSlot, now_ns: i64) -> bool {
        self.contributing(system, now_ns).nth(1).is_none()
    }

    /// Whether the source has made enough of its track for it to be compared with others.
    pub(crate) fn is_established(&self, sensor: SensorSlot) -> bool {
        let entry = self.sensors.get(sensor);
        entry.reports >= 2 || entry.latest.state == TrackState::Confirmed as u8
    }

    /// The time at which the last of the present contributions ceases to be fresh.
    pub(crate) fn fresh_until(&self, system: SystemSlot) -> i64 {
        self.members(system)
            .map(|member| {
                let entry = self.sensors.get(member);
                entry.time_ns + self.fresh_ns[usize::from(entry.source)]
            })
            .max()
            .unwrap_or(i64::MIN)
    }

    /// Links a sensor track that belongs nowhere to `system`.
    pub(crate) fn join(&mut self, sensor: SensorSlot, system: SystemSlot) {
        let first = &mut self.systems.get_mut(system).members;
        let entry = self.sensors.get_mut(sensor);
        entry.system = system;
        entry.next = Link::to(first.replace(sensor));
        entry.role = Role::Duplicate;
        entry.forget_target();
        let (identity, seen) = (entry.latest.identity, (entry.started_ns, entry.source));
        self.systems.identify(system, &identity);
        let first_seen = &mut self.systems.get_mut(system).first_seen;
        *first_seen = seen.min(*first_seen);
    }

    /// Takes a sensor track out of its system track.
    pub(crate) fn unlink(&mut self, sensor: SensorSlot) {
        let entry = self.sensors.get_mut(sensor);
        let (system, next) = (std::mem::replace(&mut entry.system, NO_SYSTEM), entry.next);
        let first = &mut self.systems.get_mut(system).members;
        if *first == Some(sensor) {
            *first = next.get();
            return;
        }
        let mut at = *first;
        while let Some(slot) = at {
            let entry = self.sensors.get_mut(slot);
            if entry.next == Link::to(Some(sensor)) {
                entry.next = next;
                return;
            }
            at = entry.next.get();
        }
    }

    /// Makes a sensor track the primary one of its source, if there is no other one that is fresh: one speaks for a
    /// source, and goes on doing so while it is fresh.
    pub(crate) fn assign_role(&mut self, sensor: SensorSlot) {
        let entry = self.sensors.get(sensor);
        let (system, source, now_ns) = (entry.system, entry.source, entry.time_ns);
        if entry.role == Role::Primary || self.primary_of(system, source, sensor, now_ns).is_some() {
            return;
        }
        self.for_members(system, |member| {
            if member.source == source {
                member.role = Role::Duplicate;
            }
        });
        self.sensors.get_mut(sensor).role = Role::Primary;
    }

    /// Lets the filter of a sensor track's system track begin anew with what the sensor track says.
    pub(crate) fn restart_filter(&mut self, sensor: SensorSlot) {
        let entry = self.sensors.get(sensor);
        self.systems.get_mut(entry.system).filter = Filter::of_report(&entry.latest);
    }

    /// Frees the place of a sensor track.
    pub(crate) fn drop_sensor_track(&mut self, sensor: SensorSlot) {
        if self.sensors.get(sensor).system != NO_SYSTEM {
            self.unlink(sensor);
        }
        self.sensors.remove(sensor);
    }

    /// Frees sensor tracks without report since `since_ns`, a few places of the table at a time.
    pub(crate) fn drop_silent(&mut self, since_ns: i64) {
        for sensor in self.sensors.next_places() {
            if self.sensors.is_silent(sensor, since_ns) {
                self.drop_sensor_track(sensor);
            }
        }
    }

    /// A decision about a sensor track, at the time of its latest report.
    pub(crate) fn decision(&self, sensor: SensorSlot, kind: DecisionKind, value: f64, limit: f64) -> Decision {
        let entry = self.sensors.get(sensor);
        let number = match entry.system {
            NO_SYSTEM => 0,
            system => self.systems.get(system).number,
        };
        Decision {
            time_ns: entry.time_ns,
            kind: kind.code(),
            system_track: number,
            source: entry.source,
            sensor_track: entry.track_number,
            value,
            limit,
            ..Decision::default()
        }
    }

    /// A decision about a system track.
    pub(crate) fn decision_on(&self, system: SystemSlot, kind: DecisionKind, time_ns: i64, value: f64) -> Decision {
        let entry = self.systems.get(system);
        Decision {
            time_ns,
            kind: kind.code(),
            system_track: entry.number,
            other_system_track: entry.merged_into,
            value,
            ..Decision::default()
        }
    }
}
