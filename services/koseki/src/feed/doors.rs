//! Where lines come from: standard input, connections and datagrams, a thread each.

use std::io::{self, BufRead, BufReader, Read, Write};
use std::net::SocketAddr;
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};
use std::time::Duration;

use koseki_client::Error;
use koseki_client::observation::fault;
use messages::admission::Fault;
use net::{AllowedSenders, Door, DoorLimits, DoorRefusal, ReceiverCounters, ReceiverSettings, UdpReceiver};
use runtime::Now;
use serde_json::json;

use super::inlet::Inlets;

/// Longest line, bytes.
const LINE_MAX: usize = 1 << 16;
/// Pause after a connection that could not be accepted.
pub(super) const PAUSE: Duration = Duration::from_millis(100);
/// Longest wait for a datagram.
const PATIENCE: Duration = Duration::from_millis(100);

/// Means to end a connection from outside of its thread.
pub(super) struct Ending {
    stop: Box<dyn Fn() + Send + Sync>,
    reason: OnceLock<DoorRefusal>,
}

impl Ending {
    /// `stop` makes the thread of the connection look at the reason.
    pub(super) fn new(stop: impl Fn() + Send + Sync + 'static) -> Self {
        Self {
            stop: Box::new(stop),
            reason: OnceLock::new(),
        }
    }

    /// Ends the connection; its thread answers the reason.
    pub(super) fn end(&self, reason: DoorRefusal) {
        let _ = self.reason.set(reason);
        (self.stop)();
    }

    /// Returns why the connection ends.
    pub(super) fn reason(&self) -> Option<DoorRefusal> {
        self.reason.get().copied()
    }
}

/// State that all threads share.
pub(super) struct Shared {
    inlets: Mutex<Inlets>,
    /// Why nothing more can be fed.
    failure: Mutex<Option<Error>>,
    /// The connections, and their limits.
    door: Mutex<Door<Arc<Ending>>>,
    pub(super) limits: DoorLimits,
    /// Counts of the datagrams.
    pub(super) datagrams: Mutex<ReceiverCounters>,
}

pub(super) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Shared {
    pub(super) fn new(inlets: Inlets) -> Self {
        Self {
            inlets: Mutex::new(inlets),
            failure: Mutex::new(None),
            door: Mutex::new(Door::new(DoorLimits::OF_SENDERS)),
            limits: DoorLimits::OF_SENDERS,
            datagrams: Mutex::default(),
        }
    }

    pub(super) fn inlets(&self) -> MutexGuard<'_, Inlets> {
        lock(&self.inlets)
    }

    pub(super) fn door(&self) -> MutexGuard<'_, Door<Arc<Ending>>> {
        lock(&self.door)
    }

    /// Returns why nothing more can be fed, once.
    pub(super) fn failure(&self) -> Option<Error> {
        lock(&self.failure).take()
    }

    /// Takes a line; `None` if nothing more can be fed.
    fn take(&self, line: &[u8], received_ns: i64) -> Option<Option<Fault>> {
        self.kept(|inlets| inlets.take(line, received_ns))
    }

    fn kept<T>(&self, of: impl FnOnce(&mut Inlets) -> Result<T, Error>) -> Option<T> {
        match of(&mut lock(&self.inlets)) {
            Ok(value) => Some(value),
            Err(error) => {
                lock(&self.failure).get_or_insert(error);
                None
            }
        }
    }

    /// Feeds the lines of `reader` until the end; `answers` gets a line for each refused line. `goes_on` is asked after
    /// each line with content.
    ///
    /// # Errors
    /// If the reader or the writer fails.
    pub(super) fn feed(
        &self,
        reader: impl Read,
        answers: &mut impl Write,
        mut goes_on: impl FnMut() -> bool,
    ) -> io::Result<()> {
        let mut reader = BufReader::new(reader);
        let (mut line, mut number) = (Vec::new(), 0_u64);
        loop {
            line.clear();
            let taken = reader.by_ref().take(LINE_MAX as u64 + 1).read_until(b'\n', &mut line)?;
            if taken == 0 {
                break;
            }
            number += 1;
            if taken > LINE_MAX {
                let limit = format!("must be at most {LINE_MAX} octets long");
                let too_long = fault(
                    "line",
                    format!("{taken} octets or more"),
                    &limit,
                    "end each object by a line feed",
                );
                refuse(answers, number, &too_long)?;
                break;
            }
            if !line.trim_ascii().is_empty() {
                if !goes_on() {
                    break;
                }
                match self.take(&line, Now::read().utc_ns) {
                    None => return Ok(()),
                    Some(Some(fault)) => refuse(answers, number, &fault)?,
                    Some(None) => {}
                }
            }
            // The reader may wait for the rest of a line.
            if !reader.buffer().contains(&b'\n') && self.kept(Inlets::flush).is_none() {
                return Ok(());
            }
        }
        let _ = self.kept(Inlets::flush);
        Ok(())
    }

    /// Feeds the lines of the datagrams. Datagrams get no answer.
    fn feed_datagrams(&self, mut receiver: UdpReceiver) {
        loop {
            let received = receiver.receive(PATIENCE, |datagram| {
                for line in datagram.bytes.split(|octet| *octet == b'\n') {
                    if !line.trim_ascii().is_empty() {
                        // A refused line is counted, and the deployment gets a report.
                        self.take(line, datagram.received_utc_ns);
                    }
                }
            });
            let _ = self.kept(Inlets::flush);
            let counters = receiver.counters();
            let before = std::mem::replace(&mut *lock(&self.datagrams), counters);
            let mut inlets = self.inlets();
            inlets.note("sender", counters.refused_senders - before.refused_senders);
            inlets.note(
                "length",
                counters.oversized + counters.empty - before.oversized - before.empty,
            );
            inlets.note("buffer", counters.kernel_drops - before.kernel_drops);
            drop(inlets);
            if received.is_err() {
                std::thread::sleep(PAUSE);
            }
        }
    }
}

/// Writes the answer to a refused line; 0: to the whole connection.
pub(super) fn refuse(answers: &mut impl Write, line: u64, fault: &Fault) -> io::Result<()> {
    let Fault {
        field,
        value,
        limit,
        remedy,
    } = fault;
    let answer = json!({"line": line, "field": field, "value": value, "limit": limit, "remedy": remedy});
    answers.write_all(format!("{answer}\n").as_bytes())?;
    answers.flush()
}

/// Starts a thread.
pub(super) fn spawn(name: &str, work: impl FnOnce() + Send + 'static) -> io::Result<()> {
    std::thread::Builder::new()
        .name(name.to_owned())
        .spawn(work)
        .map(|_| ())
}

/// Receives datagrams at an address; returns the address.
pub(super) fn open_udp(
    shared: &Arc<Shared>,
    address: SocketAddr,
    senders: AllowedSenders,
) -> anyhow::Result<SocketAddr> {
    let receiver = UdpReceiver::open(&ReceiverSettings {
        allowed_senders: senders,
        ..ReceiverSettings::new(address.ip(), address.port())
    })?;
    let local = receiver.local_address();
    let shared = Arc::clone(shared);
    spawn("datagrams", move || shared.feed_datagrams(receiver))?;
    Ok(local)
}
