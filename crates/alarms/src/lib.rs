//! Alarms: conditions that need attention, each reported once, in a sentence, with a remedy.
//!
//! Counters and estimates contain all facts but notify no operator. An alarm is derived from them in three steps:
//!
//! 1. A condition is *found* bad, good, or in between ([`Finding`]), from health messages and the picture;
//!    [`Silence`], [`Growth`], [`Lately`], [`Usual`] and [`Companions`] evaluate conditions that need memory.
//! 2. The [`Board`] *raises* the alarm after it was bad for long enough, and *clears* it after it was good for long
//!    enough (ISA-18.2 calls these on-delay and off-delay). A value in between changes nothing, so an alarm does
//!    not come and go with a value near its limit.
//! 3. Standing alarms are *published*: on the topic `system/alarms`, where each slice replaces the previous slice
//!    (crate `observed` reads it), and on standard error, at most at reading speed ([`RateLimit`]).
//!
//! The table of [`AlarmKind`] has one line for each alarm: its severity, delays, sentence and remedy.
//! docs/alarms.md and rules for Prometheus are generated from it.
//!
//! This crate reads no clock and no topic: times and messages are arguments.

#![forbid(unsafe_code)]

mod alert_rules;
mod board;
mod companions;
mod growth;
mod lately;
mod limits;
mod rate_limit;
mod reference;
mod registry;
mod silence;
mod subject;
mod usual;

pub use alert_rules::alert_rules;
pub use board::{AlarmHistory, Board, Finding, Round};
pub use companions::{Apart, Companions};
pub use growth::Growth;
pub use lately::Lately;
pub use limits::{Limits, above, below};
pub use rate_limit::RateLimit;
pub use reference::reference;
pub use registry::AlarmKind;
pub use silence::Silence;
pub use subject::Subject;
pub use usual::Usual;
