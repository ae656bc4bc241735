//! Data of a receiver's feed in any format: pieces in, observations out.
//!
//! A feed is a stream of transmissions of targets that state their own positions. The formats differ in pieces (lines,
//! frames, documents), and each has a reader with its own rules; a feed hides which reader is at work, so that the live
//! adapter, the replay of a file and the check of a file take the same way. A reader combines the transmissions of a
//! target, so a feed has a state, and its pieces have an order.

use std::fmt;

use observations::{Observation, Statement};

use crate::sbs::{AircraftMerger, LineRejection, SbsSettings};

/// How a feed is read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FeedSettings {
    /// Lines of SBS-1; a piece is a line.
    Sbs(SbsSettings),
}

/// What a piece of a feed has brought.
pub enum Fed<'a> {
    /// Report of a target.
    Target(&'a Observation),
    /// Statement of a target beside its motion.
    Statement(&'a Statement),
    /// Refused data: the reason, and the refusal in words.
    Refused(&'static str, &'a dyn fmt::Display),
}

/// Counts of a feed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FeedCounts {
    /// Transmissions of targets that were read.
    pub records: u64,
    /// Transmissions with a time of their own; the others have the time of receipt.
    pub timed: u64,
    /// Refused transmissions.
    pub refused: u64,
    /// Octets of these.
    pub refused_octets: u64,
    /// Transmissions that announce a position and hold none, or whose position is ambiguous.
    pub without_position: u64,
    /// Transmissions of targets for which the table had no room.
    pub without_room: u64,
}

/// Reader of a feed.
#[derive(Debug)]
pub struct FeedReader {
    reader: Reader,
    /// Octets of refused lines.
    refused_octets: u64,
}

#[derive(Debug)]
enum Reader {
    Sbs(AircraftMerger),
}

impl FeedReader {
    /// Creates the reader of a feed that begins.
    pub fn new(settings: FeedSettings) -> Self {
        Self {
            reader: match settings {
                FeedSettings::Sbs(settings) => Reader::Sbs(AircraftMerger::new(settings)),
            },
            refused_octets: 0,
        }
    }

    /// Takes a piece that was received at `received_utc_ns` (UTC, nanoseconds).
    pub fn take(&mut self, piece: &[u8], received_utc_ns: i64, out: &mut dyn FnMut(Fed<'_>)) {
        match &mut self.reader {
            Reader::Sbs(merger) => match merger.take(piece, received_utc_ns) {
                Ok(Some(observed)) => out(Fed::Target(&observed)),
                Ok(None) => {}
                Err(error) => {
                    self.refused_octets += piece.len() as u64;
                    out(Fed::Refused(error.rejection.sentence(), &error));
                }
            },
        }
    }

    /// Returns the counts so far.
    pub fn counts(&self) -> FeedCounts {
        match &self.reader {
            Reader::Sbs(merger) => {
                let counted = merger.counters();
                let refused = LineRejection::ALL.iter().map(|reason| counted.rejected(*reason));
                FeedCounts {
                    records: counted.messages,
                    timed: counted.timed,
                    refused: refused.sum(),
                    refused_octets: self.refused_octets,
                    without_position: counted.without_position,
                    without_room: counted.refused_aircraft,
                }
            }
        }
    }
}
