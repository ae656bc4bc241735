//! Counts of decoders as counters.

use asterix::DecoderCounts;
use messages::{Counter, Counters};

/// Counters of an ASTERIX decoder.
pub(crate) fn decoded(counts: &DecoderCounts) -> Counters {
    let mut counters = Counters::default();
    counters[Counter::Records] = counts.records;
    counters[Counter::BytesRejected] = counts.octets_skipped;
    counters[Counter::BlocksRejected] = counts.blocks_refused + counts.blocks_cut + counts.blocks_without_table;
    counters
}
