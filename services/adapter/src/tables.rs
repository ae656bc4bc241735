//! Tables in datagrams.
//!
//! Each datagram is a complete table: a header line, and as many rows as fit. The header costs a datagram a hundred
//! bytes; in return columns may have any order, columns may be added, and a lost datagram does not affect the next.
//! Times are seconds since midnight (UTC); the day is chosen nearest to the time of receipt.
//!
//! A row that cannot be read is counted, and passed over; the latest are named in health messages.

use std::fmt::Display;

use csv_table::CsvError;
use formats::rows::{Columns, RowReader};
use formats::time_base::is_since_1970;
use frames::time::{DayUnroller, NS_PER_DAY};
use messages::Counter;
use runtime::HealthEntry;

use crate::receiver::ReceiptTime;
use crate::refusals::LatestRefusals;

/// Counts of tables and rows.
#[derive(Clone, Debug, Default)]
pub(crate) struct TableCounts {
    rows: u64,
    rows_rejected: u64,
    bytes_rejected: u64,
    /// Lines of a table that came before the present part.
    lines_before: u64,
    refusals: LatestRefusals,
}

impl TableCounts {
    /// Readable rows of a datagram received at `received`; none if `open` finds no table.
    pub(crate) fn rows<'a, C: Columns + 'a>(
        &'a mut self,
        bytes: &'a [u8],
        received: ReceiptTime,
        open: impl FnOnce(&'a [u8], i64) -> Result<RowReader<&'a [u8], C>, CsvError>,
    ) -> impl Iterator<Item = C::Value> + 'a {
        let table = match open(bytes, 0) {
            Ok(table) => Some(table),
            Err(error) => {
                self.bytes_rejected += bytes.len() as u64;
                self.refuse(error, received);
                None
            }
        };
        table.into_iter().flatten().filter_map(move |row| {
            self.rows += 1;
            row.map_err(|error| self.refuse(error, received)).ok()
        })
    }

    /// Counts the lines of the next datagram, which continues an earlier table, from `lines`.
    pub(crate) fn after_lines(&mut self, lines: u64) {
        self.lines_before = lines;
    }

    /// Takes the refusal of a row that could be read, in words.
    pub(crate) fn note(&mut self, reason: (&'static str, &'static str), received: ReceiptTime, words: impl Display) {
        self.refusals.note(reason, received, words);
    }

    fn refuse(&mut self, error: CsvError, received: ReceiptTime) {
        self.rows_rejected += 1;
        self.refusals.row(error, self.lines_before, received);
    }

    /// Adds the counts, and the latest refusals.
    pub(crate) fn count(&self, health: &mut HealthEntry) {
        let counters = &mut health.counters;
        counters[Counter::Records] += self.rows;
        counters[Counter::BlocksRejected] += self.rows_rejected;
        counters[Counter::BytesRejected] += self.bytes_rejected;
        self.refusals.state(health);
    }
}

/// UTC of a row's time, nanoseconds: a time that counts from a midnight, on the day with the result nearest to the time
/// of receipt.
pub(crate) fn utc_ns(received_ns: i64, time_ns: i64) -> i64 {
    if is_since_1970(time_ns) {
        return time_ns;
    }
    DayUnroller::near(received_ns).utc_ns(time_ns.rem_euclid(NS_PER_DAY))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_time_that_counts_from_1970_is_moved_to_no_other_day() {
        let received_ns = 20_000 * NS_PER_DAY + 5;
        assert_eq!(utc_ns(received_ns, 3), 20_000 * NS_PER_DAY + 3);
        let yesterday_ns = received_ns - NS_PER_DAY;
        assert_eq!(utc_ns(received_ns, yesterday_ns), yesterday_ns);
    }
}
