//! Tables of categories: a file per category, with all editions.
//!
//! Item numbers, titles, element names, widths and LSBs are those of the document; a comment after an element
//! summarises its enumerated values. A comment also explains each intended difference from a published layout.
//!
//! A changed item has a constant per layout: the constant without an edition in its name is the layout of the first
//! edition here; `I020_V1_31` is item 020 from ed 1.31 on. The end of a file lists the items of each edition, so that
//! the last lines show the differences between editions.
//!
//! The editions in a list, such as [`CAT048`], have the same field reference numbers; later editions only added parts
//! or names for spare bits, so that a single reader serves all editions. [`CAT021_V0`] is the exception.
//!
//! # Limits of the tables
//!
//! - Conditions for mandatory items: a receiver accepts records without them.
//! - The range of a quantity within its width, and which codes are in use. A code without meaning stays a number.
//! - Content of Comm-B messages (see ICAO Doc 9871): the 56 bits and the register's number are given as numbers.
//! - The content of special purpose fields. For that of reserved expansion fields see
//!   [`expansion`](crate::expansion).

mod cat001;
mod cat002;
mod cat004;
mod cat008;
mod cat009;
mod cat010;
mod cat015;
mod cat016;
mod cat019;
mod cat020;
mod cat021;
mod cat023;
mod cat032;
mod cat034;
mod cat048;
mod cat062;
mod cat063;
mod cat065;
mod cat205;
mod cat247;

pub use cat001::*;
pub use cat002::*;
pub use cat004::*;
pub use cat008::*;
pub use cat009::*;
pub use cat010::*;
pub use cat015::*;
pub use cat016::*;
pub use cat019::*;
pub use cat020::*;
pub use cat021::*;
pub use cat023::*;
pub use cat032::*;
pub use cat034::*;
pub use cat048::*;
pub use cat062::*;
pub use cat063::*;
pub use cat065::*;
pub use cat205::*;
pub use cat247::*;

use crate::expansion::Expansion;
use crate::table::*;

items! {
    RE "RE" "Reserved Expansion Field" (= Layout::Explicit)
    SP "SP" "Special Purpose Field" (= Layout::Explicit)
    RFS "RFS" "Random Field Sequencing" (= Layout::RandomSequence)

    parts SOURCE {
        SAC: 8, // system area code
        SIC: 8, // system identification code
    }

    // Codes of transponders. L: 1 not received just now, but smoothed by a local tracker or kept from an earlier scan.
    parts MODE_1 {
        V: 1, // 1 not validated
        G: 1, // 1 garbled
        L: 1,
        MODE1: 5,
    }

    parts MODE_2 {
        V: 1,
        G: 1,
        L: 1,
        _: 1,
        MODE2: 12 OCTAL,
    }

    parts MODE_3A {
        V: 1,
        G: 1,
        L: 1,
        _: 1,
        MODE3A: 12 OCTAL,
    }

    // Quality of the pulses of a Mode 2 or Mode 3/A code: 1 low.
    parts PULSE_QUALITY {
        _: 4,
        QA4: 1, QA2: 1, QA1: 1,
        QB4: 1, QB2: 1, QB1: 1,
        QC4: 1, QC2: 1, QC1: 1,
        QD4: 1, QD2: 1, QD1: 1,
    }

    // A Mode C code and the quality of its pulses, which are in another order.
    parts MODE_C {
        V: 1, // 1 not validated
        G: 1, // 1 garbled
        _: 2,
        MODEC: 12, // Gray code
        _: 4,
        QC1: 1, QA1: 1, QC2: 1, QA2: 1, QC4: 1, QA4: 1,
        QB1: 1, QD1: 1, QB2: 1, QD2: 1, QB4: 1, QD4: 1,
    }
}

/// Every table, by category. The first of a category is its default edition.
#[rustfmt::skip]
pub static REGISTRY: &[&Category] = &[
    &CAT001_V1_4, &CAT001_V1_3, &CAT001_V1_2,
    &CAT002_V1_2, &CAT002_V1_1, &CAT002_V1_0,
    &CAT004_V1_13, &CAT004_V1_12,
    &CAT008_V1_2, &CAT008_V1_3,
    &CAT009_V2_1,
    &CAT010_V1_1,
    &CAT015_V1_2, &CAT015_V1_1, &CAT015_V1_0,
    &CAT016_V1_0,
    &CAT019_V1_3,
    &CAT020_V1_9, &CAT020_V1_10, &CAT020_V1_11,
    &CAT021_V2_4, &CAT021_V2_1, &CAT021_V2_2, &CAT021_V2_3, &CAT021_V2_5, &CAT021_V2_6, &CAT021_V2_7,
    &CAT021_V0_23, &CAT021_V0_24, &CAT021_V0_25, &CAT021_V0_26,
    &CAT023_V1_3, &CAT023_V1_2,
    &CAT032_V1_2, &CAT032_V1_1,
    &CAT034_V1_29, &CAT034_V1_28, &CAT034_V1_27,
    &CAT048_V1_31, &CAT048_V1_32, &CAT048_V1_30, &CAT048_V1_29, &CAT048_V1_28, &CAT048_V1_27,
    &CAT062_V1_18, &CAT062_V1_21, &CAT062_V1_20, &CAT062_V1_19, &CAT062_V1_17, &CAT062_V1_16,
    &CAT063_V1_6, &CAT063_V1_7,
    &CAT065_V1_5, &CAT065_V1_6, &CAT065_V1_4,
    &CAT205_V1_0,
    &CAT247_V1_2, &CAT247_V1_3,
];

/// Categories without a table here, and what their blocks hold.
pub static WITHOUT_TABLE: &[(u8, &str)] = &[
    (7, "directed interrogation"),
    (11, "surface movement guidance and control (A-SMGCS)"),
    (17, "Mode S surveillance coordination"),
    (18, "Mode S data link"),
    (25, "status of ground systems"),
    (30, "air situation pictures (ARTAS)"),
    (129, "identification and reports of unmanned aircraft"),
    (150, "flight data of a plan server (MADAP)"),
    (238, "predictions of service"),
    (240, "radar video"),
    (244, "reference trajectories"),
    (252, "sessions and services (ARTAS)"),
    (253, "remote monitoring and control"),
];

/// Coding rules of reserved expansion fields, by category and edition.
#[rustfmt::skip]
pub static EXPANSIONS: &[&Expansion] = &[
    &CAT021_RE_V1_4, &CAT021_RE_V1_5,
    &CAT048_RE_V1_11, &CAT048_RE_V1_12, &CAT048_RE_V1_13,
    &CAT062_RE_V1_2, &CAT062_RE_V1_3,
];
