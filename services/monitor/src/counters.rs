//! Counters of one process or source, in reports.

use messages::{Counter, CounterClass, Counters};
use serde::Serializer;

/// Counters of a process as a whole that no other part of a report contains.
pub(crate) fn process_remarks() -> impl Iterator<Item = Counter> {
    Counter::of(CounterClass::Process).chain([Counter::WaitedForConsumers, Counter::WideAreaLost])
}

/// Counters that need the attention of a network's operator.
pub(crate) fn network_trouble() -> impl Iterator<Item = Counter> {
    let records = [Counter::RejectedSource, Counter::BlocksRejected, Counter::BytesRejected];
    Counter::of(CounterClass::NetworkTrouble).chain(records)
}

/// Writes an object with one member per counter, by label, in the order of the codes.
pub(crate) fn serialize<S: Serializer>(counters: &Counters, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_map(Counter::ALL.iter().map(|counter| (counter.label(), counters[*counter])))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn json_has_every_counter_by_label() {
        let counters = Counters::default().with(Counter::Taken, 5);
        let value = serialize(&counters, serde_json::value::Serializer).unwrap();
        assert_eq!(value.as_object().unwrap().len(), Counter::ALL.len());
        assert_eq!((&value["taken"], &value["rejected_jump"]), (&5.into(), &0.into()));
    }
}
