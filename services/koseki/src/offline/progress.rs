//! Progress of long work, on a terminal.

use std::cell::RefCell;
use std::fs::File;
use std::io::{BufReader, IsTerminal as _, Read, Write as _};
use std::rc::Rc;

/// Less than this is done before anybody wonders, octets.
const SHOWN_OCTETS_MIN: u64 = 64 << 20;
/// Octets that are read at a time.
const BUFFER_OCTETS: usize = 1 << 18;

/// A percentage that is written over itself on standard error.
#[derive(Debug)]
pub(crate) struct Progress {
    octets: u64,
    percent: u64,
    is_shown: bool,
}

impl Progress {
    /// Progress of work on so many octets.
    pub(crate) fn new(octets: u64) -> Self {
        Self {
            octets,
            percent: 0,
            is_shown: octets >= SHOWN_OCTETS_MIN && std::io::stderr().is_terminal(),
        }
    }

    /// So many octets are done.
    pub(crate) fn at(&mut self, octets: u64) {
        if self.is_shown && octets * 100 >= (self.percent + 1) * self.octets {
            self.percent = octets * 100 / self.octets;
            let _ = write!(std::io::stderr(), "\r{} %", self.percent);
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if self.percent > 0 {
            let _ = write!(std::io::stderr(), "\r     \r");
        }
    }
}

/// A file that counts what is read of it; several may count together.
#[derive(Debug)]
pub(crate) struct Counting {
    file: BufReader<File>,
    octets: Rc<RefCell<u64>>,
}

impl Counting {
    /// Adds what is read to `octets`.
    pub(crate) fn new(file: File, octets: Rc<RefCell<u64>>) -> Self {
        Self {
            file: BufReader::with_capacity(BUFFER_OCTETS, file),
            octets,
        }
    }
}

impl Read for Counting {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let count = self.file.read(buffer)?;
        *self.octets.borrow_mut() += count as u64;
        Ok(count)
    }
}
