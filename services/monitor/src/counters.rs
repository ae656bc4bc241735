//! Counters of a process or source, in reports.

use messages::{Counter, Counters};
use serde::Serializer;

/// Writes an object with a member per counter, by label, in the order of the codes; an absent counter is 0. A process
/// or source has some 160 counters, mostly 0.
pub(crate) fn serialize<S: Serializer>(counters: &Counters, serializer: S) -> Result<S::Ok, S::Error> {
    let values = Counter::ALL.iter().map(|counter| (counter.label(), counters[*counter]));
    serializer.collect_map(values.filter(|(_, value)| *value != 0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn json_has_the_counters_that_count_something_by_label() {
        let counters = Counters::default().with(Counter::Taken, 5).with(Counter::Lost, 2);
        let value = serialize(&counters, serde_json::value::Serializer).unwrap();
        assert_eq!(value, serde_json::json!({"taken": 5, "lost": 2}));
        let value = serialize(&Counters::default(), serde_json::value::Serializer).unwrap();
        assert_eq!(value, serde_json::json!({}));
    }
}
