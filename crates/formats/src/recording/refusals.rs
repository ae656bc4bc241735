//! Parts of a recording that are not given: how often, why, and where for the first time.
//!
//! There are few reasons with many occurrences: each reason is counted, and the first occurrence is kept with all its
//! details.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::containers::Skipped;
use asterix::Error;

/// Everything refused for one reason.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct RefusalGroup {
    /// The category of the blocks; none for packets and frames, and where no category could be read.
    pub category: Option<u8>,
    /// The item with the error, if within an item.
    pub item: Option<&'static str>,
    /// The reason in a few words.
    pub reason: &'static str,
    /// The blocks, packets or frames.
    pub count: u64,
    /// Their bytes.
    pub octets: u64,
    /// Place at which the first was noticed, bytes from the begin of the recording.
    pub first_offset: usize,
    /// Fault of the first.
    pub first: String,
}

/// Parts of a recording that were rejected.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Refusals {
    by_reason: BTreeMap<RefusalKey, RefusalGroup>,
}

/// Category, reason, item.
type RefusalKey = (Option<u8>, &'static str, Option<&'static str>);

impl Refusals {
    /// The refusals, the most frequent first.
    pub fn by_count(&self) -> Vec<&RefusalGroup> {
        let mut refusals: Vec<&RefusalGroup> = self.by_reason.values().collect();
        refusals.sort_by_key(|refusal| std::cmp::Reverse(refusal.count));
        refusals
    }

    /// Counts something that gave no datagram.
    pub(super) fn skipped(&mut self, skipped: &Skipped) {
        let key = (None, skipped.why.label(), None);
        self.note(key, skipped.octets, skipped.offset, || skipped.to_string());
    }

    /// Counts `octets` that are given up for an error in them.
    pub(super) fn error(&mut self, error: &Error, octets: usize) {
        let key = (error.category(), error.label(), error.item());
        self.note(key, octets, error.offset(), || error.to_string());
    }

    fn note(&mut self, key: RefusalKey, octets: usize, offset: usize, text: impl FnOnce() -> String) {
        let (category, reason, item) = key;
        let refusal = self.by_reason.entry(key).or_insert_with(|| RefusalGroup {
            category,
            item,
            reason,
            count: 0,
            octets: 0,
            first_offset: offset,
            first: text(),
        });
        refusal.count += 1;
        refusal.octets += octets as u64;
    }
}
