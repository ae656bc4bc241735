//! Clocks that all processes of a deployment share.

use rustix::time::{ClockId, clock_gettime};

/// Monotonic time, nanoseconds.
pub(crate) fn mono_ns() -> u64 {
    let time = clock_gettime(ClockId::Monotonic);
    time.tv_sec.unsigned_abs() * 1_000_000_000 + time.tv_nsec.unsigned_abs()
}

/// UTC, nanoseconds since 1970.
pub(crate) fn utc_ns() -> i64 {
    let time = clock_gettime(ClockId::Realtime);
    time.tv_sec.saturating_mul(1_000_000_000).saturating_add(time.tv_nsec)
}
