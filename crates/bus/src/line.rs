//! Line of a publisher: the last sequence number, which outlives the publisher.
//!
//! A slice states how many samples the publisher had sent before, so that the next slice reveals missing samples. After
//! the last slice there is no such check: samples that died with a killed publisher would go unnoticed. Therefore each
//! publisher has a *line* of shared memory, a single cache line long. Before each send the publisher writes the
//! sequence number after this send to the line, and afterwards the time. The line remains after the publisher's end. A
//! subscriber with an empty queue compares: numbers below the line's number that were not taken are lost.
//!
//! The lines of a topic are a file in shared memory, created by the topic's holder: a head, and twice as many lines as
//! simultaneous publishers, so that the lines of recently ended publishers remain readable when the places are reused.
//! A publisher that leaves marks the line as ended; the line of a killed publisher is marked by the process that
//! removes the dead ([`Bus::remove_dead`](crate::Bus::remove_dead)). Each mark increments a count in the head; until
//! the count changes, a check of an empty queue costs a subscriber one load.
//!
//! Limits: a publisher in another language has no line; missing samples are then detected by gaps only. Any process of
//! the same user can write to the file. Readers accept a line only if the fields are consistent, and use no field as an
//! index or a length. A line reused before a subscriber's read is not counted.
//!
//! The protocol of both sides is in `last_words`.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicU64;
use std::sync::atomic::Ordering::{Acquire, Relaxed};

use messages::TopicName;

use crate::error::BusError;
use crate::last_words::{CLAIMED, DIED, ENDED, EndsSeen, LIVES, Line, LineHead, STATE, word_of};
pub(crate) use crate::last_words::{Identity, fold};
pub use crate::last_words::{PublisherLine, PublisherState};
use crate::mapping::Mapping;
use crate::seal::SHARED_MEMORY_DIR;

/// Most lines of a topic.
const LINES_MAX: usize = 1024;
/// Bytes of a line, and of the head.
const LINE_BYTES: usize = 64;

const _: () = assert!(size_of::<LineHead>() == LINE_BYTES && size_of::<Line>() == LINE_BYTES);

/// Reader of the lines of a topic's publishers.
#[derive(Debug)]
pub struct LineReader {
    /// None in process.
    lines: Option<Lines>,
    schema: u64,
}

impl LineReader {
    pub(crate) fn new(lines: Option<Lines>, schema: u64) -> Self {
        Self { lines, schema }
    }

    /// Last words of the publishers, the dead ones included until the lines are needed for others.
    pub fn read(&self) -> Vec<PublisherLine> {
        let lines = self.lines.iter().flat_map(Lines::read);
        lines.filter(|line| line.schema == self.schema).collect()
    }
}

/// All lines of a topic, mapped.
#[derive(Debug)]
pub(crate) struct Lines {
    mapping: Mapping,
    count: usize,
}

impl Lines {
    /// Creates the lines of `topic` for this number of simultaneous `publishers`, or opens existing lines.
    ///
    /// # Errors
    /// If the file cannot be made, or is another user's.
    pub(crate) fn create(prefix: &str, topic: &TopicName, publishers: usize) -> Result<Self, BusError> {
        let path = path_of(prefix, topic);
        let count = (2 * publishers.max(1)).min(LINES_MAX);
        Mapping::create(&path, (1 + count) * LINE_BYTES)
            .and_then(Self::of)
            .map_err(|source| io_error("create", path, source))
    }

    /// Opens the lines of `topic`.
    ///
    /// # Errors
    /// If no process holds the topic, or the lines belong to another user.
    pub(crate) fn open(prefix: &str, topic: &TopicName) -> Result<Self, BusError> {
        let path = path_of(prefix, topic);
        Mapping::open(&path)
            .and_then(Self::of)
            .map_err(|source| io_error("open", path, source))
    }

    fn of(mapping: Mapping) -> io::Result<Self> {
        let count = (mapping.bytes() / LINE_BYTES).saturating_sub(1).min(LINES_MAX);
        if count == 0 {
            return Err(io::Error::other("not a topic's lines"));
        }
        Ok(Self { mapping, count })
    }

    fn head(&self) -> &LineHead {
        // SAFETY: the mapping begins with a head, is aligned to a page, lives as long as `self`, and any bits are
        // atomic words.
        unsafe { self.mapping.start().cast().as_ref() }
    }

    fn list(&self) -> &[Line] {
        // SAFETY: as in `head`; behind the head the mapping has `count` lines.
        unsafe { std::slice::from_raw_parts(self.mapping.start().cast::<Line>().add(1).as_ptr(), self.count) }
    }

    /// The word that changes after each send.
    #[inline]
    pub(crate) fn sends(&self) -> &AtomicU64 {
        &self.head().sends
    }

    /// The word that changes with each new listener.
    #[inline]
    pub(crate) fn listeners(&self) -> &AtomicU64 {
        &self.head().listeners
    }

    /// Every line that a publisher has or had.
    pub(crate) fn read(&self) -> impl Iterator<Item = PublisherLine> + '_ {
        self.list().iter().filter_map(Line::read)
    }

    /// Assigns a line to the publisher `who`: an unused line, or else the line that ended first. `None` if all
    /// publishers live, or wait for removal.
    fn claim(&self, who: &Identity) -> Option<usize> {
        let mut places: Vec<(u64, usize, u64)> = self
            .list()
            .iter()
            .enumerate()
            .map(|(index, line)| (line.owner.load(Acquire), index, line))
            .filter(|(owner, ..)| matches!(owner & STATE, 0 | ENDED | DIED))
            .map(|(owner, index, line)| (line.end.load(Relaxed), index, owner))
            .collect();
        places.sort_unstable();
        places
            .into_iter()
            .find(|(_, index, owner)| self.list()[*index].begin(*owner, who))
            .map(|(_, index, _)| index)
    }

    /// Returns indices and owners of the lines of living or dead publishers.
    fn owners(&self) -> Vec<(usize, u64)> {
        let owners = self.list().iter().map(|line| line.owner.load(Acquire)).enumerate();
        owners
            .filter(|(_, owner)| matches!(owner & STATE, CLAIMED | LIVES))
            .collect()
    }
}

/// The line of a publisher of this process. When dropped, the line is marked as ended.
#[derive(Debug)]
pub(crate) struct OwnLine {
    lines: Lines,
    index: usize,
    own: u64,
}

impl OwnLine {
    /// A line for the publisher `who`; `None` if there is no place.
    pub(crate) fn begin(lines: Lines, who: &Identity) -> Option<Self> {
        let index = lines.claim(who)?;
        Some(Self {
            lines,
            index,
            own: word_of(who.node) | LIVES,
        })
    }

    /// States that all numbers before `next_sequence` have been given to samples.
    #[inline]
    pub(crate) fn number(&self, next_sequence: u64) {
        self.lines.list()[self.index].number(next_sequence);
    }

    /// States that the publisher lived at `now_ns`.
    #[inline]
    pub(crate) fn beat(&self, now_ns: i64) {
        self.lines.list()[self.index].beat(now_ns);
    }
}

impl Drop for OwnLine {
    fn drop(&mut self) {
        self.lines.list()[self.index].mark(self.lines.head(), self.own, ENDED);
    }
}

/// Reports ended publishers to a subscriber.
#[derive(Debug)]
pub(crate) struct Ends {
    lines: Lines,
    ends: EndsSeen,
}

impl Ends {
    /// The ends of publishers of `schema` from now on.
    pub(crate) fn from_now_on(lines: Lines, schema: u64) -> Self {
        let ends = EndsSeen::from_now_on(lines.head(), lines.list(), schema);
        Self { lines, ends }
    }

    /// Returns whether publishers have ended. The last slices of these publishers may still be in the queue: empty the
    /// queue, then [settle](Self::settle).
    #[inline]
    pub(crate) fn news(&mut self) -> bool {
        self.ends.news(self.lines.head(), self.lines.list())
    }

    /// Whether the queue must be emptied before ends can be settled.
    #[inline]
    pub(crate) fn are_waiting(&self) -> bool {
        self.ends.are_waiting()
    }

    /// Reports each publisher that ended before the last check with an empty queue.
    #[inline]
    pub(crate) fn settle(&mut self, tell: impl FnMut(&PublisherLine)) {
        self.ends.settle(tell);
    }
}

/// Returns the start of the names of files of lines.
fn name_start(prefix: &str) -> String {
    format!("{prefix}lines.")
}

fn path_of(prefix: &str, topic: &TopicName) -> PathBuf {
    let topic = topic.as_str().replace('/', ".");
    Path::new(SHARED_MEMORY_DIR).join(name_start(prefix) + &topic)
}

fn io_error(action: &'static str, path: PathBuf, source: io::Error) -> BusError {
    BusError::Io { action, path, source }
}

/// Marks all publishers of the instance as dead if their processes are missing in `nodes`. Names of the instance's
/// memory begin with `prefix`; files that cannot be opened are skipped.
pub(crate) fn mark_dead<E>(prefix: &str, nodes: impl FnOnce() -> Result<Vec<u128>, E>) {
    let start = name_start(prefix);
    let Ok(folder) = std::fs::read_dir(SHARED_MEMORY_DIR) else {
        return;
    };
    // Read before the list of processes: every living owner of a line is then in the list.
    let had: Vec<(Lines, Vec<(usize, u64)>)> = folder
        .flatten()
        .filter(|entry| entry.file_name().to_str().is_some_and(|name| name.starts_with(&start)))
        .filter_map(|entry| {
            let lines = Lines::of(Mapping::open(&entry.path()).ok()?).ok()?;
            let owners = lines.owners();
            Some((lines, owners))
        })
        .collect();
    let Ok(nodes) = nodes() else {
        return;
    };
    for (lines, owners) in &had {
        for (index, owner) in owners {
            if !nodes.iter().any(|node| word_of(*node) == owner & !STATE) {
                lines.list()[*index].mark(lines.head(), *owner, DIED);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn identity(origin: u128) -> Identity {
        Identity {
            node: 5,
            origin,
            incarnation: 6,
            schema: 7,
        }
    }

    /// Lines of two publishers, and the words of both.
    fn lines(folder: &tempfile::TempDir) -> (Lines, Mapping) {
        let path = folder.path().join("lines");
        let mapping = || Mapping::create(&path, 5 * LINE_BYTES).unwrap();
        (Lines::of(mapping()).unwrap(), mapping())
    }

    fn words(mapping: &Mapping) -> &[AtomicU64] {
        // SAFETY: the mapping is aligned to a page and has so many words, and any bits are a valid atomic word.
        unsafe { std::slice::from_raw_parts(mapping.start().cast().as_ptr(), mapping.bytes() / size_of::<u64>()) }
    }

    #[test]
    fn a_line_is_read_only_if_it_is_whole() {
        let folder = tempfile::tempdir().unwrap();
        let (all, mapping) = lines(&folder);
        let own = OwnLine::begin(lines(&folder).0, &identity(1)).unwrap();
        own.number(9);
        let found: Vec<_> = all.read().collect();
        assert_eq!((found.len(), found[0].next_sequence), (1, 9));
        // The owner, the identity and the check are the first words of a line; the head is as long as a line.
        let first = LINE_BYTES / size_of::<u64>();
        for word in &words(&mapping)[first..first + 5] {
            for bit in 0..64 {
                word.fetch_xor(1 << bit, Relaxed);
                let read: Vec<_> = all.read().collect();
                // Other bits of a state are another state, or none.
                assert!(read.is_empty() || read[0].life != PublisherState::Lives, "bit {bit}");
                word.fetch_xor(1 << bit, Relaxed);
            }
        }
        assert_eq!(all.read().collect::<Vec<_>>(), found);
    }

    #[test]
    fn lines_of_absurd_values_are_neither_read_nor_an_end_of_their_readers() {
        let folder = tempfile::tempdir().unwrap();
        for word in [1, 2, 3, 4, 7, 1 << 63, u64::MAX, u64::MAX - 4, u64::MAX - 5] {
            let (all, mapping) = lines(&folder);
            let mut ends = Ends::from_now_on(lines(&folder).0, word);
            let own = OwnLine::begin(lines(&folder).0, &identity(1));
            words(&mapping).iter().for_each(|place| place.store(word, Relaxed));
            assert_eq!(all.read().count(), 0);
            assert!(all.owners().len() <= 4);
            ends.news();
            ends.settle(|ended| panic!("no publisher has ended: {ended:?}"));
            if let Some(own) = &own {
                own.number(u64::MAX);
                own.beat(i64::MIN);
            }
            drop(own);
            drop(OwnLine::begin(lines(&folder).0, &identity(2)));
            words(&mapping).iter().for_each(|place| place.store(0, Relaxed));
        }
    }

    #[test]
    fn a_file_without_a_whole_line_is_none_of_lines() {
        let folder = tempfile::tempdir().unwrap();
        for bytes in [1, LINE_BYTES, 2 * LINE_BYTES - 1] {
            let mapping = Mapping::create(&folder.path().join(bytes.to_string()), bytes).unwrap();
            assert!(Lines::of(mapping).is_err(), "{bytes} bytes");
        }
        let longest = (LINES_MAX + 9) * LINE_BYTES + 1;
        let lines = Lines::of(Mapping::create(&folder.path().join("long"), longest).unwrap()).unwrap();
        assert_eq!(lines.list().len(), LINES_MAX);
    }
}
