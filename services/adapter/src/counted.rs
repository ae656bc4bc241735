//! Counts of decoders as counters.

use asterix::DecoderCounts;
use formats::sbs::{AircraftMerger, LineRejection};
use messages::{Counter, Counters};

/// Counters of an ASTERIX decoder.
pub(crate) fn decoded(counts: &DecoderCounts) -> Counters {
    let mut counters = Counters::default();
    counters[Counter::Records] = counts.records;
    counters[Counter::BytesRejected] = counts.octets_skipped;
    counters[Counter::BlocksRejected] = counts.blocks_refused + counts.blocks_cut + counts.blocks_without_table;
    counters
}

/// Counters of the merger of SBS-1 lines.
pub(crate) fn merged(merger: &AircraftMerger) -> Counters {
    let counted = merger.counters();
    let rejected = LineRejection::ALL.iter().map(|reason| counted.rejected(*reason));
    let mut counters = Counters::default();
    counters[Counter::Records] = counted.messages;
    counters[Counter::BlocksRejected] = rejected.sum();
    counters[Counter::RejectedNoPosition] = counted.without_position;
    counters[Counter::TracksDropped] = counted.refused_aircraft;
    counters
}
