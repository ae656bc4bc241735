//! Description of the folder as a ROS 2 bag: `metadata.yaml`.
//!
//! The file is replaced as a whole, so a reader finds a complete one also after a kill. It is renewed while the
//! recording grows, and by the next recorder. If it cannot be written, the former one stays: the recording itself does
//! not depend on it.

use std::collections::BTreeMap;
use std::fs::File;
use std::path::{Path, PathBuf};

use recording::Contents;
use runtime::{Now, NumberedFiles};

/// Time between two renewals, nanoseconds.
const PERIOD_NS: i64 = 5_000_000_000;

/// Contents of the files of the recording.
#[derive(Debug)]
pub(crate) struct Bag {
    folder: PathBuf,
    files: BTreeMap<PathBuf, Contents>,
    written_ns: i64,
}

impl Bag {
    /// Describes the files that earlier recorders left.
    pub(crate) fn new(folder: &Path, files: &NumberedFiles) -> Self {
        let contents = |path: PathBuf| {
            let contents = File::open(&path).ok().and_then(|mut file| Contents::of(&mut file).ok());
            contents.map(|contents| (path, contents))
        };
        let earlier = files.list().unwrap_or_default().into_iter();
        let bag = Self {
            folder: folder.to_owned(),
            files: earlier.filter_map(|(_, path)| contents(path)).collect(),
            written_ns: i64::MIN,
        };
        bag.write();
        bag
    }

    /// Notes the contents of a file; writes the description if due.
    pub(crate) fn note(&mut self, path: &Path, contents: Contents, now: Now) {
        let is_new = self.files.insert(path.to_owned(), contents).is_none();
        if is_new || now.mono_ns.saturating_sub(self.written_ns) >= PERIOD_NS {
            self.written_ns = now.mono_ns;
            self.write();
        }
    }

    /// Removes a deleted file.
    pub(crate) fn forget(&mut self, path: &Path) {
        self.files.remove(path);
    }

    /// Writes the description.
    pub(crate) fn write(&self) {
        let name = |path: &PathBuf| path.file_name().map(|name| name.to_string_lossy().into_owned());
        let files = self.files.iter();
        let files: Vec<_> = files
            .filter_map(|(path, contents)| Some((name(path)?, contents.clone())))
            .collect();
        let new = self.folder.join(".metadata.yaml");
        let written = std::fs::write(&new, recording::bag(&files));
        if written
            .and_then(|()| std::fs::rename(&new, self.folder.join("metadata.yaml")))
            .is_err()
        {
            let _ = std::fs::remove_file(&new);
        }
    }
}
