//! Snapshots of an antenna array in datagrams (EL-1), and the direction finder behind the socket.
//!
//! The layout is that of [`formats::snapshot_datagram`]. Refused datagrams are counted by reason.

use anyhow::Context as _;
use formats::snapshot_datagram::{self, SnapshotRefusal};
use messages::{Counter, Counters};
use observations::SnapshotBlock;
use runtime::Process;
use runtime::{HealthEntry, Now};

use crate::Processed;
use crate::channel::SourceChannel;
use crate::receiver::{DatagramReader, ReceiptTime};
use crate::refusals::LatestRefusals;

/// Reader of datagrams of snapshots.
#[derive(Debug)]
pub(crate) struct Snapshots {
    channel: SourceChannel,
    /// The datagram being read; the memory is used again.
    block: SnapshotBlock,
    refused: Counters,
    refusals: LatestRefusals,
}

impl Snapshots {
    pub(crate) fn new(process: &Process, sources: &[Processed<'_>]) -> anyhow::Result<Self> {
        let source = *sources.first().context("no source is behind this receiver")?;
        Ok(Self {
            channel: SourceChannel::open(process, source)?,
            block: SnapshotBlock::default(),
            refused: Counters::default(),
            refusals: LatestRefusals::default(),
        })
    }
}

impl DatagramReader for Snapshots {
    fn take(&mut self, bytes: &[u8], received: ReceiptTime) -> anyhow::Result<()> {
        self.channel.received(received)?;
        match snapshot_datagram::decode(bytes, &mut self.block) {
            Ok(()) => self.channel.snapshots(&self.block, received.mono_ns)?,
            Err(refusal) => {
                let counter = match refusal {
                    SnapshotRefusal::Foreign => Counter::SnapshotsForeign,
                    SnapshotRefusal::Length => Counter::SnapshotsLength,
                    SnapshotRefusal::Value(_) => Counter::SnapshotsValue,
                };
                let name = match refusal {
                    SnapshotRefusal::Value(name) => name,
                    _ => "",
                };
                let words = format!("a datagram of {} octets {refusal}", bytes.len());
                self.refusals.note((counter.label(), name), received, words);
                self.refused.add(counter, 1);
                self.refused.add(Counter::BytesRejected, bytes.len() as u64);
            }
        }
        Ok(())
    }

    fn publish(&mut self, _count: usize, _now: Now) -> anyhow::Result<()> {
        self.channel.publish()
    }

    fn health(&self, _whole: &mut HealthEntry, sources: &mut Vec<HealthEntry>) {
        let mut of_source = self.channel.health(&self.refused);
        self.refusals.state(&mut of_source);
        sources.push(of_source);
    }
}
