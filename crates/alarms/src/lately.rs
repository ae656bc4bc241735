//! Growth of counters in a recent interval.
//!
//! A single bad report in a thousand is no fault of its source, and an hour of good reports does not excuse later
//! bad ones. Shares are therefore computed over an interval that moves with the clock.

use std::collections::{BTreeMap, VecDeque};

use crate::registry::AlarmKind;
use crate::subject::Subject;

/// Counts and their times, monotonic, nanoseconds; the oldest first.
type CountHistory<const N: usize> = VecDeque<([u64; N], i64)>;

/// Number of steps in which the interval moves.
const STEPS: i64 = 60;

/// Growth of `N` counters of each subject in the recent interval.
#[derive(Clone, Debug)]
pub struct Lately<const N: usize> {
    while_ns: i64,
    past: BTreeMap<(AlarmKind, Subject), CountHistory<N>>,
}

impl<const N: usize> Lately<N> {
    /// Creates an interval of `while_ns` nanoseconds.
    pub fn new(while_ns: i64) -> Self {
        Self {
            while_ns,
            past: BTreeMap::new(),
        }
    }

    /// Returns the growth of counters with the values `counts` at `now_ns` (monotonic, nanoseconds). Before the
    /// first call, the counters are 0.
    pub fn grown(&mut self, kind: AlarmKind, subject: Subject, counts: [u64; N], now_ns: i64) -> [u64; N] {
        let begun = || VecDeque::from([([0; N], now_ns)]);
        let past = self.past.entry((kind, subject)).or_insert_with(begun);
        while past.get(1).is_some_and(|(_, at_ns)| now_ns - at_ns >= self.while_ns) {
            past.pop_front();
        }
        let before = past.front().map_or([0; N], |(counts, _)| *counts);
        if past
            .back()
            .is_none_or(|(_, at_ns)| now_ns - at_ns >= self.while_ns / STEPS)
        {
            past.push_back((counts, now_ns));
        }
        std::array::from_fn(|index| counts[index].saturating_sub(before[index]))
    }
}

#[cfg(test)]
mod tests {
    use test_support::S;

    use super::*;

    #[test]
    fn what_is_long_past_does_not_count() {
        let mut lately = Lately::new(60 * S);
        let mut look = |source, second, count: u64| {
            let subject = Subject::source(source);
            lately.grown(AlarmKind::SourceIsolated, subject, [count, 2 * count], second * S)
        };
        assert_eq!(look(0, 0, 5), [5, 10]);
        for second in 1..60 {
            assert_eq!(
                look(0, second, 5 + second as u64),
                [5 + second as u64, 2 * (5 + second as u64)]
            );
        }
        assert_eq!(look(0, 61, 70), [64, 128], "there were 6 a minute before");
        assert_eq!(look(0, 1061, 71), [1, 2]);
        assert_eq!(look(1, 1061, 3), [3, 6], "another source");
        assert_eq!(look(0, 1062, 1), [0, 0], "counts begin anew");
    }
}
