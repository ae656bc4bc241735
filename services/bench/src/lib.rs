//! The bench: drives the real processes at fixed rates, and measures them (PL-10).
//!
//! A latency by itself means little: it combines the machine, the transport, the work and the program's own
//! overhead. The bench therefore measures four things in one session, in turns, on the same cores, with the same
//! way of waiting and the same payload:
//!
//! | | measured | where |
//! |---|---|---|
//! | machine | a thread that only reads the clock | `jitter` |
//! | floor | a process that only passes the payload on, over bare shared memory | `relay` |
//! | layers | rings between threads, the bare relay, the relay over the bus, fusion | `floor`, `ring` |
//! | engine | the fusion of the same reports without any process around it | `engine_time` |
//! | pipeline | the fusion process as in any deployment | `site`, `measure` |
//!
//! Reports have due times fixed in advance (`pace`). Latency counts from the due time, so a stall shows in every
//! report that had to wait for its end. The bench's thread alternates between sending due reports and polling for
//! answers (`drive`); it does not allocate meanwhile. Each report is answered by one system track, which carries
//! its stamps; reports without an answer are counted (`recorder`).
//!
//! Limits: bench and fusion need a core each. A delay of the bench in sending shows as latency of the first stage,
//! and is part of the whole. The traffic is even, unlike that of real sensors. A subscriber of the system tracks
//! other than the bench is slower by its own waiting time.

#![forbid(unsafe_code)]

mod compare;
mod distributions;
mod drive;
mod engine;
mod engine_time;
mod exchange;
mod figures;
mod floor;
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
mod product;
mod progress;
mod recorder;
pub mod relay;
mod report;
mod ring;
mod search;
mod settings;
mod site;
mod subscribers;
mod text;
mod throughput;
mod tracker;
mod tracker_load;
mod traffic;
mod verdict;
mod watch;

pub use compare::run as compare;
pub use engine::run as engine;
pub use floor::run as floor;
pub use latency::run as latency;
pub use outputs::OutputFiles;
pub use product::{Engine, Product, TrackerStage};
pub use report::{BenchReport, MeasurementOutcome};
pub use settings::{Flood, MeasurementRefusal, Settings, Wait};
pub use throughput::run as throughput;
pub use tracker::{TrackerBench, TrackerFigures, run as tracker};
pub use tracker_load::TrackerLoad;
pub use watch::{Extra, run as watch};
