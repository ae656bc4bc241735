//! Times for saving tracks: after each change, and every second, so that the saved time shows the age of the data.

/// Interval for saving unchanged tracks again, nanoseconds.
const AGAIN_NS: i64 = 1_000_000_000;

/// State of the tracks at the last keeping.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct LastKept {
    changes: u64,
    /// UTC, nanoseconds.
    time_ns: i64,
}

impl LastKept {
    /// Returns whether saving is due at `now_ns` (UTC, nanoseconds), after this number of changes; if so, records the
    /// saving as done.
    pub(crate) fn is_due(&mut self, changes: u64, now_ns: i64) -> bool {
        let is_due = changes != self.changes || now_ns.abs_diff(self.time_ns) >= AGAIN_NS.unsigned_abs();
        if is_due {
            *self = Self {
                changes,
                time_ns: now_ns,
            };
        }
        is_due
    }
}
