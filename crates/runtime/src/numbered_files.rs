//! Numbered files of a sequence.

use std::io;
use std::path::{Path, PathBuf};

/// Files of a folder, numbered in their order: the beginning of the names, six digits, and an ending.
#[derive(Clone, Debug)]
pub struct NumberedFiles {
    folder: PathBuf,
    stem: String,
    ending: &'static str,
}

impl NumberedFiles {
    /// Files in `folder` whose names begin with `stem` and end in `ending`.
    pub fn new(folder: &Path, stem: impl Into<String>, ending: &'static str) -> Self {
        Self {
            folder: folder.to_owned(),
            stem: stem.into(),
            ending,
        }
    }

    /// Returns the path of the file with this number.
    pub fn path(&self, number: u32) -> PathBuf {
        self.folder.join(format!("{}{number:06}{}", self.stem, self.ending))
    }

    /// Returns the existing files with their numbers, rising.
    ///
    /// # Errors
    /// If the folder cannot be read.
    pub fn list(&self) -> io::Result<Vec<(u32, PathBuf)>> {
        let mut files = Vec::new();
        for entry in std::fs::read_dir(&self.folder)? {
            let path = entry?.path();
            let name = path.file_name().and_then(|name| name.to_str());
            let number = name.and_then(|name| name.strip_prefix(&self.stem)?.strip_suffix(self.ending)?.parse().ok());
            files.extend(number.map(|number| (number, path)));
        }
        files.sort();
        Ok(files)
    }

    /// Returns the oldest files without which the others have at most `bytes`; never the latest file, which is being
    /// written.
    ///
    /// # Errors
    /// If the folder cannot be read.
    pub fn beyond(&self, bytes: u64) -> io::Result<Vec<PathBuf>> {
        let files = self.list()?;
        let size = |path: &PathBuf| std::fs::metadata(path).map_or(0, |file| file.len());
        let mut all: u64 = files.iter().map(|(_, path)| size(path)).sum();
        let mut oldest = Vec::new();
        for (_, path) in files.iter().take(files.len().saturating_sub(1)) {
            if all <= bytes {
                break;
            }
            all -= size(path);
            oldest.push(path.clone());
        }
        Ok(oldest)
    }
}
