//! Protocol of records in memory that outlasts its process: one writer, which may be killed between any two stores, and
//! any number of readers, of a dead writer's memory or beside a living one.
//!
//! A record has two copies, and the older one is replaced. Each copy states the number of writes of the record, and a
//! checksum over this number, the contents and the place. No order of the stores is asked for: a copy with words of two
//! writes, whatever their order, does not agree with its checksum.
//!
//! # No record is half new
//! A reader takes the newest copy that agrees, and its contents are those of one write. After a kill, and beside a
//! writer that writes the record at most once meanwhile, one of the copies agrees: the last record, or the one before.
//! Beside a faster writer both copies may be found broken: then there are no contents, and the reader asks again. On a
//! machine that reorders stores, it may also find the record before those two; a fence that excludes this would cost
//! every write of a record.
//!
//! Indices and lengths come from the reader's own layout, never from the memory. The workspace `models` checks the
//! protocol in all orders of operations.

use std::sync::atomic::Ordering::Relaxed;

use crate::atomic::AtomicU64;

/// Words of a copy before its contents: number of writes and checksum.
pub(crate) const FRONT: usize = 2;
const FACTOR: u64 = 0x9e37_79b9_7f4a_7c15;

/// Records of one kind in the memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RecordArea {
    /// First word of the area.
    pub first: usize,
    /// Number of records.
    pub places: usize,
    /// Words of a record's contents.
    pub words: usize,
}

/// State of a record in memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RecordState {
    /// Never written.
    Nothing,
    /// The newest copy is whole; the other copy is whole or blank.
    Whole,
    /// One copy is not whole: its writer was killed, or the memory was damaged. The other copy is whole or blank.
    Torn {
        /// Whether the other copy is whole.
        has_other: bool,
    },
    /// Neither copy is whole.
    Damaged,
}

/// State of one copy of a record.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum Copy {
    Blank,
    Whole(u64),
    Broken,
}

impl RecordArea {
    const fn copy(&self) -> usize {
        FRONT + self.words
    }

    /// Returns the number of words of the area.
    #[expect(clippy::len_without_is_empty, reason = "it never is")]
    pub const fn len(&self) -> usize {
        2 * self.copy() * self.places
    }

    pub(crate) fn copy_at(&self, place: usize, copy: usize) -> usize {
        self.first + (2 * place + copy) * self.copy()
    }

    /// Writes `contents` as the record of `place` for the `times`-th time, counted from 1.
    #[inline]
    pub fn write(&self, memory: &[AtomicU64], place: usize, times: u64, contents: &[u64]) {
        debug_assert!(place < self.places, "record {place} of {}", self.places);
        let start = self.copy_at(place, (times & 1) as usize);
        let Some(copy) = memory.get(start..start + FRONT + contents.len()) else {
            return;
        };
        copy[0].store(times, Relaxed);
        copy[1].store(checksum(start, times, contents), Relaxed);
        for (word, content) in copy[FRONT..].iter().zip(contents) {
            word.store(*content, Relaxed);
        }
    }

    /// Reads the newest whole copy of the record of `place` into `contents`: none if no copy is whole.
    pub fn read(&self, memory: &[AtomicU64], place: usize, contents: &mut Vec<u64>) -> RecordState {
        let mut other = Vec::with_capacity(self.words);
        let first = self.read_copy(memory, place, 0, contents);
        let second = self.read_copy(memory, place, 1, &mut other);
        let is_second_newer = match (&first, &second) {
            (Copy::Whole(first), Copy::Whole(second)) => second > first,
            (_, second) => matches!(second, Copy::Whole(_)),
        };
        if is_second_newer {
            *contents = other;
        } else if !matches!(first, Copy::Whole(_)) {
            contents.clear();
        }
        match (first, second) {
            (Copy::Blank, Copy::Blank) => RecordState::Nothing,
            (Copy::Broken, Copy::Broken) => RecordState::Damaged,
            (Copy::Broken, Copy::Blank) | (Copy::Blank, Copy::Broken) => RecordState::Torn { has_other: false },
            (Copy::Broken, _) | (_, Copy::Broken) => RecordState::Torn { has_other: true },
            _ => RecordState::Whole,
        }
    }

    /// Reads copy 0 or 1 of the record of `place` into `contents`.
    pub(crate) fn read_copy(&self, memory: &[AtomicU64], place: usize, copy: usize, contents: &mut Vec<u64>) -> Copy {
        let start = self.copy_at(place, copy);
        contents.clear();
        let Some([times, check, words @ ..]) = memory.get(start..start + self.copy()) else {
            return Copy::Broken;
        };
        let (times, check) = (times.load(Relaxed), check.load(Relaxed));
        contents.extend(words.iter().map(|word| word.load(Relaxed)));
        if times == 0 && check == 0 {
            Copy::Blank
        } else if times & 1 == copy as u64 && check == checksum(start, times, contents) {
            Copy::Whole(times)
        } else {
            Copy::Broken
        }
    }
}

/// Mixes a word for a fingerprint or a checksum.
#[inline]
pub fn mixed(word: u64) -> u64 {
    word.wrapping_mul(FACTOR).rotate_left(29)
}

/// Returns the checksum of a copy's words and place. A change of a single word always changes the checksum.
#[inline]
fn checksum(start: usize, times: u64, contents: &[u64]) -> u64 {
    // Four words at a time: each product depends on the product before it. The number of writes is mixed first: a word
    // that counts as it does would otherwise cancel it, and a copy with both new and the rest old would seem whole.
    let mut lanes = [start as u64, mixed(times), 1, 2];
    let (fours, rest) = contents.as_chunks::<4>();
    for four in fours {
        for (lane, word) in lanes.iter_mut().zip(four) {
            *lane = mixed(*lane ^ word);
        }
    }
    for (lane, word) in lanes.iter_mut().zip(rest) {
        *lane = mixed(*lane ^ word);
    }
    lanes
        .iter()
        .fold(0, |sum: u64, lane| (sum ^ lane).wrapping_mul(FACTOR).rotate_left(31))
}
