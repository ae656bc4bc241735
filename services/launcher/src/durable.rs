//! Copies on disk of the memory that outlasts the processes, to survive a reboot.
//!
//! The keeper makes copies in a separate thread, every few seconds, from memory still in use. At the start, the
//! launcher restores missing memory from the copies. An orderly end replaces the copies by the last state
//! ([`crate::last_end`]).

use std::path::{Path, PathBuf};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

use anyhow::Context as _;
use bus::Root;

use crate::say;

/// Reason for the failure of the latest copy; `None` without a failure.
type Failure = Arc<Mutex<Option<String>>>;

/// Copying, as long as this lives.
#[derive(Debug)]
pub(crate) struct CheckpointCopier {
    /// The thread ends when this is gone.
    end: Option<Sender<()>>,
    failure: Failure,
    thread: Option<JoinHandle<()>>,
}

impl CheckpointCopier {
    /// Copies the memory kept by the processes at `root` into `folder`, once in the time `every`.
    ///
    /// # Errors
    /// If the thread cannot be started.
    pub(crate) fn start(root: Root, folder: PathBuf, every: Duration) -> anyhow::Result<Self> {
        let (end, ended) = channel();
        let failure = Failure::default();
        let of_thread = Arc::clone(&failure);
        let work = move || {
            while ended.recv_timeout(every) == Err(RecvTimeoutError::Timeout) {
                let failed = root.copy_outlasting(&folder).err().map(|error| error.to_string());
                let before = std::mem::replace(
                    &mut *of_thread.lock().unwrap_or_else(PoisonError::into_inner),
                    failed.clone(),
                );
                if let (None, Some(error)) = (before, failed) {
                    say(&format!("memory for a successor is not copied to disk: {error}"));
                }
            }
        };
        let thread = std::thread::Builder::new().name("copies".to_owned()).spawn(work)?;
        Ok(Self {
            end: Some(end),
            failure,
            thread: Some(thread),
        })
    }

    /// Returns the reason for the failure of the latest copy; `None` without a failure.
    pub(crate) fn failure(&self) -> Option<String> {
        self.failure.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

impl Drop for CheckpointCopier {
    fn drop(&mut self) {
        self.end = None;
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// Restores the memory kept in `folder` after a reboot.
///
/// # Errors
/// If nothing can be kept there.
pub(crate) fn revive(root: &Root, folder: &Path) -> anyhow::Result<()> {
    std::fs::create_dir_all(folder).with_context(|| format!("checkpoint.folder: making {}", folder.display()))?;
    match root.revive_outlasting(folder) {
        Ok(0) => {}
        Ok(count) => say(&format!("going on from {count} copies in {}", folder.display())),
        Err(error) => say(&format!("starting afresh, the copies cannot be used: {error}")),
    }
    Ok(())
}
