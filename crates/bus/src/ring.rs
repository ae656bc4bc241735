//! Protocol of a log: a single writer at a time stores samples in a ring, and any number of readers copy them.
//!
//! # No reader takes a sample that is half another
//! The writer stores the words of a sample, then the count of samples ever written (release), and behind that a fence
//! (release) before it stores the words of the next sample. A reader reads the count (acquire), copies places, and
//! behind a fence (acquire) reads the count again. If a word of a later sample was copied, the second count shows that
//! sample as begun at least, and the copies are given up. The place of the sample that may be being written is never
//! copied.
//!
//! A successor of a killed writer goes on at the count, behind the same fence: a reader that copies a word of the
//! successor sees the count of the predecessor.
//!
//! # No count is absurd
//! The count has [`COUNT_BITS`] bits, a sample per microsecond for nine years, so that no number of a sample overflows.
//! The other bits of the word are a check: a word with a single wrong bit is refused, and replaced by the writer's next
//! word. A place is a number without its upper bits. The workspace `models` checks the protocol in all orders of
//! operations.

use std::slice;
use std::sync::atomic::Ordering::{Acquire, Relaxed, Release};

use crate::atomic::{AtomicU64, fence};

/// Words of the head: a cache line.
pub(crate) const HEAD: usize = 8;
pub(crate) const CREATED: usize = 0;
const NEXT: usize = 1;
/// Bits of the count of samples.
const COUNT_BITS: u32 = 48;
const COUNT: u64 = (1 << COUNT_BITS) - 1;
/// Samples that a reader copies at a time.
pub(crate) const AT_A_TIME: u64 = 256;

/// The count of samples was not written by a writer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct DamagedCount;

/// Words of a log.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RingWords<'a> {
    /// The head and all places.
    pub(crate) words: &'a [AtomicU64],
    /// Number of places, a power of two.
    pub(crate) places: u64,
    /// Words of a sample.
    pub(crate) sample: usize,
}

impl<'a> RingWords<'a> {
    /// Number of the sample that a new writer writes first.
    pub(crate) fn begin(self) -> u64 {
        let word = self.words[NEXT].load(Acquire);
        // A log must be written whatever the state of the count: readers see a jump, or wait.
        let next = count(word).unwrap_or(word & COUNT);
        // A reader that sees a word of the next sample also sees this count.
        fence(Release);
        next
    }

    /// Writes sample `number`; returns the number of the next sample.
    #[inline]
    pub(crate) fn write(self, number: u64, sample: impl Iterator<Item = u64>) -> u64 {
        for (word, value) in self.place(number).iter().zip(sample) {
            word.store(value, Relaxed);
        }
        let next = (number + 1) & COUNT;
        self.words[NEXT].store(word_of(next), Release);
        // Likewise.
        fence(Release);
        next
    }

    /// Copies the samples from number `next` on that are still there, a few hundred at most; returns the number of the
    /// first. `None` if there are no new samples.
    ///
    /// # Errors
    /// If the count is damaged, a state that lasts until the next sample.
    pub(crate) fn read<T>(
        self,
        next: u64,
        copied: &mut Vec<T>,
        of_words: impl Fn(SampleWords<'a>) -> Option<T>,
    ) -> Result<Option<u64>, DamagedCount> {
        loop {
            let first = self.copy(next, copied, &of_words)?;
            if first.is_none_or(|first| self.are_still_there(first)) {
                return Ok(first);
            }
        }
    }

    /// Copies samples as [`Self::read`] does; some may be half another.
    pub(crate) fn copy<T>(
        self,
        next: u64,
        copied: &mut Vec<T>,
        of_words: impl Fn(SampleWords<'a>) -> Option<T>,
    ) -> Result<Option<u64>, DamagedCount> {
        let written = count(self.words[NEXT].load(Acquire)).ok_or(DamagedCount)?;
        // A single place may be being written.
        let oldest = (written + 1).saturating_sub(self.places);
        let first = next.max(oldest);
        let Some(new) = written.checked_sub(first).filter(|new| *new > 0) else {
            return Ok(None);
        };
        copied.clear();
        for number in first..first + new.min(AT_A_TIME) {
            copied.extend(of_words(SampleWords(self.place(number).iter())));
        }
        Ok(Some(first))
    }

    /// Whether no sample from `first` on was overwritten before the copy.
    fn are_still_there(self, first: u64) -> bool {
        fence(Acquire);
        let written = count(self.words[NEXT].load(Relaxed));
        written.is_some_and(|written| first + self.places > written)
    }

    fn place(self, number: u64) -> &'a [AtomicU64] {
        let first = HEAD + (number & (self.places - 1)) as usize * self.sample;
        &self.words[first..first + self.sample]
    }
}

/// The words of a sample, each read once.
#[derive(Debug)]
pub(crate) struct SampleWords<'a>(slice::Iter<'a, AtomicU64>);

impl Iterator for SampleWords<'_> {
    type Item = u64;

    #[inline]
    fn next(&mut self) -> Option<u64> {
        Some(self.0.next()?.load(Relaxed))
    }
}

/// Word of a `count`, with the check: each bit of the count changes a single bit of the check.
#[inline]
fn word_of(count: u64) -> u64 {
    (count ^ count >> 16 ^ count >> 32) << COUNT_BITS | count
}

/// The count in a word; `None` if count and check disagree.
#[inline]
fn count(word: u64) -> Option<u64> {
    let count = word & COUNT;
    (word == word_of(count)).then_some(count)
}
