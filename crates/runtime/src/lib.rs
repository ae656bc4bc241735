//! Access of Koseki's processes to the machine.
//!
//! Algorithms use no clock, file or core. This crate alone reads clocks, catches signals and pins threads. It
//! contains no algorithm and no configuration of one: a process gets the facts of its [`deployment`], and its own
//! settings.

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
mod order_desk;
mod pause;
mod process;
mod publication;
mod queues;
pub mod service;
pub mod signals;
mod wake_up_limit;

pub use agent::{Agent, Turn};
pub use clock::Now;
pub use health::HealthEntry;
pub use notice::notice;
pub use numbered_files::NumberedFiles;
pub use pause::LookPause;
pub use process::{Options, Process, Speed};
pub use publication::Publication;
pub use service::Rest;
pub use wake_up_limit::WakeUpLimit;
