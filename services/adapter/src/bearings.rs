//! Bearings, arrival times and fixes in datagrams (FM-7, FM-11, or ASTERIX of category 205), and the direction finder
//! or network of receivers behind the socket.
//!
//! A datagram is a table or consists of data blocks of ASTERIX. The first octet decides: a block of category 205 begins
//! with 205, which begins no text.

use anyhow::Context as _;
use asterix::{Decoder, StatedTables, blocks};
use deployment::{Asterix, Input};
use formats::emitter_rows_csv::EmitterRowReader;
use formats::observation::FinderReports;
use formats::plane::Plane;
use messages::Counter;
use runtime::Process;
use runtime::{HealthEntry, Now};

use crate::Processed;
use crate::channel::SourceChannel;
use crate::counted::decoded;
use crate::finder::{finder_reports, in_words};
use crate::receiver::{DatagramReader, ReceiptTime};
use crate::tables::{TableCounts, utc_ns};

/// First octet of a data block of category 205.
const CATEGORY_205: u8 = 205;

/// Reader of measurements of emitters.
#[derive(Debug)]
pub(crate) struct Bearings {
    channel: SourceChannel,
    /// The plane of the deployment.
    plane: Plane,
    tables: TableCounts,
    reports: Option<FinderReports>,
    decoder: Decoder,
    bytes_rejected: u64,
    blocks_rejected: u64,
}

impl Bearings {
    pub(crate) fn new(process: &Process, sources: &[Processed<'_>]) -> anyhow::Result<Self> {
        let source = *sources.first().context("no source is behind this receiver")?;
        let stated = match &source.source.input {
            Input::Live(live) => live.asterix.clone(),
            _ => Asterix::default(),
        };
        Ok(Self {
            channel: SourceChannel::open(process, source)?,
            plane: Plane::Given(process.config.frame),
            tables: TableCounts::default(),
            reports: finder_reports(source.source, source.reading()),
            decoder: StatedTables::new(&stated.editions, stated.is_strict).decoder(),
            bytes_rejected: 0,
            blocks_rejected: 0,
        })
    }

    /// Takes data blocks.
    fn take_blocks(&mut self, bytes: &[u8], received: ReceiptTime) -> anyhow::Result<()> {
        let Some(reports) = &mut self.reports else {
            return Ok(());
        };
        for block in blocks(bytes) {
            let block = match block {
                Ok(block) => block,
                Err(error) => {
                    self.blocks_rejected += 1;
                    self.bytes_rejected += (bytes.len() - error.offset()) as u64;
                    self.tables.note((error.label(), ""), received, error);
                    break;
                }
            };
            for record in self.decoder.block_records(block) {
                let record = match record {
                    Ok(record) => record,
                    Err(error) => {
                        let reason = (error.label(), error.item().unwrap_or_default());
                        self.tables.note(reason, received, error);
                        continue;
                    }
                };
                match reports.take(&record, Some(received.utc_ns), 0) {
                    Ok(Some(measured)) => self.channel.emitter(&measured, received.mono_ns)?,
                    Ok(None) => {}
                    Err(refusal) => {
                        let said = in_words(refusal);
                        self.tables.note((refusal.label(), ""), received, said);
                    }
                }
            }
        }
        Ok(())
    }
}

impl DatagramReader for Bearings {
    fn take(&mut self, bytes: &[u8], received: ReceiptTime) -> anyhow::Result<()> {
        self.channel.received(received)?;
        if bytes.first() == Some(&CATEGORY_205) {
            return self.take_blocks(bytes, received);
        }
        let plane = self.plane;
        let open = |bytes, first_day_ns| Ok(EmitterRowReader::new(bytes, first_day_ns)?.placed_in(plane));
        for measured in self.tables.rows(bytes, received, open) {
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
        let mut counted = decoded(self.decoder.counts());
        if let Some(reports) = &self.reports {
            counted += reports.counters();
        }
        counted[Counter::BlocksRejected] += self.blocks_rejected;
        counted[Counter::BytesRejected] += self.bytes_rejected;
        let mut of_source = self.channel.health(&counted);
        self.tables.count(&mut of_source);
        sources.push(of_source);
    }
}
