//! ASTERIX in datagrams, and the sensors behind a socket.
//!
//! A control centre receives many radars on a single multicast group. Each data block names its sensor (system area
//! code and system identification code, the first item of every category). The block goes to the source of that sensor,
//! to be read with the source's configured editions. Blocks of unknown sensors, data that are no block, and datagrams
//! of senders outside the list are counted and skipped.

use anyhow::Context as _;
use asterix::{Decoder, StatedTables, blocks};
use deployment::{Asterix, Input, Source};
use formats::observation::{self, Reading};
use messages::Counter;
use net::BATCH_MAX;
use reception::Method;
use runtime::Process;
use runtime::{HealthEntry, Now};

use crate::Processed;
use crate::channel::SourceChannel;
use crate::counted::decoded;
use crate::misfits::{Misfits, Strangers};
use crate::receiver::{DatagramReader, ReceiptTime};
use crate::refusals::LatestRefusals;

/// Sources behind the socket, and counts of data without a source.
#[derive(Debug)]
pub(crate) struct BlockSources {
    /// SAC and SIC of each source; `None` takes the blocks of all other sensors.
    senders: Vec<Option<(u8, u8)>>,
    /// Reports of each source's sender that the source takes.
    methods: Vec<Method>,
    decoders: Vec<Decoder>,
    channels: Vec<SourceChannel>,
    misfits: Vec<Misfits>,
    /// Latest refusals of each source.
    refusals: Vec<LatestRefusals>,
    /// Latest refusals of data that belong to no source.
    unread: LatestRefusals,
    strangers: Strangers,
    blocks_rejected: u64,
    bytes_rejected: u64,
}

impl BlockSources {
    pub(crate) fn new(process: &Process, sources: &[Processed<'_>]) -> anyhow::Result<Self> {
        let mut all = Self {
            senders: Vec::new(),
            methods: Vec::new(),
            decoders: Vec::new(),
            channels: Vec::new(),
            misfits: Vec::new(),
            refusals: vec![LatestRefusals::default(); sources.len()],
            unread: LatestRefusals::default(),
            strangers: Strangers::default(),
            blocks_rejected: 0,
            bytes_rejected: 0,
        };
        for processed in sources {
            let (source, model) = (processed.source, &processed.reading().model);
            let asterix = asterix(source).context("a source of datagrams is live or simulated")?;
            let tables = StatedTables::new(&asterix.editions, asterix.is_strict);
            all.senders.push(source.sac_sic);
            all.methods.push(model.method);
            all.decoders.push(tables.decoder());
            all.misfits.push(Misfits::new(tables));
            all.channels.push(SourceChannel::open(process, *processed)?);
        }
        Ok(all)
    }
}

/// Returns the source of this sender, or else the source of all other senders.
fn find(senders: &[Option<(u8, u8)>], sender: Option<(u8, u8)>) -> Option<usize> {
    let of = |wanted| senders.iter().position(|sender| *sender == wanted);
    sender.and_then(|sender| of(Some(sender))).or_else(|| of(None))
}

/// Returns the sources with the same sender as the source in this place, which is the first: each takes other
/// reports.
fn of_sender(senders: &[Option<(u8, u8)>], first: usize) -> impl Iterator<Item = usize> {
    (first..senders.len()).filter(move |place| senders[*place] == senders[first])
}

fn refuse(refusals: &mut LatestRefusals, error: &asterix::Error, received: ReceiptTime) {
    refusals.note((error.label(), error.item().unwrap_or_default()), received, error);
}

fn asterix(source: &Source) -> Option<&Asterix> {
    match &source.input {
        Input::Live(live) | Input::Simulated(live) => Some(&live.asterix),
        Input::Recorded(_) | Input::External | Input::Tracker(_) => None,
    }
}

impl DatagramReader for BlockSources {
    fn take(&mut self, bytes: &[u8], received: ReceiptTime) -> anyhow::Result<()> {
        for block in blocks(bytes) {
            let Ok(block) = block.inspect_err(|error| {
                self.blocks_rejected += 1;
                refuse(&mut self.unread, error, received);
                self.bytes_rejected += (bytes.len() - error.offset()) as u64;
            }) else {
                break;
            };
            let sender = block.sender();
            let Some(index) = find(&self.senders, sender) else {
                self.strangers.hear(sender);
                continue;
            };
            self.channels[index].received(received)?;
            for record in self.decoders[index].block_records(block) {
                let record = match record {
                    Ok(record) => record,
                    Err(error) => {
                        // The rest of the block is skipped as well.
                        self.misfits[index].try_others(&block);
                        refuse(&mut self.refusals[index], &error, received);
                        continue;
                    }
                };
                match observation::read(&record) {
                    Reading::Target(observed) => {
                        // A block may contain reports of several sensors. A report of an unknown sensor goes to the
                        // block's own source, which rejects and counts the report.
                        let is_own = observed.sac_sic == sender;
                        let other = || find(&self.senders, observed.sac_sic).unwrap_or(index);
                        let first = if is_own { index } else { other() };
                        let admits = |place: &usize| self.methods[*place].admits(observed.secondary);
                        let mut places = of_sender(&self.senders, first).filter(admits).peekable();
                        if places.peek().is_none() {
                            self.channels[first].take(&observed, received.mono_ns)?;
                        }
                        for place in places {
                            self.channels[place].received(received)?;
                            self.channels[place].take(&observed, received.mono_ns)?;
                            if let Some(refused) = self.channels[place].take_refused_place() {
                                self.refusals[place].place(refused, received);
                            }
                        }
                    }
                    Reading::Service(service) => {
                        for place in of_sender(&self.senders, index) {
                            self.channels[place].service(&service, received.mono_ns)?;
                        }
                    }
                    Reading::Other => {}
                }
            }
        }
        Ok(())
    }

    fn publish(&mut self, count: usize, now: Now) -> anyhow::Result<()> {
        // A full batch leaves further datagrams in the socket.
        let elapsed = (count < BATCH_MAX).then(Now::read);
        for channel in &mut self.channels {
            channel.publish()?;
            if let Some(elapsed) = elapsed {
                // All data from the beginning of the turn have been taken, despite later arrivals.
                channel.silent(now.mono_ns)?;
                channel.elapsed(elapsed)?;
            }
        }
        Ok(())
    }

    fn health(&self, whole: &mut HealthEntry, sources: &mut Vec<HealthEntry>) {
        let decoders = self.decoders.iter().map(|decoder| decoded(decoder.counts()));
        let health = self
            .channels
            .iter()
            .zip(decoders)
            .zip(&self.misfits)
            .zip(&self.refusals);
        sources.extend(health.map(|(((channel, decoded), misfits), refusals)| {
            let mut entry = channel.health(&decoded);
            misfits.report(&mut entry);
            refusals.state(&mut entry);
            entry
        }));
        self.strangers.report(whole);
        self.unread.state(whole);
        whole.set(Counter::BlocksRejected, self.blocks_rejected);
        whole.set(Counter::BytesRejected, self.bytes_rejected);
    }
}
