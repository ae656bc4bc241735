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

mod alignment;
mod association_step;
mod assumed;
mod body_frame;
mod border;
pub mod checkpoint;
mod credibility;
mod crossing;
mod dependence;
mod description;
mod detection_map;
mod driver;
#[cfg(test)]
mod driver_tests;
mod engine;
mod engine_counters;
#[cfg(test)]
mod engine_tests;
mod error_shape;
pub mod event_log;
mod existence;
mod explanation;
mod filter;
#[cfg(test)]
mod filter_tests;
mod foresight;
mod former_members;
mod gaps;
mod host_clock;
mod identity;
mod image;
mod inlet;
mod innovation;
mod kept_measurement;
mod kept_measurements;
mod late;
mod learned;
mod life;
mod lifetimes;
mod linking;
mod manoeuvres;
mod mean_errors;
mod mean_innovation;
mod measurement;
mod merger;
mod motion;
mod moving_sources;
mod namesakes;
mod number_hasher;
pub mod numbering;
mod order_table;
mod orders;
mod outlet;
mod plane_filter;
mod point_leaps;
mod points;
mod pressure;
mod principal;
mod publishing;
mod purity;
mod quota;
mod recognition;
mod reference_point;
pub mod registration;
mod restarts;
mod restore;
mod resumption;
mod rhythm;
mod scan;
mod schedule;
mod seeker;
mod sensor_tracks;
mod silent_tracks;
pub mod smoothing;
mod source_model;
mod sources;
mod step_memory;
pub mod suspects;
mod system_track_message;
mod system_tracks;
#[cfg(test)]
mod testing;
mod tracker_gain;
mod tracks;
mod verification;
mod vertical_filter;
mod weighing;

pub use driver::{Driver, ReportNumber};
pub use engine::Engine;
pub use engine_counters::EngineCounters;
pub use explanation::Sink;
pub use fusion_rules::{State, quality, rules};
pub(crate) use fusion_rules::{accuracy, gross, history, places, state};
pub use fusion_settings::{self as settings, Settings};
pub use learned::Learned;
pub use measurement::FilterInput;
pub use merger::{Merger, PushOutcome};
