//! Tables in datagrams.
//!
//! Each datagram is a complete table: a header line, and as many rows as fit. The header costs a datagram a hundred
//! bytes; in return columns may have any order, columns may be added, and a lost datagram does not affect the next.
//! Times are seconds since midnight (UTC); the day is chosen nearest to the time of receipt.
//!
//! A row that cannot be read is counted, and passed over.

use csv_table::CsvError;
use formats::rows::{Columns, RowReader};
use frames::time::{DayUnroller, NS_PER_DAY};
use messages::{Counter, Counters};

/// Counts of tables and their rows.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct TableCounts {
    rows: u64,
    rows_rejected: u64,
    bytes_rejected: u64,
}

impl TableCounts {
    /// Rows of a datagram that can be read; none if `open` finds that it is no table.
    pub(crate) fn rows<'a, C: Columns + 'a>(
        &'a mut self,
        bytes: &'a [u8],
        open: impl FnOnce(&'a [u8], i64) -> Result<RowReader<&'a [u8], C>, CsvError>,
    ) -> impl Iterator<Item = C::Value> + 'a {
        let table = open(bytes, 0).ok();
        if table.is_none() {
            self.bytes_rejected += bytes.len() as u64;
            self.rows_rejected += 1;
        }
        table.into_iter().flatten().filter_map(|row| {
            self.rows += 1;
            row.inspect_err(|_| self.rows_rejected += 1).ok()
        })
    }

    /// Adds the counts.
    pub(crate) fn count(&self, counters: &mut Counters) {
        counters[Counter::Records] += self.rows;
        counters[Counter::BlocksRejected] += self.rows_rejected;
        counters[Counter::BytesRejected] += self.bytes_rejected;
    }
}

/// UTC of a row's time, nanoseconds, on the day that brings it nearest to the time of receipt.
pub(crate) fn utc_ns(received_ns: i64, time_ns: i64) -> i64 {
    DayUnroller::near(received_ns).utc_ns(time_ns.rem_euclid(NS_PER_DAY))
}
