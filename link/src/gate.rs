//! The gate before a link's listener: connections that send nothing reach the listener never.
//!
//! Zenoh's listener processes failed handshakes in sequence, so that some thousand silent connections block all
//! others. The gate accepts at the configured endpoint, waits for the first byte, and only then forwards the
//! connection to Zenoh on loopback. Silent connections are limited in time and number by a [`Door`]: the oldest is
//! closed first. A second door limits the connections that are in their handshakes.

use std::net::{Ipv4Addr, SocketAddr, TcpListener as StdListener, ToSocketAddrs as _};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

use anyhow::{Context as _, anyhow};
use net::{Door, DoorLimits, Peer};
use runtime::clock::mono_ns;
use tokio::io::copy_bidirectional;
use tokio::net::{TcpListener, TcpSocket, TcpStream};
use tokio::sync::{Notify, oneshot};
use tokio::time::timeout;

use crate::refused;

/// Time for the first byte, and for each handshake after it.
const PATIENCE: Duration = Duration::from_millis(1500);
/// Limits of silent connections.
const SILENT: DoorLimits = DoorLimits {
    connections_max: 4096,
    address_max: 256,
    first: Some(PATIENCE),
    yields: PATIENCE,
    idle: PATIENCE,
};
/// Limits of connections in their handshakes: none gives way.
const BEGUN: DoorLimits = DoorLimits {
    connections_max: 1024,
    address_max: 128,
    first: None,
    ..SILENT
};
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

/// Connections that are not through with their handshakes.
#[derive(Debug)]
struct Doors {
    /// Silent connections, each with the notification that closes it.
    silent: Door<Arc<Notify>>,
    begun: Door<()>,
}

fn lock(doors: &Mutex<Doors>) -> MutexGuard<'_, Doors> {
    doors.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Admits connections to Zenoh's listener at `inner`.
async fn admit(listener: TcpListener, inner: SocketAddr) {
    let doors = Arc::new(Mutex::new(Doors {
        silent: Door::new(SILENT),
        begun: Door::new(BEGUN),
    }));
    loop {
        match listener.accept().await {
            Ok((connection, from)) => {
                tokio::spawn(pass(connection, Peer(Some(from)), inner, Arc::clone(&doors)));
            }
            // The process has too many files open: some close soon.
            Err(_) => tokio::time::sleep(PATIENCE / 100).await,
        }
    }
}

/// Waits for the first byte of a connection, and passes the connection on.
async fn pass(mut outer: TcpStream, from: Peer, inner: SocketAddr, doors: Arc<Mutex<Doors>>) {
    let end = Arc::new(Notify::new());
    let admitted = lock(&doors).silent.admit(from, mono_ns(), Arc::clone(&end));
    let Ok(admitted) = admitted else {
        refused::turn_away();
        return;
    };
    if let Some((_, other)) = admitted.instead_of {
        other.notify_one();
    }
    let mut first = [0];
    let speaks = tokio::select! {
        read = timeout(PATIENCE, outer.peek(&mut first)) => matches!(read, Ok(Ok(1))),
        () = end.notified() => false,
    };
    let begun = {
        let mut doors = lock(&doors);
        doors.silent.leave(admitted.ticket);
        speaks.then(|| doors.begun.admit(from, mono_ns(), ()).ok()).flatten()
    };
    let Some(begun) = begun else {
        refused::turn_away();
        return;
    };
    tokio::spawn(async move {
        tokio::time::sleep(BEGINS).await;
        lock(&doors).begun.leave(begun.ticket);
    });
    if let Ok(mut to) = TcpStream::connect(inner).await {
        let _ = (outer.set_nodelay(true), to.set_nodelay(true));
        // Whichever side ends, both are at their end.
        let _ = copy_bidirectional(&mut outer, &mut to).await;
    }
}
