//! Messages in several sentences.
//!
//! A sentence holds 60 characters of payload; longer messages, such as the static data of a ship, come in parts. The
//! parts of one message have the same sequence number, 0 to 9, which the receiver counts on for every such message of a
//! channel. A stream of several receivers mixes their parts, so connection, station and channel belong to the key; the
//! assembler of `aivdm` holds a single message.
//!
//! Parts must come in order, and soon: a busy receiver uses each number again after ten seconds, so an older beginning
//! with a newer end would be a message that nobody has sent. A first part therefore replaces an unfinished message of
//! its key, and a part of another count or place ends it.

use std::hash::BuildHasher;

use rustc_hash::FxBuildHasher;

use super::counters::AisRejection;
use super::line::AisLine;

/// Longest payload, characters: the 1064 bits of the longest message, and some that receivers append.
pub(super) const PAYLOAD_MAX: usize = 192;
/// Most messages that wait for parts.
const WAITING_MAX: usize = 64;
/// Time from the first part to the last, nanoseconds.
const AGE_MAX_NS: u64 = 5_000_000_000;

/// A whole message, still in six-bit characters.
#[derive(Clone, Copy, Debug)]
pub(super) struct Whole {
    payload: [u8; PAYLOAD_MAX],
    length: usize,
    /// Bits of the last character that do not count.
    pub(super) fill_bits: u8,
    /// Time of receipt as a line states it, UTC, nanoseconds since 1970.
    pub(super) received_ns: Option<i64>,
}

impl Whole {
    fn begun(received_ns: Option<i64>) -> Self {
        Self {
            payload: [b'0'; PAYLOAD_MAX],
            length: 0,
            fill_bits: 0,
            received_ns,
        }
    }

    /// Characters of the message.
    pub(super) fn payload(&self) -> &[u8] {
        &self.payload[..self.length]
    }

    /// Appends the characters of a part.
    pub(super) fn push(&mut self, part: &[u8]) -> Result<(), AisRejection> {
        let end = self.length + part.len();
        let place = self.payload.get_mut(self.length..end).ok_or(AisRejection::Length)?;
        place.copy_from_slice(part);
        self.length = end;
        Ok(())
    }
}

/// A message whose parts are not yet complete.
#[derive(Debug)]
struct Waiting {
    key: (u32, u8, bool, Option<u8>),
    station: Option<u64>,
    parts: u8,
    next: u8,
    begun_ns: i64,
    whole: Whole,
}

/// Messages whose parts are not yet complete.
#[derive(Debug)]
pub(super) struct Assembler {
    waiting: Vec<Waiting>,
}

impl Assembler {
    pub(super) fn new() -> Self {
        Self {
            waiting: Vec::with_capacity(WAITING_MAX),
        }
    }

    /// Gives up the messages that wait for parts; returns how many there were.
    pub(super) fn end(&mut self) -> u64 {
        self.waiting.drain(..).len() as u64
    }

    /// Takes a line of a connection at `now_ns`; gives the message that it completes. Messages that are given up are
    /// added to `unfinished`.
    pub(super) fn take(
        &mut self,
        connection: u32,
        line: &AisLine<'_>,
        now_ns: i64,
        unfinished: &mut u64,
    ) -> Result<Option<Whole>, AisRejection> {
        let part = &line.sentence;
        if part.fragment_count == 1 {
            let mut whole = Whole::begun(line.received_ns);
            whole.fill_bits = part.fill_bits;
            return whole.push(part.payload).map(|()| Some(whole));
        }
        let before = self.waiting.len();
        self.waiting
            .retain(|waiting| now_ns.abs_diff(waiting.begun_ns) <= AGE_MAX_NS);
        *unfinished += (before - self.waiting.len()) as u64;
        let key = (connection, part.channel.to_byte(), part.is_own_ship, part.seq_id);
        let station = line.station.map(|station| FxBuildHasher.hash_one(station));
        // The parts behind the first need not name their station.
        let is_of = |waiting: &Waiting| {
            let is_unnamed = station.is_none() && part.fragment_number > 1;
            waiting.key == key && (waiting.station == station || is_unnamed)
        };
        let earlier = self
            .waiting
            .iter()
            .position(is_of)
            .map(|place| self.waiting.remove(place));
        let mut waiting = match (part.fragment_number, earlier) {
            (1, earlier) => {
                *unfinished += u64::from(earlier.is_some());
                Waiting {
                    key,
                    station,
                    parts: part.fragment_count,
                    next: 1,
                    begun_ns: now_ns,
                    whole: Whole::begun(line.received_ns),
                }
            }
            (number, Some(earlier)) if (earlier.parts, earlier.next) == (part.fragment_count, number) => earlier,
            (_, earlier) => {
                *unfinished += u64::from(earlier.is_some());
                return Err(AisRejection::Order);
            }
        };
        waiting.whole.push(part.payload)?;
        if waiting.next == waiting.parts {
            waiting.whole.fill_bits = part.fill_bits;
            return Ok(Some(waiting.whole));
        }
        waiting.next += 1;
        if self.waiting.len() == WAITING_MAX {
            // The one that has waited longest is the least likely to be finished.
            self.waiting.remove(0);
            *unfinished += 1;
        }
        self.waiting.push(waiting);
        Ok(None)
    }
}
