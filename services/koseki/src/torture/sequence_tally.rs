//! Losses, told from the numbers of the samples alone.

use std::collections::BTreeMap;

use messages::BatchHeader;

/// Tally of what came from each publisher, by its start time, since the subscriber joined.
#[derive(Debug, Default)]
pub(super) struct SequenceTally(BTreeMap<u64, Publisher>);

#[derive(Debug)]
struct Publisher {
    first: u64,
    next: u64,
    taken: u64,
}

impl SequenceTally {
    /// A slice of `count` samples came to a subscriber that joined at `joined_ns`.
    pub(super) fn take(&mut self, header: &BatchHeader, count: usize, joined_ns: u64) {
        // Of a publisher that started later, every sample is expected.
        let first = if header.incarnation < joined_ns {
            header.first_sequence
        } else {
            0
        };
        let publisher = self.0.entry(header.incarnation).or_insert(Publisher {
            first,
            next: first,
            taken: 0,
        });
        publisher.next = publisher.next.max(header.first_sequence + count as u64);
        publisher.taken += count as u64;
    }

    /// Samples that did not come although later ones of their publisher did.
    pub(super) fn lost(&self) -> u64 {
        self.0
            .values()
            .map(|publisher| publisher.next - publisher.first - publisher.taken)
            .sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_missing_between_numbers_is_lost() {
        let mut tally = SequenceTally::default();
        let mut take = |incarnation, first_sequence, count| {
            let header = BatchHeader {
                incarnation,
                first_sequence,
                ..BatchHeader::default()
            };
            tally.take(&header, count, 100);
            tally.lost()
        };
        assert_eq!([take(50, 7, 3), take(50, 12, 1)], [0, 2], "an older publisher");
        assert_eq!([take(150, 4, 1), take(150, 5, 5)], [6, 6], "a later one");
    }
}
