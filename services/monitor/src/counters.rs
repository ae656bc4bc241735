//! The counters of one process or source, and what they add up to.

use messages::{COUNTERS_MAX, Counter};
use serde::{Serialize, Serializer};

/// Counters that show how many there are now, not how many there have been.
const LEVELS: [Counter; 3] = [Counter::LiveTracks, Counter::TentativeTracks, Counter::CoastedTracks];

/// Why an adapter did not pass a report on.
pub(crate) const REJECTIONS: [Counter; 12] = [
    Counter::RejectedFieldMonitor,
    Counter::RejectedTestTarget,
    Counter::RejectedNoPosition,
    Counter::RejectedNoTrackNumber,
    Counter::RejectedPosition,
    Counter::RejectedSpeed,
    Counter::RejectedJump,
    Counter::RejectedTime,
    Counter::RejectedLate,
    Counter::RejectedQuality,
    Counter::RejectedSource,
    Counter::RefusedTracks,
];

/// What else an adapter says of records that it did not, or not wholly, turn into reports.
pub(crate) const ADAPTER_REMARKS: [Counter; 5] = [
    Counter::ServiceMessages,
    Counter::BlocksRefused,
    Counter::BytesRefused,
    Counter::RejectedHeight,
    Counter::HeightAssumed,
];

/// Reports that fusion took, but did not use.
pub(crate) const FUSION_REFUSALS: [Counter; 6] = [
    Counter::Duplicates,
    Counter::OutOfOrder,
    Counter::Invalid,
    Counter::SchemaMismatch,
    Counter::QueueFull,
    Counter::TableFull,
];

/// What crosses a process's socket; if none of it does, it has none.
pub(crate) const TRAFFIC: [Counter; 5] = [
    Counter::Datagrams,
    Counter::DatagramsRefused,
    Counter::Connections,
    Counter::DatagramsSent,
    Counter::SendFailures,
];

/// What an operator of a network should look into.
pub(crate) const NETWORK_TROUBLE: [Counter; 7] = [
    Counter::DatagramsRefused,
    Counter::DatagramsUnusable,
    Counter::KernelDrops,
    Counter::RejectedSource,
    Counter::BlocksRefused,
    Counter::BytesRefused,
    Counter::SendFailures,
];

/// Values of all counters. In JSON: an object with one member per counter, by label, in the order of their codes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Counters([u64; COUNTERS_MAX]);

impl Default for Counters {
    fn default() -> Self {
        Self([0; COUNTERS_MAX])
    }
}

impl Counters {
    /// The value of one counter.
    pub fn get(&self, counter: Counter) -> u64 {
        self.0[counter as usize]
    }

    /// The sum of several counters.
    pub fn sum(&self, counters: &[Counter]) -> u64 {
        counters.iter().map(|counter| self.get(*counter)).sum()
    }

    /// What `later` has counted, on top of this. Levels are those of `later`.
    #[must_use]
    pub(crate) fn followed_by(&self, later: &Self) -> Self {
        let mut sum = Self(std::array::from_fn(|index| {
            self.0[index].saturating_add(later.0[index])
        }));
        for level in LEVELS {
            sum.0[level as usize] = later.get(level);
        }
        sum
    }

    #[cfg(test)]
    pub(crate) fn with(mut self, counter: Counter, value: u64) -> Self {
        self.0[counter as usize] = value;
        self
    }
}

impl From<[u64; COUNTERS_MAX]> for Counters {
    fn from(values: [u64; COUNTERS_MAX]) -> Self {
        Self(values)
    }
}

impl Serialize for Counters {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(Counter::ALL.iter().map(|counter| (counter.label(), self.get(*counter))))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_add_up_and_levels_do_not() {
        let first = Counters::default().with(Counter::Taken, 5).with(Counter::LiveTracks, 7);
        let second = Counters::default().with(Counter::Taken, 2).with(Counter::LiveTracks, 3);
        let both = first.followed_by(&second);
        assert_eq!((both.get(Counter::Taken), both.get(Counter::LiveTracks)), (7, 3));
    }

    #[test]
    fn every_level_says_that_it_is_one_and_every_rejection_is_listed() {
        for counter in Counter::ALL {
            assert_eq!(
                counter.sentence().starts_with("Level:"),
                LEVELS.contains(counter),
                "{counter:?}"
            );
            let listed = REJECTIONS.contains(counter) || ADAPTER_REMARKS.contains(counter);
            assert!(listed || !counter.label().starts_with("rejected_"), "{counter:?}");
        }
    }

    #[test]
    fn json_has_every_counter_by_label() {
        let value = serde_json::to_value(Counters::default().with(Counter::Taken, 5)).unwrap();
        assert_eq!(value.as_object().unwrap().len(), Counter::ALL.len());
        assert_eq!(value["taken"], 5);
        assert_eq!(value["rejected_jump"], 0);
    }
}
