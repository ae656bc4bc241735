//! The gate before a link's listener: connections that send nothing reach the listener never.
//!
//! Zenoh's listener processes failed handshakes in sequence, so that some thousand silent connections block all
//! others. The gate accepts at the configured endpoint, waits for the first byte, and only then forwards the
//! connection to Zenoh on loopback. Silent connections are limited in time and, for each address, in number; the
//! oldest is closed first. Active connections are limited for each address during their handshakes.

use std::collections::{HashMap, VecDeque};
use std::net::{IpAddr, Ipv4Addr, SocketAddr, TcpListener as StdListener, ToSocketAddrs as _};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

use anyhow::{Context as _, anyhow};
use tokio::io::copy_bidirectional;
use tokio::net::{TcpListener, TcpSocket, TcpStream};
use tokio::sync::{Notify, oneshot};
use tokio::time::timeout;

use crate::refused;

/// Time for the first byte, and for each handshake after it.
const PATIENCE: Duration = Duration::from_millis(1500);
/// Silent connections of one address at a time.
const SILENT_MAX: usize = 256;
/// Largest number of simultaneous handshakes of an address.
const BEGUN_MAX: usize = 128;
/// Time after its first byte during which a connection counts as a handshake.
const BEGINS: Duration = Duration::from_secs(3);
/// Connections that wait to be accepted.
const BACKLOG: u32 = 4096;

/// The gates of a link. They are open until this is dropped.
#[derive(Debug)]
pub(crate) struct Gates {
    end: Option<oneshot::Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl Gates {
    /// Opens a gate at each of these endpoints. Returns the endpoints at which Zenoh has to listen behind them.
    ///
    /// # Errors
    /// If an endpoint cannot be listened at.
    pub(crate) fn open(endpoints: &[String]) -> anyhow::Result<(Self, Vec<String>)> {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
        let mut behind = Vec::new();
        for endpoint in endpoints {
            let (protocol, place) = endpoint
                .split_once('/')
                .with_context(|| format!("{endpoint}: no endpoint"))?;
            let inner = free_port()?;
            let listener = {
                // Sockets belong to the runtime that is entered.
                let _entered = runtime.enter();
                listen(place).with_context(|| format!("listening at {endpoint}"))?
            };
            runtime.spawn(admit(listener, inner));
            behind.push(format!("{protocol}/{inner}"));
        }
        let (end, ends) = oneshot::channel();
        let thread = std::thread::Builder::new().name("gate".to_owned()).spawn(move || {
            // Its sender is dropped at the end.
            let _ = runtime.block_on(ends);
            runtime.shutdown_background();
        })?;
        let gates = Self {
            end: Some(end),
            thread: Some(thread),
        };
        Ok((gates, behind))
    }
}

impl Drop for Gates {
    fn drop(&mut self) {
        drop(self.end.take());
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// An address on loopback that was free a moment ago.
fn free_port() -> anyhow::Result<SocketAddr> {
    Ok(StdListener::bind((Ipv4Addr::LOCALHOST, 0))?.local_addr()?)
}

fn listen(place: &str) -> anyhow::Result<TcpListener> {
    let address = place.to_socket_addrs()?.next().ok_or_else(|| anyhow!("no address"))?;
    let socket = match address {
        SocketAddr::V4(_) => TcpSocket::new_v4()?,
        SocketAddr::V6(_) => TcpSocket::new_v6()?,
    };
    socket.set_reuseaddr(true)?;
    socket.bind(address)?;
    Ok(socket.listen(BACKLOG)?)
}

/// Connections of each address that are not through with their handshakes.
#[derive(Debug, Default)]
struct Addresses(HashMap<IpAddr, SilentConnections>);

#[derive(Debug, Default)]
struct SilentConnections {
    /// Silent connections, oldest first, each with the notification that closes it.
    silent: VecDeque<Arc<Notify>>,
    begun: usize,
}

type SharedAddresses = Arc<Mutex<Addresses>>;

fn lock(addresses: &SharedAddresses) -> MutexGuard<'_, Addresses> {
    addresses.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Addresses {
    /// Adds a connection. Returns the notification that closes it if later connections replace it.
    fn come(&mut self, from: IpAddr) -> Arc<Notify> {
        let pending = self.0.entry(from).or_default();
        if pending.silent.len() >= SILENT_MAX
            && let Some(oldest) = pending.silent.pop_front()
        {
            oldest.notify_one();
        }
        let end = Arc::new(Notify::new());
        pending.silent.push_back(Arc::clone(&end));
        end
    }

    /// A connection is silent no more: it has ended, or `speaks`. Returns whether the connection may begin.
    fn leave(&mut self, from: IpAddr, end: &Arc<Notify>, speaks: bool) -> bool {
        let pending = self.0.entry(from).or_default();
        pending.silent.retain(|silent| !Arc::ptr_eq(silent, end));
        let begins = speaks && pending.begun < BEGUN_MAX;
        pending.begun += usize::from(begins);
        self.forget(from);
        begins
    }

    /// The handshakes of a connection have had their time.
    fn begun(&mut self, from: IpAddr) {
        if let Some(pending) = self.0.get_mut(&from) {
            pending.begun = pending.begun.saturating_sub(1);
        }
        self.forget(from);
    }

    fn forget(&mut self, from: IpAddr) {
        if self
            .0
            .get(&from)
            .is_some_and(|pending| pending.silent.is_empty() && pending.begun == 0)
        {
            self.0.remove(&from);
        }
    }
}

/// Admits connections to Zenoh's listener at `inner`.
async fn admit(listener: TcpListener, inner: SocketAddr) {
    let addresses = SharedAddresses::default();
    loop {
        match listener.accept().await {
            Ok((connection, from)) => {
                tokio::spawn(pass(connection, from.ip(), inner, Arc::clone(&addresses)));
            }
            // The process has too many files open: some close soon.
            Err(_) => tokio::time::sleep(PATIENCE / 100).await,
        }
    }
}

/// Waits for the first byte of a connection, and passes the connection on.
async fn pass(mut outer: TcpStream, from: IpAddr, inner: SocketAddr, addresses: SharedAddresses) {
    let end = lock(&addresses).come(from);
    let mut first = [0];
    let speaks = tokio::select! {
        read = timeout(PATIENCE, outer.peek(&mut first)) => matches!(read, Ok(Ok(1))),
        () = end.notified() => false,
    };
    if !lock(&addresses).leave(from, &end, speaks) {
        refused::turn_away();
        return;
    }
    let counted = Arc::clone(&addresses);
    tokio::spawn(async move {
        tokio::time::sleep(BEGINS).await;
        lock(&counted).begun(from);
    });
    if let Ok(mut to) = TcpStream::connect(inner).await {
        let _ = (outer.set_nodelay(true), to.set_nodelay(true));
        // Whichever side ends, both are at their end.
        let _ = copy_bidirectional(&mut outer, &mut to).await;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HERE: IpAddr = IpAddr::V4(Ipv4Addr::LOCALHOST);
    const THERE: IpAddr = IpAddr::V4(Ipv4Addr::new(192, 0, 2, 1));

    #[test]
    fn silent_connections_of_an_address_are_bounded_and_the_oldest_gives_way() {
        let mut addresses = Addresses::default();
        let ends: Vec<_> = (0..SILENT_MAX + 3).map(|_| addresses.come(HERE)).collect();
        let other = addresses.come(THERE);
        assert_eq!(addresses.0[&HERE].silent.len(), SILENT_MAX);
        assert!(Arc::ptr_eq(&addresses.0[&HERE].silent[0], &ends[3]));
        assert!(addresses.leave(THERE, &other, true), "another address is not concerned");
        for end in &ends {
            assert!(!addresses.leave(HERE, end, false));
        }
        addresses.begun(THERE);
        assert!(addresses.0.is_empty());
    }

    #[test]
    fn connections_that_begin_are_bounded_for_each_address() {
        let mut addresses = Addresses::default();
        let begin = |addresses: &mut Addresses, from| {
            let end = addresses.come(from);
            addresses.leave(from, &end, true)
        };
        assert!((0..BEGUN_MAX).all(|_| begin(&mut addresses, HERE)));
        assert!(!begin(&mut addresses, HERE));
        assert!(begin(&mut addresses, THERE));
        addresses.begun(HERE);
        assert!(begin(&mut addresses, HERE));
    }
}
