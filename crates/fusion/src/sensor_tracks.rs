//! The live sensor tracks of all sources: latest report, history, and the system track each belongs to.

use messages::SensorTrack;
use rustc_hash::FxHashMap;

use crate::history::Histories;
use crate::quality::Qualities;

/// Place of a sensor track in its table.
pub(crate) type SensorSlot = u32;

/// [`SensorEntry::system`] of a sensor track that belongs to no system track yet.
pub(crate) const NO_SYSTEM: u32 = u32::MAX;

/// What a sensor track is to its system track.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Role {
    /// It speaks for its source.
    Primary,
    /// Its source already has a primary there: another part of the same target, or a number not yet taken over.
    Duplicate,
}

/// One live sensor track.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SensorEntry {
    pub(crate) latest: SensorTrack,
    pub(crate) role: Role,
    /// System track it belongs to, or [`NO_SYSTEM`].
    pub(crate) system: u32,
    /// Next sensor track of the same system track.
    pub(crate) next: Option<SensorSlot>,
    /// Reports in a row that did not fit the rest of the system track.
    pub(crate) misfits: u32,
    /// Another system track that the last reports fitted, and how many in a row.
    pub(crate) rival: Option<(u32, u32)>,
}

/// The table: preallocated entries, found by source and track number.
#[derive(Debug)]
pub(crate) struct SensorTracks {
    entries: Vec<SensorEntry>,
    free: Vec<SensorSlot>,
    by_number: FxHashMap<(u16, u32), SensorSlot>,
    pub(crate) histories: Histories,
    pub(crate) qualities: Qualities,
}

impl SensorTracks {
    pub(crate) fn new(capacity: usize, stored_reports: usize) -> Self {
        let empty = SensorEntry {
            latest: SensorTrack::default(),
            role: Role::Duplicate,
            system: NO_SYSTEM,
            next: None,
            misfits: 0,
            rival: None,
        };
        // With room for twice the entries, the map clears its tombstones in place and never grows.
        let by_number = FxHashMap::with_capacity_and_hasher(2 * capacity, rustc_hash::FxBuildHasher);
        Self {
            entries: vec![empty; capacity],
            free: (0..capacity as SensorSlot).rev().collect(),
            by_number,
            histories: Histories::new(capacity, stored_reports + 1),
            qualities: Qualities::new(capacity),
        }
    }

    pub(crate) fn find(&self, source: u16, number: u32) -> Option<SensorSlot> {
        self.by_number.get(&(source, number)).copied()
    }

    /// A new entry for `report`, not yet linked to a system track; `None` if the table is full.
    pub(crate) fn insert(&mut self, report: &SensorTrack) -> Option<SensorSlot> {
        let slot = self.free.pop()?;
        self.by_number.insert((report.source, report.track_number), slot);
        self.histories.clear(slot as usize);
        self.qualities.clear(slot as usize);
        self.entries[slot as usize] = SensorEntry {
            latest: *report,
            role: Role::Duplicate,
            system: NO_SYSTEM,
            next: None,
            misfits: 0,
            rival: None,
        };
        self.histories.push(slot as usize, report);
        Some(slot)
    }

    /// Stores a further report of the sensor track in `slot`.
    pub(crate) fn update(&mut self, slot: SensorSlot, report: &SensorTrack) {
        self.entries[slot as usize].latest = *report;
        self.histories.push(slot as usize, report);
    }

    /// Frees `slot`, which no system track may link to any more.
    pub(crate) fn remove(&mut self, slot: SensorSlot) {
        let latest = &self.entries[slot as usize].latest;
        self.by_number.remove(&(latest.source, latest.track_number));
        self.free.push(slot);
    }

    pub(crate) fn get(&self, slot: SensorSlot) -> &SensorEntry {
        &self.entries[slot as usize]
    }

    pub(crate) fn get_mut(&mut self, slot: SensorSlot) -> &mut SensorEntry {
        &mut self.entries[slot as usize]
    }
}
