//! Memory with areas of records, each in two copies.
//!
//! A process can be killed between any two stores. A record is therefore never overwritten: of its two copies, the
//! older is replaced. Each copy states the number of writes of the record and a checksum of all its words. A reader
//! takes the newest copy with a correct checksum. A kill during a write leaves the previous copy of that record;
//! every other record is whole.

use std::fmt;
use std::sync::Arc;
use std::sync::atomic::AtomicU64;
use std::sync::atomic::Ordering::{Relaxed, Release};

/// "KOSEKI" and the kind of file.
const MAGIC: u64 = u64::from_le_bytes(*b"KOSEKICP");
/// Words before the first area: the magic number and a fingerprint of the layout.
pub const HEAD: usize = 2;
/// Words of a copy before its contents: number of writes and checksum.
const FRONT: usize = 2;

/// Words that outlive their process, or words in their place in tests.
pub trait Memory: std::fmt::Debug + Send {
    /// Returns the words; their number never changes.
    fn words(&self) -> &[AtomicU64];
}

impl<M: Memory + Sync> Memory for Arc<M> {
    fn words(&self) -> &[AtomicU64] {
        (**self).words()
    }
}

impl Memory for Vec<AtomicU64> {
    fn words(&self) -> &[AtomicU64] {
        self
    }
}

/// Memory that cannot be used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MemoryRefusal {
    /// No checkpoint, or a checkpoint of other settings, sources or another build.
    Foreign,
    /// Damaged checkpoint, with the number of records that are not whole.
    Damaged(usize),
}

impl fmt::Display for MemoryRefusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Foreign => f.write_str("it is no checkpoint of this build with these sources and table sizes"),
            Self::Damaged(records) => write!(f, "it is damaged: {records} of its records are not whole"),
        }
    }
}

impl std::error::Error for MemoryRefusal {}

/// Writes the [`HEAD`] of blank memory.
pub fn mark(memory: &[AtomicU64], fingerprint: u64) {
    memory[1].store(fingerprint, Relaxed);
    memory[0].store(MAGIC, Release);
}

/// Whether memory of so many `words` has the head of [`mark`].
pub fn is_marked(memory: &[AtomicU64], words: usize, fingerprint: u64) -> bool {
    memory.len() == words && memory[0].load(Relaxed) == MAGIC && memory[1].load(Relaxed) == fingerprint
}

/// Mixes a word for a fingerprint.
pub fn mixed(word: u64) -> u64 {
    word.wrapping_mul(FACTOR).rotate_left(29)
}

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

    fn copy_at(&self, place: usize, copy: usize) -> usize {
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

    /// Reads the newest whole copy of the record of `place` into `contents`.
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
        let words = &memory[start..start + self.copy()];
        let (times, check) = (words[0].load(Relaxed), words[1].load(Relaxed));
        contents.clear();
        contents.extend(words[FRONT..].iter().map(|word| word.load(Relaxed)));
        if times == 0 && check == 0 {
            Copy::Blank
        } else if times & 1 == copy as u64 && check == checksum(start, times, contents) {
            Copy::Whole(times)
        } else {
            Copy::Broken
        }
    }
}

/// Returns the checksum of a copy's words and place. A change of a single word always changes the checksum.
#[inline]
fn checksum(start: usize, times: u64, contents: &[u64]) -> u64 {
    // Four words at a time: each product depends on the product before it.
    let mut lanes = [start as u64, times, 1, 2];
    let (fours, rest) = contents.as_chunks::<4>();
    for four in fours {
        for (lane, word) in lanes.iter_mut().zip(four) {
            *lane = (*lane ^ word).wrapping_mul(FACTOR).rotate_left(29);
        }
    }
    for (lane, word) in lanes.iter_mut().zip(rest) {
        *lane = (*lane ^ word).wrapping_mul(FACTOR).rotate_left(29);
    }
    lanes
        .iter()
        .fold(0, |sum: u64, lane| (sum ^ lane).wrapping_mul(FACTOR).rotate_left(31))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const AREA: RecordArea = RecordArea {
        first: 3,
        places: 2,
        words: 5,
    };

    fn blank() -> Vec<AtomicU64> {
        (0..AREA.first + AREA.len()).map(|_| AtomicU64::new(0)).collect()
    }

    fn copied(memory: &[AtomicU64]) -> Vec<u64> {
        memory.iter().map(|word| word.load(Relaxed)).collect()
    }

    #[test]
    fn the_copy_written_last_is_read() {
        let memory = blank();
        let mut contents = Vec::new();
        for times in 1..=4 {
            AREA.write(&memory, 1, times, &[times; 5]);
            assert_eq!(AREA.read(&memory, 1, &mut contents), RecordState::Whole);
            assert_eq!(contents, [times; 5]);
        }
    }

    proptest! {
        /// A writer that is killed between any two stores, in any order of stores, leaves the old or the new record.
        #[test]
        fn a_record_is_never_half_new(
            writes in prop::collection::vec(prop::array::uniform5(any::<u64>()), 1..6),
            stored in prop::array::uniform7(any::<bool>()),
        ) {
            let memory = blank();
            let (last, before) = writes.split_last().unwrap();
            for (times, contents) in before.iter().enumerate() {
                AREA.write(&memory, 1, times as u64 + 1, contents);
            }
            let old = copied(&memory);
            AREA.write(&memory, 1, writes.len() as u64, last);
            let new = copied(&memory);
            let start = AREA.copy_at(1, writes.len() % 2);
            for (word, _) in stored.iter().enumerate().filter(|(_, stored)| !**stored) {
                memory[start + word].store(old[start + word], Relaxed);
            }
            let mut contents = Vec::new();
            match AREA.read(&memory, 1, &mut contents) {
                RecordState::Nothing | RecordState::Torn { has_other: false } => prop_assert!(before.is_empty()),
                RecordState::Damaged => prop_assert!(false, "the older copy was not touched"),
                RecordState::Whole if copied(&memory) == new => prop_assert_eq!(&contents[..], &last[..]),
                RecordState::Whole | RecordState::Torn { has_other: true } => {
                    prop_assert_eq!(&contents[..], &before.last().unwrap()[..]);
                }
            }
            prop_assert_eq!(AREA.read(&memory, 0, &mut contents), RecordState::Nothing);
        }

        /// A change of any bit is detected.
        #[test]
        fn no_bit_can_change_unseen(
            first in prop::array::uniform5(any::<u64>()),
            second in prop::array::uniform5(any::<u64>()),
            word in 0..2 * (FRONT + 5),
            bit in 0..64u32,
        ) {
            let memory = blank();
            AREA.write(&memory, 0, 1, &first);
            AREA.write(&memory, 0, 2, &second);
            memory[AREA.first + word].fetch_xor(1 << bit, Relaxed);
            let mut contents = Vec::new();
            prop_assert_eq!(AREA.read(&memory, 0, &mut contents), RecordState::Torn { has_other: true });
            prop_assert!(contents == first || contents == second);
        }
    }
}
