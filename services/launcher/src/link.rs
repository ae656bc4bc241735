//! Words between the launcher and its keeper, over a socket that only the two of them have.
//!
//! The keeper is connected to shared memory and the launcher is not: what the launcher knows of its children (`Facts`)
//! the keeper publishes, and what the children say of themselves (`Heard`) the keeper passes on. Facts are the whole
//! state each time, so the latest is all that matters. Neither side waits for the other: a word for which there is no
//! room is said again later.

use std::collections::BTreeMap;
use std::io;
use std::os::fd::{AsFd as _, OwnedFd};
use std::os::unix::net::UnixDatagram;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

/// Longest word, octets: some 100 children have room.
const WORD_MAX: usize = 64 << 10;

/// What the launcher knows.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Facts {
    /// When the launcher started, monotonic, nanoseconds.
    pub(crate) incarnation: u64,
    /// Children that have died so far. Whenever it rises, shared memory has to be taken back.
    pub(crate) deaths: u64,
    /// Times that the deployment was rebuilt.
    pub(crate) rebuilds: u64,
    /// Whether the deployment is being stopped.
    pub(crate) stopping: bool,
    /// Whether the deployment has ended, but for the keeper.
    pub(crate) ended: bool,
    /// Every child.
    pub(crate) children: Vec<ChildFacts>,
}

/// What the launcher knows of one child.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct ChildFacts {
    /// Its name.
    pub(crate) name: String,
    /// Its process number; 0 while it has none.
    pub(crate) process_id: u32,
    /// Its source's number, for an adapter of one source.
    pub(crate) source: u16,
    /// Code of its `LifeState`.
    pub(crate) life: u8,
    /// How often it was started again.
    pub(crate) restarts: u32,
    /// How it last ended; empty if it did not, or has finished.
    pub(crate) last_end: String,
}

/// What the keeper has heard since its last word: of each process, by its number, the last that it said of itself. One
/// without anything in it says that the keeper is there.
pub(crate) type Heard = BTreeMap<u32, Said>;

/// Word of a process about itself.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(crate) struct Said {
    /// Code of its `LifeState`.
    pub(crate) life: u8,
    /// When its loop said so, monotonic, nanoseconds.
    pub(crate) said_ns: i64,
    /// Whether it has taken reports, of which the deployment's work is made: fusion alone says so.
    pub(crate) has_reports: bool,
}

/// One end of the socket.
#[derive(Debug)]
pub(crate) struct Link(UnixDatagram);

impl Link {
    /// The launcher's end, and the one that becomes the keeper's standard input.
    pub(crate) fn pair() -> io::Result<(Self, OwnedFd)> {
        let (own, other) = UnixDatagram::pair()?;
        own.set_nonblocking(true)?;
        Ok((Self(own), other.into()))
    }

    /// The keeper's end.
    ///
    /// # Errors
    /// If standard input is no socket.
    pub(crate) fn of_keeper() -> io::Result<Self> {
        let socket = UnixDatagram::from(io::stdin().as_fd().try_clone_to_owned()?);
        socket.set_nonblocking(true)?;
        socket.peer_addr()?;
        Ok(Self(socket))
    }

    /// Says `word`. Returns whether there was room for it; if the other side is gone there is none.
    pub(crate) fn say(&self, word: &impl Serialize) -> bool {
        serde_json::to_vec(word).is_ok_and(|octets| self.0.send(&octets).is_ok())
    }

    /// The next word that has come.
    pub(crate) fn hear<T: DeserializeOwned>(&self) -> Option<T> {
        let mut octets = vec![0; WORD_MAX];
        let length = self.0.recv(&mut octets).ok()?;
        serde_json::from_slice(&octets[..length]).ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neither_side_waits_for_the_other() {
        let (launcher, other) = Link::pair().unwrap();
        assert!(launcher.hear::<Heard>().is_none());
        let said = (0..100_000).take_while(|_| launcher.say(&Facts::default())).count();
        assert!(said > 0 && said < 100_000, "{said}");
        let keeper = Link(UnixDatagram::from(other));
        for _ in 0..said {
            assert!(keeper.hear::<Facts>().is_some());
        }
        assert!(launcher.say(&Facts::default()), "there is room again");
    }
}
