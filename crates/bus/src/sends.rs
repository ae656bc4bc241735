//! Protocol of a topic's hint: the word counts sends, and a reader counts the sends received so far.
//!
//! # No slice of a living publisher of this crate is overlooked
//! The publisher writes the queue, and then increments the word (release). A reader reads the word (acquire) before it
//! looks into the queue. If the queue is empty, the reader has received all sends up to that value of the word; from
//! then on the reader counts received slices. The reader looks again while the count differs from the word.
//!
//! The count never exceeds the number of received sends. Once all increments are visible, the word is the number of
//! sends: if the two are equal, nothing waits. Only while an increment is still missing (a slice was received before
//! the publisher incremented the word), a slice of another publisher may wait unseen. A publisher that is killed at
//! this moment, or gives no hint, makes this last until the next full look. After an overflow the count is too small,
//! and the reader looks until the queue is empty. The workspace `models` checks the protocol in all orders of
//! operations.

use std::sync::atomic::Ordering::{Acquire, Release};

use crate::atomic::AtomicU64;

/// The word of a topic.
pub(crate) trait Word {
    /// States that a slice has entered the queues.
    fn raise(&self);
    /// Present value.
    fn value(&self) -> u64;
}

impl Word for AtomicU64 {
    #[inline]
    fn raise(&self) {
        self.fetch_add(1, Release);
    }

    #[inline]
    fn value(&self) -> u64 {
        self.load(Acquire)
    }
}

/// A reader's count of the sends received so far.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct ReceivedSends {
    /// In the terms of the word; `None` before the first empty queue.
    count: Option<u64>,
}

impl ReceivedSends {
    /// Whether all sends have been received, as far as the word shows.
    #[inline]
    pub(crate) fn are_all(self, word: &impl Word) -> bool {
        self.count == Some(word.value())
    }

    /// Notes the result of a look: a slice, or nothing; `before` is the word before the look.
    #[inline]
    pub(crate) fn note(&mut self, before: u64, found_nothing: bool) {
        self.count = match found_nothing {
            true => Some(before),
            false => self.count.map(|count| count.wrapping_add(1)),
        };
    }
}
