//! The command line: that of `koseki bench` and `koseki torture`.

mod bench;
mod tracker;

use std::path::PathBuf;

use clap::{Parser, Subcommand};
use torture::Torture;

use bench::BENCH_EXAMPLES;
pub(crate) use bench::{BenchCommand, BenchRelay};

/// Measures Koseki, and tests it by faults: executed by `koseki bench` and `koseki torture`.
#[derive(Debug, Parser)]
#[command(name = "koseki", bin_name = "koseki", version, max_term_width = 80)]
pub(crate) struct LabCli {
    /// Base folder of instances, for this command and its child processes [default: the first folder owned by this
    /// user of $KOSEKI_ROOT, /run/koseki, $XDG_RUNTIME_DIR/koseki, /tmp/koseki-UID]
    #[arg(long, value_name = "DIR", global = true)]
    pub(crate) root: Option<PathBuf>,
    #[command(subcommand)]
    pub(crate) command: LabCommand,
}

/// Commands.
#[derive(Debug, Subcommand)]
pub(crate) enum LabCommand {
    /// Measure latency and throughput of the real processes, beside a bare relay on the same machine
    #[command(after_help = BENCH_EXAMPLES, subcommand)]
    Bench(BenchCommand),
    /// Inject random faults into a separate deployment, and judge the effects on a subscriber
    #[command(after_help = torture::EXAMPLES)]
    Torture(Torture),
    /// The bare relay of `koseki bench`
    #[command(hide = true)]
    BenchRelay(BenchRelay),
    /// Write the man pages into a folder, for packages
    #[command(hide = true)]
    Man {
        /// The folder
        #[arg(long, value_name = "FOLDER")]
        out: PathBuf,
    },
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory as _;

    use super::*;

    #[test]
    fn the_definitions_are_consistent() {
        LabCli::command().debug_assert();
    }
}
