//! Lines from a server, connected to again and again.
//!
//! Servers restart, cables are pulled, and a connection with a dead peer stays open in silence. A feed must recover
//! from all of these. [`TcpLines`] is in any of three states: *pausing* before the next attempt, *connecting*, or
//! *connected*. Each call of [`TcpLines::poll`] takes a single step within the caller's time limit, so that a thread
//! can serve a feed beside other work.
//!
//! - A pause doubles with each failed attempt up to a limit: a server without service for a night gets few attempts,
//!   but regular attempts. Only a connection with a complete line resets the pauses: a server that accepts and closes
//!   every connection counts as failed.
//! - An attempt that takes longer than the limit is given up.
//! - A connection on which nothing comes for too long is given up too. TCP itself would notice after hours.
//!
//! The caller passes the present time. The duration of a state counts from the first call in the state; waiting
//! within a call can make a state longer, but never shorter.

use std::io::{self, ErrorKind, Read};
use std::net::SocketAddr;
use std::os::fd::AsFd;
use std::time::Duration;

use nix::libc;
use rustix::event::PollFlags;
use socket2::{Domain, Protocol, Socket, Type};

use crate::splitter::Splitter;
use crate::{NetError, wait};

/// Lengths of a line that can be allowed.
const LINE_OCTETS: std::ops::RangeInclusive<usize> = 1..=1 << 20;
/// Doublings after which the pause is at any limit.
const DOUBLINGS_MAX: u32 = 20;

/// The server, and the patience with this server.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LinesSettings {
    /// The server's address and port. An address, not a name: asking for the address of a name may block for long.
    pub server: SocketAddr,
    /// Longest attempt to connect.
    pub connect_max: Duration,
    /// Pause before the second attempt; doubled from there.
    pub pause_min: Duration,
    /// Longest pause between attempts.
    pub pause_max: Duration,
    /// Longest silence before the connection is given up.
    pub silence_max: Duration,
    /// Longest line that is accepted, without the end, at most 1 MiB; `None` for a stream without lines, whose octets
    /// are handed on as they come.
    pub line_octets_max: Option<usize>,
}

impl LinesSettings {
    /// Attempts of at most 5 s with pauses of 0.5 s to 30 s, silence of at most 60 s, lines of at most 1024 bytes.
    pub fn new(server: SocketAddr) -> Self {
        Self {
            server,
            connect_max: Duration::from_secs(5),
            pause_min: Duration::from_millis(500),
            pause_max: Duration::from_secs(30),
            silence_max: Duration::from_secs(60),
            line_octets_max: Some(1024),
        }
    }

    /// Whether the settings are plausible.
    ///
    /// # Errors
    /// [`NetError::Setting`] for the first that cannot.
    pub fn check(&self) -> Result<(), NetError> {
        let server = self.server;
        if server.port() == 0 || server.ip().is_unspecified() || server.ip().is_multicast() {
            let reason = "is no server; give the address of one machine and a port above 0";
            return Err(NetError::setting("server", server, reason));
        }
        let durations = [
            ("longest attempt to connect", self.connect_max),
            ("shortest pause", self.pause_min),
            ("longest silence", self.silence_max),
        ];
        if let Some((name, zero)) = durations.iter().find(|(_, duration)| duration.is_zero()) {
            return Err(NetError::setting(name, format!("{zero:?}"), "must be longer than 0"));
        }
        if self.pause_max < self.pause_min {
            let reason = format!("must be at least the shortest pause, {:?}", self.pause_min);
            return Err(NetError::setting(
                "longest pause",
                format!("{:?}", self.pause_max),
                reason,
            ));
        }
        if let Some(octets) = self.line_octets_max.filter(|octets| !LINE_OCTETS.contains(octets)) {
            let reason = format!("must be {} to {} octets", LINE_OCTETS.start(), LINE_OCTETS.end());
            return Err(NetError::setting("longest line", octets, reason));
        }
        Ok(())
    }
}

/// Counts since the start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LinesCounters {
    /// Lines handed on.
    pub lines: u64,
    /// Bytes received, including line ends and discarded bytes.
    pub octets: u64,
    /// Lines longer than accepted, passed over.
    pub oversized: u64,
    /// Lines cut off by the end of the connection.
    pub cut: u64,
    /// Connections that came about.
    pub connections: u64,
    /// Attempts to connect that failed.
    pub failed_attempts: u64,
    /// Connections that were lost, or closed by the server.
    pub lost_connections: u64,
    /// Connections given up because nothing came.
    pub silent_connections: u64,
}

/// A client of a server that sends lines.
#[derive(Debug)]
pub struct TcpLines {
    settings: LinesSettings,
    state: ConnectionState,
    /// Time of the first call in the present state, or of the last received bytes; `None` until the next call.
    since_ns: Option<i64>,
    /// Attempts in a row that brought no line.
    fruitless: u32,
    splitter: Splitter,
    counters: LinesCounters,
}

#[derive(Debug)]
enum ConnectionState {
    Pausing(Duration),
    Connecting(Socket),
    Connected(Socket),
}

impl TcpLines {
    /// Returns a client that connects at the first poll.
    ///
    /// # Errors
    /// [`NetError::Setting`] if a setting cannot be meant. Whether the server is there makes no difference.
    pub fn new(settings: LinesSettings) -> Result<Self, NetError> {
        settings.check()?;
        Ok(Self {
            settings,
            state: ConnectionState::Pausing(Duration::ZERO),
            since_ns: None,
            fruitless: 0,
            splitter: Splitter::new(settings.line_octets_max),
            counters: LinesCounters::default(),
        })
    }

    /// Takes a step: begins or continues an attempt to connect, or takes the received bytes, at most a single read.
    /// Without work, waits up to `timeout`. `visit` receives each complete line without the end, or the octets of a
    /// stream without lines; returns the number of calls. `now_ns` is a monotonic time, nanoseconds.
    ///
    /// Faults of the server are no errors: such faults are counted, and the attempt is repeated later.
    pub fn poll(&mut self, now_ns: i64, timeout: Duration, mut visit: impl FnMut(&[u8])) -> usize {
        let limit = match self.state {
            ConnectionState::Pausing(pause) => pause,
            ConnectionState::Connecting(_) => self.settings.connect_max,
            ConnectionState::Connected(_) => self.settings.silence_max,
        };
        let since_ns = *self.since_ns.get_or_insert(now_ns);
        let passed_ns = now_ns.saturating_sub(since_ns).max(0).cast_unsigned();
        let rest = limit.saturating_sub(Duration::from_nanos(passed_ns));
        match self.state {
            ConnectionState::Pausing(_) => self.go_on_pausing(rest, timeout),
            ConnectionState::Connecting(_) => self.go_on_connecting(rest, timeout),
            ConnectionState::Connected(_) => return self.go_on_reading(rest, timeout, &mut visit),
        }
        0
    }

    /// Whether there is a connection now.
    pub fn is_connected(&self) -> bool {
        matches!(self.state, ConnectionState::Connected(_))
    }

    /// Returns the counts since the start.
    pub fn counters(&self) -> LinesCounters {
        LinesCounters {
            oversized: self.splitter.oversized(),
            ..self.counters
        }
    }

    fn enter(&mut self, state: ConnectionState) {
        self.state = state;
        self.since_ns = None;
    }

    fn go_on_pausing(&mut self, rest: Duration, timeout: Duration) {
        if !rest.is_zero() {
            // A wait that fails counts as too short a wait.
            let _ = wait::pause(rest.min(timeout));
            return;
        }
        match open(self.settings.server) {
            Ok(socket) => self.enter(ConnectionState::Connecting(socket)),
            Err(_) => self.attempt_failed(),
        }
    }

    fn go_on_connecting(&mut self, rest: Duration, timeout: Duration) {
        let ConnectionState::Connecting(socket) = &self.state else {
            return;
        };
        match connected(socket, rest.min(timeout)) {
            Ok(true) => self.begin_reading(),
            Ok(false) if !rest.is_zero() => {}
            Ok(false) | Err(_) => self.attempt_failed(),
        }
    }

    fn begin_reading(&mut self) {
        if let ConnectionState::Connecting(socket) =
            std::mem::replace(&mut self.state, ConnectionState::Pausing(Duration::ZERO))
        {
            self.counters.connections += 1;
            self.enter(ConnectionState::Connected(socket));
        }
    }

    fn go_on_reading(&mut self, rest: Duration, timeout: Duration, visit: &mut impl FnMut(&[u8])) -> usize {
        if let Some(lines) = self.read(visit) {
            return lines;
        }
        if rest.is_zero() {
            self.counters.silent_connections += 1;
            self.disconnect();
            return 0;
        }
        let ConnectionState::Connected(socket) = &self.state else {
            return 0;
        };
        match wait::ready(socket.as_fd(), PollFlags::IN, timeout.min(rest)) {
            Ok(true) => self.read(visit).unwrap_or(0),
            // A wait that fails is made up for by the next read, which finds out why.
            Ok(false) | Err(_) => 0,
        }
    }

    /// A single read; `None` if nothing is there, but may still come.
    fn read(&mut self, visit: &mut impl FnMut(&[u8])) -> Option<usize> {
        let ConnectionState::Connected(socket) = &mut self.state else {
            return Some(0);
        };
        match socket.read(self.splitter.free()) {
            Ok(octets @ 1..) => {
                self.since_ns = None;
                self.counters.octets += octets as u64;
                let lines = self.splitter.fill(octets, visit);
                self.counters.lines += lines as u64;
                if lines > 0 {
                    self.fruitless = 0;
                }
                Some(lines)
            }
            Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted) => None,
            Ok(_) | Err(_) => {
                self.counters.lost_connections += 1;
                self.disconnect();
                Some(0)
            }
        }
    }

    fn attempt_failed(&mut self) {
        self.counters.failed_attempts += 1;
        self.pause();
    }

    fn disconnect(&mut self) {
        self.counters.cut += u64::from(self.splitter.reset());
        self.pause();
    }

    fn pause(&mut self) {
        let doublings = self.fruitless.min(DOUBLINGS_MAX);
        let pause = self.settings.pause_min.saturating_mul(1 << doublings);
        self.fruitless = self.fruitless.saturating_add(1);
        self.enter(ConnectionState::Pausing(pause.min(self.settings.pause_max)));
    }
}

/// A socket connecting to `server`.
fn open(server: SocketAddr) -> io::Result<Socket> {
    let socket = Socket::new(Domain::for_address(server), Type::STREAM, Some(Protocol::TCP))?;
    socket.set_nonblocking(true)?;
    match socket.connect(&server.into()) {
        Err(error) if error.raw_os_error() != Some(libc::EINPROGRESS) => Err(error),
        _ => Ok(socket),
    }
}

/// Whether `socket` has arrived, waiting at most `timeout`.
fn connected(socket: &Socket, timeout: Duration) -> io::Result<bool> {
    if !wait::ready(socket.as_fd(), PollFlags::OUT, timeout)? {
        return Ok(false);
    }
    match socket.take_error()? {
        Some(error) => Err(error),
        None => Ok(true),
    }
}
