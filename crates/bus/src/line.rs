//! Line of a publisher: its last sequence number, which outlives the publisher.
//!
//! A slice states how many samples its publisher had sent before, so that the next slice reveals missing samples.
//! After the last slice there is no such check: samples that died with a killed publisher would go unnoticed.
//! Therefore each publisher has a *line* of shared memory, one cache line long. Before each send the publisher writes
//! the sequence number after this send to the line, and afterwards the time. The line remains after the publisher's
//! end. A subscriber with an empty queue compares: numbers below the line's number that were not taken are lost.
//!
//! The lines of a topic are a file in shared memory, created by the topic's holder: a head, and twice as many lines
//! as simultaneous publishers, so that the lines of recently ended publishers remain readable when their places are
//! reused. A publisher that leaves marks its line as ended; the line of a killed publisher is marked by the process
//! that removes the dead ([`Bus::remove_dead`](crate::Bus::remove_dead)). Each mark increments a count in the head;
//! until the count changes, a check of an empty queue costs a subscriber one load.
//!
//! Limits: a publisher in another language has no line; its missing samples are detected by gaps only. Any process of
//! the same user can write to the file. Readers accept a line only if its fields are consistent, and use no field as
//! an index or a length. A line reused before a subscriber reads it is not counted.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering::{AcqRel, Acquire, Relaxed, Release};
use std::sync::atomic::{AtomicU64, fence};

use messages::TopicName;

use crate::error::BusError;
use crate::mapping::Mapping;
use crate::seal::SHARED_MEMORY_DIR;

/// Most lines of a topic.
const LINES_MAX: usize = 1024;
/// Bytes of a line, and of the head.
const LINE_BYTES: usize = 64;

/// States of a line, in the lower bits of its owner's word.
const CLAIMED: u64 = 1;
const LIVES: u64 = 2;
const ENDED: u64 = 3;
const DIED: u64 = 4;
const STATE_BITS: u32 = 3;
const STATE: u64 = (1 << STATE_BITS) - 1;

#[repr(C, align(64))]
struct LineHead {
    /// How many lines have been marked as ended or died.
    ends: AtomicU64,
    /// How many slices have been sent: see the module `hint`.
    sends: AtomicU64,
    /// How many listeners have come: see the module `wake_up`.
    listeners: AtomicU64,
}

#[repr(C, align(64))]
struct Line {
    /// Process of the line's present or former publisher, and the line's state; 0 if the line was never used.
    owner: AtomicU64,
    origin: AtomicU64,
    incarnation: AtomicU64,
    schema: AtomicU64,
    /// Agrees with the four fields before it.
    check: AtomicU64,
    next_sequence: AtomicU64,
    heartbeat_ns: AtomicU64,
    /// Count of ends when this one ended: the oldest is filled again first.
    end: AtomicU64,
}

const _: () = assert!(size_of::<LineHead>() == LINE_BYTES && size_of::<Line>() == LINE_BYTES);

/// Last words of a publisher.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PublisherLine {
    /// When the publisher started, by its own statement (monotonic, ns).
    pub incarnation: u64,
    /// Sequence number after the last sample that was sent, or that was about to be when its publisher was killed.
    pub next_sequence: u64,
    /// Monotonic time of the last send, nanoseconds; 0 before the first one.
    pub heartbeat_ns: i64,
    /// Whether the publisher lives, has left, or was killed.
    pub life: PublisherState,
    pub(crate) origin: u64,
    pub(crate) schema: u64,
    /// Differs from that of every other publisher.
    pub(crate) check: u64,
}

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

    /// Last words of the publishers, the dead ones included until their lines are needed for others.
    pub fn read(&self) -> Vec<PublisherLine> {
        let lines = self.lines.iter().flat_map(Lines::read);
        lines.filter(|line| line.schema == self.schema).collect()
    }
}

/// State of a publisher.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PublisherState {
    /// The publisher lives, or its death is not detected yet.
    Lives,
    /// It left.
    Ended,
    /// Its process ended without leaving.
    Died,
}

/// Identity of a publisher in its line.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Identity {
    /// iceoryx2's number of the process.
    pub(crate) node: u128,
    /// iceoryx2's number of the port.
    pub(crate) origin: u128,
    pub(crate) incarnation: u64,
    pub(crate) schema: u64,
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
        // SAFETY: as in `head`; behind it the mapping has `count` lines.
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

    fn mark(&self, index: usize, from: u64, state: u64) {
        let (head, line) = (self.head(), &self.list()[index]);
        line.end.store(head.ends.load(Relaxed).wrapping_add(1), Relaxed);
        let marked = line
            .owner
            .compare_exchange(from, from & !STATE | state, AcqRel, Relaxed);
        if marked.is_ok() {
            head.ends.fetch_add(1, AcqRel);
        }
    }

    /// Returns indices and owners of the lines of living or dead publishers.
    fn owners(&self) -> Vec<(usize, u64)> {
        let owners = self.list().iter().map(|line| line.owner.load(Acquire)).enumerate();
        owners
            .filter(|(_, owner)| matches!(owner & STATE, CLAIMED | LIVES))
            .collect()
    }
}

impl Line {
    /// Fills the line for `who`, unless another was faster.
    fn begin(&self, owner: u64, who: &Identity) -> bool {
        let own = word_of(who.node);
        if self
            .owner
            .compare_exchange(owner, own | CLAIMED, AcqRel, Relaxed)
            .is_err()
        {
            return false;
        }
        // No reader sees a field of the new publisher under the old one's name.
        fence(Release);
        let origin = fold(who.origin);
        self.origin.store(origin, Relaxed);
        self.incarnation.store(who.incarnation, Relaxed);
        self.schema.store(who.schema, Relaxed);
        self.check
            .store(check(own, origin, who.incarnation, who.schema), Relaxed);
        self.next_sequence.store(0, Relaxed);
        self.heartbeat_ns.store(0, Relaxed);
        self.owner.store(own | LIVES, Release);
        true
    }

    fn read(&self) -> Option<PublisherLine> {
        let owner = self.owner.load(Acquire);
        let line = PublisherLine {
            incarnation: self.incarnation.load(Relaxed),
            next_sequence: self.next_sequence.load(Relaxed),
            heartbeat_ns: self.heartbeat_ns.load(Relaxed).cast_signed(),
            life: match owner & STATE {
                LIVES => PublisherState::Lives,
                ENDED => PublisherState::Ended,
                DIED => PublisherState::Died,
                _ => return None,
            },
            origin: self.origin.load(Relaxed),
            schema: self.schema.load(Relaxed),
            check: self.check.load(Relaxed),
        };
        // The line was one publisher's all the while.
        fence(Acquire);
        let same = self.owner.load(Relaxed) == owner;
        let agrees = line.check == check(owner & !STATE, line.origin, line.incarnation, line.schema);
        (same && agrees).then_some(line)
    }
}

/// The line of a publisher of this process. When dropped, it is marked as ended.
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
        self.lines.list()[self.index]
            .next_sequence
            .store(next_sequence, Release);
    }

    /// States that the publisher lived at `now_ns`.
    #[inline]
    pub(crate) fn beat(&self, now_ns: i64) {
        let heartbeat_ns = &self.lines.list()[self.index].heartbeat_ns;
        heartbeat_ns.store(now_ns.cast_unsigned(), Release);
    }
}

impl Drop for OwnLine {
    fn drop(&mut self) {
        self.lines.mark(self.index, self.own, ENDED);
    }
}

/// Reports ended publishers to a subscriber.
#[derive(Debug)]
pub(crate) struct Ends {
    lines: Lines,
    schema: u64,
    /// Count of ends when it was last looked.
    seen: u64,
    /// For each line, the last publisher with a reported end.
    told: Vec<u64>,
    /// Ended publishers not reported yet.
    waiting: Vec<PublisherLine>,
}

impl Ends {
    /// The ends of publishers of `schema` from now on.
    pub(crate) fn from_now_on(lines: Lines, schema: u64) -> Self {
        let (seen, count) = (lines.head().ends.load(Acquire), lines.count);
        let mut ends = Self {
            lines,
            schema,
            seen,
            told: vec![0; count],
            waiting: Vec::with_capacity(count),
        };
        ends.look();
        ends.waiting.clear();
        ends
    }

    /// Returns whether publishers have ended. Their last slices may still be in the queue: empty the queue, then
    /// [settle](Self::settle).
    #[inline]
    pub(crate) fn news(&mut self) -> bool {
        let ends = self.lines.head().ends.load(Acquire);
        if ends == self.seen {
            return false;
        }
        self.seen = ends;
        self.look();
        true
    }

    /// Whether the queue must be emptied before ends can be settled.
    #[inline]
    pub(crate) fn are_waiting(&self) -> bool {
        !self.waiting.is_empty()
    }

    fn look(&mut self) {
        for (line, told) in self.lines.list().iter().zip(&mut self.told) {
            let ended = line
                .read()
                .filter(|line| line.life != PublisherState::Lives && line.schema == self.schema);
            if let Some(ended) =
                ended.filter(|ended| ended.check != *told && self.waiting.len() < self.waiting.capacity())
            {
                *told = ended.check;
                self.waiting.push(ended);
            }
        }
    }

    /// Reports each publisher that ended before the last check with an empty queue.
    #[inline]
    pub(crate) fn settle(&mut self, mut tell: impl FnMut(&PublisherLine)) {
        for ended in self.waiting.drain(..) {
            tell(&ended);
        }
    }
}

/// The upper bits of an owner's word: iceoryx2's number of the process, folded, without room for the state.
fn word_of(node: u128) -> u64 {
    fold(node) << STATE_BITS
}

/// A number of iceoryx2's, which is unique on the machine, in half the bits.
pub(crate) fn fold(number: u128) -> u64 {
    scramble(number as u64 ^ scramble((number >> 64) as u64))
}

fn check(owner: u64, origin: u64, incarnation: u64, schema: u64) -> u64 {
    [origin, incarnation, schema]
        .iter()
        .fold(owner, |sum, word| scramble(sum ^ word))
        .max(1)
}

/// The finaliser of SplitMix64 (Steele, Lea and Flood 2014): each bit of the result depends on all.
fn scramble(word: u64) -> u64 {
    let word = (word ^ (word >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let word = (word ^ (word >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    word ^ (word >> 31)
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

/// Marks all publishers of the instance as dead whose processes are missing in `nodes`. Names of the instance's
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
                lines.mark(*index, *owner, DIED);
            }
        }
    }
}
