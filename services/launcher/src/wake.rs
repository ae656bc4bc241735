//! Sleeping until a child ends or a signal comes, but not longer than a given time.
//!
//! Asking every child again and again would notice an end late or keep a core busy. The kernel says so instead, with
//! `SIGCHLD`; a thread of its own turns that signal, and those that ask to stop, into something to wait for.

use std::io;
use std::sync::mpsc::{Receiver, TrySendError, sync_channel};
use std::thread;
use std::time::Duration;

use signal_hook::consts::{SIGCHLD, SIGINT, SIGTERM};
use signal_hook::iterator::Signals;

/// Wakes up for signals.
#[derive(Debug)]
pub(crate) struct Wake(Receiver<()>);

impl Wake {
    /// Listens for the end of children and for requests to stop, from now on.
    pub(crate) fn on_signals() -> io::Result<Self> {
        let mut signals = Signals::new([SIGCHLD, SIGINT, SIGTERM])?;
        // One place: signals that come while nobody waits are one reason to look, not several.
        let (sender, receiver) = sync_channel(1);
        thread::Builder::new().name("signals".to_owned()).spawn(move || {
            for _ in signals.forever() {
                if let Err(TrySendError::Disconnected(())) = sender.try_send(()) {
                    return;
                }
            }
        })?;
        Ok(Self(receiver))
    }

    /// Waits for a signal, `at_most` so long.
    pub(crate) fn wait(&self, at_most: Duration) {
        // The thread above never ends before this receiver does; a time-out is as good as a signal.
        let _ = self.0.recv_timeout(at_most);
    }
}
