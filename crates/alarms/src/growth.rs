//! Counters whose growth is an alarm.

use std::collections::BTreeMap;

use crate::registry::AlarmKind;
use crate::subject::Subject;

/// Detector of growing counters: a counter is bad in each round in which it has grown since the previous round.
#[derive(Clone, Debug, Default)]
pub struct Growth {
    counts: BTreeMap<(AlarmKind, Subject), u64>,
}

impl Growth {
    /// Whether `count` has grown since the previous call. The first call compares with `at_first`: 0 for a counter
    /// observed from its start, else the count itself.
    pub fn has_grown(&mut self, kind: AlarmKind, subject: Subject, count: u64, at_first: u64) -> bool {
        let before = self.counts.entry((kind, subject)).or_insert(at_first);
        std::mem::replace(before, count) < count
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn growth_is_found_once() {
        let (mut growth, kind) = (Growth::default(), AlarmKind::SamplesLost);
        let mut look = |source, count, at_first| growth.has_grown(kind, Subject::source(source), count, at_first);
        assert_eq!([look(0, 5, 0), look(0, 5, 0), look(0, 6, 0)], [true, false, true]);
        assert_eq!(
            [look(1, 5, 5), look(1, 7, 7)],
            [false, true],
            "nobody knows when it had become 5"
        );
        assert!(!look(0, 2, 0), "counts begin anew");
    }
}
