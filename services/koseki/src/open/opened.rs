//! A file or feed that was judged: its sources, as tables of a configuration.

use std::path::PathBuf;

/// Limits of a source whose place is not known.
pub(super) const ANYWHERE: &str =
    "# Its place is not known, so its range is not checked.\n[source.limits]\nrange_m = 2000000.0\n";

/// A file or feed, judged.
#[derive(Debug)]
pub(super) struct Opened {
    /// Begin of the names of its sources.
    pub(super) label: String,
    pub(super) input: OpenedInput,
    pub(super) sources: Vec<SourceText>,
    /// What was decided, each with its reason.
    pub(super) decisions: Vec<String>,
    /// First position in the data, latitude and longitude, degrees.
    pub(super) first_deg: Option<[f64; 2]>,
    /// First time with a date in the data, UTC, nanoseconds since 1970.
    pub(super) first_utc_ns: Option<i64>,
    /// Whether positions are in metres of a frame without a place.
    pub(super) is_in_metres: bool,
}

/// Where the data come from.
#[derive(Debug)]
pub(super) enum OpenedInput {
    File(PathBuf),
    /// Keys of a receiver.
    Feed(String),
}

/// A source of the configuration.
#[derive(Debug, Default)]
pub(super) struct SourceText {
    /// End of its name.
    pub(super) suffix: String,
    /// Keys of the source, lines.
    pub(super) keys: String,
    /// Keys of its input, lines.
    pub(super) input_keys: String,
    /// Tables below the source.
    pub(super) tables: String,
}

impl Opened {
    /// Whether the data are recorded.
    pub(super) fn is_recorded(&self) -> bool {
        matches!(self.input, OpenedInput::File(_))
    }
}

/// Table of a source's place, latitude and longitude, degrees.
pub(super) fn place([latitude, longitude]: [f64; 2]) -> String {
    format!("[source.place]\nlatitude_deg = {latitude:?}\nlongitude_deg = {longitude:?}\n")
}
