//! Fusion: many sensors' tracks in, one system track per target out.
//!
//! [`Engine::take`] finds the system track of an arriving sensor track, or starts a new system track, and stores the
//! report in the source's history. The rule gives the weight of each source; the engine combines the sources at the
//! reference time, and hands the new state of the system track to the caller. [`Engine::advance`] lets time pass:
//! tracks without reports coast and end.
//!
//! The time in a report is a claim of the source. Live, [`Engine::take_at`] receives the time of arrival, and time
//! passes by that time alone. In order of time, time passes up to the point reached by all sources.
//!
//! A [`Driver`] makes these calls, and writes the [event log](event_log) from which another driver repeats them.
//!
//! With recorded inputs, [`Merger`] first puts the reports of all sources into the order of their times.
//!
//! Architecture invariants: no clock, no thread, no file, no shared memory. The same reports with the same settings
//! give the same states, bit for bit. After construction nothing is allocated; no hash map is iterated.

#![forbid(unsafe_code)]

mod admit;
mod associate;
mod continuity;
mod engine;
mod engine_counters;
#[cfg(test)]
mod engine_tests;
mod explanation;
mod judge;
mod measure;
mod merger;
mod orders;
mod publish;
mod schedule;
pub mod smoothing;
mod tables;
#[cfg(test)]
mod testing;
mod update;

pub use continuity::driver::{Driver, ReportNumber};
pub use continuity::{checkpoint, event_log, numbering, suspects};
pub use engine::Engine;
pub use engine_counters::EngineCounters;
pub use explanation::Sink;
pub use fusion_rules::{State, quality, rules};
pub(crate) use fusion_rules::{accuracy, history, places, state};
pub use fusion_settings::{self as settings, Settings};
pub use merger::{Merger, PushOutcome};
pub use source_models::{Learned, Sources, Stamps, registration};
pub use update::filter_input::FilterInput;
