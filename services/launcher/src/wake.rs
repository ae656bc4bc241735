//! Sleep until a child ends or a signal arrives, with a time limit.
//!
//! Polling every child would detect an end late or keep a core busy. The kernel sends `SIGCHLD` instead; a separate
//! thread turns this signal, and stop requests, into a wake-up.

use std::io;
use std::sync::mpsc::{Receiver, TrySendError, sync_channel};
use std::thread;
use std::time::Duration;

use signal_hook::consts::{SIGCHLD, SIGINT, SIGTERM};
use signal_hook::iterator::Signals;

/// Wake-ups by signals.
#[derive(Debug)]
pub(crate) struct Wake(Receiver<()>);

impl Wake {
    /// Longest sleep while messages from and to the keeper are due, and while a child stops.
    pub(crate) const TICK: Duration = Duration::from_millis(50);

    /// Catches ends of children and stop requests from now on.
    pub(crate) fn on_signals() -> io::Result<Self> {
        let mut signals = Signals::new([SIGCHLD, SIGINT, SIGTERM])?;
        // A single place: several signals without a waiter cause a single wake-up.
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

    /// Waits for a signal, at most for `at_most`.
    pub(crate) fn wait(&self, at_most: Duration) {
        // The thread above outlives this receiver; a time-out needs no other treatment than a signal.
        let _ = self.0.recv_timeout(at_most);
    }
}
