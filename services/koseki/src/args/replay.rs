//! `koseki replay`.

use std::path::PathBuf;

use clap::Args;

use runtime::Speed;

use super::values::{speed, utc};

pub(super) const REPLAY_EXAMPLES: &str = "\
Examples:
  koseki replay records/tower/latest --verify
      compares with the recorded states
  koseki replay records/tower/latest --out again.csv
  koseki replay records/tower/latest --config other.toml --out other.csv
  koseki replay records/tower/latest --sources radar --out radar-alone.csv
  koseki replay records/tower/latest --live --instance again
      the sensor tracks again, at the present time

The recording must contain all topics: [recorder] format = [\"csv\", \"mcap\"].
Reports are processed in fusion's order, from a recorded start or snapshot on.
After a missing report, for example during an outage of the recorder, states are
not verified until the next start or snapshot; the summary states this time.
Bits are equal for the same build on processors of the same family. --verify
prints the first difference, and fails with a difference, without any verified
state, or with damaged parts in the recording. With --config sources are matched
by name. With --live at another speed than 1, targets move faster accordingly.";

/// `koseki replay`.
#[derive(Debug, Args)]
pub(crate) struct ReplayArgs {
    /// The folder of a recording, or a file in the folder
    #[arg(value_name = "RECORDING")]
    pub(crate) recording: PathBuf,
    /// Write the states of the system tracks, in the recorder's form
    #[arg(long, value_name = "FILE")]
    pub(crate) out: Option<PathBuf>,
    /// Compare with the recorded system tracks in all fields except the stamps of processing
    #[arg(long, conflicts_with_all = ["config", "sources"])]
    pub(crate) verify: bool,
    /// Fuse with another configuration
    #[arg(long, value_name = "CONFIG")]
    pub(crate) config: Option<PathBuf>,
    /// Use only these sources
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    pub(crate) sources: Vec<String>,
    /// Publish the sensor tracks into a deployment, to sources with the same names and kind `external`
    #[arg(long, conflicts_with_all = ["verify", "config", "out"])]
    pub(crate) live: bool,
    /// Instance that receives the sensor tracks [default: the name of the recorded instance]
    #[arg(long, value_name = "NAME", requires = "live")]
    pub(crate) instance: Option<String>,
    /// Seconds of the recording per second, with --live [default: 1]; otherwise the speed is unlimited
    #[arg(long, value_name = "FACTOR|max", value_parser = speed)]
    pub(crate) speed: Option<Speed>,
    /// Omit states, or slices to send, of before this time, UTC, as in 2026-05-01T10:00:00Z
    #[arg(long, value_name = "TIME", value_parser = utc)]
    pub(crate) from: Option<i64>,
    /// Omit states, or slices to send, of after this time
    #[arg(long, value_name = "TIME", value_parser = utc)]
    pub(crate) to: Option<i64>,
}
