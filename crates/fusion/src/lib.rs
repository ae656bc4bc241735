//! Fusion: many sensors' tracks in, one system track per target out.
//!
//! A sensor track arrives; [`Engine::take`] finds the system track it belongs to (or starts one), stores the report
//! in that source's history, asks the rule how much each source counts, combines them at the reference time, and hands
//! the new state of the system track to the caller. [`Engine::advance`] lets time pass: tracks without reports coast
//! and end.
//!
//! What a source says of the time is a claim. Live, [`Engine::take_at`] is told when a report came, and time passes by
//! that alone; in order of time, it passes to where all sources have got.
//!
//! A [`Driver`] makes these calls, and writes the [event log](event_log) from which another driver repeats them.
//!
//! With recorded inputs, [`Merger`] first puts the reports of all sources into the order of their times.
//!
//! Architecture invariants: no clock, no thread, no file, no shared memory; the same reports with the same settings
//! give the same states, bit for bit; after construction nothing is allocated; no hash map is iterated.

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
pub use source_models::{Learned, Sources, registration};
pub use update::filter_input::FilterInput;
