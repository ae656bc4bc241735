//! Memory that outlasts the processes of an instance, and the instance's other memory.
//!
//! Memory for a process's successor must survive the launcher's death and the removal of all remains by the next start.
//! The memory is a separate file, `/dev/shm/kept_<of the instance>_<name>.<random>`, with the link
//! `<base>/<instance>.<name>`. The base folder is private: the link leads only to files made by this user's processes.
//! The file's own name proves nothing, because every user can create files in its folder. A successor fills a new file
//! and then redirects the link, which is atomic.
//!
//! Without room for the file, the words are at first in private memory of the process. Each [`Outlasting::publish`]
//! tries again to move the words into the file.
//!
//! Only an orderly end of the instance removes the memory ([`Root::remove_outlasting`]), after its last state has
//! become a file ([`Root::outlasting_file`], [`Root::publish_outlasting`]).
//!
//! The machine's death ends this memory. For data that must survive a reboot, the memory is copied to a folder on disk
//! at times ([`Root::copy_outlasting`]), and restored from this folder ([`Root::revive_outlasting`]). A record written
//! during the copy may be torn, as after a kill of the writer.

use std::fs::{self, File};
use std::io::{self, Seek as _, SeekFrom, Write as _};
use std::os::unix::fs::OpenOptionsExt as _;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use kept::Memory;

use crate::base;
use crate::error::{BusError, io_error};
use crate::line::fold;
use crate::mapping::Mapping;
use crate::root::Root;
use crate::seal::{SHARED_MEMORY_DIR, random};

/// End of the name of a restored file; other names end with a hexadecimal digit.
const REVIVED: &str = "-revived";
/// Words per page: blank pages take no room in a copy.
const PAGE: usize = 512;

/// Words that outlast a process, mapped.
#[derive(Debug)]
pub struct Outlasting {
    mapping: Mapping,
    path: PathBuf,
    link: PathBuf,
    /// Whether the words are in the file, and not in memory of this process alone.
    is_in_file: AtomicBool,
}

// SAFETY: several threads may look at atomic words at a time.
unsafe impl Sync for Outlasting {}

impl Root {
    /// Returns new words, all 0, which are visible to others only after being [published](Outlasting::publish) under
    /// `name`.
    ///
    /// # Errors
    /// If the machine has no memory left for the words. Shared memory without room is no error here.
    pub fn make_outlasting(&self, name: &str, words: usize) -> Result<Outlasting, BusError> {
        self.make_outlasting_as(&format!("{name}.{:08x}", random()), name, words)
    }

    fn make_outlasting_as(&self, file: &str, name: &str, words: usize) -> Result<Outlasting, BusError> {
        let path = Path::new(SHARED_MEMORY_DIR).join(format!("{}{file}", self.kept_prefix()));
        let bytes = words * size_of::<u64>();
        let in_file = Mapping::create(&path, bytes);
        let is_in_file = AtomicBool::new(in_file.is_ok());
        let mapping = in_file.or_else(|_| {
            let _ = fs::remove_file(&path);
            Mapping::anonymous(bytes)
        });
        Ok(Outlasting {
            mapping: mapping.map_err(io_error("allocate", &path))?,
            link: self.outlasting_link(name),
            path,
            is_in_file,
        })
    }

    /// The words that were published under `name` last; `None` if none were published, or the words are gone.
    ///
    /// # Errors
    /// If something else has the place of the words.
    pub fn outlasting(&self, name: &str) -> Result<Option<Outlasting>, BusError> {
        let link = self.outlasting_link(name);
        let path = match fs::read_link(&link) {
            Ok(path) => path,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
            Err(error) => return Err(io_error("read", &link)(error)),
        };
        match Mapping::open(&path) {
            Ok(mapping) => Ok(Some(Outlasting {
                mapping,
                path,
                link,
                is_in_file: AtomicBool::new(true),
            })),
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
            Err(error) => Err(io_error("map", &path)(error)),
        }
    }

    /// Copies all that is published to files in `folder`, whole or not at all.
    ///
    /// # Errors
    /// If a file cannot be written; the previous copy stays.
    pub fn copy_outlasting(&self, folder: &Path) -> Result<(), BusError> {
        fs::create_dir_all(folder).map_err(io_error("create", folder))?;
        for name in self.outlasting_names() {
            let Some(memory) = self.outlasting(&name)? else {
                continue;
            };
            let path = self.copy_path(folder, &name);
            let new = path.with_extension(format!("{name}.new"));
            write_copy(&new, memory.words())
                .and_then(|()| fs::rename(&new, &path))
                .map_err(io_error("write", &new))?;
        }
        // The names themselves.
        let folder_itself = File::open(folder).and_then(|folder| folder.sync_all());
        folder_itself.map_err(io_error("write", folder))
    }

    /// Publishes the copies in `folder`, except names that still exist; returns the number of published copies. An
    /// empty or unreadable copy is published as a single blank word.
    ///
    /// # Errors
    /// If there is no memory for the words.
    pub fn revive_outlasting(&self, folder: &Path) -> Result<usize, BusError> {
        let mut revived = 0;
        let prefix = format!("{}.", self.instance());
        for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
            let file = entry.file_name();
            let name = file.to_str().and_then(|file| file.strip_prefix(&prefix));
            let Some(name) = name.filter(|name| !name.contains('.')) else {
                continue;
            };
            if self.outlasting(name)?.is_some() {
                continue;
            }
            let path = entry.path();
            // An empty or unreadable copy becomes a blank word, which every reader rejects: a successor needs to know
            // that a copy existed, even if the contents are lost.
            let octets = fs::read(&path).unwrap_or_default();
            self.publish_octets(&format!("{name}.{:08x}{REVIVED}", random()), name, &octets)?;
            revived += 1;
        }
        Ok(revived)
    }

    /// Publishes `octets`, the last state of memory that was published under `name`. Empty octets become a single blank
    /// word, which every reader rejects: a successor needs to know that there was a predecessor.
    ///
    /// # Errors
    /// If there is no memory for the words.
    pub fn publish_outlasting(&self, name: &str, octets: &[u8]) -> Result<(), BusError> {
        self.publish_octets(&format!("{name}.{:08x}", random()), name, octets)
    }

    fn publish_octets(&self, file: &str, name: &str, octets: &[u8]) -> Result<(), BusError> {
        let words = octets.as_chunks::<{ size_of::<u64>() }>().0;
        let memory = self.make_outlasting_as(file, name, words.len().max(1))?;
        for (to, word) in memory.words().iter().zip(words) {
            to.store(u64::from_ne_bytes(*word), Ordering::Relaxed);
        }
        memory.publish()
    }

    /// Returns the file of the memory published under `name`; `None` if nothing is.
    pub fn outlasting_file(&self, name: &str) -> Option<PathBuf> {
        fs::read_link(self.outlasting_link(name))
            .ok()
            .filter(|path| path.exists())
    }

    /// Removes the copies in `folder`.
    pub fn remove_copies(&self, folder: &Path) {
        let prefix = format!("{}.", self.instance());
        for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
            if entry.file_name().to_str().is_some_and(|name| name.starts_with(&prefix)) {
                let _ = fs::remove_file(entry.path());
            }
        }
    }

    /// Names under which something was published.
    pub fn outlasting_names(&self) -> Vec<String> {
        let links = format!("{}.", self.instance());
        let entries = fs::read_dir(self.base()).into_iter().flatten().flatten();
        let links = entries
            .filter(|entry| entry.file_type().is_ok_and(|kind| kind.is_symlink()))
            .filter_map(|entry| Some(entry.file_name().to_str()?.strip_prefix(&links)?.to_owned()));
        // Names with a dot are not published yet.
        links.filter(|name| !name.contains('.')).collect()
    }

    fn copy_path(&self, folder: &Path, name: &str) -> PathBuf {
        folder.join(format!("{}.{name}", self.instance()))
    }

    /// Removes all published memory, and the files of processes killed before publication. Memory [put
    /// aside](Self::put_outlasting_aside) remains.
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

    /// Copies the memory published under `name` to an adjacent file, with a name that ends with `ending`, for analysis;
    /// returns the path.
    pub fn copy_outlasting_aside(&self, name: &str, ending: &str) -> Option<PathBuf> {
        let link = self.outlasting_link(name);
        let aside = link.with_extension(format!("{name}-{ending}"));
        fs::copy(&link, &aside).is_ok().then_some(aside)
    }

    /// Moves the memory published under `name` aside for analysis; returns the path.
    pub fn put_outlasting_aside(&self, name: &str) -> Option<PathBuf> {
        let aside = self.copy_outlasting_aside(name, "refused");
        let _ = fs::remove_file(self.outlasting_link(name));
        aside
    }

    fn outlasting_link(&self, name: &str) -> PathBuf {
        self.base().join(format!("{}.{name}", self.instance()))
    }

    /// Returns the start of the names of all files in shared memory that outlast the instance's processes.
    pub fn kept_prefix(&self) -> String {
        let of_path = self.path().as_os_str().as_encoded_bytes().iter();
        let of_instance = of_path.fold(u128::from(rustix::process::geteuid().as_raw()), |hash, octet| {
            u128::from(fold(hash ^ u128::from(*octet)))
        });
        format!("kept_{of_instance:016x}_")
    }
}

impl Outlasting {
    /// Whether nothing but the existence of a predecessor is known.
    pub fn is_blank(&self) -> bool {
        matches!(self.words(), [only] if only.load(Ordering::Relaxed) == 0)
    }

    /// Returns whether the memory was restored from a copy, and may lack the last records.
    pub fn is_revived(&self) -> bool {
        self.path.to_str().is_some_and(|path| path.ends_with(REVIVED))
    }

    /// The words.
    pub fn words(&self) -> &[AtomicU64] {
        let count = self.mapping.bytes() / size_of::<u64>();
        // SAFETY: the mapping has so many words, is aligned to a page, and lives as long as `self`; any bits are atomic
        // words.
        unsafe { std::slice::from_raw_parts(self.mapping.start().cast().as_ptr(), count) }
    }

    /// Has successors find these words from now on, and no others. To be called by the thread that writes the words.
    ///
    /// # Errors
    /// If there is no room for the words in shared memory, or the link cannot be made; a later call may succeed.
    pub fn publish(&self) -> Result<(), BusError> {
        if !self.is_in_file.load(Ordering::Relaxed) {
            self.mapping.move_to(&self.path).map_err(|error| {
                let _ = fs::remove_file(&self.path);
                io_error("create", &self.path)(error)
            })?;
            self.is_in_file.store(true, Ordering::Relaxed);
        }
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

fn write_copy(path: &Path, words: &[AtomicU64]) -> io::Result<()> {
    let mut options = File::options();
    let mut file = options.write(true).create(true).truncate(true).mode(0o600).open(path)?;
    file.set_len(size_of_val(words) as u64)?;
    let mut octets = Vec::with_capacity(PAGE * size_of::<u64>());
    for page in words.chunks(PAGE) {
        octets.clear();
        let page = page.iter().map(|word| word.load(Ordering::Relaxed).to_ne_bytes());
        octets.extend(page.flatten());
        if octets.iter().any(|octet| *octet != 0) {
            file.write_all(&octets)?;
        } else {
            file.seek(SeekFrom::Current(octets.len() as i64))?;
        }
    }
    file.sync_all()
}

/// Removes this user's files in shared memory with names that begin with `prefix`, except a single file.
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

    #[test]
    fn words_written_without_room_are_published_later() {
        let base = tempfile::tempdir().unwrap();
        let root = Root::in_base(base.path(), "full").unwrap();
        let memory = Outlasting {
            mapping: Mapping::anonymous(1000 * size_of::<u64>()).unwrap(),
            is_in_file: AtomicBool::new(false),
            ..root.make_outlasting("a", 1).unwrap()
        };
        let words = memory.words();
        words[999].store(7, Relaxed);
        // The file's name is taken by a folder: as without room, the words stay in place.
        fs::remove_file(&memory.path).unwrap();
        fs::create_dir(&memory.path).unwrap();
        assert!(memory.publish().is_err() && root.outlasting("a").unwrap().is_none());
        words[998].store(8, Relaxed);
        fs::remove_dir(&memory.path).unwrap();
        memory.publish().unwrap();
        words[0].store(9, Relaxed);
        let found = root.outlasting("a").unwrap().unwrap();
        assert_eq!([0, 998, 999].map(|place| found.words()[place].load(Relaxed)), [9, 8, 7]);
        root.remove_outlasting();
    }

    #[test]
    fn copies_outlast_the_machine() {
        let base = tempfile::tempdir().unwrap();
        let folder = base.path().join("disk");
        let root = Root::in_base(base.path(), "copied").unwrap();
        let memory = root.make_outlasting("a", 3 * PAGE + 1).unwrap();
        memory.words()[2 * PAGE + 5].store(7, Relaxed);
        memory.words()[3 * PAGE].store(8, Relaxed);
        memory.publish().unwrap();
        root.copy_outlasting(&folder).unwrap();
        assert_eq!(root.revive_outlasting(&folder).unwrap(), 0, "it is there still");
        root.remove_outlasting();
        assert_eq!(root.revive_outlasting(&folder).unwrap(), 1);
        let revived = root.outlasting("a").unwrap().unwrap();
        let words: Vec<u64> = revived.words().iter().map(|word| word.load(Relaxed)).collect();
        assert_eq!(
            (words[2 * PAGE + 5], words[3 * PAGE], words.len()),
            (7, 8, 3 * PAGE + 1)
        );
        assert_eq!(words.iter().sum::<u64>(), 15);
        assert!(revived.is_revived() && !memory.is_revived());
        root.remove_outlasting();
        root.remove_copies(&folder);
        assert_eq!(root.revive_outlasting(&folder).unwrap(), 0);
    }

    #[test]
    fn a_copy_that_is_empty_or_unreadable_is_revived_as_a_blank_word() {
        let base = tempfile::tempdir().unwrap();
        let folder = base.path().join("disk");
        let root = Root::in_base(base.path(), "spoilt").unwrap();
        fs::create_dir_all(folder.join("spoilt.folder")).unwrap();
        fs::write(folder.join("spoilt.empty"), []).unwrap();
        fs::write(folder.join("spoilt.short"), [1; 5]).unwrap();
        assert_eq!(root.revive_outlasting(&folder).unwrap(), 3);
        for name in ["folder", "empty", "short"] {
            let revived = root.outlasting(name).unwrap().unwrap();
            let words: Vec<u64> = revived.words().iter().map(|word| word.load(Relaxed)).collect();
            assert_eq!((words, revived.is_revived()), (vec![0], true), "{name}");
        }
        root.remove_outlasting();
    }

    #[test]
    fn memory_of_any_length_has_its_whole_words_only() {
        let base = tempfile::tempdir().unwrap();
        let root = Root::in_base(base.path(), "short").unwrap();
        let memory = root.make_outlasting("a", 3).unwrap();
        memory.publish().unwrap();
        for (length, words) in [(1, 0), (7, 0), (8, 1), (23, 2)] {
            let file = File::options().write(true).open(&memory.path).unwrap();
            file.set_len(length).unwrap();
            let found = root.outlasting("a").unwrap().unwrap();
            assert_eq!((found.words().len(), found.is_blank()), (words, words == 1));
            assert!(!kept::is_marked(found.words(), 3, 0));
        }
        fs::write(&memory.path, []).unwrap();
        assert!(root.outlasting("a").is_err(), "without any");
        root.remove_outlasting();
    }
}
