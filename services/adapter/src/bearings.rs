//! Bearings from the network: one socket, and the direction finder behind it.
//!
//! Each datagram is a table by itself (FM-7): a header line, and a row per bearing, as many as fit. The header costs a
//! datagram a hundred octets, and buys that columns may come in any order, that more may be added, and that any of them can be
//! lost without harm to the next. Times are seconds since midnight (UTC); the day is the one that brings them nearest to the time
//! of receipt.
//!
//! A row that cannot be read is counted, and passed over.

use std::net::{IpAddr, SocketAddr};
use std::time::Duration;

use anyhow::Context as _;
use configuration::{Process, Source};
use formats::bearings_csv::BearingReader;
use frames::time::DayUnroller;
use messages::{Counter, Counters};
use net::{ReceiverSettings, UdpReceiver};
use runtime::{Agent, HealthEntry, Now, Turn};

use crate::channel::Channel;

/// Longest wait for a datagram in one turn: health messages must be said, and a stop be heard.
const PATIENCE: Duration = Duration::from_millis(50);

/// The agent of a receiver of bearings.
#[derive(Debug)]
pub(crate) struct Bearings {
    receiver: UdpReceiver,
    tables: Tables,
}

/// What becomes of the datagrams.
#[derive(Debug)]
struct Tables {
    channel: Channel,
    rows: u64,
    rows_refused: u64,
    octets_refused: u64,
}

impl Bearings {
    pub(crate) fn new(process: &Process, settings: &ReceiverSettings, sources: &[&Source]) -> anyhow::Result<Self> {
        let source = sources.first().context("no source is behind this receiver")?;
        let receiver = UdpReceiver::open(settings).with_context(|| {
            let address = SocketAddr::new(settings.address, settings.port);
            format!("receiving at {address}")
        })?;
        Ok(Self {
            receiver,
            tables: Tables {
                channel: Channel::open(process, source)?,
                rows: 0,
                rows_refused: 0,
                octets_refused: 0,
            },
        })
    }

    /// The receiver of a simulated source, at `port` of the deployment's own loopback address.
    pub(crate) fn loopback(process: &Process, port: u16, sources: &[&Source]) -> anyhow::Result<Self> {
        let address = IpAddr::V4(process.loopback);
        Self::new(process, &ReceiverSettings::new(address, port), sources)
    }
}

impl Tables {
    /// Takes the rows of a datagram.
    fn take(&mut self, bytes: &[u8], received_ns: i64, ingested_ns: i64) -> anyhow::Result<()> {
        let Ok(rows) = BearingReader::new(bytes, 0) else {
            self.octets_refused += bytes.len() as u64;
            self.rows_refused += 1;
            return Ok(());
        };
        let days = DayUnroller::near(received_ns);
        self.channel.received(received_ns);
        for row in rows {
            self.rows += 1;
            let Ok(mut bearing) = row else {
                self.rows_refused += 1;
                continue;
            };
            let time_of_day_ns = bearing.time_of_measurement_ns.rem_euclid(frames::time::NS_PER_DAY);
            bearing.time_of_measurement_ns = days.utc_ns(time_of_day_ns);
            self.channel.bearing(&bearing, ingested_ns)?;
        }
        Ok(())
    }
}

impl Agent for Bearings {
    fn turn(&mut self, now: Now) -> anyhow::Result<Turn> {
        let (receiver, tables) = (&mut self.receiver, &mut self.tables);
        let to_mono_ns = now.mono_ns - now.utc_ns;
        let mut failed = Ok(());
        receiver.receive(PATIENCE, |datagram| {
            let received_ns = datagram.received_utc_ns;
            let taken = tables.take(datagram.bytes, received_ns, received_ns + to_mono_ns);
            if failed.is_ok() {
                failed = taken;
            }
        })?;
        failed?;
        tables.channel.publish()?;
        Ok(Turn::Worked)
    }

    fn health(&self, entries: &mut Vec<HealthEntry>) {
        let tables = &self.tables;
        let mut read = Counters::default();
        read[Counter::Records] = tables.rows;
        read[Counter::BlocksRejected] = tables.rows_refused;
        read[Counter::BytesRejected] = tables.octets_refused;
        let source = tables.channel.health(&read);
        let mut whole = HealthEntry {
            progress_ns: source.progress_ns,
            note: self.receiver.warning().unwrap_or_default().to_owned(),
            ..HealthEntry::default()
        };
        for counter in [Counter::Records, Counter::Reports, Counter::Published] {
            whole.set(counter, source.counters[counter]);
        }
        let counted = self.receiver.counters();
        whole.set(Counter::Datagrams, counted.datagrams);
        whole.set(Counter::DatagramsRejected, counted.refused_senders);
        whole.set(
            Counter::DatagramsRejectedLength,
            counted.empty + counted.oversized + counted.unstamped,
        );
        whole.set(Counter::DatagramsDropped, counted.kernel_drops);
        entries.push(whole);
        entries.push(source);
    }
}
