//! The system tracks that were shown and are without fresh reports: coasted, withheld, or suspended.
//!
//! The grid holds each system track at the place of its latest report. A target that has flown on for half a minute is
//! far from there, so that a search of the grid does not find it. These tracks are therefore listed apart, with the
//! data for a search side by side: their motion does not change while they are silent.

use messages::NS_PER_S;
use serde::{Deserialize, Serialize};

use crate::update::filter::TargetFilter;

/// Place of a system track in the table of system tracks.
type Slot = u32;

/// Most suspended system tracks at a time; a further track ends the oldest.
pub(crate) const SUSPENDED_MAX: usize = 512;
/// [`SilentTracks::places`] of a system track that is not silent.
const ABSENT: u32 = u32::MAX;
/// Search radius around the place of a silent target in straight flight, metres.
const REACH_M: f64 = 10e3;
/// Largest change of velocity in the search, m/s: a target that flies at 250 m/s has turned by 35°.
const VELOCITY_REACH_MPS: f64 = 150.0;

/// State of the number of a silent system track, in the order in which others take its place.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub(crate) enum Rest {
    /// The number rests, and the track was never shown.
    Unshown,
    /// The number rests.
    Shown,
    /// The number does not rest.
    None,
}

impl Rest {
    pub(crate) fn of(rests: bool, was_shown: bool) -> Self {
        match (rests, was_shown) {
            (false, _) => Self::None,
            (true, false) => Self::Unshown,
            (true, true) => Self::Shown,
        }
    }
}

/// A silent system track in the form read by a search.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct SilentTrack {
    slot: Slot,
    /// Source that started the track.
    owner: u16,
    rest: Rest,
    /// Time of the latest measurement, nanoseconds.
    time_ns: i64,
    position_m: [f64; 2],
    velocity_mps: [f64; 2],
}

/// The list, in no order.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct SilentTracks {
    tracks: Vec<SilentTrack>,
    /// Place in the list, by place in the table of system tracks.
    places: Vec<u32>,
}

impl SilentTracks {
    /// With room for all system tracks of a table of `capacity`.
    pub(crate) fn new(capacity: usize) -> Self {
        Self {
            tracks: Vec::with_capacity(capacity),
            places: vec![ABSENT; capacity],
        }
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.tracks.is_empty()
    }

    /// Lists a system track with its motion, the source that started it, and whether its number rests.
    pub(crate) fn add(&mut self, slot: Slot, filter: &TargetFilter, owner: u16, rest: Rest) {
        let mean = &filter.estimate.mean;
        let silent = SilentTrack {
            slot,
            owner,
            rest,
            time_ns: filter.time_ns,
            position_m: [mean[0], mean[1]],
            velocity_mps: [mean[3], mean[4]],
        };
        let place = &mut self.places[slot as usize];
        if *place == ABSENT {
            *place = self.tracks.len() as u32;
            self.tracks.push(silent);
        } else {
            self.tracks[*place as usize] = silent;
        }
    }

    /// Removes a system track; no effect if the track is not listed.
    pub(crate) fn remove(&mut self, slot: Slot) {
        let place = std::mem::replace(&mut self.places[slot as usize], ABSENT);
        if place == ABSENT {
            return;
        }
        self.tracks.swap_remove(place as usize);
        if let Some(moved) = self.tracks.get(place as usize) {
            self.places[moved.slot as usize] = place;
        }
    }

    /// The suspended system track with the longest silence, among those whose owner `may_go`; tracks that were never
    /// shown come first.
    pub(crate) fn longest_suspended(&self, may_go: impl Fn(u16) -> bool) -> Option<Slot> {
        let suspended = self
            .tracks
            .iter()
            .filter(|silent| silent.rest != Rest::None && may_go(silent.owner));
        let longest = suspended.min_by_key(|silent| (silent.rest, silent.time_ns, silent.slot));
        longest.map(|silent| silent.slot)
    }

    /// The listed system tracks that were shown and may be at a place, with a velocity, at `time_ns`.
    pub(crate) fn near(
        &self,
        position_m: [f64; 2],
        velocity_mps: [f64; 2],
        time_ns: i64,
    ) -> impl Iterator<Item = Slot> {
        let is_near = move |silent: &&SilentTrack| {
            let seconds = (time_ns - silent.time_ns) as f64 / NS_PER_S;
            let (mut apart2, mut change2) = (0.0, 0.0);
            for axis in 0..2 {
                let carried_m = silent.position_m[axis] + seconds * silent.velocity_mps[axis];
                apart2 += (position_m[axis] - carried_m).powi(2);
                change2 += (velocity_mps[axis] - silent.velocity_mps[axis]).powi(2);
            }
            apart2 <= REACH_M * REACH_M && change2 <= VELOCITY_REACH_MPS * VELOCITY_REACH_MPS
        };
        let may_be_found = |silent: &&SilentTrack| silent.rest != Rest::Unshown;
        self.tracks
            .iter()
            .filter(may_be_found)
            .filter(is_near)
            .map(|silent| silent.slot)
    }
}

#[cfg(test)]
mod tests {
    use estimation::Gaussian;
    use messages::Covariance;
    use proptest::prelude::*;

    use super::*;

    fn at(x: f64, vx: f64) -> TargetFilter {
        let covariance = Covariance::diagonal([1.0; 3], [1.0; 3]);
        TargetFilter::new(0, Gaussian::new([x, 0.0, 0.0], [vx, 0.0, 0.0], &covariance), false)
    }

    #[test]
    fn a_silent_track_is_found_where_it_would_be_and_not_where_it_was() {
        let mut silent = SilentTracks::new(3);
        silent.add(1, &at(0.0, 250.0), 0, Rest::None);
        silent.add(2, &at(0.0, -250.0), 0, Rest::None);
        let found = |x: f64, vx: f64| silent.near([x, 0.0], [vx, 0.0], 60_000_000_000).collect::<Vec<_>>();
        assert_eq!(found(15_000.0, 240.0), [1]);
        assert_eq!(found(-14_000.0, -240.0), [2]);
        assert_eq!(found(15_000.0, -240.0), [0; 0]);
        assert_eq!(found(0.0, 250.0), [0; 0]);
    }

    #[test]
    fn those_that_were_never_shown_go_first_and_are_not_found_by_place() {
        let mut silent = SilentTracks::new(3);
        silent.add(0, &at(0.0, 0.0), 0, Rest::Shown);
        silent.add(1, &at(0.0, 0.0), 0, Rest::Unshown);
        silent.add(2, &at(0.0, 0.0), 0, Rest::None);
        assert_eq!(silent.longest_suspended(|_| true), Some(1));
        let found: Vec<_> = silent.near([0.0; 2], [0.0; 2], 0).collect();
        assert_eq!(found, [0, 2]);
    }

    proptest! {
        #[test]
        fn the_list_is_the_set_of_added_tracks(steps in prop::collection::vec((0u32..8, any::<bool>()), 0..60)) {
            let mut silent = SilentTracks::new(8);
            let mut model = std::collections::BTreeSet::new();
            for (slot, adds) in steps {
                if adds {
                    silent.add(slot, &at(0.0, 0.0), 0, Rest::Shown);
                    model.insert(slot);
                } else {
                    silent.remove(slot);
                    model.remove(&slot);
                }
                let listed: Vec<_> = silent.near([0.0; 2], [0.0; 2], 0).collect();
                prop_assert_eq!(&listed.iter().copied().collect::<std::collections::BTreeSet<_>>(), &model);
                prop_assert_eq!(listed.len(), model.len());
                prop_assert_eq!(silent.longest_suspended(|_| true), model.first().copied());
            }
        }
    }
}
