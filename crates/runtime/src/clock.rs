//! The two clocks, read in one place.
//!
//! Stamps that are subtracted from one another are monotonic (`CLOCK_MONOTONIC`, the same for all processes of a
//! machine); times that are compared with sensors' times are UTC. Nobody else reads a clock: algorithms are told the
//! time, and a duty cycle reads it once.

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

/// Reads the monotonic clock, nanoseconds.
pub fn mono_ns() -> i64 {
    read(ClockId::Monotonic)
}

/// Reads the monotonic clock as a point in time from which waiting is measured.
pub fn instant() -> Instant {
    Instant::now()
}

fn read(clock: ClockId) -> i64 {
    let time = clock_gettime(clock);
    time.tv_sec * 1_000_000_000 + time.tv_nsec
}
