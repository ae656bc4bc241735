//! SBS-1 (BaseStation) from a server on the network: a connection, and its source.
//!
//! A server may start later, end and return; a lost connection is made again. The time of receipt of a line is the time
//! of the read, since TCP has no time stamps.

use std::net::{Ipv4Addr, Ipv6Addr, SocketAddr};
use std::time::Duration;

use anyhow::Context as _;
use formats::sbs::{AircraftMerger, SbsSettings};
use messages::Counter;
use net::{LinesSettings, TcpLines};
use runtime::Process;
use runtime::clock::SteadyClock;
use runtime::{Agent, HealthEntry, Now, Turn};

use crate::Processed;
use crate::capture::Capture;
use crate::channel::SourceChannel;
use crate::counted::merged;
use crate::receiver::ReceiptTime;
use crate::refusals::LatestRefusals;

/// Longest wait for a line in a turn, bounded by health messages and stop requests.
const PATIENCE: Duration = Duration::from_millis(50);

/// Agent of a receiver of lines.
#[derive(Debug)]
pub(crate) struct LineAgent {
    client: TcpLines,
    capture: Option<Capture>,
    merger: AircraftMerger,
    channel: SourceChannel,
    server: SocketAddr,
    steady: SteadyClock,
    refusals: LatestRefusals,
}

impl LineAgent {
    pub(crate) fn new(
        process: &Process,
        server: SocketAddr,
        settings: SbsSettings,
        sources: &[Processed<'_>],
    ) -> anyhow::Result<Self> {
        let source = *sources.first().context("no source is behind this receiver")?;
        Ok(Self {
            client: TcpLines::new(LinesSettings::new(server))?,
            // The readers are unknown here.
            capture: Capture::open(
                process,
                SocketAddr::new(
                    match server {
                        SocketAddr::V4(_) => Ipv4Addr::UNSPECIFIED.into(),
                        SocketAddr::V6(_) => Ipv6Addr::UNSPECIFIED.into(),
                    },
                    0,
                ),
            )?,
            merger: AircraftMerger::new(settings),
            channel: SourceChannel::open(process, source)?,
            server,
            steady: SteadyClock::of(Now::read()),
            refusals: LatestRefusals::default(),
        })
    }
}

impl Agent for LineAgent {
    fn turn(&mut self, now: Now) -> anyhow::Result<Turn> {
        let (merger, channel, refusals) = (&mut self.merger, &mut self.channel, &mut self.refusals);
        let (capture, server, steady) = (&mut self.capture, self.server, self.steady);
        let mut failed = Ok(());
        self.client.poll(now.mono_ns, PATIENCE, |line| {
            let read = Now::read();
            let received = ReceiptTime::of(read.utc_ns, read, steady);
            if let Some(capture) = capture {
                capture.take(server, read.utc_ns, line);
            }
            let observed = match merger.take(line, read.utc_ns) {
                Ok(Some(observed)) => observed,
                Ok(None) => return,
                // A rejected line is counted by reason.
                Err(error) => {
                    refusals.note((error.rejection.sentence(), ""), received, error);
                    return;
                }
            };
            let taken = channel
                .received(received)
                .and_then(|()| channel.take(&observed, read.mono_ns));
            if let Some(place) = channel.take_refused_place() {
                refusals.place(place, received);
            }
            if failed.is_ok() {
                failed = taken;
            }
        });
        failed?;
        let too_long = self.client.counters().oversized;
        self.refusals.too_long(too_long, || {
            let read = Now::read();
            ReceiptTime::of(read.utc_ns, read, steady)
        });
        self.channel.publish()?;
        if let Some(capture) = &mut self.capture {
            capture.hand_over();
        }
        Ok(Turn::Worked)
    }

    fn health(&self, entries: &mut Vec<HealthEntry>) {
        let (mut decoded, lines) = (merged(&self.merger), self.client.counters());
        decoded[Counter::BlocksRejected] += lines.oversized;
        let mut of_source = self.channel.health(&decoded);
        self.refusals.state(&mut of_source);
        let mut whole = HealthEntry {
            progress_ns: of_source.progress_ns,
            ..HealthEntry::default()
        };
        whole.add_sources(std::slice::from_ref(&of_source));
        whole.set(Counter::Connections, lines.connections);
        if !self.client.is_connected() {
            whole.note = format!("not connected to {}", self.server);
        }
        if let Some(capture) = &self.capture {
            capture.count(&mut whole);
        }
        entries.push(whole);
        entries.push(of_source);
    }
}
