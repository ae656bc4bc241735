//! Where the recordings are that tests are made with; they are no part of the project.

use std::path::{Path, PathBuf};

/// The folder of the recordings, if it holds `part`; else says that the test is skipped.
pub(crate) fn data_folder(part: &str) -> Option<PathBuf> {
    let default = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data");
    let folder = std::env::var_os("KOSEKI_DATA").map_or(default, PathBuf::from);
    if folder.join(part).is_dir() {
        return Some(folder);
    }
    println!(
        "skipped: no recordings at {} (set KOSEKI_DATA)",
        folder.join(part).display()
    );
    None
}
