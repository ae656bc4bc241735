//! A configuration key is declared once, in the crate that uses its value.
//!
//! A key has a name, a type, a unit, a range, a default and a sentence that explains it. The obvious way writes them in
//! a struct, in its `Default`, in a second struct for the file, in a check, in a help text and in a document, and in
//! time the six differ. [`settings!`] declares them together:
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
//! Per key, in this order: document text; name in Rust, and `as "name"` where the file's is another; type; `= default`
//! (a key without one must be given); `, in [low, high]`, `, in [above low]` or `, in [from low]`; and `, usually "…"`,
//! the default in words where the value alone does not say it. The unit is the end of the name (`_s`, `_mps`; see
//! [`unit_of`]). A table's first line may be `check path;`: a function that looks at several of its keys together.
//! After the name of a table, `with field: Table` lets the keys of another table stand among its own (`= path` names a
//! function that makes its defaults), and `beside [field: Type]` adds a field that is no key.
//!
//! What is read comes from a [`Document`]: TOML text, parsed once, with single values replaced (`--set`). Unknown keys
//! are refused, since a misspelt key that is silently ignored is a setting that silently does not hold. Every mistake
//! is a [`SettingsError`] with the key's whole path, its line, its value and what would be right.
//! [`reference`](reference()) prints all keys as a document, [`help`] as a text for a terminal.
//!
//! Reading is not generic: a table gives its keys and its values as `dyn Value`, so that a new key costs a line of code
//! and next to no time to compile. Leaves are read by `serde`.

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
mod spelling;
mod table;
mod value;
mod words;

pub use document::Document;
pub use error::SettingsError;
pub use key::{Key, Range, unit_of, within};
pub use place::Place;
pub use quantities::{Degrees, Seconds};
pub use reference::{help, reference};
pub use table::{check, check_table, nearest, read_table};
pub use value::{Node, Table, Value};
pub use words::not_known;

#[cfg(test)]
mod tests;
