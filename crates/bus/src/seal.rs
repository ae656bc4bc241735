//! Seal of an instance: a file that proves that Koseki created the instance's folder, and a lock that proves that the
//! folder is in use.
//!
//! The file contains the *prefix*, the start of the names of the instance's memory. This memory is in a folder in
//! which every user of the machine can create files, so that a predictable prefix could be occupied beforehand. The
//! prefix is random for each run, and drawn again if files with this prefix exist.
//!
//! Every member of the instance holds a shared lock of the file until leaving; removal takes the exclusive lock first.
//! Therefore no process can join during a removal and recreate removed files.

use std::fs::{self, DirBuilder, File, OpenOptions};
use std::io::{self, Read, Write as _};
use std::os::unix::fs::{DirBuilderExt as _, MetadataExt as _, OpenOptionsExt as _};
use std::path::Path;
use std::time::{Duration, Instant};

use rustix::fs::{FlockOperation, flock};
use rustix::rand::{GetRandomFlags, getrandom};

use crate::error::{BusError, io_error};

/// Where POSIX shared memory appears as files.
pub(crate) const SHARED_MEMORY_DIR: &str = "/dev/shm";
/// Flag for opening files: a link in the place of the file is an error.
pub(crate) const NO_LINKS: i32 = rustix::fs::OFlags::NOFOLLOW.bits() as i32;

/// Letters of the prefix: 'k', eight hexadecimal digits, '_'.
pub(crate) const PREFIX_LEN: usize = 10;

/// Name of the file in the instance's folder.
pub(crate) const SEAL: &str = "koseki-instance";

/// An instance's seal.
#[derive(Debug)]
pub(crate) struct Seal {
    pub(crate) file: File,
    /// `None` if the process that was making the instance was killed before any memory existed.
    pub(crate) prefix: Option<String>,
}

impl Seal {
    /// The seal in `folder`; `None` if there is no folder, or the folder is empty.
    ///
    /// # Errors
    /// [`BusError::NotOurs`] if there is something in the folder, but no seal.
    pub(crate) fn open(folder: &Path) -> Result<Option<Self>, BusError> {
        let path = folder.join(SEAL);
        let not_ours = || BusError::NotOurs {
            path: folder.to_owned(),
        };
        if fs::symlink_metadata(folder).is_ok_and(|found| !found.is_dir()) {
            return Err(not_ours());
        }
        let mut file = match OpenOptions::new().read(true).custom_flags(NO_LINKS).open(&path) {
            Ok(file) => file,
            Err(error) if error.kind() == io::ErrorKind::NotFound => {
                let entries = fs::read_dir(folder).into_iter().flatten().count();
                return if entries == 0 { Ok(None) } else { Err(not_ours()) };
            }
            Err(error) => return Err(io_error("open", &path)(error)),
        };
        let mut text = String::new();
        // The whole content, and a little more.
        let read = Read::take(&mut file, 64).read_to_string(&mut text);
        read.map_err(io_error("read", &path))?;
        let prefix = match text.trim_end() {
            "" => None,
            prefix if is_prefix(prefix) => Some(prefix.to_owned()),
            _ => return Err(not_ours()),
        };
        Ok(Some(Self { file, prefix }))
    }

    /// Makes the folder and the seal. Only for the holder of the instance's lock.
    pub(crate) fn make(folder: &Path) -> Result<(), BusError> {
        let made = DirBuilder::new().recursive(true).mode(0o700).create(folder);
        made.map_err(io_error("create", folder))?;
        let path = folder.join(SEAL);
        let written = OpenOptions::new()
            .write(true)
            .create_new(true)
            .mode(0o600)
            .open(&path)
            .and_then(|mut file| writeln!(file, "{}", free_prefix()?));
        written.map_err(io_error("write", &path))
    }

    /// Returns whether there is no member, and no process can join during the life of this seal.
    pub(crate) fn lock_alone(&self) -> io::Result<bool> {
        let patience = Patience::begin();
        while !self.try_lock_alone()? {
            if patience.is_over() {
                return Ok(false);
            }
            patience.pause();
        }
        Ok(true)
    }

    /// Like [`Self::lock_alone`], without waiting for processes that only look. Gives up the process's own
    /// membership.
    pub(crate) fn try_lock_alone(&self) -> io::Result<bool> {
        match flock(&self.file, FlockOperation::NonBlockingLockExclusive) {
            Ok(()) => Ok(true),
            Err(rustix::io::Errno::WOULDBLOCK) => Ok(false),
            Err(error) => Err(error.into()),
        }
    }
}

/// Time limit for a lock held briefly by others: by a status command, or by a process between fork and exec.
#[derive(Debug)]
pub(crate) struct Patience(Instant);

impl Patience {
    pub(crate) fn begin() -> Self {
        Self(Instant::now() + Duration::from_millis(250))
    }

    /// Returns a limit short enough that another process waiting in the meantime does not run out of time.
    pub(crate) fn begin_short() -> Self {
        Self(Instant::now() + Duration::from_millis(50))
    }

    pub(crate) fn is_over(&self) -> bool {
        Instant::now() >= self.0
    }

    pub(crate) fn pause(&self) {
        std::thread::sleep(Duration::from_millis(10));
    }
}

/// Whether `path` still names the file that was opened.
pub(crate) fn is_same_file(file: &File, path: &Path) -> bool {
    match (file.metadata(), fs::symlink_metadata(path)) {
        (Ok(a), Ok(b)) => (a.dev(), a.ino()) == (b.dev(), b.ino()),
        _ => false,
    }
}

/// Returns an unpredictable number.
pub(crate) fn random() -> u32 {
    let mut octets = [0; 4];
    // The kernel refuses random bytes only while the machine starts, and then the place is checked all the same.
    let _ = getrandom(&mut octets, GetRandomFlags::empty());
    u32::from_ne_bytes(octets)
}

fn is_prefix(text: &str) -> bool {
    let digits = text.strip_prefix('k').and_then(|rest| rest.strip_suffix('_'));
    text.len() == PREFIX_LEN && digits.is_some_and(|digits| digits.bytes().all(|digit| digit.is_ascii_hexdigit()))
}

/// A prefix with which nothing begins in shared memory.
fn free_prefix() -> io::Result<String> {
    let mut names = Vec::new();
    for entry in fs::read_dir(SHARED_MEMORY_DIR)? {
        names.push(entry?.file_name());
    }
    loop {
        let prefix = format!("k{:08x}_", random());
        if !names
            .iter()
            .any(|name| name.as_encoded_bytes().starts_with(prefix.as_bytes()))
        {
            return Ok(prefix);
        }
    }
}
