//! File of a table, which counts its bytes.

use std::fs::File;
use std::io::{self, Write};

/// File of a table.
#[derive(Debug)]
pub(crate) struct TableFile {
    file: File,
    bytes: u64,
}

impl TableFile {
    /// Continues a file of so many bytes.
    pub(crate) fn new(file: File, bytes: u64) -> Self {
        Self { file, bytes }
    }

    /// Returns the length of the file, bytes.
    pub(crate) fn bytes(&self) -> u64 {
        self.bytes
    }
}

impl Write for TableFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.file.write(bytes)?;
        self.bytes += written as u64;
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}
