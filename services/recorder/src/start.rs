//! Start of a recorder: the run that it records.

use std::path::Path;

/// Recorded run of a deployment.
#[derive(Clone, Copy, Debug)]
pub struct Start<'a> {
    /// Folder for the run's files.
    pub folder: &'a Path,
    /// Description of the run, unique to it.
    pub run: &'a str,
    /// Version of the executable, with the commit if known.
    pub version: &'a str,
    /// Midnight from which tables count their seconds, UTC, nanoseconds.
    pub first_day_ns: i64,
}
