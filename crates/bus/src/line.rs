//! The publisher's line: last words that outlive their publisher.
//!
//! A slice says how many samples its publisher had sent before it, so what is missing shows with the next slice. After
//! the last one nothing follows: of a publisher that was killed, nobody would know which samples died with it. So each
//! publisher has a line of shared memory, one cache line long. Before each send it writes there which number follows
//! that send, and after it the time. The line stays when its publisher is gone, and a subscriber that has emptied the
//! queue compares: numbers up to the line's that it has not taken are lost to it.
//!
//! The lines of a topic are one file in shared memory, made by the topic's holder: a head, then twice as many lines as
//! there can be publishers at a time, so that the lines of those that ended last can still be read when their places
//! are filled again. A publisher that leaves marks its line as ended; that of a killed one is marked by whoever removes
//! the dead ([`Bus::remove_dead`](crate::Bus::remove_dead)). Each mark raises a count in the head, which tells
//! subscribers to look: until then a look at an empty queue costs them one load.
//!
//! Limits: a publisher in another language has no line, and what is missing of it shows by gaps only. Any process of
//! the same user can write into the file. Readers believe a line only if its fields agree with each other, and use
//! nothing of it as a place or a length. A line whose place was filled again before a subscriber looked is not missed
//! by it.

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
/// Octets of a line, and of the head.
const LINE_BYTES: usize = 64;

/// States of a line, in the lower bits of its owner's word.
const CLAIMED: u64 = 1;
const LIVES: u64 = 2;
const ENDED: u64 = 3;
const DIED: u64 = 4;
const STATE_BITS: u32 = 3;
const STATE: u64 = (1 << STATE_BITS) - 1;

#[repr(C, align(64))]
struct Head {
    /// How many lines have been marked as ended or died.
    ends: AtomicU64,
}

#[repr(C, align(64))]
struct Line {
    /// The process that has or had the line, and the line's state; 0 if nobody ever had it.
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

const _: () = assert!(size_of::<Head>() == LINE_BYTES && size_of::<Line>() == LINE_BYTES);

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
    pub life: Life,
    pub(crate) origin: u64,
    pub(crate) schema: u64,
    /// Differs from that of every other publisher.
    pub(crate) check: u64,
}

/// State of a publisher.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Life {
    /// It lives, or its death was not found yet.
    Lives,
    /// It left.
    Ended,
    /// Its process ended without leaving.
    Died,
}

/// Identity of a publisher, as its line states it.
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
    /// Creates the lines of `topic`, which so many `publishers` can have at a time, or opens them if they exist.
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
    /// If nobody holds the topic, or they are another user's.
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

    fn head(&self) -> &Head {
        // SAFETY: the mapping begins with a head, is aligned to a page, lives as long as `self`, and any bits are
        // atomic words.
        unsafe { self.mapping.start().cast().as_ref() }
    }

    fn list(&self) -> &[Line] {
        // SAFETY: as in `head`; behind it the mapping has `count` lines.
        unsafe { std::slice::from_raw_parts(self.mapping.start().cast::<Line>().add(1).as_ptr(), self.count) }
    }

    /// Every line that a publisher has or had.
    pub(crate) fn read(&self) -> impl Iterator<Item = PublisherLine> + '_ {
        self.list().iter().filter_map(Line::read)
    }

    /// Takes a line for the publisher `who`: one that nobody ever had, else the one that ended first. `None` if all
    /// publishers live, or wait to be removed.
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

    /// Places and owners of the lines whose publishers live, or died.
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
                LIVES => Life::Lives,
                ENDED => Life::Ended,
                DIED => Life::Died,
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

/// Tells a subscriber of publishers that have ended.
#[derive(Debug)]
pub(crate) struct Ends {
    lines: Lines,
    schema: u64,
    /// Count of ends when it was last looked.
    seen: u64,
    /// Which publisher's end was told last, for each line.
    told: Vec<u64>,
    /// Ended publishers to be told of.
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

    /// Whether publishers have ended. What they sent may still be in the queue: empty it, then [settle](Self::settle).
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
                .filter(|line| line.life != Life::Lives && line.schema == self.schema);
            if let Some(ended) =
                ended.filter(|ended| ended.check != *told && self.waiting.len() < self.waiting.capacity())
            {
                *told = ended.check;
                self.waiting.push(ended);
            }
        }
    }

    /// Tells of each publisher that had ended before the queue was last asked and found empty.
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

/// What the name of each file of lines begins with.
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

/// Marks as dead all publishers of the instance whose process is not among the `nodes` any more. Names of its memory
/// begin with `prefix`; a file that cannot be opened is left out.
pub(crate) fn mark_dead<E>(prefix: &str, nodes: impl FnOnce() -> Result<Vec<u128>, E>) {
    let start = name_start(prefix);
    let Ok(folder) = std::fs::read_dir(SHARED_MEMORY_DIR) else {
        return;
    };
    // Before the processes are listed: whoever has a line by now is among them, if it lives.
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
