//! Rows of a table from a server on the network, over one connection.
//!
//! The server sends the header line first, then rows as they come. A line that begins with a small letter is a header;
//! a later header replaces it. The rows of one read are put under the header, as in a datagram, so the readers of
//! datagrams read them. The time of receipt is that of the read, since TCP has no time stamps of its own.

use std::net::SocketAddr;
use std::time::Duration;

use messages::Counter;
use net::{LinesSettings, TcpLines};
use runtime::clock::SteadyClock;
use runtime::{Agent, HealthEntry, Now, Turn};

use crate::receiver::{DatagramReader, ReceiptTime};

/// Longest wait for a line in one turn, bounded by health messages and stop requests.
const PATIENCE: Duration = Duration::from_millis(50);
/// Longest row that is accepted, bytes.
const ROW_OCTETS_MAX: usize = 4096;

/// Agent of a receiver of rows.
#[derive(Debug)]
pub(crate) struct RowLineAgent<D> {
    client: TcpLines,
    server: SocketAddr,
    reader: D,
    rows: TableOfLines,
    steady: SteadyClock,
    /// Rows that came before any header.
    headless: u64,
}

/// Rows under their header.
#[derive(Debug, Default)]
struct TableOfLines {
    /// The header with its line end, and the rows behind it.
    table: Vec<u8>,
    header_octets: usize,
}

impl TableOfLines {
    /// Whether the line is a header, which begins a table of its own.
    fn is_header(line: &[u8]) -> bool {
        line.first().is_some_and(u8::is_ascii_lowercase)
    }

    fn begin(&mut self, header: &[u8]) {
        self.table.clear();
        self.table.extend_from_slice(header);
        self.table.push(b'\n');
        self.header_octets = self.table.len();
    }

    /// Takes a row; `false` if there is no header.
    fn push(&mut self, row: &[u8]) -> bool {
        if self.header_octets == 0 {
            return false;
        }
        self.table.extend_from_slice(row);
        self.table.push(b'\n');
        true
    }

    /// The table, if it has rows.
    fn whole(&self) -> Option<&[u8]> {
        (self.table.len() > self.header_octets).then_some(&self.table[..])
    }

    fn clear_rows(&mut self) {
        self.table.truncate(self.header_octets);
    }
}

impl<D: DatagramReader> RowLineAgent<D> {
    pub(crate) fn new(server: SocketAddr, reader: D) -> anyhow::Result<Self> {
        let settings = LinesSettings {
            line_octets_max: ROW_OCTETS_MAX,
            ..LinesSettings::new(server)
        };
        Ok(Self {
            client: TcpLines::new(settings)?,
            server,
            reader,
            rows: TableOfLines::default(),
            steady: SteadyClock::of(Now::read()),
            headless: 0,
        })
    }

    /// Hands the rows so far to the reader.
    fn hand_over(rows: &mut TableOfLines, reader: &mut D, steady: SteadyClock) -> anyhow::Result<()> {
        let Some(table) = rows.whole() else { return Ok(()) };
        let read = Now::read();
        reader.take(table, ReceiptTime::of(read.utc_ns, read, steady))?;
        rows.clear_rows();
        Ok(())
    }
}

impl<D: DatagramReader> Agent for RowLineAgent<D> {
    fn turn(&mut self, now: Now) -> anyhow::Result<Turn> {
        let (rows, reader, headless, steady) = (&mut self.rows, &mut self.reader, &mut self.headless, self.steady);
        let mut failed = Ok(());
        self.client.poll(now.mono_ns, PATIENCE, |line| {
            if TableOfLines::is_header(line) {
                let taken = Self::hand_over(rows, reader, steady);
                if failed.is_ok() {
                    failed = taken;
                }
                rows.begin(line);
            } else {
                *headless += u64::from(!rows.push(line));
            }
        });
        failed?;
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
