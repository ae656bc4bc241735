//! Commands on tables, for whoever runs them: the executable on files, the Python package on columns in memory.
//!
//! A command is what its words say ([`Command`], with the help of the command line). It opens, writes and speaks only
//! through its [`Host`], so that one and the same engine, driven in one and the same way, has the same results for all.

#![forbid(unsafe_code)]

mod args;
mod compare;
mod files;
mod fuse;
mod host;
mod locate;
mod picture;
mod reading;
mod score;
mod simulate;
mod terminal;
mod track;
pub mod values;

pub use args::{Command, refusal};
pub use files::{InputError, OutputFile, Usage, check_outputs, is_same_file, open};
pub use host::{Host, Input, Output};
pub use reading::Refusals;
pub use terminal::Terminal;

impl Command {
    /// Does what the words say.
    ///
    /// # Errors
    /// If what is asked for makes no sense, a table cannot be read or written, or the host wants it to end.
    pub fn run(&self, host: &dyn Host) -> anyhow::Result<()> {
        match self {
            Self::Simulate(simulate) => simulate::run(simulate, host),
            Self::Fuse(fuse) => fuse::run(fuse, host),
            Self::Track(track) => track::run(track, host),
            Self::Locate(locate) => locate::run(locate, host),
            Self::Compare(compare) => compare::run(compare, host),
            Self::Score(score) => score::run(score, host),
        }
    }
}

/// Whether the words or an input were refused, rather than that something failed.
pub fn is_refused(error: &anyhow::Error) -> bool {
    error.is::<Usage>() || error.is::<InputError>() || error.is::<configuration::ConfigError>()
}
