//! Both clocks, read in one place.
//!
//! Stamps that are subtracted from one another are monotonic (`CLOCK_MONOTONIC`, common to all processes of a
//! machine). Times that are compared with sensors' times are UTC. No other crate reads a clock: time is an argument
//! of algorithms, and a duty cycle reads the clocks once.

use std::time::Instant;

use rustix::time::{ClockId, clock_gettime};

/// Both clocks at one moment, nanoseconds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Now {
    /// `CLOCK_MONOTONIC`.
    pub mono_ns: i64,
    /// UTC since 1970.
    pub utc_ns: i64,
}

impl Now {
    /// Reads both clocks.
    pub fn read() -> Self {
        Self {
            mono_ns: mono_ns(),
            utc_ns: read(ClockId::Realtime),
        }
    }
}

/// UTC of the machine at one moment, continued by the monotonic clock: later changes of the machine's UTC have no
/// effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SteadyClock {
    /// UTC less monotonic time, nanoseconds.
    ahead_ns: i64,
}

impl SteadyClock {
    /// Creates the clock that agrees with the machine's UTC at `now`.
    pub fn of(now: Now) -> Self {
        Self {
            ahead_ns: now.utc_ns.saturating_sub(now.mono_ns),
        }
    }

    /// Returns the clock's UTC at a monotonic time, nanoseconds.
    pub fn utc_ns(self, mono_ns: i64) -> i64 {
        mono_ns.saturating_add(self.ahead_ns)
    }

    /// Returns the clock's lead over the machine's UTC at `now`, nanoseconds.
    pub fn ahead_of(self, now: Now) -> i64 {
        self.utc_ns(now.mono_ns).saturating_sub(now.utc_ns)
    }

    /// Returns the same clock, moved ahead by `by_ns`.
    #[must_use]
    pub fn moved(self, by_ns: i64) -> Self {
        Self {
            ahead_ns: self.ahead_ns.saturating_add(by_ns),
        }
    }
}

/// Returns the identity of the machine's present boot. The identity changes with each reboot, with one exception in
/// 65,535, and is never 0; 0 if the kernel does not provide one.
pub fn boot_identity() -> u16 {
    let identity = std::fs::read("/proc/sys/kernel/random/boot_id").unwrap_or_default();
    if identity.is_empty() {
        return 0;
    }
    // FNV-1a, folded.
    let hash = identity.iter().fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| {
        (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3)
    });
    (hash % u64::from(u16::MAX)) as u16 + 1
}

/// Reads the monotonic clock, nanoseconds.
pub fn mono_ns() -> i64 {
    read(ClockId::Monotonic)
}

/// Reads the monotonic clock as a point in time for waits.
pub fn instant() -> Instant {
    Instant::now()
}

fn read(clock: ClockId) -> i64 {
    let time = clock_gettime(clock);
    time.tv_sec * 1_000_000_000 + time.tv_nsec
}
