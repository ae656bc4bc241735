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

mod association_step;
mod assumed;
mod border;
pub mod checkpoint;
mod crossing;
mod description;
mod driver;
#[cfg(test)]
mod driver_tests;
mod engine;
mod engine_counters;
#[cfg(test)]
mod engine_tests;
pub mod event_log;
mod existence;
mod explanation;
mod filter;
mod filter_input;
#[cfg(test)]
mod filter_tests;
mod foresight;
mod former_members;
mod host_clock;
mod identity;
mod image;
mod inlet;
mod kept_measurement;
mod kept_measurements;
mod late;
mod life;
mod linking;
mod mean_errors;
mod merger;
mod namesakes;
mod number_hasher;
pub mod numbering;
mod order_table;
mod orders;
mod outlet;
mod plane_filter;
mod point_leaps;
mod publishing;
mod quota;
mod recognition;
mod reference_point;
mod restore;
mod resumption;
mod scan;
mod schedule;
mod sensor_tracks;
mod silent_tracks;
pub mod smoothing;
pub mod suspects;
mod system_track_message;
mod system_tracks;
#[cfg(test)]
mod testing;
mod tracks;
mod verification;
mod vertical_filter;
mod weighing;

pub use driver::{Driver, ReportNumber};
pub use engine::Engine;
pub use engine_counters::EngineCounters;
pub use explanation::Sink;
pub use filter_input::FilterInput;
pub use fusion_rules::{State, quality, rules};
pub(crate) use fusion_rules::{accuracy, history, places, state};
pub use fusion_settings::{self as settings, Settings};
pub use merger::{Merger, PushOutcome};
pub use source_models::{Learned, Sources, registration};
