//! Connections of feeders: a thread each, behind a [`Door`](net::Door).

use std::io::{self, Read, Write};
use std::net::{Shutdown, SocketAddr, TcpListener, TcpStream};
use std::os::unix::fs::{FileTypeExt as _, PermissionsExt as _};
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};
use std::time::Duration;

use koseki_client::observation::fault;
use messages::admission::Fault;
use net::{AllowedSenders, DoorCounters, DoorLimits, DoorNews, DoorRefusal, Peer};
use runtime::Now;

use super::doors::{Ending, PAUSE, Shared, refuse, spawn};

/// Longest time for which a client may take no refusals.
const WRITE_MAX: Duration = Duration::from_secs(5);
/// Longest wait for the end of a refused client's data, and number of reads of these data.
const LINGER: Duration = Duration::from_millis(100);
const LINGERING_READS: usize = 8;
/// Maximum number of refused clients with such a wait at a time; further refused clients are closed at once.
const LINGERING_MAX: usize = 16;

/// Connection of a feeder.
pub(super) trait Connection: Read + Write + Send + Sync + Sized + 'static {
    fn second(&self) -> io::Result<Self>;
    fn limit(&self, read: Option<Duration>, write: Duration) -> io::Result<()>;
    fn end(&self, how: Shutdown) -> io::Result<()>;
}

macro_rules! connection {
    ($stream:ty) => {
        impl Connection for $stream {
            fn second(&self) -> io::Result<Self> {
                self.try_clone()
            }

            fn limit(&self, read: Option<Duration>, write: Duration) -> io::Result<()> {
                self.set_read_timeout(read)?;
                self.set_write_timeout(Some(write))
            }

            fn end(&self, how: Shutdown) -> io::Result<()> {
                self.shutdown(how)
            }
        }
    };
}
connection!(TcpStream);
connection!(UnixStream);

/// Means to stop the reads of a connection's thread, which then answers and ends.
fn ending_of(stream: impl Connection) -> Ending {
    Ending::new(move || _ = stream.end(Shutdown::Read))
}

/// The fault of a whole connection.
fn fault_of(reason: DoorRefusal, limits: &DoorLimits) -> Fault {
    let first_s = limits.first.unwrap_or_default().as_secs();
    let (limit, remedy) = match reason {
        DoorRefusal::Silent => (
            format!("must send a first line within {first_s} s"),
            "connect when there is a line to send".to_owned(),
        ),
        DoorRefusal::GaveWay => (
            "must send a line before others need the place".to_owned(),
            "connect when there is a line to send".to_owned(),
        ),
        DoorRefusal::Idle => (
            format!(
                "must send a line every {} s, or every {} s while places are short",
                limits.idle.as_secs(),
                limits.yields.as_secs()
            ),
            "connect again".to_owned(),
        ),
        DoorRefusal::Address | DoorRefusal::Full | DoorRefusal::Sender | DoorRefusal::Slow => (
            format!(
                "must be at most {} connections at a time, {} of them from one address",
                limits.connections_max, limits.address_max
            ),
            "end another connection, send the lines of several sources by one, or start a further `koseki feed`"
                .to_owned(),
        ),
    };
    fault("connection", reason.word(), &limit, remedy)
}

/// Answers a connection for which there is no place. The client's data are read, for some time: a connection closed
/// before would lose the answer.
fn refuse_connection(mut stream: impl Connection, fault: &Fault) -> io::Result<()> {
    stream.limit(Some(LINGER), LINGER)?;
    refuse(&mut stream, 0, fault)?;
    stream.end(Shutdown::Write)?;
    let mut octets = [0; 4096];
    for _ in 0..LINGERING_READS {
        if stream.read(&mut octets)? == 0 {
            break;
        }
    }
    Ok(())
}

/// Serves an admitted connection until the end.
fn serve(shared: &Shared, ticket: net::Ticket, stream: impl Connection, mut writer: impl Connection, ending: &Ending) {
    let goes_on = || {
        shared.door().heard(ticket, Now::read().mono_ns);
        ending.reason().is_none()
    };
    // A connection that breaks off has ended.
    let _ = shared.feed(stream, &mut writer, goes_on);
    shared.door().leave(ticket);
    if let Some(reason) = ending.reason() {
        let _ = refuse(&mut writer, 0, &fault_of(reason, &shared.limits));
    }
    // The `ending` may hold the connection open for a moment longer.
    let _ = writer.end(Shutdown::Both);
}

/// Admits a connection and starts its thread, or refuses the connection.
fn receive(shared: &Arc<Shared>, lingering: &Arc<AtomicUsize>, stream: impl Connection, peer: Peer) -> io::Result<()> {
    stream.limit(None, WRITE_MAX)?;
    let (writer, ending) = (stream.second()?, Arc::new(ending_of(stream.second()?)));
    let admitted = shared.door().admit(peer, Now::read().mono_ns, Arc::clone(&ending));
    match admitted {
        Ok(admitted) => {
            if let Some((reason, other)) = admitted.instead_of {
                other.end(reason);
            }
            let of_thread = Arc::clone(shared);
            let work = move || serve(&of_thread, admitted.ticket, stream, writer, &ending);
            let started = spawn("connection", work);
            if started.is_err() {
                shared.door().leave(admitted.ticket);
            }
            started
        }
        Err((reason, _)) => {
            let fault = fault_of(reason, &shared.limits);
            if lingering.fetch_add(1, Relaxed) >= LINGERING_MAX {
                lingering.fetch_sub(1, Relaxed);
                return Ok(());
            }
            let of_thread = Arc::clone(lingering);
            let started = spawn("refusal", move || {
                // A client that does not read the answer loses the answer.
                let _ = refuse_connection(stream, &fault);
                of_thread.fetch_sub(1, Relaxed);
            });
            if started.is_err() {
                lingering.fetch_sub(1, Relaxed);
            }
            started
        }
    }
}

/// Accepts connections in a separate thread.
fn accept_all<S: Connection>(
    shared: &Arc<Shared>,
    senders: AllowedSenders,
    accept: impl Fn() -> io::Result<(S, Peer)> + Send + 'static,
) -> io::Result<()> {
    let (shared, lingering) = (Arc::clone(shared), Arc::default());
    spawn("listener", move || {
        loop {
            let Ok((stream, peer)) = accept() else {
                std::thread::sleep(PAUSE);
                continue;
            };
            if peer.0.is_some_and(|address| !senders.allow(address.ip())) {
                shared.door().refuse(peer, DoorRefusal::Sender);
                continue;
            }
            // The process may be short of files or threads, until others end.
            if receive(&shared, &lingering, stream, peer).is_err() {
                std::thread::sleep(PAUSE);
            }
        }
    })
}

/// Looks after the connections: ends silent ones, and reports refused ones and refused lines.
#[derive(Debug, Default)]
pub(super) struct Doorkeeper {
    news: DoorNews,
    /// Counts that the inlets have.
    noted: DoorCounters,
}

impl Doorkeeper {
    /// To be called now and then, with the monotonic time.
    pub(super) fn look(&mut self, shared: &Shared, now_ns: i64) {
        let expired = shared.door().expired(now_ns);
        for (reason, ending) in expired {
            ending.end(reason);
        }
        let counters = shared.door().counters();
        if self.news.is_due(&counters, now_ns) {
            runtime::notice(format_args!("koseki feed: connections refused or ended: {counters}"));
        }
        let mut inlets = shared.inlets();
        for (reason, count) in counters.reasons() {
            // A feeder that has nothing to send for long is no fault.
            if reason != DoorRefusal::Idle {
                let name = format!("connection {}", reason.word());
                inlets.note(&name, count - self.noted.refused(reason));
            }
        }
        self.noted = counters;
        inlets.report(now_ns);
    }
}

/// Accepts connections at an address; returns the address.
pub(super) fn open_tcp(shared: &Arc<Shared>, address: SocketAddr, senders: AllowedSenders) -> io::Result<SocketAddr> {
    let listener = TcpListener::bind(address)?;
    let local = listener.local_addr()?;
    accept_all(shared, senders, move || {
        let (stream, peer) = listener.accept()?;
        Ok((stream, Peer(Some(peer))))
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
    accept_all(shared, AllowedSenders::default(), move || {
        let (stream, _) = listener.accept()?;
        Ok((stream, Peer(None)))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_answer_to_a_refused_client_outlasts_the_lines_that_it_has_sent() {
        let (mut client, server) = UnixStream::pair().unwrap();
        client.write_all(&[b'x'; 10_000]).unwrap();
        client.shutdown(Shutdown::Write).unwrap();
        // The end of a socket with unread data resets the connection.
        refuse_connection(server, &fault_of(DoorRefusal::Full, &DoorLimits::OF_SENDERS)).unwrap();
        let mut answer = String::new();
        client.read_to_string(&mut answer).unwrap();
        assert!(answer.contains("at most 64 connections"), "{answer}");
    }
}
