//! `koseki replay`.

use std::path::PathBuf;

use clap::Args;

use runtime::Speed;

use super::values::{speed, utc};

pub(super) const REPLAY_EXAMPLES: &str = "\
Examples:
  koseki replay records/tower/latest --verify                  is it the picture that was recorded?
  koseki replay records/tower/latest --out again.csv
  koseki replay records/tower/latest --config other.toml --out other.csv
  koseki replay records/tower/latest --sources radar --out radar-alone.csv
  koseki replay records/tower/latest --live --instance again   the sensors' tracks once more, as of now

The recording must be of all topics: [recorder] format = [\"csv\", \"mcap\"]. Reports are worked off in the order in which
fusion did, from its recorded beginnings on. Where a report is missing, as while there was no recorder, what comes of it
is not verified, and told, up to the next beginning or the image of fusion that a restarted recorder asks for. Bits are equal for one build on processors of one family; --verify names the first
difference, and fails if there is one or nothing was verified. With --config sources are found by their names. With --live
at another speed than 1, targets seem as much faster.";

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
    /// Publish the sensor tracks as the sources did, into a deployment whose sources of these names are `external`
    #[arg(long, conflicts_with_all = ["verify", "config", "out"])]
    pub(crate) live: bool,
    /// Instance that they are published into [default: the name of the recorded one]
    #[arg(long, value_name = "NAME", requires = "live")]
    pub(crate) instance: Option<String>,
    /// Seconds of the recording per second, with --live [default: 1]; else it is as fast as can be
    #[arg(long, value_name = "FACTOR|max", value_parser = speed)]
    pub(crate) speed: Option<Speed>,
    /// Leave out what is of before this time, UTC, as in 2026-05-01T10:00:00Z: states, or slices sent
    #[arg(long, value_name = "TIME", value_parser = utc)]
    pub(crate) from: Option<i64>,
    /// Leave out what is of after this time
    #[arg(long, value_name = "TIME", value_parser = utc)]
    pub(crate) to: Option<i64>,
}
