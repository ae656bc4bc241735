//! State of a running deployment, as derived by any reader of its topics.
//!
//! Monitor, `koseki top`, `koseki status`, display and gateway read the same topics: health, alarms, origin of the
//! system frame, orders, and system tracks. Each shows another part in another form. The derived facts are the same,
//! and stand here: processes and their epochs, silent and restarted processes, sources with state and counters,
//! latencies, present alarms, and the sentence for each state.
//!
//! - [`Deployment`] takes the samples and returns the states;
//! - [`HealthBook`] holds the latest counters and the state of every process;
//! - [`ObservedProcess`], [`SourceState`], [`TrackCounts`] and [`StandingAlarm`] are the states of processes, sources,
//!   system tracks and alarms.
//!
//! A reader with the configuration gives the configured sources; without, sources are those with messages.
//!
//! Limits: counters are known from the first message that the reader has received. Earlier epochs of a process are
//! known only as far as their messages were received.
//!
//! Architecture invariant: this crate reads no clock and no topic; times and samples are arguments.

#![forbid(unsafe_code)]

mod book;
mod deployment;
mod present;
mod process;
mod source;
mod track_counts;

pub use book::{ChildState, HealthBook, LatestHealth, NO_MESSAGE};
pub use deployment::Deployment;
pub use present::StandingAlarm;
pub use process::{ObservedProcess, ProcessState, process_title, remark};
pub use source::{RefusedInput, SourceState};
pub use track_counts::TrackCounts;
