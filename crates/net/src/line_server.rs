//! Server of bytes for all connected clients.
//!
//! Receivers of transponder signals serve lines to all clients, and wait for no client: a slow client is disconnected,
//! and may connect again. A client receives only bytes sent after the connection. The number of clients is limited, in
//! all and of an address ([`DoorLimits::OF_READERS`]).

use std::fmt::Debug;
use std::fs::{self, Permissions};
use std::io::{self, ErrorKind, Write};
use std::net::{SocketAddr, TcpListener};
use std::os::unix::fs::{FileTypeExt as _, PermissionsExt as _};
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::{Path, PathBuf};

use crate::NetError;
use crate::door::{Door, DoorCounters, DoorLimits, DoorNews, DoorRefusal, Ended, Peer};
use crate::reach::Reach;

/// A socket that sends the same to each reader.
#[derive(Debug)]
pub struct LineServer {
    listener: Listener,
    readers: Door<Box<dyn ClientConnection>>,
    news: DoorNews,
}

/// Connection to a client.
trait ClientConnection: Write + Debug + Send {}

impl<T: Write + Debug + Send> ClientConnection for T {}

#[derive(Debug)]
enum Listener {
    Tcp(TcpListener),
    Unix(UnixListener, PathBuf),
}

impl Listener {
    fn accept(&self) -> io::Result<(Box<dyn ClientConnection>, Peer)> {
        match self {
            Self::Tcp(listener) => {
                let (reader, address) = listener.accept()?;
                reader.set_nonblocking(true)?;
                // Lines are to arrive when sent.
                reader.set_nodelay(true)?;
                Ok((Box::new(reader), Peer(Some(address))))
            }
            Self::Unix(listener, _) => {
                let (reader, _) = listener.accept()?;
                reader.set_nonblocking(true)?;
                Ok((Box::new(reader), Peer(None)))
            }
        }
    }
}

impl Drop for Listener {
    fn drop(&mut self) {
        if let Self::Unix(_, path) = self {
            // If removal fails, the next server at this path replaces the file.
            let _ = fs::remove_file(path);
        }
    }
}

impl LineServer {
    /// Listens at `address`.
    ///
    /// # Errors
    /// [`NetError`] if other machines reach the address without permission, or if the operating system refuses.
    pub fn open(address: SocketAddr, reach: Reach) -> Result<Self, NetError> {
        reach.check(address).map_err(NetError::Reach)?;
        let failed = || NetError::refused::<io::Error>(format!("listening at {address}"));
        let listener = TcpListener::bind(address).map_err(failed())?;
        listener.set_nonblocking(true).map_err(failed())?;
        Ok(Self::of(Listener::Tcp(listener)))
    }

    /// Listens at a Unix socket; the server removes the file at the end. `mode` is the file mode, for example 0o660;
    /// `group` is the number of the file's group, `None` for the group of this process. The file of an earlier server
    /// without a listener is replaced.
    ///
    /// # Errors
    /// [`NetError`] if another process listens there, if a file of another kind is there, or if the operating system
    /// refuses.
    pub fn open_unix(path: &Path, mode: u32, group: Option<u32>) -> Result<Self, NetError> {
        let action = || format!("listening at {}", path.display());
        let failed = || NetError::refused::<io::Error>(action());
        let is_socket = fs::symlink_metadata(path).is_ok_and(|found| found.file_type().is_socket());
        if is_socket && UnixStream::connect(path).is_err() {
            fs::remove_file(path).map_err(failed())?;
        }
        let listener = UnixListener::bind(path).map_err(failed())?;
        let server = Self::of(Listener::Unix(listener, path.to_owned()));
        // In this order: until the last step only this user, or users permitted by the process's mask, may connect.
        std::os::unix::fs::chown(path, None, group).map_err(failed())?;
        fs::set_permissions(path, Permissions::from_mode(mode)).map_err(failed())?;
        if let Listener::Unix(listener, _) = &server.listener {
            listener.set_nonblocking(true).map_err(failed())?;
        }
        Ok(server)
    }

    fn of(listener: Listener) -> Self {
        Self {
            listener,
            readers: Door::new(DoorLimits::OF_READERS),
            news: DoorNews::default(),
        }
    }

    /// Address at which the server listens.
    ///
    /// # Errors
    /// For a Unix socket, or if the operating system refuses.
    pub fn local_address(&self) -> io::Result<SocketAddr> {
        match &self.listener {
            Listener::Tcp(listener) => listener.local_addr(),
            Listener::Unix(..) => Err(ErrorKind::Unsupported.into()),
        }
    }

    /// Takes the readers that wait, without waiting itself; how many there are now.
    ///
    /// # Errors
    /// If the operating system takes no connections any more.
    pub fn accept(&mut self) -> io::Result<usize> {
        self.accept_with(&[])
    }

    /// The same; each reader gets `head` first.
    ///
    /// # Errors
    /// The same.
    pub fn accept_with(&mut self, head: &[u8]) -> io::Result<usize> {
        loop {
            let (mut reader, peer) = match self.listener.accept() {
                Ok(accepted) => accepted,
                Err(error) if error.kind() == ErrorKind::WouldBlock => return Ok(self.readers.len()),
                // The reader has gone again already.
                Err(error) if error.kind() == ErrorKind::ConnectionAborted => continue,
                Err(error) => return Err(error),
            };
            // The buffer of a new connection is empty; a closed connection is detected at the next send.
            let _ = reader.write(head);
            // A reader without a place is counted, and let go. Readers need not send, so the time is of no matter.
            let _ = self.readers.admit(peer, 0, reader);
        }
    }

    /// Sends to every client without waiting; disconnects a client that cannot take all bytes or has closed.
    pub fn send(&mut self, octets: &[u8]) {
        self.readers.retain(|reader| match reader.write(octets) {
            Ok(written) if written == octets.len() => Ok(None),
            // The begin of a line without the end would be a wrong line.
            Ok(_) => Ok(Some(DoorRefusal::Slow)),
            Err(error) if error.kind() == ErrorKind::WouldBlock => Ok(Some(DoorRefusal::Slow)),
            Err(_) => Err(Ended),
        });
    }

    /// Returns the counts if readers were refused or let go, and that is to be reported at the monotonic time `now_ns`.
    pub fn news(&mut self, now_ns: i64) -> Option<DoorCounters> {
        let counters = self.readers.counters();
        self.news.is_due(&counters, now_ns).then_some(counters)
    }

    /// Counts so far.
    pub fn counters(&self) -> DoorCounters {
        self.readers.counters()
    }
}
