//! How long each stage may take.

use crate::stage::Stage;

/// The deadline of each stage that has one, nanoseconds: what takes longer is a miss, and is counted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Deadlines([Option<u64>; Stage::ALL.len()]);

impl Deadlines {
    /// How long `stage` may take, nanoseconds; `None` if nobody said.
    pub fn get(&self, stage: Stage) -> Option<u64> {
        self.0[stage as usize]
    }

    /// These deadlines with another one for `stage`.
    #[must_use]
    pub fn with(mut self, stage: Stage, deadline_ns: Option<u64>) -> Self {
        self.0[stage as usize] = deadline_ns;
        self
    }
}
