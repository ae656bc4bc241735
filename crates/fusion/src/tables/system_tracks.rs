//! The system tracks: state, members, and look-up by place and by address.

use kept::kept;
use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap};

use association::Grid;
use estimation::Gaussian;
use messages::{Covariance, Identity, NO_SOURCE, TargetType, TrackKind, TrackState, UniqueNumber};
use serde::{Deserialize, Serialize, Serializer};
use source_models::Rhythm;

use crate::associate::recognition::Recognition;
use crate::continuity::numbering;
use crate::judge::existence::probability;
use crate::places::{self, TablePlace};
use crate::publish::border::Ownership;
use crate::rules::RuleMemory;
use crate::settings::SourceSet;
use crate::state::State;
use crate::tables::description::Description;
use crate::tables::number_hasher::{NumberHasher, table};
use crate::tables::quota::Quota;
use crate::tables::sensor_tracks::SensorSlot;
use crate::tables::silent_tracks::{Rest, SilentTracks};
use crate::update::filter::{KeptFilter, TargetFilter};
use crate::update::foresight::Foresight;

/// Place of a system track in the table.
pub(crate) type SystemSlot = u32;

/// Effect of an order on a system track.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum Bond {
    /// No order binds the track.
    #[default]
    Free,
    /// The sensor tracks stay together.
    Joined,
    /// The track does not merge with the track of this number.
    Apart(u32),
}

/// A system track.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct SystemEntry {
    /// Number; 0 if the place is free.
    pub(crate) number: u32,
    /// Source that started the track: the place in the table is of its quota.
    owner: u16,
    pub(crate) life: TrackState,
    pub(crate) bond: Bond,
    pub(crate) identity: Identity,
    /// State as last weighed.
    pub(crate) state: State,
    /// The system filter: reference for comparisons of reports.
    pub(crate) filter: TargetFilter,
    /// Course of the target, as sine and cosine; north until the target has moved.
    pub(crate) course: [f64; 2],
    /// Logarithm of the odds that the target exists, after the latest report; NaN before there is evidence.
    pub(crate) log_odds: f64,
    /// Sum of ln(1 − probability of detection) over the misses since the last report.
    pub(crate) absence: f64,
    /// Normalised innovation squared of the latest report, in the plane; 0 without a comparison with the filter.
    pub(crate) nis: f32,
    /// Successive reports far off the filter's estimate, by all known errors of both.
    pub(crate) astray: u32,
    /// Comparison of the only source with the filter.
    pub(crate) foresight: Foresight,
    /// Earliest start of a joined sensor track.
    pub(crate) first_seen_ns: i64,
    /// Source with the point of the target that the filter follows; [`NO_SOURCE`] if there is no such point.
    pub(crate) point_source: u16,
    /// Centre that owns the target.
    pub(crate) ownership: Ownership,
    /// Rhythm of the reports.
    pub(crate) rhythm: Rhythm,
    /// Evidence from the address before the first confirmation.
    pub(crate) recognition: Recognition,
    /// Whether the target can take up the number by its identity while the number rests.
    pub(crate) is_known: bool,
    /// Whether the track was ever confirmed.
    pub(crate) was_shown: bool,
    /// Whether the purity of the sources has counted the track.
    pub(crate) is_counted: bool,
    /// Whether the filter repeats reports of another centre, since no source here follows the target.
    pub(crate) is_foreign: bool,
    /// Whether a source leads the target off.
    pub(crate) has_led_off: bool,
    /// Whether the sources see points of the target that stand apart.
    pub(crate) has_points: bool,
    /// Whether measurements of a detection point that may have leapt wait.
    pub(crate) awaits_leap: bool,
    /// Sources used by the filter.
    pub(crate) contributors: SourceSet,
    /// Number of another system track that seems to be the same target, and the number of successive findings.
    pub(crate) duplicate: Option<(u32, u32)>,
    /// Time of the next check for such a track, nanoseconds.
    pub(crate) duplicate_due_ns: i64,
    /// Number of the system track that may show the target at another point, and the number of successive findings.
    pub(crate) other_point: Option<(u32, u32)>,
    /// Way to that point, east and north, metres, if it comes first; else 0.
    pub(crate) aside_m: [f32; 2],
    /// Time of the next note of the sources that follow the track, nanoseconds.
    pub(crate) coverage_due_ns: i64,
    /// Column while a scan is being assigned.
    pub(crate) column: u32,
    /// First sensor track; the others are linked from there.
    pub(crate) members: Option<SensorSlot>,
    /// Reports so far, as counted for confirmation.
    pub(crate) reports: u32,
    /// Extrapolations published since the latest report.
    pub(crate) extrapolations: u32,
    /// Time of measurement of the latest report of any member, nanoseconds.
    pub(crate) last_report_ns: i64,
    /// End of freshness of the present contributions, nanoseconds.
    pub(crate) fresh_until_ns: i64,
    /// Alerts of the contributing sources.
    pub(crate) alerts: u8,
    /// Whether a contributing source reports the target on the ground.
    pub(crate) on_ground: bool,
    /// Kind, members and type, as stated by the contributing sources.
    pub(crate) description: Description,
    /// Number of the system track after a merge; 0 without a merge.
    pub(crate) merged_into: u32,
    /// Time of the state last kept; `i64::MIN` if another change has not been kept yet.
    pub(crate) kept_ns: i64,
    /// States since then.
    pub(crate) unkept: u8,
}

kept! {
    /// One system track as a checkpoint keeps it.
    #[derive(Clone, Copy, Debug)]
    pub(crate) struct KeptTrack {
        pub(crate) number: u32,
        pub(crate) merged_into: u32,
        owner: u16,
        life: u8,
        kind: u8,
        members: u16,
        alerts: u8,
        on_ground: bool,
        was_shown: bool,
        reports: u32,
        state_ns: i64,
        last_report_ns: i64,
        fresh_until_ns: i64,
        first_seen_ns: i64,
        log_odds: f64,
        absence: f64,
        course: [f64; 2],
        identity: Identity,
        target_type: TargetType,
        filter: KeptFilter,
    }
}

impl KeptTrack {
    /// State of the track in its life.
    pub(crate) fn life(&self) -> Option<TrackState> {
        TrackState::from_code(self.life)
    }

    /// Whether the track can be of a deployment with this number of sources.
    pub(crate) fn is_of(&self, sources: usize) -> bool {
        usize::from(self.owner) < sources && self.number != 0
    }

    /// Time of the state last sent to subscribers, nanoseconds.
    pub(crate) fn state_ns(&self) -> i64 {
        self.state_ns
    }
}

/// A deadline, the number of the system track, and the track's place; the earliest comes first.
type Deadline = Reverse<(i64, u32, SystemSlot)>;

/// Serialises deadlines in order: the order in the memory of a heap depends on its history.
fn in_order<S: Serializer>(deadlines: &BinaryHeap<Deadline>, serializer: S) -> Result<S::Ok, S::Error> {
    deadlines.clone().into_sorted_vec().serialize(serializer)
}

/// Largest logarithm of the odds: one confirmed track in ten thousand is false.
const LOG_ODDS_MAX: f64 = 9.2;
/// `probability(LOG_ODDS_MAX)`: the value of most targets.
const EXISTENCE_MAX: f32 = 0.999_898_97;

impl SystemEntry {
    /// Adds evidence for the target.
    #[inline]
    pub(crate) fn add_evidence(&mut self, log_ratio: f64) {
        self.log_odds = (self.log_odds + log_ratio).min(LOG_ODDS_MAX);
    }

    /// Probability that the target exists, in (0, 1]; 0 without evidence.
    #[inline]
    pub(crate) fn existence(&self) -> f32 {
        if self.log_odds.is_nan() {
            return 0.0;
        }
        let log_odds = self.log_odds.min(LOG_ODDS_MAX) + self.absence;
        if log_odds == LOG_ODDS_MAX {
            return EXISTENCE_MAX;
        }
        probability(log_odds) as f32
    }

    #[inline]
    pub(crate) fn kept(&self) -> KeptTrack {
        KeptTrack {
            number: self.number,
            merged_into: self.merged_into,
            owner: self.owner,
            life: self.life as u8,
            kind: self.description.kind as u8,
            members: self.description.members,
            alerts: self.alerts,
            on_ground: self.on_ground,
            was_shown: self.was_shown,
            reports: self.reports,
            state_ns: self.state.time_ns,
            last_report_ns: self.last_report_ns,
            fresh_until_ns: self.fresh_until_ns,
            first_seen_ns: self.first_seen_ns,
            log_odds: self.log_odds,
            absence: self.absence,
            course: self.course,
            identity: self.identity,
            target_type: self.description.target_type,
            filter: self.filter.kept(),
        }
    }

    /// A track from a checkpoint; without its members, which come back with their reports.
    fn resumed(kept: &KeptTrack, life: TrackState) -> Self {
        let filter = TargetFilter::resumed(&kept.filter);
        Self {
            identity: kept.identity,
            course: kept.course,
            log_odds: kept.log_odds,
            absence: kept.absence,
            nis: 0.0,
            astray: 0,
            foresight: Foresight::default(),
            first_seen_ns: kept.first_seen_ns,
            point_source: NO_SOURCE,
            is_known: kept.identity.unique_number().is_some() || !kept.was_shown,
            was_shown: kept.was_shown,
            is_counted: kept.was_shown,
            contributors: SourceSet::ALL,
            reports: kept.reports,
            extrapolations: 0,
            last_report_ns: kept.last_report_ns,
            alerts: kept.alerts,
            on_ground: kept.on_ground,
            description: Description {
                kind: TrackKind::from_code(kept.kind).unwrap_or_default(),
                members: kept.members,
                target_type: kept.target_type,
            },
            ..Self::new((kept.number, kept.owner), life, filter, kept.fresh_until_ns)
        }
    }

    fn new((number, owner): (u32, u16), life: TrackState, filter: TargetFilter, fresh_until_ns: i64) -> Self {
        Self {
            number,
            owner,
            life,
            bond: Bond::Free,
            identity: Identity::default(),
            state: filter.state(),
            course: [0.0, 1.0],
            log_odds: f64::NAN,
            absence: 0.0,
            nis: 0.0,
            astray: 0,
            foresight: Foresight::default(),
            first_seen_ns: i64::MAX,
            point_source: NO_SOURCE,
            ownership: Ownership::default(),
            rhythm: Rhythm::default(),
            recognition: Recognition::default(),
            is_known: false,
            was_shown: false,
            is_counted: false,
            is_foreign: false,
            has_led_off: false,
            awaits_leap: false,
            contributors: SourceSet::EMPTY,
            duplicate: None,
            duplicate_due_ns: i64::MIN,
            other_point: None,
            aside_m: [0.0; 2],
            has_points: false,
            coverage_due_ns: i64::MIN,
            column: 0,
            members: None,
            reports: 0,
            extrapolations: 0,
            last_report_ns: filter.time_ns,
            fresh_until_ns,
            alerts: 0,
            on_ground: false,
            description: Description::default(),
            merged_into: 0,
            kept_ns: i64::MIN,
            unkept: 0,
            filter,
        }
    }
}

impl TablePlace for SystemEntry {
    fn is_taken(&self) -> bool {
        self.number != 0
    }

    fn free() -> Self {
        let nowhere = Gaussian::new([0.0; 3], [0.0; 3], &Covariance::default());
        let filter = TargetFilter::new(0, nowhere, false);
        Self::new((0, NO_SOURCE), TrackState::Terminated, filter, i64::MIN)
    }
}

/// The table.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct SystemTracks {
    #[serde(with = "places")]
    entries: Vec<SystemEntry>,
    /// The rule's memory of each track; empty if the rule has none.
    memories: Vec<RuleMemory>,
    free: Vec<SystemSlot>,
    quota: Quota,
    pub(crate) grid: Grid,
    /// Shown tracks without fresh reports.
    pub(crate) silent: SilentTracks,
    /// A place left by an ended track for the next started track.
    vacated: Option<SystemSlot>,
    #[serde(with = "table")]
    by_address: HashMap<UniqueNumber, SystemSlot, NumberHasher>,
    /// Time of the next check of each entry, earliest first. Every entry in use has exactly one deadline here; a
    /// deadline that has become too early is put back when due, so that a report costs no change to the heap.
    #[serde(serialize_with = "in_order")]
    deadlines: BinaryHeap<Deadline>,
    next_number: u32,
    in_state: [usize; TrackState::ALL.len()],
}

impl SystemTracks {
    /// Room for `capacity` system tracks started by `sources` sources, and, if the rule `remembers`, for the rule's
    /// memory.
    pub(crate) fn new(capacity: usize, sources: usize, cell_m: f64, remembers: bool) -> Self {
        Self {
            entries: vec![SystemEntry::free(); capacity],
            memories: vec![RuleMemory::default(); if remembers { capacity } else { 0 }],
            free: (0..capacity as SystemSlot).rev().collect(),
            quota: Quota::new(capacity, sources),
            grid: Grid::new(cell_m, capacity),
            silent: SilentTracks::new(capacity),
            vacated: None,
            by_address: HashMap::with_capacity_and_hasher(2 * capacity, NumberHasher::new(2 * capacity)),
            deadlines: BinaryHeap::with_capacity(capacity),
            next_number: 1,
            in_state: [0; TrackState::ALL.len()],
        }
    }

    /// A new tentative system track with `filter`, started by `owner`; `None` if the table is full for `owner`.
    pub(crate) fn insert(&mut self, owner: u16, filter: TargetFilter, deadline_ns: i64) -> Option<SystemSlot> {
        let number = self.next_number;
        let entry = SystemEntry::new((number, owner), TrackState::Tentative, filter, deadline_ns);
        let slot = match self.vacated.take() {
            Some(slot) => self.replace(slot, entry),
            None => self.take_in(entry, deadline_ns)?,
        };
        self.next_number = numbering::following(self.next_number);
        Some(slot)
    }

    fn take_in(&mut self, entry: SystemEntry, deadline_ns: i64) -> Option<SystemSlot> {
        let slot = self.quota.take(entry.owner).then(|| self.free.pop())??;
        if let Some(memory) = self.memories.get_mut(slot as usize) {
            *memory = RuleMemory::default();
        }
        self.in_state[entry.life as usize] += 1;
        self.deadlines.push(Reverse((deadline_ns, entry.number, slot)));
        self.entries[slot as usize] = entry;
        Some(slot)
    }

    /// Puts an entry in the place of an ended entry. The deadline of the place stands, and is an early deadline.
    #[cold]
    fn replace(&mut self, slot: SystemSlot, entry: SystemEntry) -> SystemSlot {
        if let Some(memory) = self.memories.get_mut(slot as usize) {
            *memory = RuleMemory::default();
        }
        self.in_state[TrackState::Terminated as usize] -= 1;
        self.in_state[entry.life as usize] += 1;
        self.entries[slot as usize] = entry;
        slot
    }

    /// Whether there is a place for a new system track of `owner`.
    pub(crate) fn has_room(&self, owner: u16) -> bool {
        !self.free.is_empty() && self.quota.has_room(owner)
    }

    /// The suspended system track with the longest silence, among those whose place `owner` may have.
    #[cold]
    pub(crate) fn longest_suspended(&self, owner: Option<u16>) -> Option<SystemSlot> {
        let may_go = |from: u16| owner.is_none_or(|owner| self.quota.may_hand_over(from, owner));
        self.silent.longest_suspended(may_go)
    }

    /// Leaves the place of an ended system track to the next track, which `owner` starts.
    #[cold]
    pub(crate) fn vacate(&mut self, slot: SystemSlot, owner: u16) {
        let entry = &mut self.entries[slot as usize];
        if self.quota.hand_over(entry.owner, owner) {
            (entry.owner, self.vacated) = (owner, Some(slot));
        }
    }

    /// Takes in a kept track, which continues in `life`; `None` if the table has no place for the track.
    pub(crate) fn resume(&mut self, kept: &KeptTrack, life: TrackState) -> Option<SystemSlot> {
        let slot = self.take_in(SystemEntry::resumed(kept, life), kept.last_report_ns)?;
        let entry = &self.entries[slot as usize];
        let [x, y, _] = entry.filter.estimate.position_m();
        if life != TrackState::Suspended {
            self.grid.place(slot, x, y);
        }
        if let Some(address) = entry.identity.unique_number() {
            self.by_address.entry(address).or_insert(slot);
        }
        self.follow_silence(slot);
        Some(slot)
    }

    /// Takes the next number, for a track with a new number.
    pub(crate) fn take_number(&mut self) -> u32 {
        let number = self.next_number;
        self.next_number = numbering::following(number);
        number
    }

    /// Returns whether rules have a memory of each track.
    pub(crate) fn remembers(&self) -> bool {
        !self.memories.is_empty()
    }

    /// Number of the next system track.
    pub(crate) fn next_number(&self) -> u32 {
        self.next_number
    }

    /// Continues with this number.
    pub(crate) fn set_next_number(&mut self, number: u32) {
        self.next_number = number.max(1);
    }

    pub(crate) fn get(&self, slot: SystemSlot) -> &SystemEntry {
        &self.entries[slot as usize]
    }

    pub(crate) fn get_mut(&mut self, slot: SystemSlot) -> &mut SystemEntry {
        &mut self.entries[slot as usize]
    }

    /// Memory of a system track in a rule with memory.
    pub(crate) fn memory(&self, slot: SystemSlot) -> &RuleMemory {
        &self.memories[slot as usize]
    }

    /// Both parts of an entry, if the rule has a memory.
    pub(crate) fn get_with_memory(&mut self, slot: SystemSlot) -> (&mut SystemEntry, &mut RuleMemory) {
        (&mut self.entries[slot as usize], &mut self.memories[slot as usize])
    }

    /// Makes the filter's estimate the state, and clears the rule's memory.
    pub(crate) fn forget_state(&mut self, slot: SystemSlot) {
        let entry = &mut self.entries[slot as usize];
        entry.state = entry.filter.state();
        if let Some(memory) = self.memories.get_mut(slot as usize) {
            *memory = RuleMemory::default();
        }
    }

    pub(crate) fn set_life(&mut self, slot: SystemSlot, life: TrackState) {
        let entry = &mut self.entries[slot as usize];
        entry.kept_ns = i64::MIN;
        let before = std::mem::replace(&mut entry.life, life);
        self.in_state[before as usize] -= 1;
        self.in_state[life as usize] += 1;
        self.follow_silence(slot);
    }

    /// Adds a track to the silent tracks, or removes it, according to its life.
    fn follow_silence(&mut self, slot: SystemSlot) {
        let entry = &self.entries[slot as usize];
        let is_silent = match entry.life {
            TrackState::Coasted | TrackState::Suspended => true,
            TrackState::Tentative => entry.was_shown,
            TrackState::Confirmed | TrackState::Terminated => false,
        };
        if is_silent {
            let rests = entry.life == TrackState::Suspended;
            self.silent
                .add(slot, &entry.filter, entry.owner, Rest::of(rests, entry.was_shown));
        } else {
            self.silent.remove(slot);
        }
    }

    /// Makes the system track invisible to searches by place: its number rests.
    pub(crate) fn suspend(&mut self, slot: SystemSlot) {
        self.grid.remove(slot);
        self.set_life(slot, TrackState::Suspended);
    }

    /// Number of entries in `life`.
    pub(crate) fn count_in_state(&self, life: TrackState) -> usize {
        self.in_state[life as usize]
    }

    /// Every place of the table, in use or not.
    pub(crate) fn slots(&self) -> std::ops::Range<SystemSlot> {
        0..self.entries.len() as SystemSlot
    }

    /// Whether no system track lives.
    pub(crate) fn is_empty(&self) -> bool {
        let live = [TrackState::Tentative, TrackState::Confirmed, TrackState::Coasted];
        live.iter().all(|life| self.count_in_state(*life) == 0)
    }

    /// The system track with this address or MMSI.
    pub(crate) fn with_address(&self, address: UniqueNumber) -> Option<SystemSlot> {
        self.by_address.get(&address).copied()
    }

    /// Adds the data of `identity` to the system track's; an address or MMSI once set never changes. Returns whether
    /// `identity` has another address or MMSI, as a rescue aircraft may have.
    #[inline]
    pub(crate) fn identify(&mut self, slot: SystemSlot, identity: &Identity) -> bool {
        // The identities are nearly always equal, and then there is nothing to add.
        *identity != self.entries[slot as usize].identity && self.add_identity(slot, identity)
    }

    #[inline(never)]
    fn add_identity(&mut self, slot: SystemSlot, identity: &Identity) -> bool {
        let entry = &mut self.entries[slot as usize];
        let (carried, stated) = (entry.identity.unique_number(), identity.unique_number());
        let mut merged = identity.or(&entry.identity);
        if let Some(number) = carried {
            merged = merged.with_unique_number(number);
        } else if let Some(number) = stated {
            self.by_address.entry(number).or_insert(slot);
        }
        if merged != entry.identity {
            entry.identity = merged;
            entry.kept_ns = i64::MIN;
        }
        carried.is_some() && stated.is_some() && carried != stated
    }

    /// Makes the system track invisible to searches: the track has ended. The place is freed at the deadline.
    pub(crate) fn end(&mut self, slot: SystemSlot) {
        self.grid.remove(slot);
        self.set_life(slot, TrackState::Terminated);
        let entry = &mut self.entries[slot as usize];
        if let Some(address) = entry.identity.unique_number()
            && self.by_address.get(&address) == Some(&slot)
        {
            self.by_address.remove(&address);
        }
    }

    /// Whether a deadline lies before `time_ns`.
    #[inline]
    pub(crate) fn has_due_before(&self, time_ns: i64) -> bool {
        self.deadlines
            .peek()
            .is_some_and(|Reverse((deadline_ns, ..))| *deadline_ns < time_ns)
    }

    /// The entry whose deadline lies before `time_ns`, earliest first, with that deadline.
    pub(crate) fn due_before(&mut self, time_ns: i64) -> Option<(i64, SystemSlot)> {
        let Reverse((deadline_ns, _, slot)) = *self.deadlines.peek()?;
        if deadline_ns >= time_ns {
            return None;
        }
        self.deadlines.pop();
        Some((deadline_ns, slot))
    }

    /// Puts back an entry that [`SystemTracks::due_before`] yielded.
    pub(crate) fn put_back(&mut self, slot: SystemSlot, deadline_ns: i64) {
        let number = self.entries[slot as usize].number;
        self.deadlines.push(Reverse((deadline_ns, number, slot)));
    }

    /// Frees an ended entry that [`SystemTracks::due_before`] yielded.
    pub(crate) fn free(&mut self, slot: SystemSlot) {
        self.in_state[TrackState::Terminated as usize] -= 1;
        let entry = &mut self.entries[slot as usize];
        entry.number = 0;
        self.quota.give_back(entry.owner);
        self.free.push(slot);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn most_targets_have_the_probability_of_the_most_evidence() {
        assert_eq!(EXISTENCE_MAX, probability(LOG_ODDS_MAX) as f32);
    }
}
