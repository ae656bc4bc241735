//! Deadlines of the stages.

use crate::stage::Stage;

/// Deadline of each stage, nanoseconds; a longer latency is counted as a miss.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Deadlines([Option<u64>; Stage::ALL.len()]);

impl Deadlines {
    /// Returns the deadline of `stage`, nanoseconds; `None` without one.
    pub fn get(&self, stage: Stage) -> Option<u64> {
        self.0[stage as usize]
    }

    /// Returns these deadlines with another deadline for `stage`.
    #[must_use]
    pub fn with(mut self, stage: Stage, deadline_ns: Option<u64>) -> Self {
        self.0[stage as usize] = deadline_ns;
        self
    }
}
