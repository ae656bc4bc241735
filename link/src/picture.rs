//! The picture as it is now: the newest state of every system track.

use std::cmp::Ordering;
use std::collections::BTreeMap;

use messages::layout::Sample as _;
use messages::{BatchHeader, Epochs, SystemTrack, TrackState};

use crate::wire::Message;

/// Newest state of every system track that has not ended.
#[derive(Clone, Debug, Default)]
pub(crate) struct NewestStates {
    states: BTreeMap<u32, SystemTrack>,
    /// Sequence numbers of the last words of tracks that have ended lately.
    ended: BTreeMap<u32, u64>,
    /// Header of a slice that would come next.
    header: BatchHeader,
    epochs: Epochs,
}

/// Bytes after which a part of the picture is full.
const PART_OCTETS: usize = 4_000_000;

/// Tracks that have ended of which it is remembered.
const ENDED_MAX: usize = 4096;

impl NewestStates {
    /// Adds a slice of states. Slices of an older epoch of fusion are ignored.
    pub(crate) fn hear(&mut self, header: &BatchHeader, states: &[SystemTrack]) {
        if self.epochs.compare(header).is_lt() {
            return;
        }
        self.epochs.follow(header);
        self.header = BatchHeader {
            first_sequence: header.first_sequence.wrapping_add(states.len() as u64),
            ..*header
        };
        for state in states {
            if TrackState::from_code(state.state) == Some(TrackState::Terminated) {
                self.states.remove(&state.track_number);
                if self.ended.len() >= ENDED_MAX {
                    // Numbers rise: the smallest ended first, or nearly so.
                    self.ended.pop_first();
                }
                self.ended.insert(state.track_number, state.sequence);
            } else {
                self.states.insert(state.track_number, *state);
            }
        }
    }

    /// Returns whether a state of a slice with this header is newer than the known state of its track.
    pub(crate) fn is_news(&self, header: &BatchHeader, state: &SystemTrack) -> bool {
        match self.epochs.compare(header) {
            Ordering::Less => return false,
            Ordering::Greater => return true,
            Ordering::Equal => {}
        }
        let ended = self.ended.get(&state.track_number);
        let known = self.states.get(&state.track_number).map(|known| &known.sequence);
        known.max(ended).is_none_or(|known| state.sequence > *known)
    }

    /// All states, by the numbers of their tracks.
    pub(crate) fn states(&self) -> impl Iterator<Item = &SystemTrack> {
        self.states.values()
    }

    /// The newest state of a track.
    pub(crate) fn state(&self, number: u32) -> Option<&SystemTrack> {
        self.states.get(&number)
    }

    /// Returns the snapshot in parts: each state as a slice with its own sequence number, and at the end an empty
    /// slice with the snapshot's position.
    pub(crate) fn tell(&self) -> Vec<Message> {
        let mut parts = vec![Message::new()];
        for state in self.states.values() {
            if parts.last().is_none_or(|part| part.octets() >= PART_OCTETS) {
                parts.push(Message::new());
            }
            let header = BatchHeader {
                first_sequence: state.sequence,
                ..self.header
            };
            if let Some(part) = parts.last_mut() {
                part.add(&header, std::slice::from_ref(state));
            }
        }
        let header = BatchHeader {
            schema: SystemTrack::SCHEMA,
            ..self.header
        };
        if let Some(part) = parts.last_mut() {
            part.add::<SystemTrack>(&header, &[]);
        }
        parts
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wire::{self, Head};

    fn state(track_number: u32, sequence: u64, state: TrackState) -> SystemTrack {
        SystemTrack {
            track_number,
            sequence,
            state: state as u8,
            ..SystemTrack::default()
        }
    }

    #[test]
    fn the_picture_has_what_lives_and_nothing_of_an_older_fusion() {
        let mut picture = NewestStates::default();
        let header = |epoch| BatchHeader {
            epoch,
            ..BatchHeader::default()
        };
        picture.hear(
            &header(2),
            &[state(1, 0, TrackState::Confirmed), state(2, 1, TrackState::Confirmed)],
        );
        picture.hear(
            &header(2),
            &[state(1, 2, TrackState::Coasted), state(2, 3, TrackState::Terminated)],
        );
        picture.hear(&header(1), &[state(3, 9, TrackState::Confirmed)]);
        assert_eq!(picture.state(1).map(|state| state.sequence), Some(2));
        assert!(picture.state(2).is_none() && picture.state(3).is_none());
    }

    #[test]
    fn a_rebooted_host_is_heard_again_though_its_clock_is_behind() {
        let mut picture = NewestStates::default();
        let header = |epoch, boot: u32| BatchHeader {
            epoch,
            flags: boot << BatchHeader::BOOT_SHIFT,
            ..BatchHeader::default()
        };
        picture.hear(&header(900, 1), &[state(1, 5, TrackState::Confirmed)]);
        let again = state(1, 0, TrackState::Confirmed);
        assert!(picture.is_news(&header(3, 2), &again), "another boot");
        picture.hear(&header(3, 2), &[again]);
        assert_eq!(picture.state(1).map(|state| state.sequence), Some(0));
        assert!(
            !picture.is_news(&header(901, 1), &state(1, 6, TrackState::Confirmed)),
            "the boot before"
        );
        assert!(picture.is_news(&header(4, 2), &again));
    }

    #[test]
    fn what_is_told_says_how_far_it_reaches_even_if_nothing_lives() {
        let mut picture = NewestStates::default();
        let header = BatchHeader {
            first_sequence: 7,
            ..BatchHeader::default()
        };
        picture.hear(&header, &[state(1, 7, TrackState::Terminated)]);
        let [message] = &picture.tell()[..] else {
            panic!("in one part")
        };
        let (_, told) = wire::read::<SystemTrack>(&message.clone().finish(Head::default()), 1).unwrap();
        assert_eq!(told.len(), 1);
        assert_eq!((told[0].0.first_sequence, told[0].1.len()), (8, 0));
    }

    #[test]
    fn what_is_much_is_told_in_parts() {
        let mut picture = NewestStates::default();
        let header = BatchHeader {
            schema: SystemTrack::SCHEMA,
            ..BatchHeader::default()
        };
        let states: Vec<SystemTrack> = (0..8_000)
            .map(|number| state(number, u64::from(number), TrackState::Confirmed))
            .collect();
        picture.hear(&header, &states);
        let read = |part: Message| wire::read::<SystemTrack>(&part.finish(Head::default()), 1).unwrap().1;
        let parts: Vec<usize> = picture.tell().into_iter().map(|part| read(part).len()).collect();
        assert_eq!(parts.len(), 4);
        assert_eq!(
            parts.iter().sum::<usize>(),
            8_000 + 1,
            "each state, and how far it reaches"
        );
    }
}
