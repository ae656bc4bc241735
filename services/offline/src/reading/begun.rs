//! Begin of a file, for a look ahead of the pass that reads the whole file.
//!
//! A pipe can be read once. What the look has read is therefore kept, and comes again before the rest.

use std::io::{Cursor, Read};
use std::path::Path;

use csv_table::CsvError;

use crate::files::InputError;
use crate::host::{Host, TableInput};

/// Most bytes of a begin: more would leave the caches before its rows are read.
const HEAD_MAX: usize = 1 << 16;

/// A file of which the begin has been read.
pub(crate) struct BegunFile {
    head: Vec<u8>,
    rest: TableInput,
}

impl BegunFile {
    /// Reads the begin of a file.
    ///
    /// # Errors
    /// If the file cannot be read.
    pub(crate) fn of(host: &dyn Host, path: &Path) -> Result<Self, InputError> {
        let (mut rest, mut head) = (host.open(path)?, Vec::with_capacity(HEAD_MAX));
        let read = rest.by_ref().take(HEAD_MAX as u64).read_to_end(&mut head);
        let failed = |reason| InputError::new(path, CsvError::Input { line: 1, reason });
        read.map_err(failed).map(|_| Self { head, rest })
    }

    /// The begin: the whole file, or more than any kind of file is recognised by.
    pub(crate) fn head(&self) -> &[u8] {
        &self.head
    }

    /// The begin, in whole lines.
    pub(super) fn lines(&self) -> &[u8] {
        let is_all = self.head.len() < HEAD_MAX;
        let feed = self.head.iter().rposition(|octet| *octet == b'\n');
        let end = feed.filter(|_| !is_all).unwrap_or(self.head.len());
        &self.head[..end]
    }

    /// Size of the whole file, bytes.
    pub(crate) fn length(&self) -> u64 {
        self.rest.length
    }

    /// The whole file, and its size in bytes.
    pub(crate) fn whole(self) -> (Box<dyn Read>, u64) {
        let length = self.length();
        (Box::new(Cursor::new(self.head).chain(self.rest)), length)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn begun(text: &str, head: usize) -> BegunFile {
        let rest = TableInput::new(Cursor::new(text.as_bytes()[head..].to_vec()), text.len() as u64);
        let head = text.as_bytes()[..head].to_vec();
        BegunFile { head, rest }
    }

    #[test]
    fn a_file_comes_whole_after_its_begin() {
        let text = "a,b\n1,2\n3,4";
        assert_eq!(begun(text, text.len()).lines(), text.as_bytes());
        let (mut whole, length) = begun(text, 6).whole();
        let mut read = String::new();
        whole.read_to_string(&mut read).unwrap();
        assert_eq!((read.as_str(), length), (text, text.len() as u64));
    }

    #[test]
    fn a_begin_ends_with_a_whole_line() {
        let line = "123456,789\n";
        let text = line.repeat(HEAD_MAX / line.len() + 2);
        let file = begun(&text, HEAD_MAX);
        assert!(file.lines().len() > HEAD_MAX - line.len() - 1 && text[file.lines().len()..].starts_with('\n'));
    }
}
