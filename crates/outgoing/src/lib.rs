//! Tracks and states of the system as ASTERIX data blocks, and tracks as Cursor on Target events.
//!
//! Fused tracks leave as CAT062, with CAT065 and CAT063 saying how the system and its sensors are; sensor tracks leave
//! in a category that the sensor itself would send, to feed other systems with them.
//!
//! ```text
//! SystemTrack ── CotEvents ──► Cursor on Target
//! SystemTrack ── SystemReports ──► CAT062     state of the system ── StatusReports ──► CAT065, 063
//! SensorTrack ── SensorReports ──► CAT048, 020, 021 or 010; status ──► CAT034, 019, 023 or 010
//! ```
//!
//! Records are collected into blocks of one category; a full block is handed to the caller's closure, `flush` hands
//! over the last one. Nothing here reads a clock, sends a datagram or, once warm, allocates.
//!
//! # Which items are sent
//!
//! A receiver of a data block cannot ask back. Therefore an item is sent only if the track has its content and the
//! edition has a place for it. Mandatory parts without content get the value with the weakest claim; if every value
//! would be a claim, the item is omitted. Numbers are the nearest multiple of their LSB. A quantity beyond the range
//! of its bits is omitted, not limited, unless the document defines the greatest number as "or more". An accuracy
//! class is the best class whose bound holds, never a better class.
//!
//! Track numbers are shortened to the category's range. A track keeps its number during its life; no other track
//! receives this number for a minute after the end.
//!
//! # Heights
//!
//! The pipeline's height is metric: the third coordinate of a position, a height above the ellipsoid. Sources mostly
//! measure pressure altitude, and the pipeline treats it as a height, with the standard atmosphere and with mean sea
//! level on the ellipsoid. Tracks do not contain the kind of their deployment's heights. [`HeightReference`] selects
//! the items: geometric heights, by the frame's definition, or flight levels. Where the deployment has learned the
//! difference of pressure altitude and height, tracks contain the difference, and the geometric height is sent as well.

#![forbid(unsafe_code)]

mod cot;
mod identification;
mod items;
mod measured;
mod motion;
mod place;
mod quantity;
mod sensor;
mod status;
mod system;
mod technology;
mod track_numbers;

pub use cot::CotEvents;
pub use sensor::SensorReports;
pub use status::{Condition, SensorBiases, SensorStatus, ServiceEvent, StatusReports, SystemStatus};
pub use system::{SystemReports, SystemSource};

use asterix::block::HEADER_OCTETS;
use asterix::{BlockWriter, Category};

/// No record of this module has more bytes.
const RECORD_OCTETS_MAX: usize = 145;
/// The smallest block that any record fits, with its header.
pub const BLOCK_OCTETS_LEAST: usize = HEADER_OCTETS + RECORD_OCTETS_MAX;
/// The largest block: its length has 16 bits.
pub const BLOCK_OCTETS_MOST: usize = u16::MAX as usize;

/// Receiver of finished blocks; usually sends each block as a datagram.
pub type SendBlock<'s> = dyn FnMut(&[u8]) + 's;

settings::words! {
    /// Reference of the heights in the system, and so the items that carry them.
    pub enum HeightReference {
        /// Heights above the WGS-84 ellipsoid.
        Geometric = "geometric",
        /// Pressure altitudes in the standard atmosphere: flight levels.
        Barometric = "barometric",
    }
}

/// Why a sender can not be made.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum OutgoingError {
    /// The category is not sent, or not by this sender.
    #[error("{table} can not be sent here; choose one of {possible}")]
    Category {
        /// The table asked for.
        table: String,
        /// The categories there are.
        possible: &'static str,
    },
    /// A block size that no block has, or that not every record fits.
    #[error("a block of at most {octets} octets is not possible; choose {BLOCK_OCTETS_LEAST} to {BLOCK_OCTETS_MOST}")]
    BlockSize {
        /// Greatest block that was asked for, bytes.
        octets: usize,
    },
}

/// Counts of a sender.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct OutgoingCounts {
    /// Records sent, or waiting for their block to be full.
    pub records: u64,
    /// Blocks handed over.
    pub blocks: u64,
    /// States withheld by a rule: unwanted tentative states, ends of tracks never sent, states without a report in
    /// categories that contain received reports only.
    pub withheld: u64,
    /// Reports refused since every track number is taken.
    pub refused_number: u64,
    /// Reports rejected for a position that is invalid, or outside the range of the category's items.
    pub refused_position: u64,
    /// Reports refused for want of an address, without which the category has no report.
    pub refused_address: u64,
}

impl OutgoingCounts {
    /// Reports that were to be sent and were not.
    pub fn refused(&self) -> u64 {
        self.refused_number + self.refused_position + self.refused_address
    }

    /// Returns label, description and value of each counter.
    pub fn entries(&self) -> [(&'static str, &'static str, u64); 6] {
        [
            ("records", "records sent", self.records),
            ("blocks", "data blocks sent", self.blocks),
            ("withheld", "track states not sent by rule", self.withheld),
            (
                "refused_number",
                "reports refused since every track number is taken",
                self.refused_number,
            ),
            (
                "refused_position",
                "reports refused for an invalid position, or a position outside the category's range",
                self.refused_position,
            ),
            (
                "refused_address",
                "reports refused for want of an address",
                self.refused_address,
            ),
        ]
    }
}

/// Why a report was not sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Unsent {
    Withheld,
    Number,
    Position,
    Address,
}

/// The block of one category that is being filled, and the counters.
#[derive(Debug)]
struct BlockOutbox {
    blocks: BlockWriter,
    counts: OutgoingCounts,
}

impl BlockOutbox {
    fn new(category: u8, block_octets_max: usize) -> Result<Self, OutgoingError> {
        if !(BLOCK_OCTETS_LEAST..=BLOCK_OCTETS_MOST).contains(&block_octets_max) {
            return Err(OutgoingError::BlockSize {
                octets: block_octets_max,
            });
        }
        Ok(Self {
            blocks: BlockWriter::new(category, block_octets_max as u16),
            counts: OutgoingCounts::default(),
        })
    }

    fn push(&mut self, record: &[u8], send: &mut SendBlock<'_>) {
        debug_assert!(record.len() <= RECORD_OCTETS_MAX);
        let full = self.blocks.push(record).expect("the least block holds every record");
        self.counts.records += 1;
        if let Some(block) = full {
            self.counts.blocks += 1;
            send(block);
        }
    }

    fn flush(&mut self, send: &mut SendBlock<'_>) {
        if let Some(block) = self.blocks.finish() {
            self.counts.blocks += 1;
            send(block);
        }
    }

    fn count(&mut self, reason: Unsent) {
        let counter = match reason {
            Unsent::Withheld => &mut self.counts.withheld,
            Unsent::Number => &mut self.counts.refused_number,
            Unsent::Position => &mut self.counts.refused_position,
            Unsent::Address => &mut self.counts.refused_address,
        };
        *counter += 1;
    }
}

/// Checks that a table is one of a category's editions.
fn check_category(
    table: &'static Category,
    editions: &[&Category],
    possible: &'static str,
) -> Result<(), OutgoingError> {
    if table.is_one_of(editions) {
        return Ok(());
    }
    Err(OutgoingError::Category {
        table: table.to_string(),
        possible,
    })
}
