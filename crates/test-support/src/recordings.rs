//! Recordings of real sensors, which are no part of the project.
//!
//! The recordings are expected under `$KOSEKI_DATA`, or in `shared/data` beside the workspace. A test without its
//! recording prints `skipped: …` and passes; with `KOSEKI_REQUIRE_DATA` in the environment (as in `.ci/run` on
//! machines with the recordings) it fails, so that a renamed file cannot disable a test unnoticed.

use std::path::{Path, PathBuf};

/// Returns the folder of the recordings if it holds `part`; otherwise prints that something is skipped, and returns
/// `None`.
///
/// # Panics
/// If `part` is absent and `KOSEKI_REQUIRE_DATA` is set.
pub fn recordings(part: &str) -> Option<PathBuf> {
    let default = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data");
    let folder = std::env::var_os("KOSEKI_DATA").map_or(default, PathBuf::from);
    if folder.join(part).exists() {
        // Commands may be called elsewhere.
        return Some(std::path::absolute(folder).expect("a working directory"));
    }
    let absent = format!("no recording at {} (set KOSEKI_DATA)", folder.join(part).display());
    assert!(
        std::env::var_os("KOSEKI_REQUIRE_DATA").is_none(),
        "KOSEKI_REQUIRE_DATA is set, and there is {absent}"
    );
    println!("skipped: {absent}");
    None
}

/// The bytes of one recording, named by its path in the folder of the recordings; see [`recordings`].
///
/// # Panics
/// If it is absent and `KOSEKI_REQUIRE_DATA` is set, or cannot be read.
pub fn recording(name: &str) -> Option<Vec<u8>> {
    let path = recordings(name)?.join(name);
    Some(std::fs::read(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display())))
}
