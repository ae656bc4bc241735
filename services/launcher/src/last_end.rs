//! Files of an orderly end, from which the next start goes on.
//!
//! A kill of all processes leaves the outlasting memory in shared memory, and the next start resumes from this memory.
//! A planned stop must preserve as much: users follow targets by number, for any reason of the pause. But a planned
//! stop must also leave no shared memory. So the last state of each such memory becomes a compressed file beside the
//! instance's folder, `<base>/<instance>.<name>.end`, and with durable copies another file in the copies' folder. The
//! next start publishes the contents again, and removes the files: these must not exist at a later death of this run.
//!
//! A damaged file is published as a single blank word: fusion then begins numbers by the time of day. The same holds
//! for a missing file. An empty file, `<base>/<instance>.numbered`, states that numbers were given under the instance's
//! name.
//!
//! Age is judged by the readers of the contents, as after a kill.

use std::ffi::OsStr;
use std::fs::{self, File};
use std::io::{self, Read as _};
use std::os::unix::fs::OpenOptionsExt as _;
use std::path::{Path, PathBuf};

use anyhow::Context as _;
use bus::Root;
use runtime::instance::{CHECKPOINT, END_SUFFIX as SUFFIX, NUMBERED};

use crate::say;

/// Compression: the first level that leaves blank memory without weight.
const LEVEL: i32 = 1;
/// Maximum number of octets of a memory: far more than any has.
const OCTETS_MAX: u64 = 1 << 32;

/// An instance that does not run, and has a file of the last end.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct EndedInstance {
    /// Name.
    pub instance: String,
    /// File from which fusion goes on.
    pub file: PathBuf,
}

/// Returns the instances in the folder `base` that have ended in order.
pub fn ended_instances(base: &Path) -> Vec<EndedInstance> {
    let suffix = format!(".{CHECKPOINT}{SUFFIX}");
    let entries = fs::read_dir(base).into_iter().flatten().flatten();
    let of_entry = |entry: fs::DirEntry| {
        Some(EndedInstance {
            instance: entry.file_name().to_str()?.strip_suffix(&suffix)?.to_owned(),
            file: entry.path(),
        })
    };
    let mut found: Vec<EndedInstance> = entries.filter_map(of_entry).collect();
    found.sort_by(|a, b| a.instance.cmp(&b.instance));
    found
}

/// Writes the last state of all memory that outlasts the processes at `root` into each of `folders`.
///
/// # Errors
/// If a file cannot be written.
pub(crate) fn keep(root: &Root, folders: &[PathBuf]) -> anyhow::Result<()> {
    for name in root.outlasting_names() {
        let Some(memory) = root.outlasting_file(&name) else {
            continue;
        };
        for folder in folders {
            let path = end_file(root, folder, &name);
            write(&memory, &path).with_context(|| format!("keeping {name} in {}", path.display()))?;
        }
    }
    if let Some(folder) = folders.first() {
        let file = end_file(root, folder, CHECKPOINT);
        if file.exists() {
            say(&format!("the next start goes on from {}", file.display()));
        }
    }
    Ok(())
}

/// Publishes the contents of the files of the last end, taken from the first folder with such files, and removes all.
/// Memory that a killed run has left is newer than any file.
///
/// # Errors
/// If there is no memory for the contents.
pub(crate) fn take_up(root: &Root, folders: &[PathBuf]) -> anyhow::Result<()> {
    let found = folders.iter().map(|folder| end_files(root, folder));
    for (name, path) in found.into_iter().find(|files| !files.is_empty()).unwrap_or_default() {
        if root.outlasting_file(&name).is_some() {
            continue;
        }
        let octets = read(&path).unwrap_or_else(|error| {
            say(&format!(
                "warning: {} cannot be used, and {name} begins anew: {error}",
                path.display()
            ));
            Vec::new()
        });
        root.publish_outlasting(&name, &octets)?;
        if name == CHECKPOINT && !octets.is_empty() {
            say(&format!("going on from {}", path.display()));
        }
    }
    remove(root, folders);
    Ok(())
}

/// Notes that numbers are given under the instance's name. If numbers were given before, and fusion's kept memory is
/// gone, a blank checkpoint is published.
///
/// # Errors
/// If there is no memory for the checkpoint, or the note cannot be written.
pub(crate) fn note_numbers(root: &Root) -> anyhow::Result<()> {
    let note = root.base().join(format!("{}.{NUMBERED}", root.instance()));
    if !note.exists() {
        File::create(&note).with_context(|| format!("making {}", note.display()))?;
    } else if root.outlasting_file(CHECKPOINT).is_none() {
        say("nothing is left of the last run: track numbers begin by the time of day");
        root.publish_outlasting(CHECKPOINT, &[])?;
    }
    Ok(())
}

/// Removes the files of the last end.
pub(crate) fn remove(root: &Root, folders: &[PathBuf]) {
    for folder in folders {
        for (_, path) in end_files(root, folder) {
            let _ = fs::remove_file(path);
        }
    }
}

fn end_file(root: &Root, folder: &Path, name: &str) -> PathBuf {
    folder.join(format!("{}.{name}{SUFFIX}", root.instance()))
}

/// Files of the last end in `folder`, with the names of the memory.
fn end_files(root: &Root, folder: &Path) -> Vec<(String, PathBuf)> {
    let prefix = format!("{}.", root.instance());
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let named = |path: PathBuf| {
        let file = path.file_name().and_then(OsStr::to_str)?;
        let name = file.strip_prefix(&prefix)?.strip_suffix(SUFFIX)?.to_owned();
        (!name.contains('.')).then_some((name, path))
    };
    entries.filter_map(|entry| named(entry.path())).collect()
}

/// Compresses the file at `memory` into `path`, whole or not at all. The memory is read, not mapped: the contents
/// cannot harm this process.
fn write(memory: &Path, path: &Path) -> io::Result<()> {
    let new = path.with_extension("new");
    let file = File::options()
        .write(true)
        .create(true)
        .truncate(true)
        .mode(0o600)
        .open(&new)?;
    let mut encoder = zstd::Encoder::new(file, LEVEL)?;
    encoder.include_checksum(true)?;
    io::copy(&mut File::open(memory)?, &mut encoder)?;
    encoder.finish()?.sync_all()?;
    fs::rename(&new, path)
}

fn read(path: &Path) -> io::Result<Vec<u8>> {
    let mut octets = Vec::new();
    zstd::Decoder::new(File::open(path)?)?
        .take(OCTETS_MAX)
        .read_to_end(&mut octets)?;
    Ok(octets)
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::Ordering::Relaxed;

    use super::*;

    fn words(root: &Root, name: &str) -> Option<Vec<u64>> {
        let memory = root.outlasting(name).unwrap()?;
        Some(memory.words().iter().map(|word| word.load(Relaxed)).collect())
    }

    /// A root with memory under two names, in order at an end.
    fn ended(base: &Path) -> (Root, Vec<PathBuf>) {
        let root = Root::in_base(base, "it").unwrap();
        let folders = vec![base.to_owned(), base.join("disk")];
        fs::create_dir_all(&folders[1]).unwrap();
        for (name, value) in [(CHECKPOINT, 7), ("tracks-radar", 8)] {
            let memory = root.make_outlasting(name, 1000).unwrap();
            memory.words()[999].store(value, Relaxed);
            memory.publish().unwrap();
        }
        keep(&root, &folders).unwrap();
        root.remove_outlasting();
        (root, folders)
    }

    #[test]
    fn the_next_start_finds_the_last_state_once() {
        let base = tempfile::tempdir().unwrap();
        let (root, folders) = ended(base.path());
        assert_eq!(words(&root, CHECKPOINT), None);
        let listed = ended_instances(base.path());
        assert_eq!(listed.len(), 1);
        assert_eq!(listed[0].instance, "it");
        assert!(fs::metadata(&listed[0].file).unwrap().len() < 200);
        take_up(&root, &folders).unwrap();
        assert_eq!(words(&root, CHECKPOINT).unwrap()[999], 7);
        assert_eq!(words(&root, "tracks-radar").unwrap()[999], 8);
        assert!(
            !root.outlasting(CHECKPOINT).unwrap().unwrap().is_revived(),
            "no number is missing"
        );
        assert!(ended_instances(base.path()).is_empty());
        assert!(end_files(&root, &folders[1]).is_empty(), "nor a copy");
        root.remove_outlasting();
        take_up(&root, &folders).unwrap();
        assert_eq!(words(&root, CHECKPOINT), None);
    }

    #[test]
    fn the_copy_on_disk_serves_where_the_base_folder_is_gone() {
        let base = tempfile::tempdir().unwrap();
        let (root, folders) = ended(base.path());
        fs::remove_file(end_file(&root, &folders[0], CHECKPOINT)).unwrap();
        fs::remove_file(end_file(&root, &folders[0], "tracks-radar")).unwrap();
        take_up(&root, &folders).unwrap();
        assert_eq!(words(&root, CHECKPOINT).unwrap()[999], 7);
        root.remove_outlasting();
    }

    #[test]
    fn memory_of_a_killed_run_is_newer_than_a_file() {
        let base = tempfile::tempdir().unwrap();
        let (root, folders) = ended(base.path());
        root.publish_outlasting(CHECKPOINT, &9u64.to_ne_bytes()).unwrap();
        take_up(&root, &folders).unwrap();
        assert_eq!(words(&root, CHECKPOINT), Some(vec![9]));
        assert!(ended_instances(base.path()).is_empty());
        root.remove_outlasting();
    }

    #[test]
    fn damaged_and_missing_files_leave_a_blank_word() {
        let base = tempfile::tempdir().unwrap();
        let (root, folders) = ended(base.path());
        note_numbers(&root).unwrap();
        assert_eq!(words(&root, CHECKPOINT), None, "a first start");
        let file = end_file(&root, &folders[0], CHECKPOINT);
        let sound = fs::read(&file).unwrap();
        for place in 0..sound.len() {
            let mut octets = sound.clone();
            octets[place] ^= 1;
            fs::write(&file, octets).unwrap();
            take_up(&root, &folders).unwrap();
            let found = words(&root, CHECKPOINT).unwrap();
            let mut whole = vec![0; 1000];
            whole[999] = 7;
            assert!(found == [0] || found == whole, "octet {place}");
            root.remove_outlasting();
        }
        note_numbers(&root).unwrap();
        assert_eq!(words(&root, CHECKPOINT), Some(vec![0]), "gone");
        root.remove_outlasting();
    }
}
