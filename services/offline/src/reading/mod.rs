//! Sensor tracks from files for the offline engines: merged by time, checked row by row, with settings derived from
//! a first pass.

mod drive;
mod merged;
mod progress;
mod refusals;
mod setup;
mod survey;

pub(crate) use drive::{Driven, drive};
pub(crate) use merged::named_twice;
pub(crate) use progress::{Counting, Progress};
pub use refusals::Refusals;
pub(crate) use setup::{Setup, rule};
