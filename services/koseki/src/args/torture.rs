//! `koseki torture`.

use std::path::PathBuf;

use clap::Args;

pub(super) const TORTURE_EXAMPLES: &str = "\
Examples:
  koseki torture --minutes 3 --seed 7 --json torture.json
  koseki torture --set fusion.standby=true
  koseki torture tower.toml --minutes 60
  koseki torture --only none --minutes 30 --json soak.json

The deployment is one of its own, in a folder of its own: what else runs on the machine is not touched. The seed decides
which faults come, and whom they hit. Exit code 1 if anything does not come back, a target goes on under another number,
a number is given twice, or something is left behind. As root, disk and shared memory are file systems of its own, and
are full now and then. The result says each quarter of a minute which memory, files and time are used. For sources that send addresses: by them targets are told apart.";

/// `koseki torture`.
#[derive(Debug, Args)]
pub(crate) struct Torture {
    /// Configuration of what is to suffer [default: the demonstration's]
    #[arg(value_name = "CONFIG")]
    pub(crate) config: Option<PathBuf>,
    /// How long
    #[arg(long, value_name = "MINUTES", default_value_t = 3.0)]
    pub(crate) minutes: f64,
    /// Seed of the faults
    #[arg(long, value_name = "NUMBER", default_value_t = 1)]
    pub(crate) seed: u64,
    /// Cause this fault only (repeatable); none: no fault, to see what is used of the machine in the long run
    #[arg(long, value_name = "FAULT")]
    pub(crate) only: Vec<String>,
    /// Write the result
    #[arg(long, value_name = "FILE")]
    pub(crate) json: Option<PathBuf>,
    /// Replace a value of the configuration (repeatable)
    #[arg(long, value_name = "KEY=VALUE")]
    pub(crate) set: Vec<String>,
}
