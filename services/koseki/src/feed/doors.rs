//! Where lines come from: standard input, connections and datagrams, a thread each.

use std::io::{self, BufRead, BufReader, Read, Write};
use std::net::{Shutdown, SocketAddr, TcpListener};
use std::os::unix::fs::{FileTypeExt as _, PermissionsExt as _};
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::Path;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering::Relaxed};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use koseki_client::Error;
use koseki_client::observation::fault;
use messages::admission::Fault;
use net::{AllowedSenders, ReceiverCounters, ReceiverSettings, UdpReceiver};
use runtime::Now;
use serde_json::json;

use super::inlet::{Inlets, Reasons};

/// Longest line, bytes.
const LINE_MAX: usize = 1 << 16;
/// Most simultaneous connections.
const CONNECTIONS_MAX: usize = 16;
/// Longest time for which a client may take no refusals, and longest silence of a client.
const WRITE_MAX: Duration = Duration::from_secs(5);
const SILENCE_MAX: Duration = Duration::from_secs(3600);
/// Pause after a connection that could not be accepted.
const PAUSE: Duration = Duration::from_millis(100);
/// Longest wait for a datagram.
const PATIENCE: Duration = Duration::from_millis(100);
/// Period of reports of refused datagrams, nanoseconds.
const REPORT_NS: i64 = 500_000_000;
/// Longest wait for the end of what a refused client sends, and reads of it.
const LINGER: Duration = Duration::from_millis(100);
const LINGERING_READS: usize = 8;

/// State that all threads share.
pub(super) struct Shared {
    inlets: Mutex<Inlets>,
    /// Why nothing more can be fed.
    failure: Mutex<Option<Error>>,
    connections: AtomicUsize,
    pub(super) accepted: AtomicU64,
    pub(super) refused_senders: AtomicU64,
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
            connections: AtomicUsize::new(0),
            accepted: AtomicU64::new(0),
            refused_senders: AtomicU64::new(0),
            datagrams: Mutex::default(),
        }
    }

    pub(super) fn inlets(&self) -> MutexGuard<'_, Inlets> {
        lock(&self.inlets)
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

    /// Feeds the lines of `reader` until its end; `answers` gets a line for each refused line.
    ///
    /// # Errors
    /// If the reader or the writer fails.
    pub(super) fn feed(&self, reader: impl Read, answers: &mut impl Write) -> io::Result<()> {
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

    /// Feeds the lines of the datagrams. Nobody is answered, so what is refused is reported to the deployment.
    fn feed_datagrams(&self, mut receiver: UdpReceiver) {
        let mut refused = Reasons::default();
        let mut reported_ns = Now::read().mono_ns;
        loop {
            let received = receiver.receive(PATIENCE, |datagram| {
                for line in datagram.bytes.split(|octet| *octet == b'\n') {
                    if !line.trim_ascii().is_empty()
                        && let Some(Some(fault)) = self.take(line, datagram.received_utc_ns)
                    {
                        refused.add(&fault.field, 1);
                    }
                }
            });
            let _ = self.kept(Inlets::flush);
            let counters = receiver.counters();
            let before = std::mem::replace(&mut *lock(&self.datagrams), counters);
            refused.add("sender", counters.refused_senders - before.refused_senders);
            refused.add(
                "length",
                counters.oversized + counters.empty - before.oversized - before.empty,
            );
            refused.add("buffer", counters.kernel_drops - before.kernel_drops);
            let now_ns = Now::read().mono_ns;
            if now_ns - reported_ns >= REPORT_NS {
                reported_ns = now_ns;
                lock(&self.inlets).report(&std::mem::take(&mut refused));
            }
            if received.is_err() {
                std::thread::sleep(PAUSE);
            }
        }
    }

    /// Takes a place for a connection; `false` if all are taken.
    fn enter(&self) -> bool {
        let entered = self
            .connections
            .fetch_update(Relaxed, Relaxed, |count| (count < CONNECTIONS_MAX).then_some(count + 1));
        entered.is_ok()
    }

    fn leave(&self) {
        self.connections.fetch_sub(1, Relaxed);
    }
}

/// Answers a connection for which there is no place. What the client has sent is read, for some time: a connection
/// closed before would lose the answer.
fn refuse_connection(mut stream: impl Read + Write, end: impl FnOnce() -> io::Result<()>) -> io::Result<()> {
    let limit = format!("must be at most {CONNECTIONS_MAX} connections at a time");
    let too_many = fault(
        "connection",
        CONNECTIONS_MAX + 1,
        &limit,
        "end another connection, send the lines of several sources by one, or start a further `koseki feed`",
    );
    refuse(&mut stream, 0, &too_many)?;
    end()?;
    let mut octets = [0; 4096];
    for _ in 0..LINGERING_READS {
        if stream.read(&mut octets)? == 0 {
            break;
        }
    }
    Ok(())
}

/// Writes the answer to a refused line; 0: to the whole connection.
fn refuse(answers: &mut impl Write, line: u64, fault: &Fault) -> io::Result<()> {
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

/// Serves a connection in a thread of its own.
fn serve<S: Read + Write + Send + 'static>(shared: &Arc<Shared>, stream: S, writer: S) {
    shared.accepted.fetch_add(1, Relaxed);
    let of_thread = Arc::clone(shared);
    let mut writer = writer;
    let serve = move || {
        // A connection that breaks off has ended.
        let _ = of_thread.feed(stream, &mut writer);
        of_thread.leave();
    };
    if std::thread::Builder::new()
        .name("connection".to_owned())
        .spawn(serve)
        .is_err()
    {
        shared.leave();
    }
}

fn spawn(name: &str, work: impl FnOnce() + Send + 'static) -> io::Result<()> {
    std::thread::Builder::new()
        .name(name.to_owned())
        .spawn(work)
        .map(|_| ())
}

/// Accepts connections at an address; returns the address.
pub(super) fn open_tcp(shared: &Arc<Shared>, address: SocketAddr, senders: AllowedSenders) -> io::Result<SocketAddr> {
    let listener = TcpListener::bind(address)?;
    let local = listener.local_addr()?;
    let shared = Arc::clone(shared);
    spawn("listener", move || {
        loop {
            let Ok((stream, peer)) = listener.accept() else {
                std::thread::sleep(PAUSE);
                continue;
            };
            if !senders.allow(peer.ip()) {
                shared.refused_senders.fetch_add(1, Relaxed);
                continue;
            }
            if !shared.enter() {
                // A client that does not read its answer loses it.
                let _ = stream
                    .set_write_timeout(Some(LINGER))
                    .and_then(|()| stream.set_read_timeout(Some(LINGER)))
                    .and_then(|()| refuse_connection(&stream, || stream.shutdown(Shutdown::Write)));
                continue;
            }
            let limited = stream
                .set_write_timeout(Some(WRITE_MAX))
                .and_then(|()| stream.set_read_timeout(Some(SILENCE_MAX)));
            match (limited, stream.try_clone()) {
                (Ok(()), Ok(writer)) => serve(&shared, stream, writer),
                _ => shared.leave(),
            }
        }
    })?;
    Ok(local)
}

/// Accepts connections at a Unix socket.
pub(super) fn open_unix(shared: &Arc<Shared>, path: &Path, mode: u32, group: Option<u32>) -> io::Result<()> {
    let is_socket = std::fs::symlink_metadata(path).is_ok_and(|found| found.file_type().is_socket());
    if is_socket && UnixStream::connect(path).is_err() {
        std::fs::remove_file(path)?;
    }
    let listener = UnixListener::bind(path)?;
    // In this order: until the last step only users permitted by the process's mask may connect.
    std::os::unix::fs::chown(path, None, group)?;
    std::fs::set_permissions(path, std::fs::Permissions::from_mode(mode))?;
    let shared = Arc::clone(shared);
    spawn("listener", move || {
        loop {
            let Ok((stream, _)) = listener.accept() else {
                std::thread::sleep(PAUSE);
                continue;
            };
            if !shared.enter() {
                let _ = stream
                    .set_write_timeout(Some(LINGER))
                    .and_then(|()| stream.set_read_timeout(Some(LINGER)))
                    .and_then(|()| refuse_connection(&stream, || stream.shutdown(Shutdown::Write)));
                continue;
            }
            let limited = stream.set_write_timeout(Some(WRITE_MAX));
            match (limited, stream.try_clone()) {
                (Ok(()), Ok(writer)) => serve(&shared, stream, writer),
                _ => shared.leave(),
            }
        }
    })
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
