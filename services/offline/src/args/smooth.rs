//! Arguments and help of `koseki smooth`.

use std::path::PathBuf;
use std::time::Duration;

use clap::Args;
use command_line::values::above_zero;
use frames::Geodetic;
use outgoing::HeightReference;

use super::OfflineInput;
use crate::values::{heights, place, refresh};

pub(super) const SMOOTH_EXAMPLES: &str = "\
Examples:
  koseki smooth --tracks radar.csv adsb.csv --refresh 1 --out smoothed.csv
  koseki smooth --tracks radar.csv adsb.csv --refresh 1 --fused fused.csv \\
      --out smoothed.csv --json
  koseki smooth --tracks all.csv --origin 41.297,2.078 --sac 1 --sic 2 \\
      --out smoothed.csv --asterix smoothed.ast
  koseki smooth records/tower/latest --out smoothed.csv --asterix smoothed.ast

A live track knows the past only. Afterwards, the measurements of both sides of
each moment are known: positions are about twice as accurate, velocities three
to four times, and turns begin where they began. Fusion runs once more, exactly
as before: the tracks, numbers, times and all other columns are those of `koseki
fuse` with the same options, or of the recorded fusion. Only position, velocity
and covariance are replaced. The errors of the sensors (offsets, azimuths,
clocks) are taken off as the whole recording shows them, from the first row on.

--tracks  as for `koseki fuse`; so are --config, --rule and --refresh
RECORDING the folder of a recording of all topics, or its file: [recorder]
          format = [\"csv\", \"mcap\"]
--fused   the output of that `koseki fuse`: the command fails, with the line, if
          a row is not the one that it smooths
--out     the columns of `koseki fuse`, or the form of the recorder's tables.
          States of a track before its first own measurement, and tracks of
          other centres, stay as they are; the summary counts these rows.
--asterix CAT062, a record per row of --out that is confirmed, coasted or
          terminated. Positions on the Earth need --origin or a deployment in
          --config; a recording has its own, and the codes and heights of its
          gateway.

A smoothed trajectory is a good reference for the live picture, but not an
independent one: an error that all sensors have in common remains in both.
`koseki score` and `koseki compare pictures` read the result. The same files and
options give the same bytes.";

/// `koseki smooth`.
#[derive(Debug, Args)]
pub struct Smooth {
    /// Recording of all topics: a folder, or a file in the folder
    #[arg(value_name = "RECORDING", conflicts_with_all = ["tracks", "config", "rule", "refresh", "fused", "origin", "sigma"])]
    pub recording: Option<PathBuf>,
    /// Sensor tracks: CSV files, each in the order of time
    #[arg(long, value_name = "FILE", required_unless_present = "recording", num_args = 1..)]
    pub(crate) tracks: Vec<PathBuf>,
    /// Description of the sensors, and settings of fusion: a TOML file
    #[arg(long, value_name = "FILE")]
    pub(crate) config: Option<PathBuf>,
    /// Rule for the weights of sources [default: the rule in --config, else auto]
    #[arg(long, value_name = "RULE")]
    pub(crate) rule: Option<String>,
    /// Write rows at whole multiples of this interval, seconds [default: a row per update]
    #[arg(long, value_name = "SECONDS", value_parser = refresh)]
    pub(crate) refresh: Option<Duration>,
    /// Output of `koseki fuse` that is smoothed: a CSV file
    #[arg(long, value_name = "FILE")]
    pub(crate) fused: Option<PathBuf>,
    /// File for the smoothed system tracks; - for standard output
    #[arg(long, value_name = "FILE")]
    pub out: PathBuf,
    /// File for the smoothed system tracks as ASTERIX CAT062
    #[arg(long, value_name = "FILE")]
    pub asterix: Option<PathBuf>,
    /// Place of the plane on the Earth, for CAT062 and tables in degrees: degrees, and metres above the ellipsoid
    #[arg(long, value_name = "LAT,LON[,HEIGHT]", value_parser = place, allow_hyphen_values = true)]
    pub(crate) origin: Option<Geodetic>,
    /// Standard deviation of positions in tables of named columns without sigma_m, metres [default: 30 or 100]
    #[arg(long, value_name = "METRES", value_parser = above_zero)]
    pub(crate) sigma: Option<f64>,
    /// System area code of the sender, in CAT062 [default: 0, or that of a recording's gateway]
    #[arg(long, value_name = "SAC", requires = "asterix")]
    pub sac: Option<u8>,
    /// System identification code of the sender, in CAT062 [default: 0, or that of a recording's gateway]
    #[arg(long, value_name = "SIC", requires = "asterix")]
    pub sic: Option<u8>,
    /// Kind of the system's heights, for CAT062: geometric or barometric [default: geometric, or that of a gateway]
    #[arg(long, value_name = "WORD", value_parser = heights, requires = "asterix")]
    pub heights: Option<HeightReference>,
    /// Print the summary as a JSON object
    #[arg(long)]
    pub json: bool,
}

impl Smooth {
    /// The inputs in the form of `koseki fuse`.
    pub(crate) fn input(&self) -> OfflineInput {
        OfflineInput {
            tracks: self.tracks.clone(),
            config: self.config.clone(),
            origin: self.origin,
            sigma: self.sigma,
            needs_degrees: self.asterix.is_none(),
        }
    }
}
