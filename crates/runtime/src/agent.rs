//! The part of a service that does its work, a bounded piece at a time.

use std::time::Duration;

use crate::clock::Now;
use crate::health::HealthEntry;

/// What a turn of an agent came to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Turn {
    /// There may be more to do at once.
    Worked,
    /// Nothing to do; look again after this time at the latest.
    Idle(Duration),
    /// All work is done, for good.
    Finished,
}

/// The part of a service that does its work.
pub trait Agent {
    /// Does a bounded piece of work.
    ///
    /// # Errors
    /// If the service cannot go on.
    fn turn(&mut self, now: Now) -> anyhow::Result<Turn>;

    /// Waits for work, `at_most` so long.
    ///
    /// # Errors
    /// If waiting fails.
    fn wait(&mut self, at_most: Duration) -> anyhow::Result<()> {
        std::thread::sleep(at_most);
        Ok(())
    }

    /// Says how it is. The first entry speaks of the process as a whole; others may speak of single sources.
    fn health(&self, entries: &mut Vec<HealthEntry>);

    /// The process has been told to stop, or has finished: time to write what is still in memory.
    ///
    /// # Errors
    /// If that fails.
    fn close(&mut self, now: Now) -> anyhow::Result<()> {
        let _ = now;
        Ok(())
    }
}
