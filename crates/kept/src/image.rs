//! Memory with areas of records, each in two copies.
//!
//! A process can be killed between any two stores. A record is therefore never overwritten: of its two copies, the
//! older is replaced. A kill during a write leaves the previous copy of that record; every other record is whole. The
//! protocol is in `record`.

use std::fmt;
use std::sync::Arc;
use std::sync::atomic::AtomicU64;
use std::sync::atomic::Ordering::{Relaxed, Release};

/// "KOSEKI", the kind of file, and how its records are checked.
const MAGIC: u64 = u64::from_le_bytes(*b"KOSEKIC2");
/// Words before the first area: the magic number and a fingerprint of the layout.
pub const HEAD: usize = 2;

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

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::record::{FRONT, RecordArea, RecordState};

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

    #[test]
    fn a_content_that_counts_like_the_writes_does_not_hide_a_torn_record() {
        let memory = blank();
        let mut contents = Vec::new();
        for times in 1..=2 {
            AREA.write(&memory, 0, times, &[0, times, 0, 0, 0]);
        }
        let start = AREA.copy_at(0, 1);
        // Of the third write, the number of writes and the second word of the contents have been stored.
        memory[start].store(3, Relaxed);
        memory[start + FRONT + 1].store(3, Relaxed);
        assert_eq!(
            AREA.read(&memory, 0, &mut contents),
            RecordState::Torn { has_other: true }
        );
        assert_eq!(contents, [0, 2, 0, 0, 0]);
    }

    #[test]
    fn a_record_without_a_whole_copy_has_no_contents() {
        let memory = blank();
        let mut contents = vec![1];
        AREA.write(&memory, 0, 1, &[7; 5]);
        memory[AREA.copy_at(0, 1) + FRONT].store(8, Relaxed);
        assert_eq!(
            AREA.read(&memory, 0, &mut contents),
            RecordState::Torn { has_other: false }
        );
        assert!(contents.is_empty(), "torn contents: {contents:?}");
        memory[AREA.copy_at(0, 0)].store(u64::MAX, Relaxed);
        assert_eq!(AREA.read(&memory, 0, &mut contents), RecordState::Damaged);
        assert!(contents.is_empty(), "torn contents: {contents:?}");
    }

    #[test]
    fn memory_that_is_too_short_is_damaged() {
        let memory = blank();
        let mut contents = vec![1];
        let short = &memory[..memory.len() - AREA.len() / 2 - 1];
        assert_eq!(AREA.read(short, 1, &mut contents), RecordState::Damaged);
        assert!(contents.is_empty());
    }
}
