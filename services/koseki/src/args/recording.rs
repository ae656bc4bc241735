//! `koseki recording`.

use std::path::PathBuf;

use clap::{Args, Subcommand};

use super::values;

pub(super) const RECORDING_EXAMPLES: &str = "\
Examples:
  koseki up config/live.toml --set 'recorder.format=[\"csv\", \"mcap\"]' \\
      --out records/tower
  koseki recording info records/tower/latest
  koseki recording info records/tower/latest/all_topics_000002.mcap
  koseki recording cut records/tower/latest --from 2026-05-01T10:00:00Z \\
      --to 2026-05-01T10:05:00Z --out near-miss.mcap
  koseki recording merge records/tower/latest --out night.mcap
  koseki recording repair damaged.mcap --out repaired.mcap
  koseki recording export near-miss.mcap --csv near-miss --asterix near-miss.ast
  koseki recording export records/tower/latest --kml tower.kml --gpx tower.gpx \\
      --from 2026-05-01T10:00:00Z --area 1.5,41.0,2.5,41.6 --targets IBE12AB,4";

/// `koseki recording`.
#[derive(Debug, Subcommand)]
pub(crate) enum RecordingCommand {
    /// Print topics, times, counts, losses and origin of a recording of all topics
    Info(RecordingInfo),
    /// Copy a part of a recording
    Cut(RecordingCut),
    /// Copy the files of a recording into one
    Merge(RecordingMerge),
    /// Copy what can be read of a damaged recording
    Repair(RecordingRepair),
    /// Write a recording in other formats
    #[command(override_usage = "koseki recording export [OPTIONS] <RECORDING>\n         \
                                <--csv <DIR>|--asterix <FILE>|--foxglove <FILE>|\n          \
                                --geojson <FILE>|--kml <FILE>|--gpx <FILE>>")]
    Export(RecordingExport),
}

/// `koseki recording info`.
#[derive(Debug, Args)]
pub(crate) struct RecordingInfo {
    /// A file, or the folder of a recording
    #[arg(value_name = "RECORDING")]
    pub(crate) path: PathBuf,
    /// Print JSON, with the recorded configuration
    #[arg(long)]
    pub(crate) json: bool,
}

/// `koseki recording cut`.
#[derive(Debug, Args)]
pub(crate) struct RecordingCut {
    /// A file, or the folder of a recording
    #[arg(value_name = "RECORDING")]
    pub(crate) path: PathBuf,
    /// File for the copied part
    #[arg(long, value_name = "FILE")]
    pub(crate) out: PathBuf,
    /// Omit samples recorded before this time, UTC, as in 2026-05-01T10:00:00Z
    #[arg(long, value_name = "TIME", value_parser = values::utc)]
    pub(crate) from: Option<i64>,
    /// Omit samples recorded after this time
    #[arg(long, value_name = "TIME", value_parser = values::utc)]
    pub(crate) to: Option<i64>,
    /// Copy only these topics; sensor/radar stands for all topics that begin with sensor/radar/
    #[arg(long, value_name = "TOPIC", value_delimiter = ',')]
    pub(crate) topics: Vec<String>,
}

/// `koseki recording merge`.
#[derive(Debug, Args)]
pub(crate) struct RecordingMerge {
    /// Files of a recording in their order, or the folder of the recording
    #[arg(value_name = "RECORDING", required = true)]
    pub(crate) paths: Vec<PathBuf>,
    /// File for the merged recording
    #[arg(long, value_name = "FILE")]
    pub(crate) out: PathBuf,
}

/// `koseki recording repair`.
#[derive(Debug, Args)]
pub(crate) struct RecordingRepair {
    /// A file, or the folder of a recording
    #[arg(value_name = "RECORDING")]
    pub(crate) path: PathBuf,
    /// File for the copy: a whole recording without the damaged parts
    #[arg(long, value_name = "FILE")]
    pub(crate) out: PathBuf,
}

/// `koseki recording export`.
#[derive(Debug, Args)]
#[command(group = clap::ArgGroup::new("format").required(true).multiple(true))]
pub(crate) struct RecordingExport {
    /// A file, or the folder of a recording
    #[arg(value_name = "RECORDING")]
    pub(crate) path: PathBuf,
    /// New or empty folder for tables in the recorder's form
    #[arg(long, value_name = "DIR", group = "format")]
    pub(crate) csv: Option<PathBuf>,
    /// File for the system tracks as ASTERIX CAT062, a record per confirmed, coasted or terminated state
    #[arg(long, value_name = "FILE", group = "format")]
    pub(crate) asterix: Option<PathBuf>,
    /// File (MCAP) for the system tracks in the form of Foxglove and Lichtblick: a track picture per second, on a map
    /// and in space
    #[arg(long, value_name = "FILE", group = "format")]
    pub(crate) foxglove: Option<PathBuf>,
    /// File for the paths of the system tracks as GeoJSON: confirmed states, one a second
    #[arg(long, value_name = "FILE", group = "format")]
    pub(crate) geojson: Option<PathBuf>,
    /// The same as KML, with times
    #[arg(long, value_name = "FILE", group = "format")]
    pub(crate) kml: Option<PathBuf>,
    /// The same as GPX
    #[arg(long, value_name = "FILE", group = "format")]
    pub(crate) gpx: Option<PathBuf>,
    /// Of paths, omit states before this time, UTC, as in 2026-05-01T10:00:00Z
    #[arg(long, value_name = "TIME", value_parser = values::utc)]
    pub(crate) from: Option<i64>,
    /// Of paths, omit states after this time
    #[arg(long, value_name = "TIME", value_parser = values::utc)]
    pub(crate) to: Option<i64>,
    /// Of paths, omit states outside west, south, east, north, degrees
    #[arg(long, value_name = "W,S,E,N", value_parser = values::area, allow_hyphen_values = true)]
    pub(crate) area: Option<[f64; 4]>,
    /// Only the paths of these track numbers, call signs, addresses, MMSIs or names
    #[arg(long, value_name = "TARGET", value_delimiter = ',')]
    pub(crate) targets: Vec<String>,
}
