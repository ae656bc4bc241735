//! Waking of a topic's readers, and the knowledge that nobody listens.
//!
//! iceoryx2 counts the listeners of a topic by a walk over all places for listeners: some 180 instructions per slice,
//! mostly for the result that there is no listener. Therefore each new listener of this crate increments a word of the
//! topic, and a publisher that has found no listener counts again when the word has changed.
//!
//! # No wake-up is lost
//! The slice is in the queues before the publisher reads the word, and a listener has incremented the word before the
//! owner looks into the queues, with a fence between the two steps on either side: at least one side sees the other.
//!
//! A listener in another language never touches the word. Therefore the result is valid for a tenth of a second only. A
//! publisher that used the result counts again ([`WakeUp::settle`]) when there is nothing to send, and at the end.

use std::sync::atomic::Ordering::{Acquire, SeqCst};
use std::sync::atomic::fence;

use crate::hint::Hint;
use crate::ports::{DropGuard, Transport};
use crate::service::WakeUps;

/// How long nobody is known to listen, nanoseconds: less than a sleeping reader of this crate may miss a wake-up
/// ([`BACKSTOP`](crate::BACKSTOP)).
const KNOWN_NS: i64 = 100_000_000;

/// Wakes the readers of a topic.
#[derive(Debug)]
pub(crate) struct WakeUp<S: Transport> {
    port: DropGuard<WakeUps<S>>,
    /// The topic's word when nobody was found to listen, and until when this holds (monotonic, nanoseconds).
    alone: (u64, i64),
    /// Set if slices were sent on the strength of `alone`: a listener may have come meanwhile.
    owes: bool,
}

impl<S: Transport> WakeUp<S> {
    pub(crate) fn new(port: DropGuard<WakeUps<S>>) -> Self {
        Self {
            port,
            alone: (0, i64::MIN),
            owes: false,
        }
    }

    /// Wakes all listeners, after a slice has entered the queues.
    #[inline]
    pub(crate) fn wake(&mut self) {
        fence(SeqCst);
        S::wake(&self.port);
    }

    /// Likewise at `now_ns` (monotonic), for a publisher that settles.
    #[inline]
    pub(crate) fn wake_at(&mut self, hint: &Hint, now_ns: i64) {
        fence(SeqCst);
        let word = hint.listeners().load(Acquire);
        if word == self.alone.0 && now_ns < self.alone.1 {
            self.owes = true;
            return;
        }
        self.owes = false;
        let until_ns = if S::wake(&self.port) {
            i64::MIN
        } else {
            now_ns.saturating_add(KNOWN_NS)
        };
        self.alone = (word, until_ns);
    }

    /// Wakes listeners that did not touch the word.
    #[inline]
    pub(crate) fn settle(&mut self) {
        if self.owes {
            self.owes = false;
            S::wake(&self.port);
        }
    }
}
