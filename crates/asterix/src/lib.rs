//! ASTERIX: EUROCONTROL's format for surveillance data, described by one table for each edition of a category.
//!
//! # The format
//!
//! A **data block** is a byte of category, two bytes of length (big-endian, including these three bytes), and a
//! sequence of records. Neither a record nor an item contains its own length: to find the end of a record, the reader
//! must know the layout of every item in it. A wrong layout shifts everything behind it. Therefore an unknown item
//! cannot be skipped, and the edition of a category matters.
//!
//! A **record** begins with its *field specification*, FSPEC. Seven bits of each FSPEC byte state, most significant
//! first, whether items 1, 2, … 7 of the category's *user application profile* (UAP) are present; the last bit,
//! **FX**, announces another FSPEC byte with the next seven. The position in the UAP is an item's *field reference
//! number*, FRN, counted from 1. The items follow in FRN order, each in one of a few layouts:
//!
//! - *fixed*: a constant number of bytes, divided into elements of some bits;
//! - *extended*: parts of one byte (rarely more), each ending with an FX bit that announces the next part;
//! - *repetitive*: a count byte and so many equal groups, or groups each ending in an FX bit;
//! - *explicit*: a byte with the item's own length, itself included, and content agreed upon elsewhere;
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
//! NamedRecord ──────────── encode(table) ──┬─► bytes of a record ── BlockWriter ──► blocks of a size
//! numbers, item by item ── RecordWriter ────┘
//! ```
//!
//! A [`Record`] contains the positions of its items, not decoded values. There are two ways to the values.
//! [`NamedRecord`] decodes every item by its table, to a tree of names and values in the document's units. A
//! [`Field`](field::Field) reads a single element directly from the bytes, without allocation, at a position looked
//! up in the same tables at compile time. The content of a reserved expansion field has its own editions and is
//! decoded separately, see [`expansion`].
//!
//! [`NamedRecord::encode`] is the exact inverse: the tree of a record becomes the record's bytes, except for data
//! missing in the tree (spare bits, FSPEC bytes without items). [`RecordWriter`] serves senders of a fixed category
//! that must not allocate.
//!
//! A table ([`table`], [`categories`]) is data in the order and words of the EUROCONTROL document, for comparison
//! line by line. Whole bytes, names and profile entries are checked at compile time. [`registry`] lists the tables.
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

mod bit_reader;
mod bits;
mod encode;
mod extent;
mod from_json;
mod json;
mod json_text;
mod key;
mod spare;
mod stated;

pub use block::{Block, BlockWriter, Blocks, blocks, blocks_at};
pub use decoder::{Decoder, DecoderCounts};
pub use encode_error::EncodeError;
pub use error::Error;
pub use expansion::Expansion;
pub use json::JsonLines;
pub use mode::Mode;
pub use named::{NamedRecord, Value};
pub use record::{Record, Records};
pub use record_writer::RecordWriter;
pub use stated::{StatedTables, stated};
pub use table::{Category, Edition, Frn};
