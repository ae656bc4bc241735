//! What every Koseki process needs of the outside world.
//!
//! Algorithms know no clock, no file and no core; somebody must. Here, and only here, are clocks read, signals caught
//! and threads pinned. Nothing here knows an algorithm or the configuration of one: the crate `configuration` says what a
//! [`Deployment`] is, and the services are built on top of both.

#![forbid(unsafe_code)]

pub mod clock;
pub mod cores;
pub mod flow;
pub mod ground;
pub mod housekeeping;
mod loopback;
pub mod service;
pub mod signals;

pub use clock::Now;
pub use service::{Agent, Deployment, HealthEntry, Options, Process, Rest, Speed, Turn};
