//! A configuration key is declared once, in the crate that uses its value.
//!
//! A key has a name, a type, a unit, a range, a default and a description. Written separately in a struct, its
//! `Default`, a second struct for the file, a check, a help text and a document, the six copies diverge.
//! [`settings!`] declares all of them together:
//!
//! ```
//! settings::settings! {
//!     /// When a track is given up.
//!     pub struct Deletion {
//!         /// Probability of so many misses in a row, if there were a target.
//!         missed_probability: f64 = 2e-5, in [1e-300, 0.99];
//!         /// Time without a detection.
//!         silent_s: settings::Seconds = settings::Seconds::of(60.0), in [1e-3, 86_400];
//!     }
//! }
//! let read = |text: &str| settings::Document::parse(text, &[]).and_then(|document| document.read::<Deletion>());
//! assert_eq!(read("missed_probability = 0.01").unwrap().silent_s.ns(), 60_000_000_000);
//! let error = read("silent_s = 0").unwrap_err();
//! assert_eq!(error.to_string(), "silent_s: 0 is out of range; it must lie between 0.001 and 86400");
//! assert_eq!(error.line, Some(1));
//! ```
//!
//! A key's declaration has, in this order: documentation; name in Rust, and `as "name"` for a different name in the
//! file; type; `= default` (without a default the key is mandatory); `, in [low, high]`, `, in [above low]` or `, in
//! [from low]`; and `, usually "…"`, the default in words if the value alone is not clear. The end of the name is the
//! unit (`_s`, `_mps`; see [`unit_of`]). The first line of a table may be `check path;`: a function that checks
//! several keys together. After the name of a table, `with field: KeyTable` includes the keys of another table (`=
//! path` names the function for its defaults), and `beside [field: Type]` adds fields without keys.
//!
//! The input is a [`Document`]: TOML text, parsed once, with single values replaced (`--set`). Unknown keys are
//! errors, because a misspelt key would otherwise be a setting without effect. Every error is a [`SettingsError`]
//! with the key's whole path, its line, its value and the permitted values. [`reference`](reference()) prints all
//! keys as a document, [`help`] as a text for a terminal.
//!
//! A file may have tables of several crates, each declared by the crate that uses it: see [`Shared`].
//!
//! Reading is not generic: a table gives its keys and its values as `dyn KeyValue`, so that a new key costs a line of
//! code and next to no time to compile. Leaves are read by `serde`.

#![forbid(unsafe_code)]

mod containers;
mod declare;
mod document;
mod error;
mod key;
mod leaves;
mod place;
mod quantities;
mod reference;
mod shared;
mod spelling;
mod syntax;
mod table;
mod value;
mod words;

pub use document::Document;
pub use error::SettingsError;
pub use key::{Key, Range, unit_of, within};
pub use place::Place;
pub use quantities::{Degrees, Seconds};
pub use reference::{help, reference};
pub use shared::{Shared, Unread};
pub use table::{check, check_table, nearest, read_table};
pub use value::{KeyTable, KeyValue, Node};
pub use words::not_known;

#[cfg(test)]
mod tests;
