//! Removal of shared-memory files whose creation was interrupted by a kill.
//!
//! iceoryx2 creates a file of shared memory in two steps: an empty file, and then its size. After a kill between the
//! steps, the file stays empty, and every process that opens the file waits for a size: for ever, unless permissions
//! prevent opening, which is not so for root (iceoryx2 0.10 limits the time of every later step, but not of this step).
//! A reader killed in this microsecond would thus stop the keeper that removes the file, and every publisher about to
//! connect.
//!
//! A waiting process retries by the file's name, and continues as soon as the file is gone. Therefore a process that
//! opens no such file must remove it: the process that runs the instance.

use std::collections::BTreeSet;
use std::fs;
use std::os::unix::fs::MetadataExt as _;
use std::path::PathBuf;
use std::time::Duration;

use crate::base;
use crate::error::{BusError, io_error};
use crate::root::{CREATION_TIMEOUT, Root};
use crate::seal::SHARED_MEMORY_DIR;

/// Empty files of an instance, as at the last look.
#[derive(Debug)]
pub struct Unborn {
    root: Root,
    /// With inodes.
    seen: BTreeSet<(PathBuf, u64)>,
}

impl Unborn {
    /// Time between two looks: longer than iceoryx2 waits for anything else that is not ready.
    pub const PERIOD: Duration = CREATION_TIMEOUT;

    /// Nothing has been looked at yet.
    pub fn new(root: &Root) -> Self {
        Self {
            root: root.clone(),
            seen: BTreeSet::new(),
        }
    }

    /// Removes the files that are empty now and were empty at the last look; returns the number of removed files. To be
    /// called once in [`Self::PERIOD`].
    ///
    /// # Errors
    /// If the instance or the folder of shared memory cannot be read.
    pub fn remove(&mut self) -> Result<usize, BusError> {
        let Some(prefix) = self.root.prefix()? else {
            return Ok(0);
        };
        let folder = PathBuf::from(SHARED_MEMORY_DIR);
        let entries = fs::read_dir(&folder).map_err(io_error("read", &folder))?.flatten();
        let named = entries.filter(|entry| entry.file_name().to_str().is_some_and(|name| name.starts_with(&prefix)));
        let empty = named.filter_map(|entry| {
            // A vanished file is not empty.
            let found = entry.metadata().ok()?;
            (found.len() == 0 && base::is_own(&found)).then(|| (entry.path(), found.ino()))
        });
        let seen = std::mem::replace(&mut self.seen, empty.collect());
        let stale = self.seen.intersection(&seen);
        Ok(stale.filter(|(path, _)| fs::remove_file(path).is_ok()).count())
    }
}
