//! A log in shared memory: samples of a single writer, for readers at any speed.
//!
//! A topic costs the publisher some thousand instructions per slice, which is expensive if each sample must be
//! published before the sample's result. A log costs some ten: the writer stores the sample in the next place of a
//! ring, and increments a count. The writer has no list of readers, no reader can slow the writer, and written samples
//! survive a kill at any instruction. A successor continues at the next place; only a single writer may exist at a
//! time.
//!
//! The ring is a file in shared memory, created by the topic's holder: a head with the time of creation and the number
//! of samples ever written, and as many places as the topic has depth, a power of two. A reader copies places, then
//! reads the count again: places overwritten in the meantime are lost to this reader. The protocol of both sides is in
//! `ring`.

use std::marker::PhantomData;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicU64;
use std::sync::atomic::Ordering::Relaxed;

use messages::Topic;

use crate::error::BusError;
use crate::mapping::Mapping;
use crate::ring::{AT_A_TIME, CREATED, DamagedCount, HEAD, RingWords};
use crate::seal::SHARED_MEMORY_DIR;
use crate::transport::Payload;

const WORD: usize = size_of::<u64>();
/// Most words of a sample.
const WORDS_MAX: usize = 32;

/// The ring, mapped.
#[derive(Debug)]
struct Ring<T> {
    mapping: Mapping,
    places: u64,
    samples: PhantomData<fn() -> T>,
}

/// Bytes of the file of a log.
pub(crate) fn log_bytes<T: Payload>(topic: &Topic<T>) -> usize {
    HEAD * WORD + topic.capacity.depth * size_of::<T>()
}

impl<T: Payload> Ring<T> {
    const WORDS: usize = {
        assert!(size_of::<T>().is_multiple_of(WORD) && align_of::<T>() == WORD);
        assert!(size_of::<T>() <= WORDS_MAX * WORD);
        size_of::<T>() / WORD
    };

    fn of(topic: &Topic<T>, mapping: Mapping) -> std::io::Result<Self> {
        let places = topic.capacity.depth as u64;
        if !places.is_power_of_two() || mapping.bytes() != log_bytes(topic) {
            return Err(std::io::Error::other("not this log"));
        }
        Ok(Self {
            mapping,
            places,
            samples: PhantomData,
        })
    }

    fn words(&self) -> &[AtomicU64] {
        let count = self.mapping.bytes() / WORD;
        // SAFETY: the mapping is aligned to a page, has so many words, lives as long as `self`, and any bits are atomic
        // words.
        unsafe { std::slice::from_raw_parts(self.mapping.start().cast().as_ptr(), count) }
    }

    #[inline]
    fn ring(&self) -> RingWords<'_> {
        RingWords {
            words: self.words(),
            places: self.places,
            sample: Self::WORDS,
        }
    }
}

/// Makes the log of `topic`, at `created_ns` (monotonic, nanoseconds), or finds the log.
pub(crate) fn create<T: Payload>(prefix: &str, topic: &Topic<T>, created_ns: u64) -> Result<(), BusError> {
    let path = path_of(prefix, topic);
    let ring = Mapping::create(&path, log_bytes(topic)).and_then(|mapping| Ring::of(topic, mapping));
    let ring = ring.map_err(|source| BusError::Io {
        action: "create",
        path,
        source,
    })?;
    // The first creator stores the time.
    let _ = ring.words()[CREATED].compare_exchange(0, created_ns, Relaxed, Relaxed);
    Ok(())
}

/// Maps the log of `topic`; without a `prefix`, a private log.
fn open<T: Payload>(prefix: Option<&str>, topic: &Topic<T>) -> Result<Ring<T>, BusError> {
    let path = path_of(prefix.unwrap_or_default(), topic);
    let mapping = match prefix {
        Some(_) => Mapping::open(&path),
        None => Mapping::anonymous(log_bytes(topic)),
    };
    let ring = mapping.and_then(|mapping| Ring::of(topic, mapping));
    ring.map_err(|source| BusError::Io {
        action: "open",
        path,
        source,
    })
}

fn path_of<T>(prefix: &str, topic: &Topic<T>) -> PathBuf {
    let topic = topic.name.as_str().replace('/', ".");
    Path::new(SHARED_MEMORY_DIR).join(format!("{prefix}log.{topic}"))
}

/// Writes a log.
#[derive(Debug)]
pub struct LogWriter<T> {
    ring: Ring<T>,
    next: u64,
}

impl<T: Payload> LogWriter<T> {
    pub(crate) fn open(prefix: Option<&str>, topic: &Topic<T>) -> Result<Self, BusError> {
        let ring = open(prefix, topic)?;
        let next = ring.ring().begin();
        Ok(Self { ring, next })
    }

    /// Writes a sample: after the return the sample is stored, even if this process dies.
    #[inline]
    pub fn write(&mut self, sample: &T) {
        let octets = T::octets(std::slice::from_ref(sample)).as_chunks::<WORD>().0;
        let words = octets.iter().map(|octets| u64::from_ne_bytes(*octets));
        self.next = self.ring.ring().write(self.next, words);
    }
}

/// Follows a log.
#[derive(Debug)]
pub struct LogReader<T> {
    ring: Ring<T>,
    next: u64,
    copied: Vec<T>,
    refused: u64,
}

impl<T: Payload> LogReader<T> {
    pub(crate) fn open(prefix: Option<&str>, topic: &Topic<T>) -> Result<Self, BusError> {
        Ok(Self {
            ring: open(prefix, topic)?,
            next: 0,
            copied: Vec::with_capacity(AT_A_TIME as usize),
            refused: 0,
        })
    }

    /// Returns the time of creation, monotonic, nanoseconds; identifies the log.
    pub fn created_ns(&self) -> u64 {
        self.ring.words()[CREATED].load(Relaxed)
    }

    /// Continues with the sample of this number, or with the oldest sample available, unless the reader is already
    /// further.
    pub fn go_on(&mut self, next: u64) {
        self.next = self.next.max(next);
    }

    /// Returns the next samples, a few hundred at most, and the number of the first: the count of samples ever written
    /// before. `None` without new samples. A number above the expected number gives the number of lost samples.
    pub fn read(&mut self) -> Option<(u64, &[T])> {
        let read = self.ring.ring().read(self.next, &mut self.copied, of_words);
        let first = read.unwrap_or_else(|DamagedCount| {
            self.refused += 1;
            None
        })?;
        self.next = first + self.copied.len() as u64;
        Some((first, &self.copied))
    }

    /// How often the count of samples was found damaged, and nothing was read.
    pub fn refused(&self) -> u64 {
        self.refused
    }
}

/// The sample that has these words.
fn of_words<T: Payload>(words: impl Iterator<Item = u64>) -> Option<T> {
    let mut octets = [[0; WORD]; WORDS_MAX];
    for (octets, word) in octets.iter_mut().zip(words) {
        *octets = word.to_ne_bytes();
    }
    T::of_octets(octets.as_flattened().get(..size_of::<T>())?)
}

#[cfg(test)]
mod tests {
    use messages::WorkStep;

    use super::*;

    fn step(number: u64) -> WorkStep {
        WorkStep {
            time_ns: number as i64,
            sequence: number as u32,
            ..WorkStep::default()
        }
    }

    /// Writer and reader of the same ring of so many places.
    fn pair(places: usize) -> (LogWriter<WorkStep>, LogReader<WorkStep>, tempfile::TempDir) {
        let folder = tempfile::tempdir().unwrap();
        let mut topic = messages::event_log();
        topic.capacity.depth = places;
        let mapping = || Mapping::create(&folder.path().join("log"), log_bytes(&topic)).unwrap();
        let ring = || Ring::of(&topic, mapping()).unwrap();
        let writer = LogWriter { ring: ring(), next: 0 };
        let reader = LogReader {
            ring: ring(),
            next: 0,
            copied: Vec::new(),
            refused: 0,
        };
        (writer, reader, folder)
    }

    #[test]
    fn samples_come_in_order_and_those_overwritten_are_passed_over() {
        let (mut writer, mut reader, _folder) = pair(8);
        assert!(reader.read().is_none());
        (0..3).for_each(|number| writer.write(&step(number)));
        assert_eq!(reader.read(), Some((0, &[0, 1, 2].map(step)[..])));
        assert!(reader.read().is_none());
        (3..30).for_each(|number| writer.write(&step(number)));
        let last: Vec<_> = (23..30).map(step).collect();
        assert_eq!(reader.read(), Some((23, &last[..])));
        (30..34).for_each(|number| writer.write(&step(number)));
        reader.go_on(33);
        assert_eq!(reader.read(), Some((33, &[step(33)][..])));
    }

    #[test]
    fn a_count_with_a_wrong_bit_is_refused_until_the_next_sample() {
        for bit in 0..64 {
            let (mut writer, mut reader, _folder) = pair(8);
            (0..3).for_each(|number| writer.write(&step(number)));
            assert_eq!(reader.read(), Some((0, &[0, 1, 2].map(step)[..])));
            reader.ring.words()[1].fetch_xor(1 << bit, Relaxed);
            assert!(reader.read().is_none());
            assert_eq!(reader.refused(), 1);
            writer.write(&step(3));
            assert_eq!(reader.read(), Some((3, &[step(3)][..])));
        }
    }

    #[test]
    fn whatever_is_in_a_log_reader_and_writer_go_on() {
        for word in [u64::MAX, 1 << 63, (1 << 48) - 1, (1 << 48) - 3, 1 << 47] {
            let (mut writer, mut reader, _folder) = pair(8);
            reader.ring.words().iter().for_each(|place| place.store(word, Relaxed));
            // Of all these words, only the first agrees with the check.
            assert_eq!(reader.read().is_some(), word == u64::MAX);
            writer.next = writer.ring.ring().begin();
            // The numbers begin again at 0 before an overflow.
            (0..9).for_each(|number| writer.write(&step(number)));
            while reader.read().is_some() {}
            reader.go_on(u64::MAX);
            assert!(reader.read().is_none());
        }
    }

    #[test]
    fn a_reader_beside_a_writer_reads_nothing_torn() {
        const COUNT: u64 = 200_000;
        let (mut writer, mut reader, _folder) = pair(64);
        let writing = std::thread::spawn(move || (0..COUNT).for_each(|number| writer.write(&step(number))));
        let (mut next, mut taken) = (0, 0);
        while next < COUNT {
            let Some((first, samples)) = reader.read() else {
                std::thread::yield_now();
                continue;
            };
            assert!(first >= next);
            for (number, sample) in (first..).zip(samples) {
                assert_eq!(*sample, step(number));
            }
            next = first + samples.len() as u64;
            taken += samples.len();
        }
        writing.join().unwrap();
        assert!(taken > 0 && reader.read().is_none());
    }
}
