//! Continuation and repetition of the process's work: checkpoint, snapshot, event log.

pub mod checkpoint;
pub(crate) mod driver;
#[cfg(test)]
pub(crate) mod driver_tests;
pub mod event_log;
pub(crate) mod image;
pub mod numbering;
pub(crate) mod restore;
pub mod suspects;
