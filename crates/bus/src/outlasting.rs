//! Memory that outlasts the processes of an instance, and the instance's other memory with them.
//!
//! Memory that a process leaves to its successor, even where the launcher dies too and the next start removes all
//! remains, lies in a file of its own: `/dev/shm/kept_<of the instance>_<name>.<random>`, to which the link
//! `<base>/<instance>.<name>` leads. The base folder is private, so whoever follows the link finds what this user's
//! processes have made; the name of the file itself, which lies where every user can make some, proves nothing. A
//! successor fills a file of its own and then has the link lead there, which happens at once or not at all.
//!
//! Only an orderly end of the instance removes it ([`Root::remove_outlasting`]).

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicU64;

use kept::Memory;

use crate::base;
use crate::error::{BusError, io_error};
use crate::line::fold;
use crate::mapping::Mapping;
use crate::root::Root;
use crate::seal::{SHARED_MEMORY_DIR, random};

/// Words that outlast their process, mapped.
#[derive(Debug)]
pub struct Outlasting {
    mapping: Mapping,
    path: PathBuf,
    link: PathBuf,
}

// SAFETY: several threads may look at atomic words at a time.
unsafe impl Sync for Outlasting {}

impl Root {
    /// New words, all 0, which nobody finds before they are [published](Outlasting::publish) under `name`.
    ///
    /// # Errors
    /// If there is no memory left for them.
    pub fn make_outlasting(&self, name: &str, words: usize) -> Result<Outlasting, BusError> {
        let file = format!("{}{name}.{:08x}", self.kept_prefix(), random());
        let path = Path::new(SHARED_MEMORY_DIR).join(file);
        match Mapping::create(&path, words * size_of::<u64>()) {
            Ok(mapping) => Ok(Outlasting {
                mapping,
                link: self.outlasting_link(name),
                path,
            }),
            Err(error) => {
                let _ = fs::remove_file(&path);
                Err(io_error("create", &path)(error))
            }
        }
    }

    /// The words that were published under `name` last; `None` if none were, or they are gone.
    ///
    /// # Errors
    /// If something else has their place.
    pub fn outlasting(&self, name: &str) -> Result<Option<Outlasting>, BusError> {
        let link = self.outlasting_link(name);
        let path = match fs::read_link(&link) {
            Ok(path) => path,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
            Err(error) => return Err(io_error("read", &link)(error)),
        };
        match Mapping::open(&path) {
            Ok(mapping) => Ok(Some(Outlasting { mapping, path, link })),
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
            Err(error) => Err(io_error("map", &path)(error)),
        }
    }

    /// Removes all that was published, and what others left that were killed before they could publish. What was
    /// [put aside](Self::put_outlasting_aside) stays.
    pub fn remove_outlasting(&self) {
        let links = format!("{}.", self.instance());
        for entry in fs::read_dir(self.base()).into_iter().flatten().flatten() {
            let is_link = entry.file_type().is_ok_and(|kind| kind.is_symlink());
            if is_link && entry.file_name().to_str().is_some_and(|name| name.starts_with(&links)) {
                let _ = fs::remove_file(entry.path());
            }
        }
        remove_files(&self.kept_prefix(), None);
    }

    /// Puts what was published under `name` aside, for somebody to look at; where it is then.
    pub fn put_outlasting_aside(&self, name: &str) -> Option<PathBuf> {
        let link = self.outlasting_link(name);
        let aside = link.with_extension(format!("{name}-refused"));
        let copied = fs::copy(&link, &aside).is_ok();
        let _ = fs::remove_file(&link);
        copied.then_some(aside)
    }

    fn outlasting_link(&self, name: &str) -> PathBuf {
        self.base().join(format!("{}.{name}", self.instance()))
    }

    /// With what the names of all files in shared memory begin that are to outlast the instance's processes.
    pub fn kept_prefix(&self) -> String {
        let of_path = self.path().as_os_str().as_encoded_bytes().iter();
        let of_instance = of_path.fold(u128::from(rustix::process::geteuid().as_raw()), |hash, octet| {
            u128::from(fold(hash ^ u128::from(*octet)))
        });
        format!("kept_{of_instance:016x}_")
    }
}

impl Outlasting {
    /// The words.
    pub fn words(&self) -> &[AtomicU64] {
        let count = self.mapping.bytes() / size_of::<u64>();
        // SAFETY: the mapping has so many words, is aligned to a page, and lives as long as `self`; any bits are atomic
        // words.
        unsafe { std::slice::from_raw_parts(self.mapping.start().cast().as_ptr(), count) }
    }

    /// Has successors find these words from now on, and no others.
    ///
    /// # Errors
    /// If the link cannot be made.
    pub fn publish(&self) -> Result<(), BusError> {
        let new = self.link.with_extension(format!("{:08x}", random()));
        std::os::unix::fs::symlink(&self.path, &new)
            .and_then(|()| fs::rename(&new, &self.link))
            .map_err(io_error("create", &self.link))?;
        let name = self.path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
        let prefix = name.rsplit_once('.').map_or(name, |(prefix, _)| prefix);
        remove_files(&format!("{prefix}."), Some(&self.path));
        Ok(())
    }
}

impl Memory for Outlasting {
    fn words(&self) -> &[AtomicU64] {
        self.words()
    }
}

/// Removes this user's files in shared memory whose names begin with `prefix`, but for one.
fn remove_files(prefix: &str, but: Option<&Path>) {
    let entries = fs::read_dir(SHARED_MEMORY_DIR).into_iter().flatten().flatten();
    for entry in entries {
        let path = entry.path();
        let is_named = entry.file_name().to_str().is_some_and(|name| name.starts_with(prefix));
        if is_named && Some(path.as_path()) != but && entry.metadata().is_ok_and(|found| base::is_own(&found)) {
            let _ = fs::remove_file(path);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::Ordering::Relaxed;

    use super::*;

    #[test]
    fn words_outlast_whoever_wrote_them_and_the_newest_are_found() {
        let base = tempfile::tempdir().unwrap();
        let root = Root::in_base(base.path(), "kept").unwrap();
        assert!(root.outlasting("a").unwrap().is_none());
        let first = root.make_outlasting("a", 3).unwrap();
        first.words()[2].store(7, Relaxed);
        assert!(root.outlasting("a").unwrap().is_none(), "not published yet");
        first.publish().unwrap();
        let path = first.path.clone();
        drop(first);
        let found = root.outlasting("a").unwrap().unwrap();
        let words = |kept: &Outlasting| kept.words().iter().map(|word| word.load(Relaxed)).collect::<Vec<_>>();
        assert_eq!(words(&found), [0, 0, 7]);
        let second = root.make_outlasting("a", 2).unwrap();
        second.publish().unwrap();
        assert_eq!(words(&root.outlasting("a").unwrap().unwrap()), [0, 0]);
        assert!(!path.exists(), "what nobody finds is removed");
        assert_eq!(words(&found), [0, 0, 7], "but who has it keeps it");
        root.make_outlasting("a-b", 1).unwrap().publish().unwrap();
        assert!(root.outlasting("a").unwrap().is_some(), "another name's");
        root.remove_outlasting();
        assert!(root.outlasting("a").unwrap().is_none() && !second.path.exists());
        assert_eq!(fs::read_dir(base.path()).unwrap().count(), 0);
    }
}
