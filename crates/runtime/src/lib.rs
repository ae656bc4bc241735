//! What every Koseki process needs of the outside world.
//!
//! Algorithms know no clock, no file and no core; somebody must. Here, and only here, are clocks read, signals caught
//! and threads pinned. Nothing here knows an algorithm or the configuration of one: the crate `configuration` says what
//! a
//! [`Deployment`] is, and the services are built on top of both.

#![forbid(unsafe_code)]

mod agent;
pub mod clock;
pub mod cores;
pub mod flow;
mod health;
pub mod housekeeping;
pub mod instance;
mod loopback;
mod notice;
mod numbered_files;
mod process;
pub mod service;
pub mod signals;

pub use agent::{Agent, Turn};
pub use clock::Now;
pub use health::HealthEntry;
pub use instance::Deployment;
pub use notice::notice;
pub use numbered_files::NumberedFiles;
pub use process::{Options, Process, Speed};
pub use service::Rest;
