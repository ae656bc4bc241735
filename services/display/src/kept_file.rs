//! Small files that a display keeps, as JSON.

use std::ffi::OsString;
use std::fs::File;
use std::io::Write as _;
use std::path::Path;

use serde::Serialize;

/// Writes `value` beside the file and renames: a reader never sees half of it.
///
/// # Errors
/// If the file cannot be written.
pub(crate) fn write(file: &Path, value: &impl Serialize) -> std::io::Result<()> {
    let mut beside = OsString::from(file);
    beside.push(".new");
    let mut out = File::create(&beside)?;
    out.write_all(&serde_json::to_vec_pretty(value)?)?;
    out.write_all(b"\n")?;
    out.sync_all()?;
    std::fs::rename(&beside, file)
}
