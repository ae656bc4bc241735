//! Snapshots of an antenna array in datagrams (EL-1), and the direction finder behind the socket.
//!
//! The layout is that of [`formats::snapshot_datagram`]. Refused datagrams are counted by reason.

use anyhow::Context as _;
use deployment::Process;
use formats::snapshot_datagram::{self, SnapshotRefusal};
use messages::{Counter, Counters};
use observations::SnapshotBlock;
use runtime::{HealthEntry, Now};

use crate::Processed;
use crate::channel::SourceChannel;
use crate::receiver::{DatagramReader, ReceiptTime};

/// Reader of datagrams of snapshots.
#[derive(Debug)]
pub(crate) struct Snapshots {
    channel: SourceChannel,
    /// The datagram that is being read; its memory is used again.
    block: SnapshotBlock,
    refused: Counters,
}

impl Snapshots {
    pub(crate) fn new(process: &Process, sources: &[Processed<'_>]) -> anyhow::Result<Self> {
        let source = *sources.first().context("no source is behind this receiver")?;
        Ok(Self {
            channel: SourceChannel::open(process, source)?,
            block: SnapshotBlock::default(),
            refused: Counters::default(),
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
        sources.push(self.channel.health(&self.refused));
    }
}
