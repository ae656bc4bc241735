//! A whole recording, taken piece by piece by its owner: data blocks, or the pieces of a feed.
//!
//! [`super::datagrams`] borrows the bytes. A reader that stops between two pieces and goes on later keeps the unpacked
//! datagrams instead: one after the other, with their ends. Memory is that of the recording's datagrams.

use std::collections::VecDeque;

use asterix::{Block, Error, blocks};

use super::{Container, TimeStamp, datagrams};

/// Datagrams of a recording, in sequence.
#[derive(Debug)]
pub struct RecordedPieces {
    bytes: Vec<u8>,
    datagrams: VecDeque<UnpackedDatagram>,
    position: usize,
}

/// A datagram among the unpacked bytes.
#[derive(Clone, Copy, Debug)]
struct UnpackedDatagram {
    begin: usize,
    end: usize,
    /// Offset of the begin in the recording.
    offset: usize,
    /// Time of receipt if known, UTC, nanoseconds.
    received_ns: Option<i64>,
}

impl RecordedPieces {
    /// Unpacks the datagrams of the recording's container.
    pub fn new(bytes: Vec<u8>) -> Self {
        if Container::detect(&bytes) == Container::Raw {
            return Self::bare(bytes);
        }
        let (mut unpacked, mut found) = (Vec::new(), VecDeque::new());
        for datagram in datagrams(&bytes).flatten() {
            let begin = unpacked.len();
            unpacked.extend_from_slice(&datagram.bytes);
            let received_ns = match datagram.time_stamp {
                Some(TimeStamp::Utc { ns }) => Some(ns),
                _ => None,
            };
            found.push_back(UnpackedDatagram {
                begin,
                end: unpacked.len(),
                offset: datagram.offset,
                received_ns,
            });
        }
        found.retain(|datagram| datagram.end > 0);
        Self {
            bytes: unpacked,
            datagrams: found,
            position: 0,
        }
    }

    /// Unpacks the datagrams of a capture of a feed. Anything else is a feed's own stream: lines of hexadecimal digits
    /// may be frames.
    pub fn of_feed(bytes: Vec<u8>) -> Self {
        match Container::detect(&bytes) {
            Container::Pcap | Container::PcapNg => Self::new(bytes),
            _ => Self::bare(bytes),
        }
    }

    /// Bytes without a container: one datagram.
    fn bare(bytes: Vec<u8>) -> Self {
        let whole = UnpackedDatagram {
            begin: 0,
            end: bytes.len(),
            offset: 0,
            received_ns: None,
        };
        Self {
            datagrams: (whole.end > 0).then_some(whole).into_iter().collect(),
            bytes,
            position: 0,
        }
    }

    /// Returns whether all pieces have been taken.
    pub fn is_exhausted(&self) -> bool {
        self.datagrams.is_empty()
    }

    /// Offset of the next piece in the recording; that of its line in text.
    pub fn offset(&self) -> usize {
        self.datagrams.front().map_or(self.position, |datagram| {
            datagram.offset + (self.position - datagram.begin)
        })
    }

    /// Returns the next data block and the number of bytes. Data that are no block end the datagram, and are an error
    /// of that many bytes.
    pub fn next_block(&mut self) -> (Option<Result<Block<'_>, Error>>, usize) {
        let found = |rest| {
            let block = blocks(rest).next();
            let length = match &block {
                Some(Ok(block)) => block.bytes.len(),
                _ => rest.len(),
            };
            ((block, length), length)
        };
        self.next_piece(found).0
    }

    /// Returns the next piece of a datagram as `take` finds it, and the time of receipt; `take` also returns the
    /// number of bytes of the piece.
    pub fn next_piece<'a, T>(&'a mut self, take: impl FnOnce(&'a [u8]) -> (T, usize)) -> (T, Option<i64>) {
        let datagram = self.datagrams.front().copied();
        let end = datagram.map_or(self.position, |datagram| datagram.end);
        let (piece, length) = take(&self.bytes[self.position..end]);
        self.position += length;
        if self.position == end {
            self.datagrams.pop_front();
        }
        (piece, datagram.and_then(|datagram| datagram.received_ns))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_have_their_places_in_the_recording() {
        let blocks = [vec![205, 0, 4, 1], vec![48, 0, 5, 1, 2], vec![48, 0]].concat();
        let frame = |payload: &[u8]| {
            let length = (payload.len() as u16 + 12).to_be_bytes();
            [&length[..], &[0; 6], payload, &[0xA5; 4]].concat()
        };
        for (recording, expected) in [
            (blocks.clone(), [0, 4, 9]),
            ([frame(&[]), frame(&blocks)].concat(), [20, 24, 29]),
        ] {
            let mut pieces = RecordedPieces::new(recording);
            let mut found = Vec::new();
            while !pieces.is_exhausted() {
                let offset = pieces.offset();
                if let (Some(block), length) = pieces.next_block() {
                    found.push((offset, block.is_ok(), length));
                }
            }
            let [first, second, last] = expected;
            assert_eq!(found, [(first, true, 4), (second, true, 5), (last, false, 2)]);
        }
    }
}
