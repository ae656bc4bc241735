//! `koseki replay`.

use std::path::PathBuf;

use clap::Args;

use super::values::utc;

pub(super) const REPLAY_EXAMPLES: &str = "\
Examples:
  koseki replay records/tower/latest --verify                  is it the picture that was recorded?
  koseki replay records/tower/latest --out again.csv
  koseki replay records/tower/latest --config other.toml --out other.csv
  koseki replay records/tower/latest --sources radar --out radar-alone.csv

The recording must be of all topics: [recorder] format = [\"csv\", \"mcap\"]. Reports are worked off in the order in which
fusion did, between its recorded beginnings; what came of a fusion whose beginning, or of which a report, is not in the
recording is not verified, and told. Bits are equal for one build on processors of one family; --verify names the first
difference, and fails if there is one or nothing was verified. With --config sources are found by their names.";

/// `koseki replay`.
#[derive(Debug, Args)]
pub(crate) struct Replay {
    /// The folder of a start, or one file of it
    #[arg(value_name = "RECORDING")]
    pub(crate) recording: PathBuf,
    /// Write the states of the system tracks, as the recorder does
    #[arg(long, value_name = "FILE")]
    pub(crate) out: Option<PathBuf>,
    /// Compare the system tracks with those recorded, in all fields but the stamps of processing
    #[arg(long, conflicts_with_all = ["config", "sources"])]
    pub(crate) verify: bool,
    /// Fuse by another configuration
    #[arg(long, value_name = "CONFIG")]
    pub(crate) config: Option<PathBuf>,
    /// Leave out all other sources
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    pub(crate) sources: Vec<String>,
    /// Write no state of before this time, UTC, as in 2026-05-01T10:00:00Z
    #[arg(long, value_name = "TIME", value_parser = utc)]
    pub(crate) from: Option<i64>,
    /// Write no state of after this time
    #[arg(long, value_name = "TIME", value_parser = utc)]
    pub(crate) to: Option<i64>,
}
