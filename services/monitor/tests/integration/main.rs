//! The agent of the monitor over an in-process bus.

mod agent;
mod alarms;
mod allocation;
mod metrics;
mod watched;
