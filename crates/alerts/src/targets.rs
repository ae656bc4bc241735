//! The targets, by number and by place.
//!
//! A pair rule visits a hundred neighbours for each state. Targets therefore lie in slots, which the grid of places
//! names; numbers lead to slots, once for a state.

use std::collections::BTreeMap;

use association::Grid;
use messages::{Identity, SystemTrack};

use crate::target::Target;

/// Side of a cell of the grid, metres.
const CELL_M: f64 = 10_000.0;
/// Greatest width of a search, cells.
const CELLS_MAX: i32 = 64;
/// Weight of a new interval in the usual interval of a target's reports.
const INTERVAL_WEIGHT: f64 = 0.2;

/// What is kept of a target.
#[derive(Clone, Debug)]
pub(crate) struct Known {
    pub(crate) target: Target,
    pub(crate) identity: Identity,
    /// Number of its reports.
    pub(crate) updates: u32,
    /// Reference time of the state with the last report, UTC, nanoseconds.
    pub(crate) reported_ns: i64,
    /// Usual interval of its reports, seconds; 0 before the second one.
    pub(crate) interval_s: f64,
}

/// All targets.
#[derive(Clone, Debug)]
pub(crate) struct Targets {
    slots: BTreeMap<u32, u32>,
    known: Vec<Option<Known>>,
    free: Vec<u32>,
    grid: Grid,
}

impl Targets {
    /// None yet; at most `capacity` at a time.
    pub(crate) fn new(capacity: usize) -> Self {
        Self {
            slots: BTreeMap::new(),
            known: vec![None; capacity],
            free: (0..capacity as u32).rev().collect(),
            grid: Grid::new(CELL_M, capacity),
        }
    }

    pub(crate) fn len(&self) -> usize {
        self.slots.len()
    }

    /// The target with a number.
    pub(crate) fn get(&self, number: u32) -> Option<&Known> {
        self.at(*self.slots.get(&number)?)
    }

    /// The target in a slot.
    pub(crate) fn at(&self, slot: u32) -> Option<&Known> {
        self.known[slot as usize].as_ref()
    }

    /// Keeps the state of a target; returns its slot, `None` without room.
    pub(crate) fn keep(&mut self, track: &SystemTrack, target: Target) -> Option<u32> {
        let (place_m, now_ns) = (target.place_m, target.time_ns);
        let slot = match self.slots.get(&target.number) {
            Some(slot) => *slot,
            None => {
                let slot = self.free.pop()?;
                self.slots.insert(target.number, slot);
                slot
            }
        };
        let before = self.known[slot as usize].take();
        let known = match before {
            Some(known) if track.updates == known.updates => Known {
                target,
                identity: track.identity,
                ..known
            },
            Some(known) => {
                let interval_s = (now_ns - known.reported_ns) as f64 * 1e-9;
                let usual_s = match known.interval_s > 0.0 {
                    true => known.interval_s + INTERVAL_WEIGHT * (interval_s - known.interval_s),
                    false => interval_s,
                };
                Known::reported(track, target, usual_s)
            }
            None => Known::reported(track, target, 0.0),
        };
        self.known[slot as usize] = Some(known);
        self.grid.place(slot, place_m[0], place_m[1]);
        Some(slot)
    }

    /// Puts the slots of all targets but `slot` that may be within a distance of it into `near`.
    pub(crate) fn near(&self, slot: u32, place_m: [f64; 2], reach_m: f64, near: &mut Vec<u32>) {
        near.clear();
        let mut add = |other: u32| {
            if other != slot {
                near.push(other);
            }
        };
        self.grid.near(place_m[0], place_m[1], reach_m, CELLS_MAX, &mut add);
    }

    /// Removes a target.
    pub(crate) fn remove(&mut self, number: u32) {
        if let Some(slot) = self.slots.remove(&number) {
            self.known[slot as usize] = None;
            self.grid.remove(slot);
            self.free.push(slot);
        }
    }
}

impl Known {
    fn reported(track: &SystemTrack, target: Target, interval_s: f64) -> Self {
        Self {
            identity: track.identity,
            updates: track.updates,
            reported_ns: target.time_ns,
            interval_s,
            target,
        }
    }
}
