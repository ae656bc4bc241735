//! The bench: drives the real processes at fixed rates, and measures them (PL-10).
//!
//! A figure of a latency means little by itself: it is made of the machine, the transport, the work and what the
//! program adds to these. So four things are measured in one session, taking turns, on the same cores, in the same way
//! of waiting, with the same payload:
//!
//! | | what it is | where |
//! |---|---|---|
//! | machine | a thread that only reads the clock | `jitter` |
//! | floor | a process that only passes the payload on, over bare shared memory | `relay` |
//! | engine | the fusion of the same reports without any process around it | `engine_time` |
//! | pipeline | the fusion process as it runs in any deployment | `site`, `measure` |
//!
//! Reports are due at times that are fixed beforehand (`pace`), and latency counts from there, so a stall is seen in
//! every report that had to wait for its end. The bench's thread sends what is due and looks for what has come by turns
//! (`drive`); it allocates nothing meanwhile. Each report is answered by one system track, which carries its stamps;
//! those that are not are counted (`recorder`).
//!
//! Limits: bench and fusion need a core each; what the bench cannot send in time shows as latency of the first stage,
//! and is part of the whole. The traffic is even, which real sensors' is not. A subscriber of the system tracks that is
//! not the bench is slower by what it waits.

#![forbid(unsafe_code)]

mod compare;
mod distributions;
mod drive;
mod engine;
mod engine_time;
mod exchange;
mod figures;
mod jitter;
mod latency;
mod link;
mod links;
mod machine;
mod measure;
mod memory;
mod outputs;
mod pace;
mod picture;
mod pinned;
mod progress;
mod recorder;
pub mod relay;
mod report;
mod search;
mod settings;
mod site;
mod subscribers;
mod text;
mod throughput;
mod traffic;
mod verdict;
mod watch;

pub use compare::run as compare;
pub use engine::run as engine;
pub use latency::run as latency;
pub use outputs::Outputs;
pub use report::{Outcome, Report};
pub use settings::{Flood, Refused, Settings, Wait};
pub use throughput::run as throughput;
pub use watch::{Extra, run as watch};
