//! Sensor tracks from files for the offline engines: merged by time, checked row by row, with settings derived from
//! a first pass.

mod arrivals;
mod begun;
mod drive;
mod file_plane;
mod kept;
mod merged;
mod named;
mod platform_states;
mod progress;
mod reader;
mod refusals;
mod sensors;
mod setup;
mod survey;
mod time_base;

pub(crate) use arrivals::ArrivedReport;
pub(crate) use begun::BegunFile;
pub(crate) use drive::{DriveTotals, EngineReader, drive, drive_into};
pub(crate) use file_plane::FilePlane;
pub(crate) use platform_states::platform_states;
pub(crate) use progress::{CountingInput, Progress};
pub(crate) use refusals::{MIDNIGHT_REMEDY, MIDNIGHT_STEP_NS};
pub use refusals::{RowPlace, SkippedRows};
pub(crate) use setup::{Setup, rule};
pub(crate) use time_base::FileBases;
