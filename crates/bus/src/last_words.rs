//! Protocol of a publisher's line: one publisher writes, any process reads, and a later publisher takes the line over.
//!
//! # No reader mixes two publishers
//! A publisher takes a line by a swap of the owner's word to the publisher's own with the state "claimed", and only
//! then writes the fields, behind a fence (release). The publisher writes the check last, and then the owner's word
//! with the state "lives" (both release). A reader reads the check, the owner's word, the fields, and behind a fence
//! (acquire) the owner's word and the check again. The reader accepts the fields if both are unchanged, and the check
//! agrees with owner and identity.
//!
//! The owner's word names the process only: a process that takes a former line of the same process over, and leaves the
//! line again, brings the same word back. The check differs for each publisher. Once the check is read, the owner's
//! word and the fields are this publisher's or a later one's. A field of a later publisher shows at least the claim,
//! behind the fence. The later owner's word can equal the first only if the later publisher lives or has ended; then
//! the second check is the later publisher's.
//!
//! # No end is overlooked
//! A mark changes the owner's word, and then increments the count of ends in the head. A reader that sees the count
//! changed sees the mark.
//!
//! Any process of the same user can write to the words. Readers use none as an index or a length. The workspace
//! `models` checks the protocol in all orders of operations.

use std::sync::atomic::Ordering::{AcqRel, Acquire, Relaxed, Release};

use crate::atomic::{AtomicU64, fence};

/// States of a line, in the lower bits of the owner's word.
pub(crate) const CLAIMED: u64 = 1;
pub(crate) const LIVES: u64 = 2;
pub(crate) const ENDED: u64 = 3;
pub(crate) const DIED: u64 = 4;
const STATE_BITS: u32 = 3;
pub(crate) const STATE: u64 = (1 << STATE_BITS) - 1;

/// Words of a topic before the lines.
#[derive(Debug, Default)]
#[repr(C, align(64))]
pub(crate) struct LineHead {
    /// How many lines have been marked as ended or died.
    pub(crate) ends: AtomicU64,
    /// How many slices have been sent: see the module `hint`.
    pub(crate) sends: AtomicU64,
    /// How many listeners have come: see the module `wake_up`.
    pub(crate) listeners: AtomicU64,
}

/// Words of a publisher.
#[derive(Debug, Default)]
#[repr(C, align(64))]
pub(crate) struct Line {
    /// Process of the line's present or former publisher, and the line's state; 0 if the line was never used.
    pub(crate) owner: AtomicU64,
    origin: AtomicU64,
    incarnation: AtomicU64,
    schema: AtomicU64,
    /// Agrees with the four preceding fields.
    pub(crate) check: AtomicU64,
    next_sequence: AtomicU64,
    heartbeat_ns: AtomicU64,
    /// Count of ends when this line ended: the oldest line is filled again first.
    pub(crate) end: AtomicU64,
}

/// Last words of a publisher.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PublisherLine {
    /// Start of the publisher, as stated by the publisher (monotonic, ns).
    pub incarnation: u64,
    /// Sequence number after the last sample that was sent, or about to be sent when the publisher was killed.
    pub next_sequence: u64,
    /// Monotonic time of the last send, nanoseconds; 0 before the first send.
    pub heartbeat_ns: i64,
    /// Whether the publisher lives, has left, or was killed.
    pub life: PublisherState,
    pub(crate) origin: u64,
    pub(crate) schema: u64,
    /// Differs from that of every other publisher.
    pub(crate) check: u64,
}

/// State of a publisher.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PublisherState {
    /// The publisher lives, or its death is not detected yet.
    Lives,
    /// The publisher left.
    Ended,
    /// The publisher's process ended without leaving.
    Died,
}

/// Identity of a publisher in a line.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Identity {
    /// iceoryx2's number of the process.
    pub(crate) node: u128,
    /// iceoryx2's number of the port.
    pub(crate) origin: u128,
    pub(crate) incarnation: u64,
    pub(crate) schema: u64,
}

impl Line {
    /// Fills the line for `who`, unless another was faster.
    pub(crate) fn begin(&self, owner: u64, who: &Identity) -> bool {
        let own = word_of(who.node);
        if self
            .owner
            .compare_exchange(owner, own | CLAIMED, AcqRel, Relaxed)
            .is_err()
        {
            return false;
        }
        // No reader sees a field of the new publisher under the old publisher's name.
        fence(Release);
        let origin = fold(who.origin);
        self.origin.store(origin, Relaxed);
        self.incarnation.store(who.incarnation, Relaxed);
        self.schema.store(who.schema, Relaxed);
        self.next_sequence.store(0, Relaxed);
        self.heartbeat_ns.store(0, Relaxed);
        // After the fields: a reader that sees the new check sees no field of the old publisher.
        self.check
            .store(check_of(own, origin, who.incarnation, who.schema), Release);
        self.owner.store(own | LIVES, Release);
        true
    }

    /// States that all numbers before `next_sequence` have been given to samples.
    #[inline]
    pub(crate) fn number(&self, next_sequence: u64) {
        self.next_sequence.store(next_sequence, Release);
    }

    /// States that the publisher lived at `now_ns`.
    #[inline]
    pub(crate) fn beat(&self, now_ns: i64) {
        self.heartbeat_ns.store(now_ns.cast_unsigned(), Release);
    }

    /// Changes the state of a line that has the owner's word `from`.
    pub(crate) fn mark(&self, head: &LineHead, from: u64, state: u64) {
        self.end.store(head.ends.load(Relaxed).wrapping_add(1), Relaxed);
        let marked = self
            .owner
            .compare_exchange(from, from & !STATE | state, AcqRel, Relaxed);
        if marked.is_ok() {
            head.ends.fetch_add(1, AcqRel);
        }
    }

    /// Last words of the line's publisher; `None` if there was none, or a publisher is taking the line over.
    pub(crate) fn read(&self) -> Option<PublisherLine> {
        // Before the owner's word: this word then belongs to the same publisher, or to a later publisher.
        let check = self.check.load(Acquire);
        let owner = self.owner.load(Acquire);
        let line = self.look(check, owner)?;
        // The line belonged to the same publisher throughout, not to another publisher of the same process.
        fence(Acquire);
        let same = self.owner.load(Acquire) == owner && self.check.load(Relaxed) == check;
        same.then_some(line)
    }

    /// The words besides `check` and `owner`; `None` in case of disagreement.
    pub(crate) fn look(&self, check: u64, owner: u64) -> Option<PublisherLine> {
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
            check,
        };
        let agrees = check == check_of(owner & !STATE, line.origin, line.incarnation, line.schema);
        agrees.then_some(line)
    }
}

/// Known ends of a topic's publishers.
#[derive(Debug)]
pub(crate) struct EndsSeen {
    schema: u64,
    /// Count of ends at the last look.
    seen: u64,
    /// For each line, the last publisher with a reported end.
    told: Vec<u64>,
    /// Ended publishers not reported yet.
    waiting: Vec<PublisherLine>,
}

impl EndsSeen {
    /// The ends of publishers of `schema` from now on.
    pub(crate) fn from_now_on(head: &LineHead, list: &[Line], schema: u64) -> Self {
        let mut ends = Self {
            schema,
            seen: head.ends.load(Acquire),
            told: vec![0; list.len()],
            waiting: Vec::with_capacity(list.len()),
        };
        ends.look(list);
        ends.waiting.clear();
        ends
    }

    /// Returns whether publishers have ended since the last look.
    #[inline]
    pub(crate) fn news(&mut self, head: &LineHead, list: &[Line]) -> bool {
        let ends = head.ends.load(Acquire);
        if ends == self.seen {
            return false;
        }
        self.seen = ends;
        self.look(list);
        true
    }

    /// Whether ends are to be settled.
    #[inline]
    pub(crate) fn are_waiting(&self) -> bool {
        !self.waiting.is_empty()
    }

    fn look(&mut self, list: &[Line]) {
        for (line, told) in list.iter().zip(&mut self.told) {
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

    /// Reports each publisher with an end not reported yet.
    #[inline]
    pub(crate) fn settle(&mut self, mut tell: impl FnMut(&PublisherLine)) {
        for ended in self.waiting.drain(..) {
            tell(&ended);
        }
    }
}

/// The upper bits of an owner's word: iceoryx2's number of the process, folded, without room for the state.
pub(crate) fn word_of(node: u128) -> u64 {
    fold(node) << STATE_BITS
}

/// A number of iceoryx2's, which is unique on the machine, in half the bits.
pub(crate) fn fold(number: u128) -> u64 {
    scramble(number as u64 ^ scramble((number >> 64) as u64))
}

fn check_of(owner: u64, origin: u64, incarnation: u64, schema: u64) -> u64 {
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
