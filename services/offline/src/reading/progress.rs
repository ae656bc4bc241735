//! Progress of long work.

use std::cell::RefCell;
use std::io::{self, BufReader, Read};
use std::rc::Rc;

use crate::host::{Host, Input};

/// Octets that are read at a time.
const BUFFER_OCTETS: usize = 1 << 18;

/// A pass over tables, of which the host learns.
pub(crate) struct Progress<'a> {
    host: &'a dyn Host,
    octets: u64,
}

impl<'a> Progress<'a> {
    /// Progress of work on so many octets.
    pub(crate) fn new(host: &'a dyn Host, octets: u64) -> Self {
        Self { host, octets }
    }

    /// So many octets are done.
    ///
    /// # Errors
    /// If the command is to end.
    pub(crate) fn at(&self, octets: u64) -> io::Result<()> {
        self.host.progress(octets, self.octets)
    }
}

impl Drop for Progress<'_> {
    fn drop(&mut self) {
        self.host.passed();
    }
}

/// An input that counts what is read of it; several may count together.
pub(crate) struct Counting {
    input: BufReader<Input>,
    octets: Rc<RefCell<u64>>,
}

impl Counting {
    /// Adds what is read to `octets`.
    pub(crate) fn new(input: Input, octets: Rc<RefCell<u64>>) -> Self {
        Self {
            input: BufReader::with_capacity(BUFFER_OCTETS, input),
            octets,
        }
    }
}

impl Read for Counting {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.input.read(buffer)?;
        *self.octets.borrow_mut() += count as u64;
        Ok(count)
    }
}
