//! What every Koseki process needs of the outside world.
//!
//! Algorithms know no clock, no file and no core; somebody must. Here, and only here, are clocks read, signals caught,
//! threads pinned and configuration files opened. The services are built on top of it.

#![forbid(unsafe_code)]

pub mod clock;
pub mod config;
pub mod cores;
pub mod flow;
pub mod ground;
pub mod housekeeping;
pub mod service;
pub mod signals;

pub use clock::Now;
pub use config::{Config, ConfigError};
pub use service::{Agent, HealthEntry, Options, Process, Rest, Speed, Turn};
