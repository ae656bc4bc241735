//! Short numbers for tracks.
//!
//! The pipeline numbers tracks with 32 bits and never uses a number again; ASTERIX has 12 or 16 bits for a track
//! number. A receiver distinguishes tracks by these numbers alone. Therefore no two live tracks may have the same
//! number, a track must keep its number, and the number of a terminated track must rest for a while; otherwise the
//! receiver joins two targets.
//!
//! A track gets its own number if short enough and free, otherwise the next free number after the shortened number.
//! Numbers of consecutive tracks are thus reused only after all other numbers. The table has a fixed size. Terminated
//! tracks remain in the table until their room is needed, which lengthens the rest. Then all rested tracks leave,
//! together with silent tracks, because some sources report no end of a track. A table full of live tracks rejects
//! the next track.

use rustc_hash::FxHashMap;

/// A number rests at least this long after its track's end, nanoseconds.
const REST_NS: i64 = 60_000_000_000;
/// A track that is silent for this long has ended, nanoseconds.
const SILENCE_NS: i64 = 600_000_000_000;

/// Table of short numbers, with data `T` of each track.
#[derive(Debug)]
pub(super) struct TrackNumbers<T> {
    tracks: FxHashMap<u32, NumberedTrack<T>>,
    tracks_max: usize,
    /// Bit n for the number n.
    taken: Vec<u64>,
    /// The greatest number; the least is 1.
    greatest: u16,
    /// No track leaves the table before this time.
    sweep_from_ns: i64,
}

/// A track in the table.
#[derive(Clone, Copy, Debug)]
pub(super) struct NumberedTrack<T> {
    /// Short number.
    pub(super) number: u16,
    /// True for its first report.
    pub(super) is_first: bool,
    /// Memory of the track.
    pub(super) memory: T,
    ended: bool,
    last_ns: i64,
}

impl<T: Default> TrackNumbers<T> {
    /// A table of up to `tracks_max` tracks, ended ones included, with numbers from 1 to `greatest`.
    pub(super) fn new(greatest: u16, tracks_max: usize) -> Self {
        let tracks_max = tracks_max.min(usize::from(greatest));
        Self {
            // Twice the room, so that the map can tidy up in place instead of growing.
            tracks: FxHashMap::with_capacity_and_hasher(2 * tracks_max, Default::default()),
            tracks_max,
            taken: vec![0; usize::from(greatest) / 64 + 1],
            greatest,
            sweep_from_ns: i64::MIN,
        }
    }

    /// Returns the entry of a track with a report at `now_ns`, a new entry at the first report; `None` if the table
    /// is full. A terminated track restarts with its number.
    pub(super) fn report(&mut self, track: u32, now_ns: i64) -> Option<&mut NumberedTrack<T>> {
        if !self.tracks.contains_key(&track) {
            let number = self.free_number(track, now_ns)?;
            self.taken[usize::from(number) / 64] |= 1 << (number % 64);
            self.tracks.insert(track, NumberedTrack::new(number, now_ns));
            return self.tracks.get_mut(&track);
        }
        let entry = self.tracks.get_mut(&track)?;
        if entry.ended {
            *entry = NumberedTrack::new(entry.number, now_ns);
        } else {
            entry.is_first = false;
            entry.last_ns = now_ns;
        }
        Some(entry)
    }

    /// The entry of a track that ends; `None` if it never reported or has ended before.
    pub(super) fn end(&mut self, track: u32, now_ns: i64) -> Option<&NumberedTrack<T>> {
        let entry = self.tracks.get_mut(&track).filter(|entry| !entry.ended)?;
        entry.ended = true;
        entry.is_first = false;
        entry.last_ns = now_ns;
        self.sweep_from_ns = self.sweep_from_ns.min(entry.leaves_ns());
        Some(entry)
    }

    fn free_number(&mut self, track: u32, now_ns: i64) -> Option<u16> {
        if self.tracks.len() >= self.tracks_max {
            self.sweep(now_ns);
        }
        if self.tracks.len() >= self.tracks_max {
            return None;
        }
        let own = (track.wrapping_sub(1) % u32::from(self.greatest)) as u16 + 1;
        let is_free = |number: &u16| self.taken[usize::from(*number) / 64] >> (number % 64) & 1 == 0;
        (own..=self.greatest).chain(1..own).find(is_free)
    }

    /// Takes rested and silent tracks out, and notes when there will be more of them.
    fn sweep(&mut self, now_ns: i64) {
        if now_ns < self.sweep_from_ns {
            return;
        }
        let mut next_ns = i64::MAX;
        self.tracks.retain(|_, track| {
            let stays = now_ns < track.leaves_ns();
            if stays {
                next_ns = next_ns.min(track.leaves_ns());
            } else {
                self.taken[usize::from(track.number) / 64] &= !(1 << (track.number % 64));
            }
            stays
        });
        self.sweep_from_ns = next_ns;
    }
}

impl<T: Default> NumberedTrack<T> {
    fn new(number: u16, now_ns: i64) -> Self {
        Self {
            number,
            is_first: true,
            memory: T::default(),
            ended: false,
            last_ns: now_ns,
        }
    }
}

impl<T> NumberedTrack<T> {
    /// Time at which it may leave the table, nanoseconds.
    fn leaves_ns(&self) -> i64 {
        self.last_ns
            .saturating_add(if self.ended { REST_NS } else { SILENCE_NS })
    }
}

#[cfg(test)]
mod tests {
    use std::collections::{HashMap, HashSet};

    use proptest::prelude::*;

    use super::*;
    use test_support::S;

    fn number(numbers: &mut TrackNumbers<()>, track: u32, now_ns: i64) -> Option<u16> {
        numbers.report(track, now_ns).map(|entry| entry.number)
    }

    #[test]
    fn a_track_has_its_own_number_where_it_can() {
        let mut numbers = TrackNumbers::new(4095, 4095);
        assert_eq!(number(&mut numbers, 17, 0), Some(17));
        assert_eq!(number(&mut numbers, 4095, 0), Some(4095));
        assert_eq!(number(&mut numbers, 4095 + 17, 0), Some(18), "17 is taken");
        assert_eq!(number(&mut numbers, 2 * 4095, 0), Some(1), "goes round, without 0");
        assert_eq!(
            number(&mut numbers, 0, 0),
            Some(256),
            "2^32 is 256 more than a multiple of 4095"
        );
    }

    #[test]
    fn numbers_rest_after_the_end_and_silent_tracks_leave() {
        let mut numbers = TrackNumbers::new(2, 2);
        assert_eq!(number(&mut numbers, 1, 0), Some(1));
        assert_eq!(number(&mut numbers, 2, 0), Some(2));
        assert_eq!(number(&mut numbers, 3, 0), None, "full");
        assert!(numbers.end(1, 10 * S).is_some());
        assert!(numbers.end(1, 11 * S).is_none(), "has ended");
        assert_eq!(number(&mut numbers, 3, 69 * S), None, "the number rests");
        assert_eq!(number(&mut numbers, 3, 70 * S), Some(1));
        assert_eq!(number(&mut numbers, 4, 500 * S), None);
        assert_eq!(number(&mut numbers, 4, 600 * S), Some(2), "2 fell silent");
    }

    #[test]
    fn a_track_that_begins_again_keeps_its_number() {
        let mut numbers = TrackNumbers::<()>::new(4095, 10);
        assert!(numbers.report(5, 0).unwrap().is_first);
        assert!(!numbers.report(5, S).unwrap().is_first);
        assert!(!numbers.end(5, 2 * S).unwrap().is_first);
        let again = numbers.report(5, 3 * S).unwrap();
        assert!(again.is_first && again.number == 5);
        assert!(numbers.end(6, 0).is_none(), "never seen");
    }

    #[test]
    fn numbers_come_back_when_nearly_all_others_have_been_used_and_not_while_they_live() {
        let (greatest, lives, old) = (u16::MAX, 100, 17);
        let mut numbers = TrackNumbers::new(greatest, 16_384);
        let mut last_use = HashMap::new();
        for track in 1..=3 * u32::from(greatest) {
            let now_ns = i64::from(track) * S / 10;
            let found = number(&mut numbers, track, now_ns).unwrap();
            if let Some(before) = last_use.insert(found, track) {
                assert!(
                    track - before >= u32::from(greatest) - lives,
                    "{found}: {before}, {track}"
                );
                assert_ne!(found, old as u16, "it lives");
            }
            if track > old {
                assert_eq!(number(&mut numbers, old, now_ns), Some(old as u16));
            }
            if track > lives && track - lives != old {
                assert!(numbers.end(track - lives, now_ns).is_some());
            }
        }
    }

    proptest! {
        /// For any sequence of reports, live tracks have different numbers, each track keeps its number, and a reused
        /// number has rested.
        #[test]
        fn numbers_are_unique_stable_and_rested(
            events in prop::collection::vec((0..60u32, 0..20i64, prop::bool::weighted(0.3)), 1..400),
            greatest in 1..40u16, tracks_max in 1..40usize,
        ) {
            let mut numbers = TrackNumbers::new(greatest, tracks_max);
            let mut live = HashMap::<u32, (u16, i64)>::new();
            let mut released = HashMap::<u16, (u32, i64)>::new();
            let mut now_ns = 0;
            for (track, step_s, ends) in events {
                now_ns += step_s * S;
                live.retain(|_, (_, last_ns)| now_ns - *last_ns < SILENCE_NS);
                if ends {
                    let ended = numbers.end(track, now_ns).map(|entry| entry.number);
                    if let Some((known, _)) = live.remove(&track) {
                        prop_assert_eq!(ended, Some(known));
                        released.insert(known, (track, now_ns));
                    }
                    continue;
                }
                let Some(found) = number(&mut numbers, track, now_ns) else {
                    prop_assert!(!live.contains_key(&track), "a live track was refused");
                    continue;
                };
                prop_assert!((1..=greatest).contains(&found));
                if let Some((known, _)) = live.get(&track) {
                    prop_assert_eq!(*known, found);
                } else if let Some((before, ended_ns)) = released.get(&found) {
                    prop_assert!(*before == track || now_ns - ended_ns >= REST_NS);
                }
                live.insert(track, (found, now_ns));
                let distinct: HashSet<u16> = live.values().map(|(number, _)| *number).collect();
                prop_assert_eq!(distinct.len(), live.len());
                prop_assert!(live.len() <= tracks_max);
            }
        }
    }
}
