//! Places of a table shared by several sources: a flood from one source must not keep the others out.
//!
//! A source may always use the fair share, an equal part of the table, and additionally free places. Unused shares are
//! available to others: a source's *claim* is the largest part of the share that was used, or was refused. Claimed
//! free places are reserved for the source. A source that alone sees nearly everything thus gets nearly the whole
//! table; a flooding source takes nothing from earlier sources, and loses places to later sources as its own entries
//! end.

use serde::{Deserialize, Serialize};

/// The places of a table, by source.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Quota {
    sources: Vec<Places>,
    /// Equal part of the table.
    share: usize,
    free: usize,
    /// Claimed places that the sources do not have.
    reserved: usize,
}

#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
struct Places {
    taken: usize,
    /// At least as many as are taken, up to the share.
    claimed: usize,
}

impl Places {
    fn reserved(&self) -> usize {
        self.claimed.saturating_sub(self.taken)
    }
}

impl Quota {
    /// Of a table with `capacity` places, for `sources` sources.
    pub(crate) fn new(capacity: usize, sources: usize) -> Self {
        Self {
            sources: vec![Places::default(); sources],
            share: capacity / sources,
            free: capacity,
            reserved: 0,
        }
    }

    /// Number of places that `source` has.
    pub(crate) fn taken(&self, source: u16) -> usize {
        self.sources[usize::from(source)].taken
    }

    /// Takes a place for `source`; `false` if none is available.
    pub(crate) fn take(&mut self, source: u16) -> bool {
        let places = &mut self.sources[usize::from(source)];
        if places.reserved() > 0 && self.free > 0 {
            self.reserved -= 1;
        } else if self.free <= self.reserved {
            // The next returned place is reserved for the source.
            if places.claimed < self.share {
                places.claimed += 1;
                self.reserved += 1;
            }
            return false;
        }
        self.free -= 1;
        places.taken += 1;
        places.claimed = places.claimed.max(places.taken.min(self.share));
        true
    }

    /// Whether [`Self::take`] would give `source` a place.
    pub(crate) fn has_room(&self, source: u16) -> bool {
        let reserved = self.sources[usize::from(source)].reserved();
        self.free > self.reserved || (reserved > 0 && self.free > 0)
    }

    /// Whether a place of `from`, given back, would be available to `to`.
    pub(crate) fn may_hand_over(&self, from: u16, to: u16) -> bool {
        let before = self.sources[usize::from(from)];
        let after = Places {
            taken: before.taken - 1,
            ..before
        };
        let receiver = if from == to {
            after
        } else {
            self.sources[usize::from(to)]
        };
        receiver.reserved() > 0 || self.free + 1 > self.reserved + after.reserved() - before.reserved()
    }

    /// Gives a place of `from` to `to`, if permitted; returns whether permitted.
    pub(crate) fn hand_over(&mut self, from: u16, to: u16) -> bool {
        let may = self.may_hand_over(from, to);
        if may {
            self.give_back(from);
            self.take(to);
        }
        may
    }

    /// Gives a place of `source` back.
    pub(crate) fn give_back(&mut self, source: u16) {
        let places = &mut self.sources[usize::from(source)];
        let reserved = places.reserved();
        places.taken -= 1;
        self.reserved += places.reserved() - reserved;
        self.free += 1;
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn one_source_may_have_all_that_nobody_else_wants() {
        let mut quota = Quota::new(10, 2);
        assert!((0..10).all(|_| quota.take(0)));
        assert!(!quota.take(0));
    }

    #[test]
    fn what_a_source_has_had_of_its_share_stays_its_own() {
        let mut quota = Quota::new(10, 2);
        assert!((0..4).all(|_| quota.take(1)));
        (0..4).for_each(|_| quota.give_back(1));
        assert_eq!((0..10).filter(|_| quota.take(0)).count(), 6);
        assert!((0..4).all(|_| quota.take(1)));
        assert!(!quota.take(1), "there is no place left");
    }

    #[test]
    fn who_comes_late_gets_its_share_as_places_are_given_back() {
        let mut quota = Quota::new(10, 2);
        assert!((0..10).all(|_| quota.take(0)));
        for _ in 0..20 {
            quota.take(1);
            quota.give_back(0);
            quota.take(1);
            if !quota.take(0) && quota.sources[0].taken == 5 {
                break;
            }
        }
        assert_eq!((quota.sources[0].taken, quota.sources[1].taken), (5, 5));
    }

    proptest! {
        #[test]
        fn places_add_up_and_nobody_is_kept_from_its_claim(
            capacity in 1usize..40, events in prop::collection::vec((0u16..3, any::<bool>()), 0..300),
        ) {
            let mut quota = Quota::new(capacity, 3);
            for (source, takes) in events {
                let before = quota.sources[usize::from(source)];
                let receiver = (source + 1) % 3;
                if takes && before.taken > 3 {
                    let may = quota.may_hand_over(source, receiver);
                    let had = quota.sources[usize::from(receiver)].taken;
                    prop_assert_eq!(quota.hand_over(source, receiver), may);
                    prop_assert_eq!(quota.sources[usize::from(receiver)].taken, had + usize::from(may));
                } else if takes {
                    prop_assert_eq!(quota.has_room(source), quota.clone().take(source));
                    let taken = quota.take(source);
                    prop_assert!(taken || before.reserved() == 0 || quota.free == 0);
                } else if before.taken > 0 {
                    quota.give_back(source);
                }
                let sum = |of: fn(&Places) -> usize| quota.sources.iter().map(of).sum::<usize>();
                prop_assert_eq!(sum(|places| places.taken) + quota.free, capacity);
                prop_assert_eq!(sum(Places::reserved), quota.reserved);
            }
        }
    }
}
