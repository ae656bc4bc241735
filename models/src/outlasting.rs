//! The outlasting record: a writer and a reader beside it, in all orders of operations.
//!
//! A writer that is killed between two stores leaves what a reader beside it may see between them.

use loom::sync::Arc;
use loom::sync::atomic::Ordering::Relaxed;

use crate::atomic::{AtomicU64, Weakness, check};
use crate::record::{RecordArea, RecordState};

const AREA: RecordArea = RecordArea {
    first: 1,
    places: 1,
    words: 2,
};
/// Writes before the reader comes.
const BEFORE: u64 = 2;

type Read = fn(&[AtomicU64], &mut Vec<u64>) -> RecordState;

/// A writer does the `writes` with these numbers, whose contents are their number, beside a reader; returns to `judge`
/// what was read.
fn beside(writes: &'static [u64], read: Read, judge: fn(RecordState, &[u64])) {
    check(Weakness::None, move || {
        let words = AREA.first + AREA.len();
        let memory: Arc<Vec<_>> = Arc::new((0..words).map(|_| AtomicU64::default()).collect());
        (1..=BEFORE).for_each(|times| AREA.write(&memory, 0, times, &[times; 2]));
        let writer = Arc::clone(&memory);
        loom::thread::spawn(move || {
            writes
                .iter()
                .for_each(|times| AREA.write(&writer, 0, *times, &[*times; 2]))
        });
        let mut contents = Vec::new();
        let state = read(&memory, &mut contents);
        judge(state, &contents);
    });
}

/// As every reader does.
const READ: Read = |memory, contents| AREA.read(memory, 0, contents);

/// Without the checksum: the copy with the greater number of writes.
const READ_UNCHECKED: Read = |memory, contents| {
    let copies = memory[AREA.first..].chunks(AREA.len() / 2);
    let newest = copies.max_by_key(|copy| copy[0].load(Relaxed)).unwrap();
    contents.extend(newest[2..].iter().map(|word| word.load(Relaxed)));
    RecordState::Whole
};

/// The contents of one write, the first or a later one.
fn are_of_one(contents: &[u64], first: u64) -> bool {
    matches!(contents, [one, other] if one == other && *one >= first)
}

fn must_be_last_or_before(state: RecordState, contents: &[u64]) {
    assert!(
        are_of_one(contents, BEFORE),
        "no record, or half another: {state:?} {contents:?}"
    );
}

fn must_be_whole_or_none(state: RecordState, contents: &[u64]) {
    let is_none = state == RecordState::Damaged && contents.is_empty();
    assert!(
        is_none || are_of_one(contents, 1),
        "half another: {state:?} {contents:?}"
    );
}

#[test]
fn a_reader_beside_a_write_finds_the_last_record_or_the_one_before() {
    beside(&[3], READ, must_be_last_or_before);
}

#[test]
fn a_reader_beside_a_faster_writer_finds_a_whole_record_or_none() {
    beside(&[3, 4], READ, must_be_whole_or_none);
}

#[test]
#[should_panic = "half another"]
fn a_reader_without_the_checksum_reads_halves() {
    beside(&[3], READ_UNCHECKED, must_be_last_or_before);
}

#[test]
#[should_panic = "no record"]
fn a_writer_that_replaces_the_newer_copy_leaves_no_record() {
    // Even like the last one, this number has the same copy; the older copy is of a record that was replaced.
    beside(&[4], READ, must_be_last_or_before);
}
