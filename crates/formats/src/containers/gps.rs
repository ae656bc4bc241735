//! The `.gps` format: data blocks of a recorder of RASS tools, with the recorder's time behind each.
//!
//! ```text
//! byte 0         2,200        n               n + 6        n + 9    n + 10
//!       header,  data block,  not published,  time of day, unknown, next block
//! ```
//!
//! The format is not published. What is read here is what the decoder of Croatia Control reads: a header of 2,200
//! octets, then data blocks with ten octets behind each, of which octets 6 to 8 (counted from 0) are a time of day in
//! units of 1/128 s. The meaning of the other seven octets is unknown: of a board and a line by the descriptions of
//! such recorders, and a number of the time's source. They differ between recorders and are not used. The content of
//! the header is unknown, too.
//!
//! The length of a block is the only way to the next one, and neither a block nor the ten octets have a mark. Behind an
//! impossible length the reader goes on at the next place where blocks of known categories follow each other.
//!
//! # Source
//!
//! `asterixgpssubformat.cxx` of github.com/CroatiaControlLtd/asterix, read for the places of the octets.

use asterix::blocks;
use asterix::registry;
use frames::time::{NS_PER_DAY, time_of_day_ns};

use super::skipped::{Reason, Skipped};
use super::{Container, RecordedDatagram, TimeStamp};
use crate::text::text;

/// Octets before the first data block.
const HEADER_OCTETS: usize = 2_200;
/// Octets behind each data block.
const TRAILER_OCTETS: usize = 10;
/// Place of the time of day behind a data block.
const TIME_AT: usize = 6;
/// Category, and length of the block.
const BLOCK_HEADER_OCTETS: usize = 3;
/// Longest data block: blocks came in datagrams.
const BLOCK_OCTETS_MAX: usize = 1 << 12;
/// Data blocks of known categories in a row that make the format certain.
const ENOUGH: usize = 3;

/// Whether the bytes are a header and data blocks, each with its ten octets. Texts, whose letters are such lengths by
/// accident, and bare data blocks are none.
pub(crate) fn begins(bytes: &[u8]) -> bool {
    is_chain(bytes, HEADER_OCTETS) && text(bytes).is_none() && !is_bare(bytes)
}

/// Whether the first octets are data blocks without anything between.
fn is_bare(bytes: &[u8]) -> bool {
    let known = |category| registry::default_edition(category).is_some();
    let first = blocks(bytes).take(ENOUGH);
    let good = first.filter(|block| block.as_ref().is_ok_and(|block| known(block.category)));
    good.count() == ENOUGH
}

/// Whether data blocks of known categories follow each other from `at` on: [`ENOUGH`] of them, or fewer up to the end.
fn is_chain(bytes: &[u8], at: usize) -> bool {
    let mut at = at;
    for count in 0..ENOUGH {
        if count > 0 && at == bytes.len() {
            return true;
        }
        match block_octets(bytes, at) {
            Some(length) if registry::default_edition(bytes[at]).is_some() => at += length + TRAILER_OCTETS,
            _ => return false,
        }
        if at > bytes.len() {
            return false;
        }
    }
    true
}

/// The length of the data block at `at`, if it is a possible one. Category 0 does not exist.
fn block_octets(bytes: &[u8], at: usize) -> Option<usize> {
    let &[category, high, low] = bytes.get(at..at + BLOCK_HEADER_OCTETS)? else {
        return None;
    };
    let length = usize::from(u16::from_be_bytes([high, low]));
    (category > 0 && (BLOCK_HEADER_OCTETS + 1..=BLOCK_OCTETS_MAX).contains(&length)).then_some(length)
}

/// The data blocks of a recording.
#[derive(Debug)]
pub(super) struct GpsBlocks<'a> {
    bytes: &'a [u8],
    position: usize,
}

impl<'a> GpsBlocks<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, position: 0 }
    }

    pub(super) fn position(&self) -> usize {
        self.position
    }

    pub(super) fn next(&mut self) -> Option<Result<RecordedDatagram<'a>, Skipped>> {
        if self.position == self.bytes.len() {
            return None;
        }
        if self.position == 0 {
            if self.bytes.len() <= HEADER_OCTETS {
                return Some(Err(self.skip(
                    0,
                    self.bytes.len(),
                    Reason::OtherContainer {
                        expected: Container::Gps,
                    },
                )));
            }
            self.position = HEADER_OCTETS;
        }
        let begin = self.position;
        let available = self.bytes.len() - begin;
        let length = block_octets(self.bytes, begin);
        let needed = length.unwrap_or(BLOCK_HEADER_OCTETS) + TRAILER_OCTETS;
        match length {
            Some(length) if needed <= available => {
                let (block, trailer) = self.bytes[begin..begin + needed].split_at(length);
                self.position += needed;
                Some(Ok(RecordedDatagram::of(block, time_stamp(trailer), begin)))
            }
            _ => Some(Err(self.lost(begin, needed, length.is_some() || available < needed))),
        }
    }

    /// Skips octets that are no data block, up to the next place where data blocks follow each other. A possible length
    /// beyond the end (`is_cut`) without such a place is the end of the recording.
    fn lost(&mut self, begin: usize, needed: usize, is_cut: bool) -> Skipped {
        let available = self.bytes.len() - begin;
        let next = (begin + 1..self.bytes.len()).find(|at| is_chain(self.bytes, *at));
        let why = match next {
            None if is_cut => Reason::FileCut { needed, available },
            _ if begin == HEADER_OCTETS && next.is_none() => Reason::OtherContainer {
                expected: Container::Gps,
            },
            _ => Reason::GpsBlock {
                length: self
                    .bytes
                    .get(begin + 1..begin + BLOCK_HEADER_OCTETS)
                    .map_or(0, |length| usize::from(u16::from_be_bytes([length[0], length[1]]))),
            },
        };
        self.skip(begin, next.unwrap_or(self.bytes.len()) - begin, why)
    }

    fn skip(&mut self, offset: usize, octets: usize, why: Reason) -> Skipped {
        self.position = offset + octets;
        Skipped { offset, octets, why }
    }
}

/// The recorder's time; `None` for a number that is no time of day.
fn time_stamp(trailer: &[u8]) -> Option<TimeStamp> {
    let &[high, middle, low] = trailer.get(TIME_AT..TIME_AT + 3)? else {
        return None;
    };
    let ns = time_of_day_ns(u32::from_be_bytes([0, high, middle, low]));
    (ns < NS_PER_DAY).then_some(TimeStamp::TimeOfDay { ns })
}
