//! The tables: one file for each category, with all its editions.
//!
//! Item numbers, titles, element names, widths and LSBs are those of the document; enumerated values are summed up
//! behind their element. Where a table departs from a published layout on purpose, a comment says so and why.
//!
//! An item that changed has a constant for each of its layouts: the one without edition in its name is that of the
//! first edition here, and `I020_V1_31` is item 020 from ed 1.31 on. At the end of a file each edition is put together
//! from its items, so that the last lines show in what the editions differ.
//!
//! The editions in one list, such as [`CAT048`], have the same field reference numbers; their items only gained parts,
//! names for spare bits and the like, so that one reader can be written for all of them. [`CAT021_V0`] is the exception.
//!
//! # What tables do not say
//!
//! - Which items a record must have, and on what condition: a receiver lives with what is sent.
//! - The range of a quantity within its width, and which codes are in use. A code without meaning stays a number.
//! - What a Comm-B message holds (ICAO Doc 9871 does): the 56 bits and the register's number are given as numbers.
//! - The content of special purpose fields. For that of reserved expansion fields see
//!   [`expansion`](crate::expansion).

mod cat001;
mod cat002;
mod cat010;
mod cat019;
mod cat020;
mod cat021;
mod cat023;
mod cat034;
mod cat048;
mod cat062;
mod cat063;
mod cat065;

pub use cat001::*;
pub use cat002::*;
pub use cat010::*;
pub use cat019::*;
pub use cat020::*;
pub use cat021::*;
pub use cat023::*;
pub use cat034::*;
pub use cat048::*;
pub use cat062::*;
pub use cat063::*;
pub use cat065::*;

use crate::table::*;

const RE: Item = Item::new("RE", "Reserved Expansion Field", Layout::Explicit);
const SP: Item = Item::new("SP", "Special Purpose Field", Layout::Explicit);
const RFS: Item = Item::new("RFS", "Random Field Sequencing", Layout::RandomSequence);

/// Quality of the pulses of a Mode 2 or Mode 3/A code: 1 low.
#[rustfmt::skip]
const PULSE_QUALITY: &[Part] = &[
    spare(4),
    flag("QA4"), flag("QA2"), flag("QA1"),
    flag("QB4"), flag("QB2"), flag("QB1"),
    flag("QC4"), flag("QC2"), flag("QC1"),
    flag("QD4"), flag("QD2"), flag("QD1"),
];

/// A Mode C code and the quality of its pulses, which are in another order.
#[rustfmt::skip]
const MODE_C: &[Part] = &[
    flag("V"), // 1 not validated
    flag("G"), // 1 garbled
    spare(2),
    element("MODEC", 12, RAW), // Gray code
    spare(4),
    flag("QC1"), flag("QA1"), flag("QC2"), flag("QA2"), flag("QC4"), flag("QA4"),
    flag("QB1"), flag("QD1"), flag("QB2"), flag("QD2"), flag("QB4"), flag("QD4"),
];
