//! ASTERIX: EUROCONTROL's format for surveillance data, described by one table for each edition of a category.
//!
//! # The format
//!
//! A **data block** is one octet of category, two of length (in octets, big-endian, the header's three included)
//! and then one record after the other. Neither a record nor an item in it carries its own length: to find where
//! one ends and the next begins, the reader must know the layout of every item it meets. One wrong layout shifts
//! everything behind it, which is why an unknown item can not be stepped over, and why the edition of a category
//! matters.
//!
//! A **record** begins with its *field specification*, FSPEC. Seven bits of each FSPEC octet say, most significant
//! first, whether item 1, 2, … 7 of the category's *user application profile* (UAP) is present; the last bit, **FX**,
//! says that another FSPEC octet with the next seven follows. The position in the UAP is an item's *field reference
//! number*, FRN, counted from 1. The items follow in FRN order, each in one of a few layouts:
//!
//! - *fixed*: a constant number of octets, divided into elements of some bits;
//! - *extended*: parts of one octet (rarely more), each ending in an FX bit that says whether the next part follows;
//! - *repetitive*: a count octet and so many equal groups, or groups each ending in an FX bit;
//! - *explicit*: an octet with the item's own length, itself included, and content agreed upon elsewhere;
//! - *compound*: an FSPEC of its own and subitems in these same layouts.
//!
//! In the oldest categories one FRN stands for a *random field sequence* instead: a count, and so many times an FRN and
//! its item, for items in another order or given more than once.
//!
//! # The module
//!
//! ```text
//! bytes ── blocks ──► Block ── records(table, mode) ──► Record ──┬── NamedRecord: every item by name, to show
//!              └────── Decoder does both, and counts ──────┘      └── Field: an element at its place, in SI units
//!
//! JSON ── from_json(table) ──► NamedRecord
//! NamedRecord ──────────── encode(table) ──┬─► octets of a record ── BlockWriter ──► blocks of a size
//! numbers, item by item ── RecordWriter ────┘
//! ```
//!
//! A [`Record`] knows where each of its items lies and has decoded none of them. From there two ways lead on:
//! [`NamedRecord`] decodes every item as the table says, into a tree of names and values with the document's units;
//! a [`Field`](field::Field) reads one element straight from the octets, without allocating, at a place that is looked
//! up in the same tables while the program is compiled. The content of a reserved expansion field has editions of its
//! own and is decoded apart, see [`expansion`].
//!
//! The way back, [`NamedRecord::encode`], is the exact inverse: the tree of a record becomes the record's octets, save
//! for what the tree does not hold (spare bits that were set, FSPEC octets that announced nothing). [`RecordWriter`] is
//! for a sender that knows its category and must not allocate.
//!
//! A table ([`table`], [`categories`]) is data in the order and words of the EUROCONTROL document, so that it can be
//! checked against it line by line; what can be checked mechanically (whole octets, names, profile entries) is checked
//! when the table is compiled. [`registry`] lists the tables.
//!
//! # Sources
//!
//! EUROCONTROL-SPEC-0149, *Specification for Surveillance Data Exchange – ASTERIX*, part 1 for the structure; each
//! category file names its own part.

#![forbid(unsafe_code)]

#[macro_use]
mod notation;

pub mod block;
pub mod categories;
pub mod choice;
pub mod decoder;
pub mod encode_error;
pub mod error;
pub mod expansion;
pub mod field;
pub mod mode;
pub mod named;
pub mod record;
pub mod record_writer;
pub mod registry;
pub mod table;
pub mod text;
pub mod times;

mod bits;
mod encode;
mod extent;
mod from_json;
mod spare;

pub use block::{Block, BlockWriter, Blocks, blocks, blocks_at};
pub use decoder::{Counts, Decoder};
pub use encode_error::EncodeError;
pub use error::Error;
pub use expansion::Expansion;
pub use mode::Mode;
pub use named::{NamedRecord, Value};
pub use record::{Record, Records};
pub use record_writer::RecordWriter;
pub use table::{Category, Edition, Frn};
