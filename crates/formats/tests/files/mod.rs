//! Recordings of real sensors, where they are.
//!
//! They are no part of the project. They are looked for under `$KOSEKI_DATA`, or in `shared/data` beside the
//! workspace; what needs one that is absent says so and does without.

use std::env;
use std::fs;
use std::path::{Path, PathBuf};

use formats::containers::datagrams;

/// The data blocks of a recording, whatever they are packed in, one after the other. It is named by its path in the
/// folder of recordings.
pub(crate) fn recording(name: &str) -> Option<Vec<u8>> {
    let folder = env::var_os("KOSEKI_DATA").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data"),
        PathBuf::from,
    );
    let path = folder.join(name);
    let Ok(bytes) = fs::read(&path) else {
        println!("skipped: no recording {}", path.display());
        return None;
    };
    let datagrams = datagrams(&bytes).flatten();
    Some(datagrams.flat_map(|datagram| datagram.bytes.into_owned()).collect())
}
