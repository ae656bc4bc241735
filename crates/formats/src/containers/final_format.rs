//! The final format: frames of a recorder.
//!
//! ```text
//! byte 0   2            3           4              5                    8 …    n - 4
//!       length of all n, board, line number, day of recording, time of day, blocks, A5 A5 A5 A5
//! ```
//!
//! Numbers are big-endian; the time of day counts hundredths of a second since midnight. Board, line and day mean
//! something to the recorder only, and are often 0.

use super::skipped::{Reason, Skipped};
use super::{Container, RecordedDatagram, TimeStamp};

const HEADER_OCTETS: usize = 8;
const TRAILER: [u8; 4] = [0xA5; 4];
/// The unit of the time of day.
const TIME_NS: i64 = 10_000_000;

/// Whether the bytes begin with a whole frame.
pub(super) fn begins(bytes: &[u8]) -> bool {
    frame(bytes).is_some()
}

/// The frames of a recording.
#[derive(Debug)]
pub(super) struct Frames<'a> {
    bytes: &'a [u8],
    position: usize,
}

impl<'a> Frames<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, position: 0 }
    }

    pub(super) fn position(&self) -> usize {
        self.position
    }

    pub(super) fn next(&mut self) -> Option<Result<RecordedDatagram<'a>, Skipped>> {
        let (begin, rest) = (self.position, &self.bytes[self.position..]);
        if rest.is_empty() {
            return None;
        }
        let Some(frame) = frame(rest) else {
            let skipped = self.skip(begin, rest);
            self.position += skipped.octets;
            return Some(Err(skipped));
        };
        self.position += frame.len();
        let hundredths = i64::from(u32::from_be_bytes([0, frame[5], frame[6], frame[7]]));
        let time_stamp = TimeStamp::TimeOfDay {
            ns: hundredths * TIME_NS,
        };
        let payload = &frame[HEADER_OCTETS..frame.len() - TRAILER.len()];
        Some(Ok(RecordedDatagram::of(
            payload,
            Some(time_stamp),
            begin + HEADER_OCTETS,
        )))
    }

    /// Skips bytes outside frames, up to the end of the next trailer, where the next attempt begins.
    fn skip(&self, begin: usize, rest: &[u8]) -> Skipped {
        let length = length(rest);
        let trailer = rest.windows(TRAILER.len()).position(|octets| octets == TRAILER);
        let why = match (trailer, length) {
            (None, _) if begin == 0 => Reason::OtherContainer {
                expected: Container::Final,
            },
            (None, None) => Reason::FileCut {
                needed: HEADER_OCTETS + TRAILER.len(),
                available: rest.len(),
            },
            (None, Some(length)) if length > rest.len() => Reason::FileCut {
                needed: length,
                available: rest.len(),
            },
            (_, length) => Reason::Trailer {
                length: length.unwrap_or(0),
            },
        };
        Skipped {
            offset: begin,
            octets: trailer.map_or(rest.len(), |at| at + TRAILER.len()),
            why,
        }
    }
}

fn length(bytes: &[u8]) -> Option<usize> {
    let &[high, low, ..] = bytes else { return None };
    Some(usize::from(u16::from_be_bytes([high, low])))
}

/// The frame at the begin of `bytes`, if there is a whole one.
fn frame(bytes: &[u8]) -> Option<&[u8]> {
    let frame = bytes.get(..length(bytes)?)?;
    let holds_both = frame.len() >= HEADER_OCTETS + TRAILER.len();
    (holds_both && frame.ends_with(&TRAILER)).then_some(frame)
}
