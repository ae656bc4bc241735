//! Event log in shared memory.

use bus::{Bus, BusError, LogWriter, Transport};
use fusion::event_log::EventLog;
use messages::WorkStep;

/// Storage of steps that outlives the process.
#[derive(Debug)]
pub(crate) struct Log(LogWriter<WorkStep>);

impl Log {
    /// Opens the event log of the deployment.
    ///
    /// # Errors
    /// If there is no log.
    pub(crate) fn open<S: Transport>(bus: &Bus<S>) -> Result<Self, BusError> {
        bus.log_writer(&messages::event_log()).map(Self)
    }
}

impl EventLog for Log {
    #[inline]
    fn write(&mut self, step: &WorkStep) {
        self.0.write(step);
    }
}
