//! Alarms: conditions that somebody should look at, told once, in a sentence, with what to do about them.
//!
//! Counters and estimates say everything and tell nobody. An alarm is made of them in three steps:
//!
//! 1. Something is *found* to be bad, good, or in between ([`Finding`]), from health messages and the picture;
//!    [`Silence`], [`Growth`], [`Lately`], [`Usual`] and [`Companions`] find what takes a memory.
//! 2. The [`Board`] *raises* the alarm when it has been bad for long enough, and *clears* it when it has been good for
//!    long enough (ISA-18.2 calls these on-delay and off-delay). What lies in between changes nothing: so an alarm does
//!    not come and go with a value that wavers about its limit.
//! 3. What stands is *told*: on the topic `system/alarms`, each slice of which replaces the one before
//!    ([`Present`] reads it); on standard error, no faster than a person reads ([`RateLimit`]).
//!
//! Which alarms there are, how bad each is, how long its delays are, what it says and what to do is one line each in
//! the table of [`AlarmKind`]; docs/alarms.md and rules for Prometheus are written from it.
//!
//! Nothing here reads a clock or a topic: times and messages are arguments.

#![forbid(unsafe_code)]

mod alert_rules;
mod board;
mod companions;
mod growth;
mod lately;
mod limits;
mod present;
mod rate_limit;
mod reference;
mod registry;
mod silence;
mod subject;
mod usual;

pub use alert_rules::alert_rules;
pub use board::{Board, Finding, History, Round};
pub use companions::{Apart, Companions};
pub use growth::Growth;
pub use lately::Lately;
pub use limits::{Limits, above, below};
pub use present::Present;
pub use rate_limit::RateLimit;
pub use reference::reference;
pub use registry::AlarmKind;
pub use silence::Silence;
pub use subject::Subject;
pub use usual::Usual;
