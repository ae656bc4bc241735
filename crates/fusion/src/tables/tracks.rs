//! The sensor tracks and the system tracks, and the links between them.

use kept::kept;
use serde::{Deserialize, Serialize};

use messages::{Decision, DecisionKind, TrackState};
use source_models::{Fact, Measurement, PairFact, Rhythm, Sources};

use crate::continuity::checkpoint::{CheckpointWriter, RecordKind};
use crate::continuity::numbering;
use crate::settings::{Settings, SourceSet};
use crate::tables::former_members::FormerMembers;
use crate::tables::sensor_tracks::{MemberEntries, MemberLink, NO_SYSTEM, Role, SensorEntry, SensorSlot, SensorTracks};
use crate::tables::system_tracks::{SystemEntry, SystemSlot, SystemTracks};
use crate::update::filter::TargetFilter;
use crate::update::filter_input::FilterInput;
use crate::update::kept_measurements::KeptMeasurements;

/// Both tables, linked with each other, and the properties of the sources.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct Tracks {
    pub(crate) sensors: SensorTracks,
    pub(crate) systems: SystemTracks,
    /// The learned properties of the sources.
    pub(crate) sources: Sources,
    /// Measurements of the last seconds, for late reports.
    pub(crate) kept: KeptMeasurements,
    /// Output for data that must outlive the process.
    #[serde(skip)]
    pub(crate) checkpoint: Option<CheckpointWriter>,
    /// Members from before the start, and of suspended system tracks.
    remembered: FormerMembers,
}

/// Time between two kept states of a system track, nanoseconds, and number of states per kept state.
const KEPT_EVERY_NS: i64 = 100_000_000;
const KEPT_EVERY: u8 = 2;

kept! {
    /// A sensor track's membership, as a checkpoint keeps it.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub(crate) struct TrackMembership {
        pub(crate) source: u16,
        pub(crate) track_number: u32,
        /// Number of its system track; 0: none.
        pub(crate) system_track: u32,
    }
}

impl Tracks {
    pub(crate) fn new(sensors: SensorTracks, systems: SystemTracks, sources: Sources, kept: KeptMeasurements) -> Self {
        Self {
            remembered: FormerMembers::new(sensors.capacity()),
            sensors,
            systems,
            sources,
            kept,
            checkpoint: None,
        }
    }

    /// Remembers members of system tracks that have just been taken in again, the newest first, as many as there is
    /// room for. For a member returned by address there is an older record too.
    pub(crate) fn remember(&mut self, members: Vec<(TrackMembership, SystemSlot)>) {
        for (member, system) in members {
            let key = (member.source, member.track_number);
            if !self.remembered.contains(key.0, key.1)
                && self.remembered.add(key, system, member.system_track).is_none()
            {
                break;
            }
        }
    }

    /// Lets the number of a system track rest: its sensor tracks leave, and return by their numbers.
    pub(crate) fn suspend(&mut self, system: SystemSlot) {
        let number = self.systems.get(system).number;
        let Self {
            systems, remembered, ..
        } = self;
        remembered.make_room(|former| {
            let entry = systems.get(former.slot);
            entry.number == former.number && entry.life != TrackState::Terminated
        });
        while let Some(sensor) = self.systems.get(system).members {
            let entry = self.sensors.get(sensor);
            let member = TrackMembership {
                source: entry.source,
                track_number: entry.track_number,
                system_track: number,
            };
            let place = self
                .remembered
                .add((member.source, member.track_number), system, number);
            if let (Some(checkpoint), Some(place)) = (&mut self.checkpoint, place) {
                checkpoint.write(RecordKind::Remembered, place as usize, &member);
            }
            self.drop_sensor_track(sensor);
        }
        self.systems.suspend(system);
        self.kept.forget(system);
    }

    /// Whether a sensor track without an entry was a member of a system track continued from a checkpoint: for its
    /// source the track is old.
    #[inline]
    pub(crate) fn goes_on(&self, source: u16, track_number: u32) -> bool {
        if self.remembered.is_empty() {
            return false;
        }
        self.remembered.get(source, track_number).is_some_and(|former| {
            let entry = self.systems.get(former.slot);
            let is_over = matches!(entry.life, TrackState::Suspended | TrackState::Terminated);
            entry.number == former.number && !is_over
        })
    }

    /// The former system track of a sensor track that has just reported for the first time, if still alive. Each
    /// record is used once; a system track that was never shown is returned only if `is_last`.
    pub(crate) fn recall(&mut self, sensor: SensorSlot, is_last: bool) -> Option<SystemSlot> {
        if self.remembered.is_empty() {
            return None;
        }
        let entry = self.sensors.get(sensor);
        let former = self.remembered.get(entry.source, entry.track_number)?;
        // A track that was never shown waits until no other track fits.
        let is_unshown = |former: &SystemEntry| former.life == TrackState::Suspended && !former.was_shown;
        if !is_last && is_unshown(self.systems.get(former.slot)) {
            return None;
        }
        self.remembered.take(entry.source, entry.track_number);
        if let Some(checkpoint) = &mut self.checkpoint {
            checkpoint.write(
                RecordKind::Remembered,
                former.place as usize,
                &TrackMembership::default(),
            );
        }
        let entry = self.systems.get(former.slot);
        (entry.number == former.number && entry.life != TrackState::Terminated).then_some(former.slot)
    }

    /// Writes the data of a system track into the checkpoint, unless just written: a slightly older state does no
    /// harm.
    #[inline]
    pub(crate) fn keep(&mut self, system: SystemSlot) {
        if let Some(checkpoint) = &mut self.checkpoint {
            let entry = self.systems.get_mut(system);
            entry.unkept = entry.unkept.saturating_add(1);
            let has_changed = entry.kept_ns == i64::MIN;
            let is_due = entry.unkept >= KEPT_EVERY && entry.state.time_ns >= entry.kept_ns + KEPT_EVERY_NS;
            if has_changed || is_due {
                (entry.kept_ns, entry.unkept) = (entry.state.time_ns, 0);
                checkpoint.write(RecordKind::Systems, system as usize, &entry.kept());
            }
        }
    }

    fn keep_member(&mut self, sensor: SensorSlot) {
        if let Some(checkpoint) = &mut self.checkpoint {
            let entry = self.sensors.get(sensor);
            let member = match entry.system {
                NO_SYSTEM => TrackMembership::default(),
                system => TrackMembership {
                    source: entry.source,
                    track_number: entry.track_number,
                    system_track: self.systems.get(system).number,
                },
            };
            checkpoint.write(RecordKind::Members, sensor as usize, &member);
        }
    }

    /// Reserves numbers before the next system track uses the first.
    pub(crate) fn reserve_numbers(&mut self) {
        let next = self.systems.next_number();
        if let Some(checkpoint) = &mut self.checkpoint
            && next.is_multiple_of(numbering::BLOCK)
        {
            checkpoint.write(RecordKind::Numbers, 0, &numbering::reserved(next));
        }
    }

    /// Takes the next number of a system track, reserved like all numbers.
    pub(crate) fn take_number(&mut self) -> u32 {
        let number = self.systems.take_number();
        self.reserve_numbers();
        number
    }

    /// Gives a system track, and its members, another number.
    pub(crate) fn renumber(&mut self, system: SystemSlot, number: u32) {
        let entry = self.systems.get_mut(system);
        (entry.number, entry.kept_ns) = (number, i64::MIN);
        let mut next = entry.members;
        while let Some(member) = next {
            self.keep_member(member);
            next = self.sensors.get(member).next.get();
        }
        self.keep(system);
    }

    /// Returns whether rules have access to earlier reports.
    pub(crate) fn looks_back(&self) -> bool {
        self.systems.remembers()
    }

    /// Begins to keep data in `checkpoint`.
    pub(crate) fn keep_in(&mut self, mut checkpoint: CheckpointWriter) {
        checkpoint.write(RecordKind::Numbers, 0, &numbering::reserved(self.systems.next_number()));
        for ((source, track_number), former) in self.remembered.iter() {
            let member = TrackMembership {
                source: *source,
                track_number: *track_number,
                system_track: former.number,
            };
            checkpoint.write(RecordKind::Remembered, former.place as usize, &member);
        }
        self.checkpoint = Some(checkpoint);
        for system in self.systems.slots() {
            if self.systems.get(system).number != 0 {
                self.keep(system);
            }
        }
    }

    /// The sensor tracks of a system track, newest link first.
    pub(crate) fn members(&self, system: SystemSlot) -> impl Iterator<Item = SensorSlot> {
        self.member_entries(system).map(|(member, _)| member)
    }

    /// The sensor tracks of a system track with entries, newest link first.
    #[inline]
    pub(crate) fn member_entries(&self, system: SystemSlot) -> MemberEntries<'_> {
        self.sensors.members_from(self.systems.get(system).members)
    }

    /// Calls `change` with every sensor track of a system track; `change` may not link the sensor tracks elsewhere.
    #[inline]
    pub(crate) fn for_members(&mut self, system: SystemSlot, change: impl FnMut(&mut SensorEntry)) {
        self.sensors.for_members_from(self.systems.get(system).members, change);
    }

    /// The sensor tracks that contribute to `system` at `now_ns`: the fresh primary tracks.
    pub(crate) fn contributing(&self, system: SystemSlot, now_ns: i64) -> impl Iterator<Item = SensorSlot> {
        self.contributing_entries(system, now_ns).map(|(member, _)| member)
    }

    /// The same with entries.
    #[inline]
    pub(crate) fn contributing_entries(
        &self,
        system: SystemSlot,
        now_ns: i64,
    ) -> impl Iterator<Item = (SensorSlot, &SensorEntry)> {
        self.member_entries(system)
            .filter(move |(_, entry)| self.contributes(entry, now_ns))
    }

    /// Whether a sensor track contributes to its system track at `now_ns`.
    #[inline]
    pub(crate) fn contributes(&self, entry: &SensorEntry, now_ns: i64) -> bool {
        entry.role == Role::Primary && self.is_fresh(entry, now_ns)
    }

    /// Whether the latest report of a sensor track counts at `now_ns`, by the source's period and the rhythm of the
    /// target.
    #[inline]
    pub(crate) fn is_fresh(&self, entry: &SensorEntry, now_ns: i64) -> bool {
        self.is_fresh_by_period(entry, now_ns) || self.is_fresh_by_rhythm(entry, now_ns)
    }

    /// The same by the source's period alone: afterwards another sensor track of the source may represent the target.
    #[inline]
    fn is_fresh_by_period(&self, entry: &SensorEntry, now_ns: i64) -> bool {
        now_ns - entry.time_ns <= self.sources.fresh_ns(entry.source)
    }

    /// Whether a sensor track still represents its source beside another: not a track from before the source's
    /// restart.
    fn still_speaks(&self, entry: &SensorEntry, now_ns: i64) -> bool {
        self.is_fresh_by_period(entry, now_ns) && !self.sources.is_before_restart(entry.source, entry.time_ns)
    }

    fn is_fresh_by_rhythm(&self, entry: &SensorEntry, now_ns: i64) -> bool {
        entry.system != NO_SYSTEM && now_ns - entry.time_ns <= self.systems.get(entry.system).rhythm.fresh_ns()
    }

    /// The contributing tracks that are no tracks of other centres.
    pub(crate) fn contributing_here(&self, system: SystemSlot, now_ns: i64) -> impl Iterator<Item = SensorSlot> {
        self.contributing_entries(system, now_ns)
            .filter(|(_, entry)| !entry.is_foreign)
            .map(|(member, _)| member)
    }

    /// The sensor track that represents `source` in `system`, other than `own`.
    pub(crate) fn primary_of(
        &self,
        system: SystemSlot,
        source: u16,
        own: SensorSlot,
        now_ns: i64,
    ) -> Option<SensorSlot> {
        self.member_entries(system)
            .find(|(member, entry)| {
                let speaks = entry.role == Role::Primary && self.still_speaks(entry, now_ns);
                *member != own && entry.source == source && speaks
            })
            .map(|(member, _)| member)
    }

    /// The sources that contribute to a system track, without sources with tracks from before a restart.
    pub(crate) fn sources_of(&self, system: SystemSlot, now_ns: i64) -> SourceSet {
        self.contributing_entries(system, now_ns)
            .filter(|(_, entry)| !self.sources.is_before_restart(entry.source, entry.time_ns))
            .map(|(_, entry)| entry.source)
            .collect()
    }

    /// The sources that contribute to the system track of `own`, and whether `own` alone contributes.
    pub(crate) fn sources_beside(&self, own: SensorSlot, now_ns: i64) -> (SourceSet, bool) {
        let (mut sources, mut is_alone) = (SourceSet::EMPTY, true);
        for (member, entry) in self.contributing_entries(self.sensors.get(own).system, now_ns) {
            sources.insert(entry.source);
            is_alone &= member == own;
        }
        (sources, is_alone)
    }

    /// Whether `own` alone contributes to its system track.
    pub(crate) fn is_alone(&self, own: SensorSlot, now_ns: i64) -> bool {
        let system = self.sensors.get(own).system;
        self.contributing(system, now_ns).all(|member| member == own)
    }

    /// Whether at most one source contributes to `system`.
    pub(crate) fn has_one_source(&self, system: SystemSlot, now_ns: i64) -> bool {
        self.contributing(system, now_ns).nth(1).is_none()
    }

    /// Whether the track is established enough at its source for a comparison with others.
    pub(crate) fn is_established(&self, sensor: SensorSlot) -> bool {
        let entry = self.sensors.get(sensor);
        entry.reports >= 2 || entry.latest.state == TrackState::Confirmed as u8
    }

    /// Time at which the last of the present contributions ceases to be fresh.
    pub(crate) fn fresh_until(&self, system: SystemSlot) -> i64 {
        let own_ns = self.systems.get(system).rhythm.fresh_ns();
        let mut until_ns = i64::MIN;
        for (_, entry) in self.member_entries(system) {
            until_ns = until_ns.max(entry.time_ns + self.sources.fresh_ns(entry.source).max(own_ns));
        }
        until_ns
    }

    /// Links a sensor track without a system track to `system`.
    pub(crate) fn join(&mut self, sensor: SensorSlot, system: SystemSlot) {
        let first = &mut self.systems.get_mut(system).members;
        let entry = self.sensors.get_mut(sensor);
        entry.system = system;
        entry.next = MemberLink::to(first.replace(sensor));
        entry.role = Role::Duplicate;
        entry.forget_target();
        let (identity, started_ns) = (entry.latest.identity, entry.started_ns);
        self.systems.identify(system, &identity);
        let first_seen_ns = &mut self.systems.get_mut(system).first_seen_ns;
        *first_seen_ns = started_ns.min(*first_seen_ns);
        self.keep_member(sensor);
    }

    /// Removes a sensor track from its system track.
    #[cold]
    pub(crate) fn unlink(&mut self, sensor: SensorSlot) {
        let entry = self.sensors.get_mut(sensor);
        let (system, next) = (std::mem::replace(&mut entry.system, NO_SYSTEM), entry.next);
        let first = &mut self.systems.get_mut(system).members;
        if *first == Some(sensor) {
            *first = next.get();
        } else {
            let mut at = *first;
            while let Some(slot) = at {
                let entry = self.sensors.get_mut(slot);
                if entry.next == MemberLink::to(Some(sensor)) {
                    entry.next = next;
                    break;
                }
                at = entry.next.get();
            }
        }
        self.keep_member(sensor);
    }

    /// Learns common errors of sources from a sensor track's latest report, and those of other sources on its target.
    #[inline]
    pub(crate) fn learn_dependence(&mut self, settings: &Settings, sensor: SensorSlot) {
        let entry = self.sensors.get(sensor);
        let period_ns = settings.sources[usize::from(entry.source)].period_ns;
        if !entry.repaired && Sources::compares(entry.reports, period_ns) {
            self.compare_with_members(settings, sensor);
        }
    }

    #[inline(never)]
    fn compare_with_members(&mut self, settings: &Settings, sensor: SensorSlot) {
        let Self {
            sensors,
            systems,
            sources,
            ..
        } = self;
        let entry = sensors.get(sensor);
        for (_, other) in sensors.members_from(systems.get(entry.system).members) {
            if !other.repaired {
                sources.learn(settings, Fact::Pair(PairFact::Reports(&entry.latest, &other.latest)));
            }
        }
    }

    /// Makes a sensor track the primary track of its source, and of the sources that it depends on, if no other track
    /// is fresh: a single track represents a source, as long as the track is fresh.
    #[inline]
    pub(crate) fn assign_role(&mut self, sensor: SensorSlot) {
        let entry = self.sensors.get(sensor);
        // No other source of the group precedes the first source.
        if entry.role != Role::Primary || self.sources.group_of(entry.source) != entry.source {
            self.assign_role_in_group(sensor);
        }
    }

    #[inline(never)]
    fn assign_role_in_group(&mut self, sensor: SensorSlot) {
        let entry = self.sensors.get(sensor);
        let (system, source, now_ns) = (entry.system, entry.source, entry.time_ns);
        let group = self.sources.group_of(source);
        let other = self
            .member_entries(system)
            .find(|(member, entry)| {
                *member != sensor
                    && self.sources.group_of(entry.source) == group
                    && entry.role == Role::Primary
                    && self.still_speaks(entry, now_ns)
            })
            .map(|(_, other)| other.source);
        if entry.role == Role::Primary {
            // Two sources found to depend on each other: the first source represents both from now on.
            if other.is_some_and(|other| other < source) {
                self.sensors.get_mut(sensor).role = Role::Duplicate;
            }
            return;
        }
        if other.is_some() {
            return;
        }
        self.for_members(system, |member| {
            if member.source == source {
                member.role = Role::Duplicate;
            }
        });
        self.sensors.get_mut(sensor).role = Role::Primary;
    }

    /// A measurement in the latest report of a sensor track, or the whole report, as input of its track's filter.
    pub(crate) fn input(&self, sensor: SensorSlot, measurement: Option<&Measurement>) -> FilterInput {
        let entry = self.sensors.get(sensor);
        entry.input(self.systems.get(entry.system).number, measurement)
    }

    /// Restarts the filter of a sensor track's system track with the sensor track's report.
    #[cold]
    pub(crate) fn restart_filter(&mut self, sensor: SensorSlot) {
        let entry = self.sensors.get(sensor);
        let system = self.systems.get_mut(entry.system);
        system.filter = TargetFilter::of_report(&entry.latest);
        system.is_foreign = entry.is_foreign;
        system.contributors = SourceSet::of(entry.source);
        self.kept.forget(entry.system);
    }

    /// Frees the place of a sensor track.
    #[cold]
    pub(crate) fn drop_sensor_track(&mut self, sensor: SensorSlot) {
        if self.sensors.get(sensor).system != NO_SYSTEM {
            self.unlink(sensor);
        }
        self.sensors.remove(sensor);
    }

    /// Frees sensor tracks that have been silent for the life time of their source's tracks at `now_ns`, a few places
    /// of the table at a time.
    pub(crate) fn drop_silent(&mut self, now_ns: i64) {
        let since_ns = now_ns.saturating_sub(self.sources.terminate_ns());
        for sensor in self.sensors.next_places() {
            if !self.sensors.is_silent(sensor, since_ns) {
                continue;
            }
            let silence_ns = self.silence_ns(sensor);
            if self.sensors.is_silent(sensor, now_ns.saturating_sub(silence_ns)) {
                self.drop_sensor_track(sensor);
            }
        }
    }

    /// Time without a report after which a sensor track has ended, nanoseconds.
    pub(crate) fn silence_ns(&self, sensor: SensorSlot) -> i64 {
        let entry = self.sensors.get(sensor);
        let rhythm = match entry.system {
            NO_SYSTEM => Rhythm::default(),
            system => self.systems.get(system).rhythm,
        };
        self.sources.silence_at(rhythm, self.sources.silence_ns(entry.source))
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
