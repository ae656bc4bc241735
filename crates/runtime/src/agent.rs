//! Work of a service in bounded pieces.

use std::time::Duration;

use crate::clock::Now;
use crate::health::HealthEntry;

/// Result of a turn of an agent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Turn {
    /// More work may be waiting.
    Worked,
    /// No work; the next turn is due after this time at the latest.
    Idle(Duration),
    /// All work is done; no turn follows.
    Finished,
}

/// Work of a service.
pub trait Agent {
    /// Does a bounded piece of work.
    ///
    /// # Errors
    /// If the service cannot continue.
    fn turn(&mut self, now: Now) -> anyhow::Result<Turn>;

    /// Waits for work, at most for the time `at_most`.
    ///
    /// # Errors
    /// If the wait fails.
    fn wait(&mut self, at_most: Duration) -> anyhow::Result<()> {
        std::thread::sleep(at_most);
        Ok(())
    }

    /// Adds the health entries. The first entry is of the process as a whole; further entries may be of single
    /// sources.
    fn health(&self, entries: &mut Vec<HealthEntry>);

    /// Writes data that are still in memory, after a stop request or at the end of the work.
    ///
    /// # Errors
    /// If the data cannot be written.
    fn close(&mut self, now: Now) -> anyhow::Result<()> {
        let _ = now;
        Ok(())
    }
}
