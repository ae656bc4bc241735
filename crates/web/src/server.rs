//! Accepts connections and hands their requests, if the guard lets them pass, to a router.

use std::io;
use std::net::{IpAddr, SocketAddr, TcpListener};
use std::pin::{Pin, pin};
use std::sync::atomic::{AtomicBool, AtomicI64, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::task::{Context, Poll};
use std::thread::JoinHandle;
use std::time::Duration;

use axum::Router;
use axum::body::{Body, Bytes};
use axum::http::{Request, Response};
use hyper::body::{Frame, Incoming, SizeHint};
use hyper::server::conn::http1;
use hyper::service::{Service as _, service_fn};
use hyper_util::rt::TokioIo;
use hyper_util::service::TowerToHyperService;
use net::{Door, DoorLimits, DoorRefusal, Peer, Ticket};
use tokio::net::TcpStream;
use tokio::sync::{Notify, oneshot};
use tokio::time::timeout;

use crate::guard::{Guard, RequestCounts, RequestRefusal, sealed};

/// Time that a connection has, from its being accepted to the last byte of the answer.
pub const PATIENCE: Duration = Duration::from_secs(10);
/// Most connections at a time, beside WebSockets.
pub const CONNECTIONS_MAX: usize = 64;
/// Limits of the connections, beside WebSockets: a proxy has one address and many clients. While places are short, the
/// oldest connection without a request gives way, else the oldest.
const LIMITS: DoorLimits = DoorLimits {
    connections_max: CONNECTIONS_MAX,
    address_max: CONNECTIONS_MAX * 3 / 4,
    first: Some(PATIENCE),
    yields: Duration::ZERO,
    idle: PATIENCE,
};
/// Longest head of a request, bytes.
const HEAD_MAX: usize = 8192;
/// Most header lines of a request.
const HEADERS_MAX: usize = 64;
/// Pause after a connection could not be accepted (for example, no descriptor is left), to avoid a busy loop.
const REFUSAL_PAUSE: Duration = Duration::from_millis(100);
/// Time for which, at the end, one more connection is waited for that had come by then, and how often.
const END_PAUSE: Duration = Duration::from_millis(5);
const LAST_LOOKS: usize = 20;

/// Extension of a response that has no end, such as a stream of events. [`PATIENCE`] then limits the time between two
/// parts of the body, and the connection no longer counts among [`CONNECTIONS_MAX`]: the service limits the number.
/// The body must have a part at least every half [`PATIENCE`].
#[derive(Clone, Copy, Debug)]
pub struct LongAnswer;

/// Progress of a connection.
#[derive(Debug, Default)]
struct Progress {
    /// Whether the answer is a [`LongAnswer`].
    is_long: AtomicBool,
    /// How often a part of such an answer was asked for: only as long as the client takes the parts before.
    parts: AtomicU64,
}

impl Progress {
    fn is_long(&self) -> bool {
        self.is_long.load(Ordering::Relaxed)
    }

    /// Whether a long answer has advanced beyond the part `seen`, which becomes the present part.
    fn has_advanced(&self, seen: &mut u64) -> bool {
        let parts = self.parts.load(Ordering::Relaxed);
        self.is_long() && std::mem::replace(seen, parts) != parts
    }
}

/// Body of a long answer.
struct LongBody {
    body: Body,
    progress: Arc<Progress>,
}

impl hyper::body::Body for LongBody {
    type Data = Bytes;
    type Error = axum::Error;

    fn poll_frame(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
    ) -> Poll<Option<Result<Frame<Bytes>, axum::Error>>> {
        self.progress.parts.fetch_add(1, Ordering::Relaxed);
        Pin::new(&mut self.body).poll_frame(context)
    }

    fn is_end_stream(&self) -> bool {
        self.body.is_end_stream()
    }

    fn size_hint(&self) -> SizeHint {
        self.body.size_hint()
    }
}

/// Server on its own thread; dropping the server ends it. Requests received before are answered, unless that takes
/// long.
#[derive(Debug)]
pub struct Server {
    address: SocketAddr,
    counts: Arc<RequestCounts>,
    stop: Option<oneshot::Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl Server {
    /// Serves `router` on a thread called `name`, at `address` (port 0: the system chooses a port).
    ///
    /// # Errors
    /// If the address is taken or not of this machine, or the system refuses a thread.
    pub fn start(name: &str, address: SocketAddr, guard: Guard, router: Router) -> io::Result<Self> {
        Self::start_on(name, listen(address)?, guard, router)
    }

    /// As [`Server::start`], with a socket that listens already.
    ///
    /// # Errors
    /// If the system refuses a thread.
    pub fn start_on(name: &str, listener: TcpListener, guard: Guard, router: Router) -> io::Result<Self> {
        listener.set_nonblocking(true)?;
        let address = listener.local_addr()?;
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
        let counts = Arc::new(RequestCounts::default());
        let desk = ConnectionDesk {
            guard: Arc::new(guard),
            counts: Arc::clone(&counts),
            router,
            places: Arc::new(Places {
                door: Mutex::new(Door::new(LIMITS)),
                events: AtomicI64::new(0),
            }),
        };
        let (stop, stopped) = oneshot::channel();
        let thread = std::thread::Builder::new().name(name.to_owned()).spawn(move || {
            // An error means that the socket cannot be watched; it cannot be reported from here, and nothing is
            // served.
            let _ = runtime.block_on(async { desk.serve(tokio::net::TcpListener::from_std(listener)?, stopped).await });
            // Sockets that are still open are not waited for.
            runtime.shutdown_background();
        })?;
        Ok(Self {
            address,
            counts,
            stop: Some(stop),
            thread: Some(thread),
        })
    }

    /// Address of the listening socket.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// Refusals so far.
    pub fn counts(&self) -> &Arc<RequestCounts> {
        &self.counts
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        // The thread may have ended on its own.
        drop(self.stop.take());
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// Listens at `address`.
///
/// # Errors
/// If the address is in use or not of this machine; the error contains the remedy.
pub fn listen(address: SocketAddr) -> io::Result<TcpListener> {
    TcpListener::bind(address).map_err(|error| {
        let remedy = match error.kind() {
            io::ErrorKind::AddrInUse => "; end the process that holds it (`ss -ltnp` names it), or take another port",
            io::ErrorKind::AddrNotAvailable => "; take an address of this machine (`ip addr` names them)",
            _ => "",
        };
        io::Error::new(error.kind(), format!("listening at {address}: {error}{remedy}"))
    })
}

/// Places of the connections, without those whose answer is long.
struct Places {
    /// The connections, each with what ends it.
    door: Mutex<Door<Arc<Notify>>>,
    /// Events so far, in the place of a time: only their order decides who gives way, and each connection ends itself
    /// after [`PATIENCE`].
    events: AtomicI64,
}

impl Places {
    fn door(&self) -> MutexGuard<'_, Door<Arc<Notify>>> {
        self.door.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn next_event(&self) -> i64 {
        self.events.fetch_add(1, Ordering::Relaxed)
    }

    /// Gives a connection of `peer` a place, if there is one or another connection gives way. A connection that gives
    /// way or has no place is counted.
    fn take(&self, peer: SocketAddr, counts: &RequestCounts) -> Option<(Ticket, Arc<Notify>)> {
        let end = Arc::new(Notify::new());
        let refusal = |reason| match reason {
            DoorRefusal::Silent | DoorRefusal::Slow => RequestRefusal::Slow,
            _ => RequestRefusal::Full,
        };
        match self.door().admit(Peer(Some(peer)), self.next_event(), Arc::clone(&end)) {
            Ok(admitted) => {
                if let Some((reason, other)) = admitted.instead_of {
                    counts.add(refusal(reason));
                    other.notify_one();
                }
                Some((admitted.ticket, end))
            }
            Err((reason, _)) => {
                counts.add(refusal(reason));
                None
            }
        }
    }
}

/// Desk at which connections arrive.
struct ConnectionDesk {
    guard: Arc<Guard>,
    counts: Arc<RequestCounts>,
    router: Router,
    places: Arc<Places>,
}

impl ConnectionDesk {
    async fn serve(self, listener: tokio::net::TcpListener, mut stopped: oneshot::Receiver<()>) -> io::Result<()> {
        loop {
            tokio::select! {
                biased;
                _ = &mut stopped => break,
                accepted = listener.accept() => match accepted {
                    Ok((stream, peer)) => self.take(stream, peer),
                    // The client closed the connection before its acceptance.
                    Err(error) if error.kind() == io::ErrorKind::ConnectionAborted => {}
                    Err(_) => tokio::time::sleep(REFUSAL_PAUSE).await,
                },
            }
        }
        for _ in 0..LAST_LOOKS {
            while let Ok(Ok((stream, peer))) = timeout(END_PAUSE, listener.accept()).await {
                self.take(stream, peer);
            }
            if self.places.door().is_empty() {
                break;
            }
        }
        Ok(())
    }

    fn take(&self, stream: TcpStream, peer: SocketAddr) {
        let Ok(local) = stream.local_addr() else { return };
        // Small messages are not to wait for company.
        let _ = stream.set_nodelay(true);
        let Some((ticket, end)) = self.places.take(peer, &self.counts) else {
            return;
        };
        let (guard, counts, router) = (Arc::clone(&self.guard), Arc::clone(&self.counts), self.router.clone());
        let local = local.ip().to_canonical();
        let place = (Arc::clone(&self.places), ticket);
        tokio::spawn(async move {
            let conversation = converse(stream, local, &guard, &counts, router, &place);
            tokio::select! {
                refusal = conversation => {
                    if let Some(refusal) = refusal {
                        counts.add(refusal);
                    }
                }
                // Another connection has the place.
                () = end.notified() => {}
            }
            let (places, ticket) = place;
            places.door().leave(ticket);
        });
    }
}

/// Handles a request and its answer; for a WebSocket, only the handshake. Returns why the connection was refused after
/// it had its `place`, if it was.
async fn converse(
    stream: TcpStream,
    local: IpAddr,
    guard: &Guard,
    counts: &RequestCounts,
    router: Router,
    place: &(Arc<Places>, Ticket),
) -> Option<RequestRefusal> {
    let progress = Arc::new(Progress::default());
    let service = service_fn(|request: Request<Incoming>| {
        let (places, ticket) = (Arc::clone(&place.0), place.1);
        places.door().heard(ticket, places.next_event());
        let stopped = guard.stop(&request, local, counts);
        let router = TowerToHyperService::new(router.clone());
        let progress = Arc::clone(&progress);
        async move {
            let answer = match stopped {
                Some(answer) => Ok(answer),
                None => router.call(request.map(Body::new)).await,
            };
            answer.map(|answer| {
                let is_long = answer.extensions().get::<LongAnswer>().is_some();
                if is_long {
                    places.door().leave(ticket);
                }
                sealed(if is_long { watched(answer, progress) } else { answer })
            })
        }
    });
    let mut conversation = pin!(
        http1::Builder::new()
            .max_buf_size(HEAD_MAX)
            .max_headers(HEADERS_MAX)
            .keep_alive(false)
            .half_close(true)
            .serve_connection(TokioIo::new(stream), service)
            .with_upgrades()
    );
    let mut seen = 0;
    loop {
        match timeout(PATIENCE, &mut conversation).await {
            Ok(Err(error)) if error.is_parse() || error.is_parse_too_large() => {
                return Some(RequestRefusal::Malformed);
            }
            // A client that leaves early is no trouble.
            Ok(_) => return None,
            Err(_) if progress.has_advanced(&mut seen) => {}
            Err(_) => return Some(RequestRefusal::Slow),
        }
    }
}

/// Watches the progress of a long answer.
fn watched(answer: Response<Body>, progress: Arc<Progress>) -> Response<Body> {
    progress.is_long.store(true, Ordering::Relaxed);
    answer.map(|body| Body::new(LongBody { body, progress }))
}
