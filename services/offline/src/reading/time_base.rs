//! The time base of the files of a command.

use std::path::{Path, PathBuf};

use crate::files::InputError;

/// Files that are read together, and the common time base.
#[derive(Debug, Default)]
pub(crate) struct FileBases {
    first: Option<(PathBuf, bool)>,
}

impl FileBases {
    /// Adds a file, with times that count from 1970 or from a midnight.
    ///
    /// # Errors
    /// If the times of the first file count from the other base: no times of the two would meet.
    pub(crate) fn add(&mut self, path: &Path, is_since_1970: bool) -> Result<(), InputError> {
        let (first, is_first_since_1970) = self.first.get_or_insert_with(|| (path.to_owned(), is_since_1970));
        if *is_first_since_1970 == is_since_1970 {
            return Ok(());
        }
        let [own, others] = match is_since_1970 {
            true => ["1970", "a midnight"],
            false => ["a midnight", "1970"],
        };
        let what = format!(
            "times count from {own}, but those of {} from {others}; count both from one of them",
            first.display()
        );
        Err(InputError::new(path, what))
    }
}
