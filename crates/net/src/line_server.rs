//! Octets for whoever connects.
//!
//! Receivers of transponder signals serve their lines to everybody, and wait for nobody: a reader that does not keep up
//! is let go, and may connect again. What was sent before a reader came is not sent to it.

use std::io::{self, ErrorKind, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};

use crate::NetError;

/// Most readers at a time.
pub const READERS_MAX: usize = 64;

/// What has been counted since the socket was opened.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LineServerCounters {
    /// Readers that have connected.
    pub readers: u64,
    /// Of these, those that were let go since they did not keep up.
    pub slow: u64,
    /// Of these, those that were turned away since there were too many.
    pub refused: u64,
}

/// A socket that sends the same to each of its readers.
#[derive(Debug)]
pub struct LineServer {
    listener: TcpListener,
    readers: Vec<TcpStream>,
    counters: LineServerCounters,
}

impl LineServer {
    /// Listens at `address`.
    ///
    /// # Errors
    /// [`NetError`] if the operating system refuses.
    pub fn open(address: SocketAddr) -> Result<Self, NetError> {
        let failed = || NetError::refused::<io::Error>(format!("listening at {address}"));
        let listener = TcpListener::bind(address).map_err(failed())?;
        listener.set_nonblocking(true).map_err(failed())?;
        Ok(Self {
            listener,
            readers: Vec::with_capacity(READERS_MAX),
            counters: LineServerCounters::default(),
        })
    }

    /// Address at which it listens.
    ///
    /// # Errors
    /// If the operating system does not say.
    pub fn local_address(&self) -> io::Result<SocketAddr> {
        self.listener.local_addr()
    }

    /// Takes the readers that wait, without waiting itself; how many there are now.
    ///
    /// # Errors
    /// If the operating system takes no connections any more.
    pub fn accept(&mut self) -> io::Result<usize> {
        loop {
            let reader = match self.listener.accept() {
                Ok((reader, _)) => reader,
                Err(error) if error.kind() == ErrorKind::WouldBlock => return Ok(self.readers.len()),
                // The reader has gone again already.
                Err(error) if error.kind() == ErrorKind::ConnectionAborted => continue,
                Err(error) => return Err(error),
            };
            if self.readers.len() == READERS_MAX {
                self.counters.refused += 1;
                continue;
            }
            reader.set_nonblocking(true)?;
            // Lines are to arrive when they are sent.
            reader.set_nodelay(true)?;
            self.counters.readers += 1;
            self.readers.push(reader);
        }
    }

    /// Sends to every reader, without waiting: one that does not take all of it, or has gone, is let go.
    pub fn send(&mut self, octets: &[u8]) {
        let slow = &mut self.counters.slow;
        self.readers.retain_mut(|reader| match reader.write(octets) {
            Ok(written) if written == octets.len() => true,
            // The begin of a line without its end would be a wrong line.
            Ok(_) => {
                *slow += 1;
                false
            }
            Err(error) => {
                *slow += u64::from(error.kind() == ErrorKind::WouldBlock);
                false
            }
        });
    }

    /// What it has counted.
    pub fn counters(&self) -> LineServerCounters {
        self.counters
    }
}
