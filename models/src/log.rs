//! The log: a writer, perhaps its successor, and a reader, in all orders of operations.

use loom::sync::Arc;

use crate::atomic::{AtomicU64, Weakness, check};
use crate::ring::{DamagedCount, HEAD, RingWords, SampleWords};

const PLACES: u64 = 2;
/// Words of a sample, each with the sample's number.
const WORDS: usize = 2;

struct LogModel {
    words: Vec<AtomicU64>,
}

impl LogModel {
    /// A log with samples up to number `next`, exclusive, of a writer that has ended.
    fn with_samples(next: u64) -> Arc<Self> {
        let words = HEAD + PLACES as usize * WORDS;
        let log = Self {
            words: (0..words).map(|_| AtomicU64::default()).collect(),
        };
        log.write(next);
        Arc::new(log)
    }

    fn ring(&self) -> RingWords<'_> {
        RingWords {
            words: &self.words,
            places: PLACES,
            sample: WORDS,
        }
    }

    /// A writer writes so many samples.
    fn write(&self, samples: u64) {
        let mut next = self.ring().begin();
        for _ in 0..samples {
            next = self.ring().write(next, std::iter::repeat_n(next, WORDS));
        }
    }
}

fn words(words: SampleWords<'_>) -> Option<Vec<u64>> {
    Some(words.collect())
}

type Read = fn(RingWords<'_>, u64, &mut Vec<Vec<u64>>) -> Result<Option<u64>, DamagedCount>;

/// As the log's reader does.
const READ: Read = |ring, next, copied| ring.read(next, copied, words);

/// Without the second look at the count.
const READ_ONCE: Read = |ring, next, copied| ring.copy(next, copied, words);

fn assert_whole(first: Option<u64>, copied: &[Vec<u64>]) {
    let samples = first.into_iter().flat_map(|first| first..).zip(copied);
    for (number, sample) in samples {
        assert_eq!(*sample, [number; WORDS], "a sample is another, or half another");
    }
}

/// A writer overwrites what a reader reads.
fn overtake(weakness: Weakness, read: Read) {
    check(weakness, move || {
        let log = LogModel::with_samples(1);
        let writer = Arc::clone(&log);
        loom::thread::spawn(move || writer.write(2));
        let mut copied = Vec::new();
        let first = read(log.ring(), 0, &mut copied).unwrap();
        assert_whole(first, &copied);
    });
}

/// A writer is killed after a sample, and its successor overwrites what a reader reads.
fn succeed(weakness: Weakness) {
    check(weakness, || {
        let log = LogModel::with_samples(1);
        let writers = Arc::clone(&log);
        loom::thread::spawn(move || {
            let killed = Arc::clone(&writers);
            loom::thread::spawn(move || killed.write(1)).join().unwrap();
            writers.write(1);
        });
        let mut copied = Vec::new();
        let first = log.ring().read(0, &mut copied, words).unwrap();
        assert_whole(first, &copied);
    });
}

#[test]
fn no_sample_is_half_another_while_it_is_overwritten() {
    overtake(Weakness::None, READ);
}

#[test]
#[should_panic = "half another"]
fn a_writer_without_fences_is_read_half() {
    overtake(Weakness::ReleaseFences, READ);
}

#[test]
#[should_panic = "half another"]
fn a_reader_without_a_fence_reads_halves() {
    overtake(Weakness::AcquireFences, READ);
}

#[test]
#[should_panic = "half another"]
fn a_reader_that_looks_at_the_count_once_reads_halves() {
    overtake(Weakness::None, READ_ONCE);
}

#[test]
#[should_panic = "half another"]
fn a_reader_that_does_not_acquire_the_count_reads_samples_before_they_are_there() {
    overtake(Weakness::Loads, READ);
}

#[test]
#[should_panic = "half another"]
fn a_writer_that_does_not_release_the_count_is_read_before_samples_are_there() {
    overtake(Weakness::Stores, READ);
}

#[test]
fn no_sample_is_half_a_successors() {
    succeed(Weakness::None);
}

#[test]
#[should_panic = "half another"]
fn a_successor_without_a_fence_is_read_half() {
    succeed(Weakness::ReleaseFences);
}
