//! Losses, found by the numbers of the samples alone.

use std::collections::BTreeMap;

/// Tally of received samples of each publisher, by start time, since the subscriber joined.
#[derive(Clone, Debug, Default)]
pub(crate) struct SequenceTally(BTreeMap<u64, Publisher>);

#[derive(Clone, Debug)]
struct Publisher {
    first: u64,
    next: u64,
    taken: u64,
}

impl SequenceTally {
    /// A sample came to a subscriber that joined at `joined_ns`; whether the number has not come before.
    pub(crate) fn take(&mut self, incarnation: u64, sequence: u64, joined_ns: u64) -> bool {
        // Every sample of a publisher that started later is expected.
        let first = if incarnation < joined_ns { sequence } else { 0 };
        let publisher = self.0.entry(incarnation).or_insert(Publisher {
            first,
            next: first,
            taken: 0,
        });
        let is_new = sequence >= publisher.next;
        publisher.next = publisher.next.max(sequence.saturating_add(1));
        publisher.taken += 1;
        is_new
    }

    /// Returns the number of missing samples with a received successor.
    pub(crate) fn lost(&self) -> u64 {
        let lost = |publisher: &Publisher| (publisher.next - publisher.first).saturating_sub(publisher.taken);
        self.0.values().map(lost).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_missing_between_numbers_is_lost() {
        let mut tally = SequenceTally::default();
        let mut take = |incarnation, sequence| {
            tally.take(incarnation, sequence, 100);
            tally.lost()
        };
        assert_eq!(
            [take(50, 7), take(50, 8), take(50, 12)],
            [0, 0, 3],
            "an older publisher"
        );
        assert_eq!([take(150, 4), take(150, 5)], [7, 7], "a later one");
    }
}
