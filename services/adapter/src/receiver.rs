//! Datagrams from the network: a socket and its reader.
//!
//! The wait for the next datagram is part of a turn, since the socket returns the datagram. The time of receipt is the
//! time at which the kernel took the datagram from the network. The stages of a report begin with this time, and the
//! sensor's time of day is checked against this time.

use std::fmt::Debug;
use std::net::IpAddr;
use std::time::Duration;

use deployment::ReceiverTransport;
use messages::Counter;
use net::{ReceiverSettings, UdpReceiver};
use runtime::Process;
use runtime::clock::SteadyClock;
use runtime::{Agent, HealthEntry, Now, Turn};

use crate::capture::Capture;

/// Longest wait for a datagram in a turn, bounded by health messages and stop requests.
const PATIENCE: Duration = Duration::from_millis(50);
/// Longest time of a datagram in the kernel, nanoseconds; a stamp farther from the present belongs to a UTC before a
/// step of the clock.
const WAITED_MAX_NS: i64 = 10_000_000_000;

/// Reader of datagrams and publisher of the contents.
pub(crate) trait DatagramReader: Debug {
    /// Takes a datagram.
    fn take(&mut self, bytes: &[u8], received: ReceiptTime) -> anyhow::Result<()>;

    /// Publishes the results of the `count` datagrams of a turn.
    fn publish(&mut self, count: usize, now: Now) -> anyhow::Result<()>;

    /// Returns the health of the receiver apart from the socket, and of each source behind the receiver.
    fn health(&self, whole: &mut HealthEntry, sources: &mut Vec<HealthEntry>);

    /// Returns the same, with the sources summed up in the receiver's entry.
    fn summed_health(&self) -> (HealthEntry, Vec<HealthEntry>) {
        let (mut whole, mut sources) = (HealthEntry::default(), Vec::new());
        self.health(&mut whole, &mut sources);
        if let Some(progress_ns) = sources.iter().map(|source| source.progress_ns).max() {
            whole.progress_ns = progress_ns;
        }
        whole.add_sources(&sources);
        (whole, sources)
    }
}

/// Time of receipt of a datagram, nanoseconds.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ReceiptTime {
    /// UTC of the machine.
    pub(crate) utc_ns: i64,
    /// Monotonic.
    pub(crate) mono_ns: i64,
    /// UTC without steps during the life of the process.
    pub(crate) steady_ns: i64,
}

impl ReceiptTime {
    /// Returns the time of receipt at `utc_ns` of the machine's clock, which shows `now`.
    pub(crate) fn of(utc_ns: i64, now: Now, steady: SteadyClock) -> Self {
        let waited_ns = now.utc_ns.saturating_sub(utc_ns);
        let is_possible = (-WAITED_MAX_NS..=WAITED_MAX_NS).contains(&waited_ns);
        let mono_ns = now.mono_ns - if is_possible { waited_ns } else { 0 };
        Self {
            utc_ns,
            mono_ns,
            steady_ns: steady.utc_ns(mono_ns),
        }
    }
}

/// Agent of a receiver of datagrams.
#[derive(Debug)]
pub(crate) struct DatagramAgent<D> {
    socket: UdpReceiver,
    capture: Option<Capture>,
    reader: D,
    steady: SteadyClock,
}

impl<D: DatagramReader> DatagramAgent<D> {
    pub(crate) fn open(process: &Process, transport: &ReceiverTransport, reader: D) -> anyhow::Result<Self> {
        let settings = match transport {
            ReceiverTransport::Udp(input) => {
                let interface = input.interface.as_deref();
                ReceiverSettings::stated(input.listen, interface, &input.senders, input.buffer_bytes)?
            }
            // A simulated sensor sends to the deployment's own loopback address.
            ReceiverTransport::Loopback { port } => ReceiverSettings::new(IpAddr::V4(process.loopback), *port),
            ReceiverTransport::Rows { .. } | ReceiverTransport::Feed(_) => {
                anyhow::bail!("a receiver of rows or of a feed has no agent of datagrams")
            }
        };
        let socket = UdpReceiver::open(&settings)?;
        let capture = Capture::open(process, socket.local_address())?;
        Ok(Self {
            socket,
            capture,
            reader,
            steady: SteadyClock::of(Now::read()),
        })
    }
}

impl<D: DatagramReader> Agent for DatagramAgent<D> {
    fn turn(&mut self, now: Now) -> anyhow::Result<Turn> {
        let (socket, capture, reader) = (&mut self.socket, &mut self.capture, &mut self.reader);
        let steady = self.steady;
        let mut failed = Ok(());
        let count = socket.receive(PATIENCE, |datagram| {
            let utc_ns = datagram.received_utc_ns;
            if let Some(capture) = capture {
                capture.take(datagram.sender, utc_ns, datagram.bytes);
            }
            let taken = reader.take(datagram.bytes, ReceiptTime::of(utc_ns, now, steady));
            if failed.is_ok() {
                failed = taken;
            }
        })?;
        failed?;
        reader.publish(count, now)?;
        if let Some(capture) = capture {
            capture.hand_over();
        }
        Ok(Turn::Worked)
    }

    fn health(&self, entries: &mut Vec<HealthEntry>) {
        let (mut whole, sources) = self.reader.summed_health();
        whole.note = self.socket.warning().unwrap_or_default().to_owned();
        let counted = self.socket.counters();
        whole.set(Counter::Datagrams, counted.datagrams);
        whole.set(Counter::DatagramsRejected, counted.refused_senders);
        whole.set(
            Counter::DatagramsRejectedLength,
            counted.empty + counted.oversized + counted.unstamped,
        );
        whole.set(Counter::DatagramsDropped, counted.kernel_drops);
        if let Some(capture) = &self.capture {
            capture.count(&mut whole);
        }
        entries.push(whole);
        entries.extend(sources);
    }
}
