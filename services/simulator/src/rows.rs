//! Rows of a table in datagrams; each datagram is a complete table with a header line.

use std::io;

use messages::Counter;
use net::UdpSender;
use runtime::HealthEntry;
use runtime::Process;

use crate::{DATAGRAM_OCTETS_MAX, sender_to};

/// Output of an instrument that sends observations as rows.
#[derive(Debug)]
pub(crate) struct RowSender {
    sender: UdpSender,
    datagram: Vec<u8>,
    rows: u64,
}

impl RowSender {
    /// Creates the output to the receiver of a simulated source or sensor; the receiver has the name of the
    /// adapter.
    pub(crate) fn new(process: &Process, adapter: &str) -> anyhow::Result<Self> {
        Ok(Self {
            sender: sender_to(process, adapter)?,
            datagram: Vec::with_capacity(DATAGRAM_OCTETS_MAX),
            rows: 0,
        })
    }

    /// Sends rows; `write` writes a table of the given rows.
    pub(crate) fn send<T>(&mut self, rows: &[T], write: impl Fn(&mut Vec<u8>, &[T]) -> io::Result<()>) {
        let mut rest = rows;
        while !rest.is_empty() {
            let count = self.fill(rest, &write);
            // The sender counts failures.
            drop(self.sender.send(&self.datagram));
            self.rows += count as u64;
            rest = &rest[count..];
        }
    }

    /// Writes as many rows as fit by halving their number. Returns the number written, at least 1.
    fn fill<T>(&mut self, rows: &[T], write: impl Fn(&mut Vec<u8>, &[T]) -> io::Result<()>) -> usize {
        let mut count = rows.len();
        loop {
            self.datagram.clear();
            // Writing into memory does not fail.
            let written = write(&mut self.datagram, &rows[..count]);
            debug_assert!(written.is_ok());
            if count == 1 || self.datagram.len() <= DATAGRAM_OCTETS_MAX {
                return count;
            }
            count = count.div_ceil(2);
        }
    }

    /// Adds the sender's counts.
    pub(crate) fn count(&self, entry: &mut HealthEntry) {
        count_sent(self.rows, &self.sender, entry);
    }
}

/// Adds the counts of a sender of so many records.
pub(crate) fn count_sent(records: u64, sender: &UdpSender, entry: &mut HealthEntry) {
    let sent = sender.counters();
    for (counter, count) in [
        (Counter::RecordsSent, records),
        (Counter::DatagramsSent, sent.sent),
        (Counter::SendFailures, sent.failed),
    ] {
        entry.counters[counter] += count;
    }
}
