//! Socket between the launcher and the keeper.
//!
//! The keeper is connected to shared memory and the launcher is not. The keeper publishes the launcher's facts about
//! the children (`LauncherFacts`) and passes on the children's health messages (`HealthByProcess`). Facts are the whole
//! state each time, so that only the latest message matters. Neither side waits for the other: a message without room
//! is sent again later.

use std::collections::BTreeMap;
use std::io;
use std::os::fd::{AsFd as _, OwnedFd};
use std::os::unix::net::UnixDatagram;
use std::time::Duration;

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::Errno;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

/// Maximum length of a message, bytes: room for some 100 children.
const WORD_MAX: usize = 64 << 10;

/// Facts of the launcher.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct LauncherFacts {
    /// Start time of the launcher, monotonic, nanoseconds.
    pub(crate) incarnation: u64,
    /// Number of deaths of children so far. After each, shared memory must be reclaimed.
    pub(crate) deaths: u64,
    /// Number of rebuilds of the deployment.
    pub(crate) rebuilds: u64,
    /// Whether the deployment is being stopped.
    pub(crate) stopping: bool,
    /// Whether all processes except the keeper have ended.
    pub(crate) ended: bool,
    /// All children.
    pub(crate) children: Vec<ChildFacts>,
}

/// Facts about a child.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct ChildFacts {
    /// Name.
    pub(crate) name: String,
    /// Process number; 0 without a process.
    pub(crate) process_id: u32,
    /// Number of the source, for an adapter of a single source.
    pub(crate) source: u16,
    /// Code of the `LifeState`.
    pub(crate) life: u8,
    /// Number of restarts.
    pub(crate) restarts: u32,
    /// Last unexpected end; empty without such an end.
    pub(crate) last_end: String,
}

/// Health messages since the keeper's last message: the latest of each process, by process number. An empty map is a
/// sign of life of the keeper.
pub(crate) type HealthByProcess = BTreeMap<u32, ProcessHealth>;

/// Health message of a process, as far as needed by the launcher.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(crate) struct ProcessHealth {
    /// Code of the `LifeState`.
    pub(crate) life: u8,
    /// Time at which the loop made the message, monotonic, nanoseconds.
    pub(crate) said_ns: i64,
    /// Whether the process has taken reports, the measure of a deployment's work: set by fusion alone.
    pub(crate) has_reports: bool,
}

/// An end of the socket.
#[derive(Debug)]
pub(crate) struct KeeperLink(UnixDatagram);

impl KeeperLink {
    /// Creates the launcher's end, and the end that becomes the keeper's standard input.
    pub(crate) fn pair() -> io::Result<(Self, OwnedFd)> {
        let (own, other) = UnixDatagram::pair()?;
        own.set_nonblocking(true)?;
        Ok((Self(own), other.into()))
    }

    /// Opens the keeper's end.
    ///
    /// # Errors
    /// If standard input is no socket.
    pub(crate) fn of_keeper() -> io::Result<Self> {
        let socket = UnixDatagram::from(io::stdin().as_fd().try_clone_to_owned()?);
        socket.set_nonblocking(true)?;
        socket.peer_addr()?;
        Ok(Self(socket))
    }

    /// Sends `word`. Returns whether there was room; without the other side there is none.
    pub(crate) fn say(&self, word: &impl Serialize) -> bool {
        serde_json::to_vec(word).is_ok_and(|octets| self.0.send(&octets).is_ok())
    }

    /// Waits for a message or a signal, at most for `at_most`.
    pub(crate) fn wait(&self, at_most: Duration) {
        let timeout = Timespec {
            tv_sec: at_most.as_secs().cast_signed(),
            tv_nsec: at_most.subsec_nanos().into(),
        };
        let mut sockets = [PollFd::new(&self.0, PollFlags::IN)];
        match poll(&mut sockets, Some(&timeout)) {
            // A signal may be a stop request.
            Ok(0) | Err(Errno::INTR) => {}
            Ok(_) if sockets[0].revents().contains(PollFlags::IN) => {}
            Ok(_) | Err(_) => std::thread::sleep(at_most),
        }
    }

    /// Returns the next received message.
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
        let (launcher, other) = KeeperLink::pair().unwrap();
        assert!(launcher.hear::<HealthByProcess>().is_none());
        let said = (0..100_000)
            .take_while(|_| launcher.say(&LauncherFacts::default()))
            .count();
        assert!(said > 0 && said < 100_000, "{said}");
        let keeper = KeeperLink(UnixDatagram::from(other));
        for _ in 0..said {
            assert!(keeper.hear::<LauncherFacts>().is_some());
        }
        assert!(launcher.say(&LauncherFacts::default()), "there is room again");
    }

    #[test]
    fn a_message_ends_a_wait() {
        let (launcher, other) = KeeperLink::pair().unwrap();
        let keeper = KeeperLink(UnixDatagram::from(other));
        keeper.0.set_nonblocking(true).unwrap();
        keeper.wait(Duration::from_millis(1));
        assert!(keeper.hear::<LauncherFacts>().is_none());
        assert!(launcher.say(&LauncherFacts::default()));
        keeper.wait(Duration::from_secs(86_400));
        assert!(keeper.hear::<LauncherFacts>().is_some());
    }
}
