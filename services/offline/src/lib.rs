//! Commands on tables, shared by the executable (on files) and the Python package (on columns in memory).
//!
//! [`TableCommand`] holds the parsed words of a command, with the help of the command line. A command opens tables,
//! writes tables and prints messages only through a [`Host`]. The same engine, driven in the same way, therefore gives
//! the same results for all hosts.

#![forbid(unsafe_code)]

mod args;
mod compare;
mod files;
mod fuse;
mod host;
mod locate;
mod locate_columns;
mod picture;
mod printed;
mod reading;
mod score;
mod score_args;
mod simulate;
mod smooth;
mod terminal;
mod track;
pub mod values;

pub use args::{Smooth, TableCommand};
pub use files::{
    BUFFER_OCTETS, InputError, OutputFile, Usage, check_outputs, is_same_file, open, read, read_text, unwritable,
};
pub use host::{Host, TableInput, TableOutput};
pub use reading::{RowPlace, SkippedRows};
pub use smooth::{BlockForm, SmoothTotals, TrackBlocks};
pub use terminal::Terminal;

impl TableCommand {
    /// Executes the command.
    ///
    /// # Errors
    /// If the arguments are contradictory, a table cannot be read or written, or the host ends the command.
    pub fn run(&self, host: &dyn Host) -> anyhow::Result<()> {
        match self {
            Self::Simulate(simulate) => simulate::run(simulate, host),
            Self::Fuse(fuse) => fuse::run(fuse, host),
            Self::Smooth(smooth) => smooth::run(smooth, host),
            Self::Track(track) => track::run(track, host),
            Self::Locate(locate) => locate::run(locate, host),
            Self::Compare(compare) => compare::run(compare, host),
            Self::Score(score) => score::run(score, host),
        }
    }
}

/// Whether the arguments or an input were rejected, as opposed to a failure of the operation.
pub fn is_refused(error: &anyhow::Error) -> bool {
    error.is::<Usage>() || error.is::<InputError>() || error.is::<configuration::ConfigError>()
}
