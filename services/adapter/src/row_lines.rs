//! Rows of a table from a server on the network, over a connection.
//!
//! The server sends the header line first, then rows as available. A line that begins with a small letter is a header;
//! a later header replaces the earlier header, and lines count from the later header. The rows of a read are put under
//! the header, as in a datagram, for the readers of datagrams. The time of receipt is the time of the read, since TCP
//! has no time stamps.

use std::net::SocketAddr;
use std::time::Duration;

use messages::Counter;
use net::{LinesSettings, TcpLines};
use runtime::clock::SteadyClock;
use runtime::{Agent, HealthEntry, Now, Turn};

use crate::plot_rows::PlotRows;
use crate::receiver::{DatagramReader as _, ReceiptTime};
use crate::refusals::LatestRefusals;

/// Longest wait for a line in a turn, bounded by health messages and stop requests.
const PATIENCE: Duration = Duration::from_millis(50);
/// Longest row that is accepted, bytes.
const ROW_OCTETS_MAX: usize = 4096;
/// Characters of a row that a refusal shows.
const SHOWN_MAX: usize = 40;

/// Agent of a receiver of rows.
#[derive(Debug)]
pub(crate) struct RowLineAgent {
    client: TcpLines,
    server: SocketAddr,
    reader: PlotRows,
    rows: TableOfLines,
    steady: SteadyClock,
    /// Rows that came before any header.
    headless: u64,
    refusals: LatestRefusals,
}

/// Rows under the header.
#[derive(Debug, Default)]
struct TableOfLines {
    /// The header with the line end, and the rows behind the header.
    table: Vec<u8>,
    header_octets: usize,
    /// Rows under the header, and the number of rows handed over before.
    count: u64,
    before: u64,
}

impl TableOfLines {
    /// Whether the line is a header, which begins a new table.
    fn is_header(line: &[u8]) -> bool {
        line.first().is_some_and(u8::is_ascii_lowercase)
    }

    fn begin(&mut self, header: &[u8]) {
        self.table.clear();
        self.table.extend_from_slice(header);
        self.table.push(b'\n');
        self.header_octets = self.table.len();
        (self.count, self.before) = (0, 0);
    }

    /// Takes a row; `false` if there is no header.
    fn push(&mut self, row: &[u8]) -> bool {
        if self.header_octets == 0 {
            return false;
        }
        self.table.extend_from_slice(row);
        self.table.push(b'\n');
        self.count += 1;
        true
    }

    /// The table, if there are rows.
    fn whole(&self) -> Option<&[u8]> {
        (self.table.len() > self.header_octets).then_some(&self.table[..])
    }

    fn clear_rows(&mut self) {
        self.table.truncate(self.header_octets);
        self.before = self.count;
    }
}

impl RowLineAgent {
    pub(crate) fn new(server: SocketAddr, reader: PlotRows) -> anyhow::Result<Self> {
        let settings = LinesSettings {
            line_octets_max: Some(ROW_OCTETS_MAX),
            ..LinesSettings::new(server)
        };
        Ok(Self {
            client: TcpLines::new(settings)?,
            server,
            reader,
            rows: TableOfLines::default(),
            steady: SteadyClock::of(Now::read()),
            headless: 0,
            refusals: LatestRefusals::default(),
        })
    }

    /// Hands the rows so far to the reader.
    fn hand_over(rows: &mut TableOfLines, reader: &mut PlotRows, steady: SteadyClock) -> anyhow::Result<()> {
        let Some(table) = rows.whole() else { return Ok(()) };
        let read = Now::read();
        reader.after_lines(rows.before);
        reader.take(table, ReceiptTime::of(read.utc_ns, read, steady))?;
        rows.clear_rows();
        Ok(())
    }
}

impl Agent for RowLineAgent {
    fn turn(&mut self, now: Now) -> anyhow::Result<Turn> {
        let (rows, reader, steady) = (&mut self.rows, &mut self.reader, self.steady);
        let (headless, refusals) = (&mut self.headless, &mut self.refusals);
        let mut failed = Ok(());
        self.client.poll(now.mono_ns, PATIENCE, |line| {
            if TableOfLines::is_header(line) {
                let taken = Self::hand_over(rows, reader, steady);
                if failed.is_ok() {
                    failed = taken;
                }
                rows.begin(line);
            } else if !rows.push(line) {
                *headless += 1;
                let begin: String = String::from_utf8_lossy(line).chars().take(SHOWN_MAX).collect();
                let words = format!("row {begin:?} came before the names of the columns; send them as the first line");
                let read = Now::read();
                refusals.note(("header", ""), ReceiptTime::of(read.utc_ns, read, steady), words);
            }
        });
        failed?;
        refusals.too_long(self.client.counters().oversized, || {
            let read = Now::read();
            ReceiptTime::of(read.utc_ns, read, steady)
        });
        let count = usize::from(rows.whole().is_some());
        Self::hand_over(rows, reader, steady)?;
        reader.publish(count, now)?;
        Ok(Turn::Worked)
    }

    fn health(&self, entries: &mut Vec<HealthEntry>) {
        let (mut whole, sources) = self.reader.summed_health();
        let lines = self.client.counters();
        whole.counters[Counter::BlocksRejected] += lines.oversized + self.headless;
        whole.set(Counter::Connections, lines.connections);
        self.refusals.state(&mut whole);
        if !self.client.is_connected() {
            whole.note = format!("not connected to {}", self.server);
        }
        entries.push(whole);
        entries.extend(sources);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_stand_under_the_latest_header() {
        let mut rows = TableOfLines::default();
        assert!(!rows.push(b"1,2") && rows.whole().is_none());
        rows.begin(b"time_s,a");
        assert!(rows.whole().is_none());
        assert!(rows.push(b"1,2") && rows.push(b"2,3"));
        assert_eq!(rows.whole(), Some(&b"time_s,a\n1,2\n2,3\n"[..]));
        rows.clear_rows();
        assert!(rows.whole().is_none() && rows.push(b"3,4"));
        assert_eq!(rows.whole(), Some(&b"time_s,a\n3,4\n"[..]));
        rows.begin(b"a,time_s");
        assert!(rows.whole().is_none());
        assert!(TableOfLines::is_header(b"time_s,a") && !TableOfLines::is_header(b"-1.5,2"));
    }
}
