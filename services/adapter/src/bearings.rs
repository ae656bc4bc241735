//! Bearings in datagrams (FM-7), and the direction finder behind the socket.

use anyhow::Context as _;
use deployment::Process;
use formats::bearings_csv::BearingReader;
use messages::Counters;
use runtime::{HealthEntry, Now};

use crate::Processed;
use crate::channel::SourceChannel;
use crate::receiver::{DatagramReader, ReceiptTime};
use crate::tables::{TableCounts, utc_ns};

/// Reader of tables of bearings.
#[derive(Debug)]
pub(crate) struct Bearings {
    channel: SourceChannel,
    tables: TableCounts,
}

impl Bearings {
    pub(crate) fn new(process: &Process, sources: &[Processed<'_>]) -> anyhow::Result<Self> {
        let source = *sources.first().context("no source is behind this receiver")?;
        Ok(Self {
            channel: SourceChannel::open(process, source)?,
            tables: TableCounts::default(),
        })
    }
}

impl DatagramReader for Bearings {
    fn take(&mut self, bytes: &[u8], received: ReceiptTime) -> anyhow::Result<()> {
        self.channel.received(received)?;
        for mut bearing in self.tables.rows(bytes, BearingReader::new) {
            bearing.time_of_measurement_ns = utc_ns(received.utc_ns, bearing.time_of_measurement_ns);
            self.channel.bearing(&bearing, received.mono_ns)?;
        }
        Ok(())
    }

    fn publish(&mut self, _count: usize, _now: Now) -> anyhow::Result<()> {
        self.channel.publish()
    }

    fn health(&self, _whole: &mut HealthEntry, sources: &mut Vec<HealthEntry>) {
        let mut read = Counters::default();
        self.tables.count(&mut read);
        sources.push(self.channel.health(&read));
    }
}
