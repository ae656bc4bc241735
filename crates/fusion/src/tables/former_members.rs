//! Sensor tracks that were members of system tracks and report no more: return to the system track under the same
//! number.
//!
//! There are two kinds: members from before the start of the process, and members of suspended system tracks. A sensor
//! track that reports for the first time is looked up once, by source and number.

use std::collections::HashMap;

use serde::{Deserialize, Serialize};

use crate::tables::number_hasher::{NumberHasher, table};
use crate::tables::system_tracks::SystemSlot;

/// The former system track of a sensor track.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct FormerSystem {
    pub(crate) slot: SystemSlot,
    /// Number of the system track: another system track may occupy the place by now.
    pub(crate) number: u32,
    /// Place of the record in the checkpoint.
    pub(crate) place: u32,
}

/// The table.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct FormerMembers {
    #[serde(with = "table")]
    systems: HashMap<(u16, u32), FormerSystem, NumberHasher>,
    /// Places of the checkpoint without a record.
    free: Vec<u32>,
}

impl FormerMembers {
    /// With room for `capacity` sensor tracks.
    pub(crate) fn new(capacity: usize) -> Self {
        Self {
            systems: HashMap::with_capacity_and_hasher(2 * capacity, NumberHasher::new(2 * capacity)),
            free: (0..capacity as u32).rev().collect(),
        }
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.systems.is_empty()
    }

    /// Notes the system track of a sensor track, and returns the place of the record. `None` without room.
    pub(crate) fn add(&mut self, (source, track_number): (u16, u32), slot: SystemSlot, number: u32) -> Option<u32> {
        let known = self.systems.get(&(source, track_number)).map(|known| known.place);
        let place = known.or_else(|| self.free.pop())?;
        let system = FormerSystem { slot, number, place };
        self.systems.insert((source, track_number), system);
        Some(place)
    }

    /// Forgets the sensor tracks whose system track is no longer there, if there is no room left.
    pub(crate) fn make_room(&mut self, is_there: impl Fn(&FormerSystem) -> bool) {
        if self.free.is_empty() {
            let free = &mut self.free;
            self.systems.retain(|_, system| {
                let stays = is_there(system);
                if !stays {
                    free.push(system.place);
                }
                stays
            });
        }
    }

    /// Takes out the system track of a sensor track.
    pub(crate) fn take(&mut self, source: u16, track_number: u32) -> Option<FormerSystem> {
        let system = self.systems.remove(&(source, track_number))?;
        self.free.push(system.place);
        Some(system)
    }

    /// The system track of a sensor track.
    pub(crate) fn get(&self, source: u16, track_number: u32) -> Option<FormerSystem> {
        self.systems.get(&(source, track_number)).copied()
    }

    /// Whether a system track is noted for a sensor track.
    pub(crate) fn contains(&self, source: u16, track_number: u32) -> bool {
        self.systems.contains_key(&(source, track_number))
    }

    pub(crate) fn iter(&self) -> impl Iterator<Item = (&(u16, u32), &FormerSystem)> {
        self.systems.iter()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn records_have_places_of_their_own_and_a_full_table_forgets_ended_tracks_only() {
        let mut members = FormerMembers::new(2);
        let places = [members.add((0, 7), 3, 30), members.add((1, 7), 3, 30)];
        assert_eq!(places, [Some(0), Some(1)]);
        assert_eq!(members.add((0, 7), 4, 40), Some(0), "the same sensor track again");
        assert_eq!(members.add((2, 7), 5, 50), None);
        members.make_room(|system| system.number == 40);
        assert_eq!(members.add((2, 7), 5, 50), Some(1));
        assert!(!members.contains(1, 7));
        let back = FormerSystem {
            slot: 4,
            number: 40,
            place: 0,
        };
        assert_eq!([members.take(0, 7), members.take(0, 7)], [Some(back), None]);
    }
}
