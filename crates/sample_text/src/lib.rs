//! Samples as text: lines of JSON or CSV with the fields' names, and the JSON Schema of these lines.
//!
//! A sample declares its fields once (`sample!` in crate `messages`). The text derives from this declaration, so
//! `koseki tap`, the display's events and the schema have the same names. [`SampleNames`] additionally replaces codes,
//! bits and numbers of sources by words, and states positions on the earth.
//!
//! The numbers of identities are text in every line, with words or without ([`messages::IdentityText`]): a Mode 3/A
//! code in octal digits, an address in hexadecimal ones, an MMSI in decimal ones under a key of its own.
//! [`LineReader`] reads lines of JSON back.
//!
//! Limits: a list of samples has no columns in CSV. A number that is not finite is `null`, or empty in CSV.

#![forbid(unsafe_code)]

mod lines;
mod names;
mod reader;
mod schema;

pub use lines::{LineFormat, LineWriter};
pub use names::SampleNames;
pub use reader::LineReader;
pub use schema::json_schema;
