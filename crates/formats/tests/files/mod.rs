//! Recordings of real sensors, where they are.
//!
//! They are no part of the project. They are looked for under `$KOSEKI_DATA`, or in `shared/data` beside the
//! workspace; what needs one that is absent says so and does without.

use std::env;
use std::fs;
use std::path::{Path, PathBuf};

/// The octets of a recording, named by its path in the folder of recordings.
pub(crate) fn recording(name: &str) -> Option<Vec<u8>> {
    let folder = env::var_os("KOSEKI_DATA").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data"),
        PathBuf::from,
    );
    let path = folder.join(name);
    let bytes = fs::read(&path).ok();
    if bytes.is_none() {
        println!("skipped: no recording {}", path.display());
    }
    bytes
}
