//! Progress of long work.

use std::cell::RefCell;
use std::io::{self, BufReader, Read};
use std::rc::Rc;

use crate::host::Host;

/// Size of the read buffer, bytes.
const BUFFER_OCTETS: usize = 1 << 18;

/// Pass over tables that reports the progress to the host.
pub(crate) struct Progress<'a> {
    host: &'a dyn Host,
    octets: u64,
}

impl<'a> Progress<'a> {
    /// Creates the progress of work on this number of bytes.
    pub(crate) fn new(host: &'a dyn Host, octets: u64) -> Self {
        Self { host, octets }
    }

    /// Reports the number of bytes done.
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

/// Input that counts the bytes read; several inputs may share a counter.
pub(crate) struct CountingInput {
    input: BufReader<Box<dyn Read>>,
    octets: Rc<RefCell<u64>>,
}

impl CountingInput {
    /// Creates an input that adds the bytes read to `octets`.
    pub(crate) fn new(input: impl Read + 'static, octets: Rc<RefCell<u64>>) -> Self {
        Self {
            input: BufReader::with_capacity(BUFFER_OCTETS, Box::new(input)),
            octets,
        }
    }
}

impl Read for CountingInput {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.input.read(buffer)?;
        *self.octets.borrow_mut() += count as u64;
        Ok(count)
    }
}
