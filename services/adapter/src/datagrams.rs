//! ASTERIX from the network: one socket, and the sensors behind it.
//!
//! A control centre receives many radars on one multicast group. Each data block says which sensor it is from (system
//! area code and system identification code, the first item of every category), so it is handed to the source of that
//! sensor and read by the editions that the source is configured with. What is from a sensor that no source has, what is
//! no block, what comes from a sender that is not on the list: counted, and passed over.
//!
//! Waiting for the next datagram is part of a turn, as the socket hands over what it has waited for. A report has come in
//! when the kernel took its datagram from the network; with that time begins its way through the stages, and by it the
//! sensor's time of day is judged.

use std::net::{IpAddr, SocketAddr};
use std::time::Duration;

use anyhow::Context as _;
use asterix::{Counts, Decoder, blocks};
use configuration::{Asterix, Input, Process, Source};
use messages::{Counter, Counters};
use net::{ReceiverSettings, UdpReceiver};
use reception::observation::{self, Reading};
use runtime::{Agent, HealthEntry, Now, Turn};

use crate::channel::Channel;

/// Longest wait for a datagram in one turn: health messages must be said, and a stop be heard.
const PATIENCE: Duration = Duration::from_millis(50);

/// The agent of a receiver of datagrams.
#[derive(Debug)]
pub(crate) struct Datagrams {
    receiver: UdpReceiver,
    sources: Sources,
}

/// The sources behind the socket, and what could not be given to one of them.
#[derive(Debug)]
struct Sources {
    /// For each source its SAC and SIC; `None` takes what no other source has.
    senders: Vec<Option<(u8, u8)>>,
    decoders: Vec<Decoder>,
    channels: Vec<Channel>,
    strangers: u64,
    blocks_refused: u64,
    bytes_refused: u64,
}

impl Datagrams {
    pub(crate) fn new(process: &Process, settings: &ReceiverSettings, sources: &[&Source]) -> anyhow::Result<Self> {
        let receiver = UdpReceiver::open(settings).with_context(|| {
            let address = SocketAddr::new(settings.address, settings.port);
            format!("receiving at {address}")
        })?;
        let mut all = Sources {
            senders: Vec::new(),
            decoders: Vec::new(),
            channels: Vec::new(),
            strangers: 0,
            blocks_refused: 0,
            bytes_refused: 0,
        };
        for source in sources {
            let asterix = asterix(source).context("a source of datagrams is live or simulated")?;
            all.senders.push(source.model.sac_sic);
            all.decoders.push(asterix.decoder());
            all.channels.push(Channel::open(process, source)?);
        }
        Ok(Self { receiver, sources: all })
    }

    /// The receiver of a simulated source, at `port` of the deployment's own loopback address.
    pub(crate) fn loopback(process: &Process, port: u16, sources: &[&Source]) -> anyhow::Result<Self> {
        let address = IpAddr::V4(process.loopback);
        Self::new(process, &ReceiverSettings::new(address, port), sources)
    }
}

fn asterix(source: &Source) -> Option<&Asterix> {
    match &source.input {
        Input::Live(live) => Some(&live.asterix),
        Input::Simulated(simulated) => Some(&simulated.live.asterix),
        Input::Recorded(_) | Input::External => None,
    }
}

impl Sources {
    /// Takes the data blocks of a datagram.
    fn take(&mut self, bytes: &[u8], received_ns: i64, ingested_ns: i64) -> anyhow::Result<()> {
        for block in blocks(bytes) {
            let Ok(block) = block.inspect_err(|error| {
                self.blocks_refused += 1;
                self.bytes_refused += (bytes.len() - error.offset()) as u64;
            }) else {
                break;
            };
            let Some(index) = self.find(block.sender()) else {
                self.strangers += 1;
                continue;
            };
            for record in self.decoders[index].records(block.bytes).flatten() {
                match observation::read(&record) {
                    Reading::Target(observed) => {
                        // A block may hold reports of several sensors. That of a stranger goes to the block's own, which
                        // refuses and counts it.
                        let own = find(&self.senders, observed.sac_sic).unwrap_or(index);
                        let channel = &mut self.channels[own];
                        channel.received(received_ns);
                        channel.take(&observed, ingested_ns)?;
                    }
                    Reading::Service(service) => {
                        self.channels[index].received(received_ns);
                        self.channels[index].service(&service, ingested_ns)?;
                    }
                    Reading::Other => {}
                }
            }
        }
        Ok(())
    }

    fn find(&self, sender: Option<(u8, u8)>) -> Option<usize> {
        find(&self.senders, sender)
    }
}

/// The source of this sender, or else the one that takes everyone's.
fn find(senders: &[Option<(u8, u8)>], sender: Option<(u8, u8)>) -> Option<usize> {
    let of = |wanted| senders.iter().position(|sender| *sender == wanted);
    sender.and_then(|sender| of(Some(sender))).or_else(|| of(None))
}

impl Agent for Datagrams {
    fn turn(&mut self, now: Now) -> anyhow::Result<Turn> {
        let (receiver, sources) = (&mut self.receiver, &mut self.sources);
        let to_mono_ns = now.mono_ns - now.utc_ns;
        let mut failed = Ok(());
        receiver.receive(PATIENCE, |datagram| {
            let received_ns = datagram.received_utc_ns;
            let taken = sources.take(datagram.bytes, received_ns, received_ns + to_mono_ns);
            if failed.is_ok() {
                failed = taken;
            }
        })?;
        failed?;
        sources.channels.iter_mut().try_for_each(Channel::publish)?;
        Ok(Turn::Worked)
    }

    fn health(&self, entries: &mut Vec<HealthEntry>) {
        let sources = &self.sources;
        let decoded = sources.decoders.iter().map(|decoder| decoded(decoder.counts()));
        let each: Vec<HealthEntry> = sources
            .channels
            .iter()
            .zip(decoded)
            .map(|(channel, decoded)| channel.health(&decoded))
            .collect();
        let mut whole = HealthEntry {
            progress_ns: each.iter().map(|entry| entry.progress_ns).max().unwrap_or(i64::MIN),
            note: self.receiver.warning().unwrap_or_default().to_owned(),
            ..HealthEntry::default()
        };
        for counter in [Counter::Records, Counter::Reports, Counter::Published] {
            whole.set(counter, each.iter().map(|entry| entry.counters[counter]).sum());
        }
        let counted = self.receiver.counters();
        whole.set(Counter::Datagrams, counted.datagrams);
        whole.set(Counter::DatagramsRejected, counted.refused_senders);
        whole.set(
            Counter::DatagramsRejectedLength,
            counted.empty + counted.oversized + counted.unstamped,
        );
        whole.set(Counter::DatagramsDropped, counted.kernel_drops);
        whole.set(Counter::RejectedSource, sources.strangers);
        whole.set(Counter::BlocksRejected, sources.blocks_refused);
        whole.set(Counter::BytesRejected, sources.bytes_refused);
        entries.push(whole);
        entries.extend(each);
    }
}

/// What a decoder has counted, indexed by [`Counter`].
fn decoded(counts: &Counts) -> Counters {
    let mut counters = Counters::default();
    counters[Counter::Records] = counts.records;
    counters[Counter::BytesRejected] = counts.octets_skipped;
    counters[Counter::BlocksRejected] = counts.blocks_refused + counts.blocks_cut + counts.blocks_without_table;
    counters
}
