//! Continuity of track numbers from the point of view of an independent subscriber.
//!
//! Addresses identify the targets, regardless of track numbers. The tally thus detects a target that continues
//! under another number, and a number reused for another target. States of an epoch older than the newest are
//! excluded.

use std::collections::{BTreeMap, BTreeSet};

use messages::{SystemTrack, TrackState, UniqueNumber};

/// Tally of targets and their track numbers.
#[derive(Clone, Debug, Default)]
pub struct NumberTally {
    epoch: u64,
    began_ns: i64,
    latest_ns: i64,
    states: u64,
    late: u64,
    /// Numbers of live tracks, by the address that they carry. A target may have two until they are merged.
    carriers: BTreeMap<u32, BTreeSet<u32>>,
    shown: BTreeSet<u32>,
    live: BTreeSet<u32>,
    heard: BTreeSet<u32>,
    first: BTreeMap<u32, u32>,
    ended: BTreeSet<u32>,
    reused: BTreeSet<u32>,
}

impl NumberTally {
    /// Adds a state published by the fusion of `epoch`.
    pub fn take(&mut self, epoch: u64, track: &SystemTrack) {
        let sent_ns = track.stages.fused_ns;
        if epoch < self.epoch {
            self.late += u64::from(sent_ns > self.began_ns);
            return;
        }
        if epoch > self.epoch {
            (self.epoch, self.began_ns) = (epoch, sent_ns);
            self.heard.clear();
        }
        self.states += 1;
        self.latest_ns = self.latest_ns.max(sent_ns);
        let number = track.track_number;
        self.heard.insert(number);
        if track.state == TrackState::Terminated as u8 {
            self.live.remove(&number);
            self.carriers.retain(|_, numbers| {
                numbers.remove(&number);
                !numbers.is_empty()
            });
            self.ended.insert(number);
            return;
        }
        if track.state == TrackState::Suspended as u8 {
            // Its target keeps the number, and is not shown.
            self.live.remove(&number);
            return;
        }
        if self.ended.contains(&number) {
            self.reused.insert(number);
        }
        if track.state == TrackState::Tentative as u8 {
            return;
        }
        self.live.insert(number);
        if let Some(address) = track.identity.unique_number().map(UniqueNumber::to_bits) {
            if *self.first.entry(number).or_insert(address) != address {
                self.reused.insert(number);
            }
            self.carriers.entry(address).or_default().insert(number);
            self.shown.insert(address);
        }
    }

    /// Clears the assignment of numbers to targets: targets receive new numbers where the earlier numbers are lost.
    /// The set of used numbers remains.
    pub fn forget_carriers(&mut self) {
        self.carriers.clear();
    }

    /// Clears the shown addresses: [`Self::shown`] counts from now on.
    pub fn begin(&mut self) {
        self.shown.clear();
    }

    /// Returns the newest epoch; 0 before the first state.
    pub fn epoch(&self) -> u64 {
        self.epoch
    }

    /// Returns the monotonic time at which the first state of the newest epoch was sent, nanoseconds.
    pub fn began_ns(&self) -> i64 {
        self.began_ns
    }

    /// Returns the monotonic time at which the latest state was sent, nanoseconds.
    pub fn latest_ns(&self) -> i64 {
        self.latest_ns
    }

    /// Returns the number of states taken, without those of older epochs.
    pub fn states(&self) -> u64 {
        self.states
    }

    /// Returns the number of states sent by an older fusion after the start of a newer one.
    pub fn late(&self) -> u64 {
        self.late
    }

    /// Returns the numbers of the live tracks that carry each address.
    pub fn carriers(&self) -> &BTreeMap<u32, BTreeSet<u32>> {
        &self.carriers
    }

    /// Whether an address was shown since [`Self::begin`].
    pub fn shown(&self, address: u32) -> bool {
        self.shown.contains(&address)
    }

    /// Returns the number of addresses shown since [`Self::begin`].
    pub fn shown_count(&self) -> usize {
        self.shown.len()
    }

    /// Returns the numbers of confirmed tracks that have not ended.
    pub fn live(&self) -> &BTreeSet<u32> {
        &self.live
    }

    /// Returns the numbers seen again after their end, or with another address.
    pub fn reused(&self) -> &BTreeSet<u32> {
        &self.reused
    }

    /// Returns targets of `before` that the newest epoch publishes under none of their previous numbers: the
    /// address, a previous number, and a present number.
    pub fn renumbered(&self, before: &Self) -> Vec<(u32, u32, u32)> {
        let moved = before.carriers.iter().filter_map(|(address, numbers)| {
            let mut now = self.carriers.get(address)?.intersection(&self.heard).peekable();
            let has = **now.peek()?;
            let had = *numbers.first()?;
            (!now.any(|number| numbers.contains(number))).then_some((*address, had, has))
        });
        moved.collect()
    }

    /// Returns tracks live in `before` that the newest epoch has neither continued nor terminated.
    pub fn forgotten(&self, before: &Self) -> Vec<u32> {
        let unheard = before.live.iter().filter(|number| !self.heard.contains(number));
        unheard.copied().collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use messages::Identity;

    fn state(number: u32, address: u32, state: TrackState, sent_ns: i64) -> SystemTrack {
        let mut track = SystemTrack {
            track_number: number,
            state: state as u8,
            identity: Identity::default().with_address(address),
            ..SystemTrack::default()
        };
        track.stages.fused_ns = sent_ns;
        track
    }

    #[test]
    fn what_goes_wrong_with_numbers_is_found() {
        let mut tally = NumberTally::default();
        for (number, address) in [(1, 11), (2, 12), (3, 13)] {
            tally.take(5, &state(number, address, TrackState::Confirmed, 100));
        }
        let before = tally.clone();
        tally.take(6, &state(1, 11, TrackState::Confirmed, 200));
        tally.take(6, &state(7, 12, TrackState::Confirmed, 201));
        assert_eq!(
            (tally.renumbered(&before), tally.forgotten(&before)),
            (vec![(12, 2, 7)], vec![2, 3])
        );
        // States that an older fusion left in the queue are no fault; states sent later are.
        tally.take(5, &state(2, 12, TrackState::Confirmed, 150));
        assert_eq!((tally.late(), tally.carriers()[&12].last()), (0, Some(&7)));
        tally.take(5, &state(2, 12, TrackState::Confirmed, 202));
        assert_eq!((tally.late(), tally.reused().len()), (1, 0));
        tally.take(6, &state(1, 14, TrackState::Confirmed, 203));
        tally.take(6, &state(7, 12, TrackState::Terminated, 204));
        tally.take(6, &state(7, 12, TrackState::Tentative, 205));
        assert_eq!(tally.reused().iter().copied().collect::<Vec<_>>(), [1, 7]);
        tally.take(6, &state(8, 15, TrackState::Confirmed, 206));
        tally.forget_carriers();
        let before = tally.clone();
        tally.take(7, &state(9, 15, TrackState::Confirmed, 207));
        assert_eq!((tally.renumbered(&before), tally.began_ns()), (vec![], 207));
        tally.take(7, &state(8, 16, TrackState::Confirmed, 208));
        assert_eq!((tally.reused().len(), tally.carriers().len()), (3, 2));
    }

    #[test]
    fn a_suspended_track_keeps_the_number_for_its_target_and_is_not_forgotten() {
        let mut tally = NumberTally::default();
        tally.take(5, &state(2, 12, TrackState::Confirmed, 100));
        tally.begin();
        tally.take(5, &state(2, 12, TrackState::Suspended, 101));
        let before = tally.clone();
        tally.take(6, &state(3, 13, TrackState::Confirmed, 102));
        assert_eq!(tally.forgotten(&before), [0; 0]);
        let mut other = tally.clone();
        tally.take(6, &state(2, 12, TrackState::Confirmed, 103));
        assert_eq!((tally.renumbered(&before), tally.reused().len()), (vec![], 0));
        other.take(6, &state(9, 12, TrackState::Confirmed, 103));
        assert_eq!(other.renumbered(&before), [(12, 2, 9)]);
    }

    #[test]
    fn a_target_that_had_two_tracks_until_they_were_merged_goes_on() {
        let mut tally = NumberTally::default();
        for number in [2, 9] {
            tally.take(5, &state(number, 12, TrackState::Confirmed, 100));
        }
        let before = tally.clone();
        tally.take(5, &state(9, 12, TrackState::Terminated, 101));
        tally.take(6, &state(2, 12, TrackState::Confirmed, 102));
        assert_eq!(tally.renumbered(&before), []);
        tally.take(6, &state(2, 12, TrackState::Terminated, 103));
        tally.take(6, &state(10, 12, TrackState::Confirmed, 104));
        assert_eq!(tally.renumbered(&before), [(12, 2, 10)]);
    }
}
