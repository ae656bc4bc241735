//! Serves one page of text over HTTP, to a program that collects metrics or to a browser.
//!
//! The requests are parsed by `httparse`; the rest of HTTP that one page needs is a status line and three headers. Each
//! connection brings one request, and is closed after the answer.
//!
//! **Nobody holds up anybody.** All connections are looked at in turn, none is waited for. Each has [`PATIENCE`] for
//! its whole life, however it spends it, and a request a greatest length. There are at most [`CLIENTS_MAX`] of them:
//! one more takes the place of the oldest, so that a client that says nothing cannot keep one out that does. What
//! clients can take of memory is limited by that.
//!
//! **Nobody is tricked.** A page in a browser may not read answers of other servers; but its own name can be made to
//! lead here (DNS rebinding), and then it may. The browser still says the name that it asked for. So a request is
//! answered only if its `Host` is the address that the client connected to, a name of this machine for itself, or one
//! that is configured.

use std::io::{self, Read as _, Write as _};
use std::net::{IpAddr, Shutdown, SocketAddr, TcpListener, TcpStream};
use std::os::fd::AsFd as _;
use std::time::{Duration, Instant};

use rustix::event::{PollFd, PollFlags};

use crate::error::NetError;
use crate::wait::{pause, wait};

/// Time that a connection has, from its being accepted to the last octet of the answer.
pub const PATIENCE: Duration = Duration::from_secs(5);
/// Most connections at a time.
const CLIENTS_MAX: usize = 64;

/// Longest head of a request, octets.
const HEAD_MAX: usize = 8192;
/// Octets of one read.
const READ_MAX: usize = 1024;
/// Most header lines of a request.
const HEADERS_MAX: usize = 64;
/// Most connections that are accepted before those that are there are looked at again: what comes with a connection at
/// once is read before another one can take its place.
const ACCEPTS_MAX: usize = CLIENTS_MAX / 4;
/// Pause after a connection could not be accepted (no descriptor is left, say), so that trying again does not spin.
const REFUSAL_PAUSE: Duration = Duration::from_millis(100);

/// See the module's documentation.
#[derive(Debug)]
pub struct PageServer {
    listener: TcpListener,
    path: &'static str,
    content_type: &'static str,
    hosts: Vec<String>,
    /// In the order in which they came.
    clients: Vec<Client>,
}

/// A connection.
#[derive(Debug)]
struct Client {
    stream: TcpStream,
    /// The address that it has connected to.
    local: IpAddr,
    until: Instant,
    head: Vec<u8>,
    /// Rest of the answer, as soon as there is one.
    answer: Option<Vec<u8>>,
}

impl PageServer {
    /// Listens at `address` (port 0: the system chooses one) for requests of `path`, as in `/metrics`.
    ///
    /// # Errors
    /// [`NetError::Refused`] if the address is taken or not of this machine.
    pub fn open(address: SocketAddr, path: &'static str, content_type: &'static str) -> Result<Self, NetError> {
        let refused = || format!("listening at {address}");
        let listener = TcpListener::bind(address).map_err(NetError::refused(refused()))?;
        listener.set_nonblocking(true).map_err(NetError::refused(refused()))?;
        Ok(Self {
            listener,
            path,
            content_type,
            hosts: Vec::new(),
            clients: Vec::with_capacity(CLIENTS_MAX),
        })
    }

    /// This server, which may also be asked for by the names `hosts`, in small letters and without ports.
    #[must_use]
    pub fn with_hosts(mut self, hosts: Vec<String>) -> Self {
        self.hosts = hosts;
        self
    }

    /// Where it listens.
    ///
    /// # Errors
    /// If the system does not say.
    pub fn local_address(&self) -> io::Result<SocketAddr> {
        self.listener.local_addr()
    }

    /// Whether no client is there that is still to be answered.
    pub fn is_idle(&self) -> bool {
        self.clients.is_empty()
    }

    /// Waits up to `timeout` until a client can be served, and serves all that can, as far as that is possible without
    /// waiting. `now` reads a monotonic clock, `page` makes the text for those who ask for it. What goes wrong with a
    /// client is the client's trouble.
    ///
    /// # Errors
    /// If the system refuses to wait.
    pub fn serve(&mut self, timeout: Duration, now: impl Fn() -> Instant, page: impl Fn() -> String) -> io::Result<()> {
        let due = self
            .clients
            .first()
            .map(|first| first.until.saturating_duration_since(now()));
        let timeout = due.map_or(timeout, |due| due.min(timeout));
        let mut descriptors = vec![PollFd::new(&self.listener, PollFlags::IN)];
        descriptors.extend(self.clients.iter().map(Client::descriptor));
        wait(&mut descriptors, timeout)?;
        let ready: Vec<bool> = descriptors.iter().map(|one| !one.revents().is_empty()).collect();
        let mut clients = std::mem::take(&mut self.clients);
        let (now, mut ready) = (now(), ready.into_iter());
        let somebody_comes = ready.next().unwrap_or(false);
        clients.retain_mut(|client| {
            let stays = !ready.next().unwrap_or(false) || client.go_on(self, &page).unwrap_or(false);
            stays && now < client.until
        });
        self.clients = clients;
        if somebody_comes { self.accept(now) } else { Ok(()) }
    }

    fn accept(&mut self, now: Instant) -> io::Result<()> {
        for _ in 0..ACCEPTS_MAX {
            match self.listener.accept() {
                Ok((stream, _)) => {
                    let Ok(client) = Client::new(stream, now + PATIENCE) else {
                        continue;
                    };
                    if self.clients.len() == CLIENTS_MAX {
                        self.clients.remove(0);
                    }
                    self.clients.push(client);
                }
                Err(error) if error.kind() == io::ErrorKind::WouldBlock => break,
                // It has gone between the notice of it and its being accepted.
                Err(error) if error.kind() == io::ErrorKind::ConnectionAborted => {}
                Err(_) => return pause(REFUSAL_PAUSE),
            }
        }
        Ok(())
    }

    /// The answer to a request that came over a connection to `local`.
    fn answer(&self, asked: Asked, page: impl Fn() -> String) -> Vec<u8> {
        let (status, text) = match asked {
            Asked::Page | Asked::Head => ("200 OK", page()),
            Asked::Elsewhere => ("404 Not Found", format!("There is nothing here but {}.\n", self.path)),
            Asked::Otherwise => ("405 Method Not Allowed", "This can only be read (GET).\n".to_owned()),
            Asked::Unclear => ("400 Bad Request", "That is no request of HTTP.\n".to_owned()),
            Asked::Another => (
                "421 Misdirected Request",
                "This is not the host that was asked for.\n".to_owned(),
            ),
        };
        let content_type = match asked {
            Asked::Page | Asked::Head => self.content_type,
            _ => "text/plain; charset=utf-8",
        };
        let allow = if asked == Asked::Otherwise {
            "Allow: GET, HEAD\r\n"
        } else {
            ""
        };
        let mut answer = format!(
            "HTTP/1.1 {status}\r\nContent-Type: {content_type}\r\nContent-Length: {}\r\n{allow}Connection: close\r\n\r\n",
            text.len()
        );
        if asked != Asked::Head {
            answer.push_str(&text);
        }
        answer.into_bytes()
    }

    /// What a request asks for that came to the address `local`; `None` while its head is not complete.
    fn understand(&self, head: &[u8], local: IpAddr) -> Option<Asked> {
        let mut headers = [httparse::EMPTY_HEADER; HEADERS_MAX];
        let mut request = httparse::Request::new(&mut headers);
        match request.parse(head) {
            Ok(httparse::Status::Partial) => return None,
            Ok(httparse::Status::Complete(_)) => {}
            Err(_) => return Some(Asked::Unclear),
        }
        let mut hosts = request
            .headers
            .iter()
            .filter(|header| header.name.eq_ignore_ascii_case("host"));
        match (hosts.next(), hosts.next()) {
            (Some(host), None) if self.is_called(host.value, local) => {}
            (Some(_), None) => return Some(Asked::Another),
            // Clients of version 1.0 need not name it; browsers always do.
            (None, _) if request.version == Some(0) => {}
            _ => return Some(Asked::Unclear),
        }
        let path = request.path.unwrap_or_default();
        let path = path.split(['?', '#']).next().unwrap_or_default();
        Some(match request.method {
            _ if path != self.path => Asked::Elsewhere,
            Some("GET") => Asked::Page,
            Some("HEAD") => Asked::Head,
            _ => Asked::Otherwise,
        })
    }

    /// Whether `host`, with or without a port, is this server, which was reached at the address `local`.
    fn is_called(&self, host: &[u8], local: IpAddr) -> bool {
        let host = String::from_utf8_lossy(host).to_ascii_lowercase();
        let (name, port) = match host.rsplit_once(':') {
            Some((name, port)) if !port.contains(']') => (name, port),
            _ => (host.as_str(), ""),
        };
        let address = name.trim_start_matches('[').trim_end_matches(']').parse::<IpAddr>();
        let known = match address {
            Ok(address) => address == local || (address.is_loopback() && local.is_loopback()),
            Err(_) => (name == "localhost" && local.is_loopback()) || self.hosts.iter().any(|known| known == name),
        };
        known && port.bytes().all(|digit| digit.is_ascii_digit())
    }
}

/// What a client wants.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Asked {
    Page,
    /// What would come with the page, without it.
    Head,
    /// Something that is not here.
    Elsewhere,
    /// The page, but not to read it.
    Otherwise,
    /// Another host.
    Another,
    Unclear,
}

impl Client {
    fn new(stream: TcpStream, until: Instant) -> io::Result<Self> {
        stream.set_nonblocking(true)?;
        Ok(Self {
            local: stream.local_addr()?.ip().to_canonical(),
            stream,
            until,
            head: Vec::new(),
            answer: None,
        })
    }

    fn descriptor(&self) -> PollFd<'_> {
        let events = match self.answer {
            None => PollFlags::IN,
            Some(_) => PollFlags::OUT,
        };
        PollFd::from_borrowed_fd(self.stream.as_fd(), events)
    }

    /// Reads or writes once; whether there is more to do.
    fn go_on(&mut self, server: &PageServer, page: impl Fn() -> String) -> io::Result<bool> {
        let Some(answer) = &mut self.answer else {
            let mut octets = [0; READ_MAX];
            let Some(count) = unless_blocked(self.stream.read(&mut octets))? else {
                return Ok(true);
            };
            self.head.extend_from_slice(&octets[..count]);
            let asked = match server.understand(&self.head, self.local) {
                None if count == 0 || self.head.len() >= HEAD_MAX => Some(Asked::Unclear),
                asked => asked,
            };
            self.answer = asked.map(|asked| server.answer(asked, page));
            return Ok(true);
        };
        if let Some(count) = unless_blocked(self.stream.write(answer))? {
            answer.drain(..count);
        }
        if answer.is_empty() {
            self.stream.shutdown(Shutdown::Write)?;
        }
        Ok(!answer.is_empty())
    }
}

/// How many octets were moved; `None` if it is to be tried again.
fn unless_blocked(moved: io::Result<usize>) -> io::Result<Option<usize>> {
    match moved {
        Ok(count) => Ok(Some(count)),
        Err(error) if matches!(error.kind(), io::ErrorKind::WouldBlock | io::ErrorKind::Interrupted) => Ok(None),
        Err(error) => Err(error),
    }
}
