//! Bearings, arrival times and fixes in datagrams (FM-7, FM-11), and the direction finder or network of receivers
//! behind the socket.

use anyhow::Context as _;
use formats::emitter_rows_csv::EmitterRowReader;
use messages::Counters;
use runtime::Process;
use runtime::{HealthEntry, Now};

use crate::Processed;
use crate::channel::SourceChannel;
use crate::receiver::{DatagramReader, ReceiptTime};
use crate::tables::{TableCounts, utc_ns};

/// Reader of tables of measurements of emitters.
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
        for measured in self.tables.rows(bytes, received, EmitterRowReader::new) {
            let measured = measured.at_ns(utc_ns(received.utc_ns, measured.time_ns()));
            self.channel.emitter(&measured, received.mono_ns)?;
        }
        Ok(())
    }

    fn publish(&mut self, count: usize, now: Now) -> anyhow::Result<()> {
        // Received rows come before the clock.
        if count == 0 {
            self.channel.elapsed(now)?;
        }
        self.channel.publish()
    }

    fn health(&self, _whole: &mut HealthEntry, sources: &mut Vec<HealthEntry>) {
        let mut of_source = self.channel.health(&Counters::default());
        self.tables.count(&mut of_source);
        sources.push(of_source);
    }
}
