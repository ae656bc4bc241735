//! Sensor tracks from files, as the offline engines take them: merged by time, checked row by row, with the settings
//! that a first pass over them suggests.

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
