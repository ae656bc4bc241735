//! Comparison with an existing output of `koseki fuse`, row by row.

use std::io::{self, BufReader, Read, Write};
use std::path::Path;

use crate::files::InputError;
use crate::host::TableInput;

/// Writer that compares the received rows with a file. Writing never fails: the first difference is noted.
pub(super) struct FusedCheck {
    file: BufReader<TableInput>,
    line: u64,
    difference: Option<String>,
}

impl FusedCheck {
    pub(super) fn new(file: TableInput) -> Self {
        Self {
            file: BufReader::with_capacity(1 << 16, file),
            line: 1,
            difference: None,
        }
    }

    /// Compares the end, and returns the first difference as an error of `path`.
    ///
    /// # Errors
    /// If there is a difference, or the file cannot be read.
    pub(super) fn finish(mut self, path: &Path) -> Result<(), InputError> {
        let mut further = [0];
        if self.difference.is_none() && self.read(&mut further) != 0 {
            self.differs("is beyond the last row that these sensor tracks give");
        }
        match self.difference {
            None => Ok(()),
            Some(difference) => Err(InputError::new(path, difference)),
        }
    }

    fn read(&mut self, octets: &mut [u8]) -> usize {
        let mut filled = 0;
        while filled < octets.len() {
            match self.file.read(&mut octets[filled..]) {
                Ok(0) => break,
                Ok(count) => filled += count,
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) => {
                    self.difference = Some(format!("cannot be read: {error}"));
                    break;
                }
            }
        }
        filled
    }

    fn differs(&mut self, how: &str) {
        let remedy = "name the files, --config, --rule and --refresh of the `koseki fuse` that has written it";
        self.difference = Some(format!("line {} {how}; {remedy}", self.line));
    }
}

impl Write for FusedCheck {
    fn write(&mut self, octets: &[u8]) -> io::Result<usize> {
        if self.difference.is_none() {
            let mut theirs = vec![0; octets.len()];
            let filled = self.read(&mut theirs);
            let same = octets
                .iter()
                .zip(&theirs[..filled])
                .take_while(|(one, other)| one == other);
            let same = same.count();
            let lines = octets[..same].iter().filter(|octet| **octet == b'\n').count();
            self.line += lines as u64;
            if same < octets.len() && self.difference.is_none() {
                self.differs("is not the row that these sensor tracks give");
            }
        }
        Ok(octets.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}
