//! Waiter for work on several topics: spinning, blocking, or both.
//!
//! Spinning reacts within a microsecond and uses a core; blocking costs nothing and reacts within tens of
//! microseconds; the hybrid spins first and blocks after a while without work (PL-5). Each mode asks the same
//! question, "is there work?", and the queues give the answer, never a notification: a notification only triggers the
//! question.
//!
//! # No wake-up is lost
//! The critical moment is between finding the queues empty and going to sleep. A publisher first delivers a slice,
//! then notifies; a notification stays in the listener's socket until drained. The waiter drains only readable
//! sockets, and always asks for work *after* draining and *before* sleeping. Therefore the question finds a slice
//! with a drained notification, and a later slice leaves the socket readable, which ends the sleep at once.
//!
//! iceoryx2 0.10 adds a difficulty. To save system calls, a publisher does not write to the socket while the listener's
//! state indicates an earlier notification in the socket; draining resets this state *before* emptying the socket. The
//! byte of a notification in between is removed, but leaves the state set: from then on no publisher writes, and a
//! listener that only waits for the socket sleeps for ever. Draining until the socket is empty resets the state again,
//! except if a publisher is preempted within a few nanoseconds; two such drains in a row make this negligible, and
//! [`BACKSTOP`] bounds the remaining risk: no sleep lasts longer before the waiter asks for work.
//!
//! # Why not iceoryx2's `WaitSet`
//! A wait set borrows the listeners, so that a struct cannot own both, and allocates at every wake-up. `poll` on the
//! listeners' descriptors has neither disadvantage.

use std::hint;
use std::io;
use std::os::fd::{AsFd, BorrowedFd};
use std::thread;
use std::time::{Duration, Instant};

use iceoryx2::port::listener::Listener;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::Errno;

use crate::error::BusError;
use crate::ports::{DropGuard, Transport};

/// Most topics that a single waiter watches.
pub const WATCHED_MAX: usize = 256;

/// Longest sleep of a blocked waiter before the waiter asks for work without a notification. Each such question wakes
/// an idle machine, and finds nothing but wake-ups that were lost within nanoseconds.
pub const BACKSTOP: Duration = Duration::from_millis(200);

/// Time between two full looks of a waiter that spins.
const FULL_LOOK: Duration = Duration::from_millis(1);

/// How long before an expected slice a hybrid waiter is awake: the end of a sleep comes so much too late at most, on a
/// machine at rest.
const AWAKE_BEFORE: Duration = Duration::from_micros(100);

/// While spinning, the clock is read once in so many questions; a shared core is then offered to others.
const QUESTIONS_PER_LOOK_AT_THE_CLOCK: usize = 16;

/// How to wait.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WaitMode {
    /// Ask again and again. Costs a whole core, and the publishers nothing.
    Spin,
    /// Sleep until notified.
    Event,
    /// Ask again and again for a while, then sleep until notified; ask again and again around an expected time.
    Hybrid {
        /// How long to spin, nanoseconds.
        spin_ns: u64,
    },
}

/// How to look for work.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Look {
    /// Only where a publisher has given a hint ([`may_have_slices`](crate::Subscriber::may_have_slices)).
    Glance,
    /// Everywhere.
    Full,
}

/// Why a wait ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Woken {
    /// There is work.
    Work,
    /// There was none for the time given.
    Timeout,
    /// A signal came: check for a request to end.
    Signal,
}

/// Waits for work on the watched topics.
#[derive(Debug)]
pub struct Waiter<S: Transport> {
    mode: WaitMode,
    /// Whether others are offered the core while this waiter spins.
    yields: bool,
    /// A descriptor for each entry of `listeners`, in the same order. Declared first: dropped first.
    descriptors: Vec<PollFd<'static>>,
    listeners: Vec<DropGuard<Listener<S>>>,
    missed: u64,
}

/// How a sleep ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Slept {
    Notified,
    FullTime,
    Signal,
}

impl<S: Transport> Waiter<S> {
    pub(crate) fn new(mode: WaitMode) -> Self {
        Self {
            mode,
            yields: true,
            descriptors: Vec::new(),
            listeners: Vec::new(),
            missed: 0,
        }
    }

    /// Returns this waiter for a core of its own: the spinning makes no system call. On a shared core, spinning would
    /// delay other processes, and be delayed by these.
    #[must_use]
    pub fn without_yielding(mut self) -> Self {
        self.yields = false;
        self
    }

    /// Whether there is a place for another listener.
    pub(crate) fn has_room(&self) -> bool {
        self.listeners.len() < WATCHED_MAX
    }

    /// Is woken by `listener`, too.
    pub(crate) fn listen(&mut self, listener: DropGuard<Listener<S>>) {
        // SAFETY: the descriptor stays open as long as the listener lives, which `self` owns, never removes, and drops
        // after `descriptors`; nothing hands the `'static` borrow out.
        let descriptor: BorrowedFd<'static> = unsafe {
            use std::os::fd::AsRawFd as _;
            BorrowedFd::borrow_raw(S::descriptor(&listener).as_raw_fd())
        };
        self.descriptors
            .push(PollFd::from_borrowed_fd(descriptor, PollFlags::IN));
        self.listeners.push(listener);
    }

    /// How this waiter waits.
    pub fn mode(&self) -> WaitMode {
        self.mode
    }

    /// Wake-ups that did not arrive: times a sleep lasted until the [`BACKSTOP`], and work was there.
    pub fn missed_wake_ups(&self) -> u64 {
        self.missed
    }

    /// Returns descriptors that become readable when a watched topic has work, for a program that also waits for other
    /// events. The descriptors stay readable until [drained](Self::drain).
    pub fn descriptors(&self) -> impl Iterator<Item = BorrowedFd<'_>> {
        self.descriptors.iter().map(AsFd::as_fd)
    }

    /// Makes the descriptors unreadable again. Ask for work afterwards, and wait no longer than [`BACKSTOP`] before the
    /// next request for work.
    ///
    /// # Errors
    /// [`BusError::Wait`] if the system refuses to read.
    pub fn drain(&mut self) -> Result<(), BusError> {
        self.sleep(Duration::ZERO).map(|_| ())
    }

    /// Waits until `has_work` returns true, `timeout` has passed, or a signal arrived. `has_work` is called first, so
    /// that present work is found without delay; it should check every subscriber ([`has_slices`]), and the caller's
    /// other events. In the blocking modes only watched topics end a sleep early.
    ///
    /// [`has_slices`]: crate::Subscriber::has_slices
    ///
    /// # Errors
    /// [`BusError::Wait`] if the system refuses to wait.
    pub fn wait(&mut self, timeout: Duration, mut has_work: impl FnMut() -> bool) -> Result<Woken, BusError> {
        self.wait_at_a_glance((timeout, None), |_| has_work())
    }

    /// Waits as [`wait`](Self::wait) does, with glances where a full look is not due: full looks follow each sleep, and
    /// each millisecond of spinning. If work is `expected` after a time, a hybrid waiter also spins around that time.
    ///
    /// # Errors
    /// [`BusError::Wait`] if the system refuses to wait.
    pub fn wait_at_a_glance(
        &mut self,
        (timeout, expected): (Duration, Option<Duration>),
        mut has_work: impl FnMut(Look) -> bool,
    ) -> Result<Woken, BusError> {
        if has_work(Look::Glance) {
            return Ok(Woken::Work);
        }
        let start = Instant::now();
        let spin = match self.mode {
            WaitMode::Spin => timeout,
            WaitMode::Event => Duration::ZERO,
            WaitMode::Hybrid { spin_ns } => Duration::from_nanos(spin_ns).min(timeout),
        };
        if spin_until(start, spin, self.yields, &mut has_work) {
            return Ok(Woken::Work);
        }
        // Times from the start at which to be awake again, and to sleep again.
        let mut awake = match (self.mode, expected) {
            (WaitMode::Hybrid { spin_ns }, Some(expected)) if expected < timeout => {
                let around = Duration::from_nanos(spin_ns).max(AWAKE_BEFORE);
                Some((expected.saturating_sub(AWAKE_BEFORE), expected + around))
            }
            _ => None,
        };
        loop {
            if let Some((from, until)) = awake
                && start.elapsed() >= from
            {
                awake = None;
                if spin_until(start, until.min(timeout), self.yields, &mut has_work) {
                    return Ok(Woken::Work);
                }
            }
            let Some(left) = timeout.checked_sub(start.elapsed()).filter(|d| !d.is_zero()) else {
                return Ok(Woken::Timeout);
            };
            let until_awake = awake.map(|(from, _)| from.saturating_sub(start.elapsed()));
            let time = left.min(until_awake.unwrap_or(BACKSTOP)).min(BACKSTOP);
            let slept = self.sleep(time)?;
            if has_work(Look::Full) {
                self.missed += u64::from(slept == Slept::FullTime && time == BACKSTOP);
                return Ok(Woken::Work);
            }
            if slept == Slept::Signal {
                return Ok(Woken::Signal);
            }
        }
    }

    /// Sleeps until a socket is readable, and drains the readable sockets, or, after the full time, all.
    fn sleep(&mut self, time: Duration) -> Result<Slept, BusError> {
        let watched = self.listeners.len();
        let failed = |source: io::Error| BusError::Wait { watched, source };
        let time = Timespec {
            tv_sec: time.as_secs().cast_signed(),
            tv_nsec: time.subsec_nanos().into(),
        };
        let readable = match poll(&mut self.descriptors, Some(&time)) {
            Ok(readable) => readable,
            Err(Errno::INTR) => return Ok(Slept::Signal),
            Err(error) => return Err(failed(error.into())),
        };
        for (descriptor, listener) in self.descriptors.iter().zip(&self.listeners) {
            if readable == 0 || !descriptor.revents().is_empty() {
                S::drain(listener).map_err(failed)?;
            }
        }
        Ok(if readable == 0 {
            Slept::FullTime
        } else {
            Slept::Notified
        })
    }
}

/// Asks for work until work is there (`true`) or `time` has passed since `start`.
fn spin_until(start: Instant, time: Duration, yields: bool, has_work: &mut impl FnMut(Look) -> bool) -> bool {
    let mut looked = Duration::ZERO;
    loop {
        let elapsed = start.elapsed();
        if elapsed >= time {
            return false;
        }
        if elapsed - looked >= FULL_LOOK {
            looked = elapsed;
            if has_work(Look::Full) {
                return true;
            }
        }
        for _ in 0..QUESTIONS_PER_LOOK_AT_THE_CLOCK {
            if has_work(Look::Glance) {
                return true;
            }
            // On a dedicated core a pause has no benefit, and delays the answer.
            if yields {
                hint::spin_loop();
            }
        }
        if yields {
            thread::yield_now();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transport::InProcess;

    #[test]
    fn a_hybrid_waiter_spins_around_an_expected_time() {
        let half = Duration::from_millis(500);
        let mode = WaitMode::Hybrid {
            spin_ns: half.as_nanos() as u64,
        };
        let mut waiter: Waiter<InProcess> = Waiter::new(mode);
        let glances_after_sleep = |waiter: &mut Waiter<InProcess>, expected| {
            let (begun, mut late) = (Instant::now(), 0);
            let woken = waiter.wait_at_a_glance((3 * half, expected), |look| {
                late += u32::from(look == Look::Glance && begun.elapsed() > half + half / 2);
                false
            });
            assert_eq!(woken.unwrap(), Woken::Timeout);
            late
        };
        assert_eq!(glances_after_sleep(&mut waiter, None), 0);
        assert!(glances_after_sleep(&mut waiter, Some(2 * half)) > 0);
    }
}
