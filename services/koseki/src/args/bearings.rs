//! `koseki bearings`.

use std::path::PathBuf;

use clap::Args;

pub(super) const BEARINGS_EXAMPLES: &str = "\
Examples:
  koseki bearings --snapshots flight.csv --array array.toml --out bearings.csv
  koseki bearings --snapshots flight.csv --array array.toml --out bearings.csv \\
      --json
  koseki locate --bearings bearings.csv --out fixes.csv
      positions of the transmitters

FILE     time_s,px,py,pz,heading_rad,frequency_hz,re_1,im_1,re_2,im_2,…
         a row per snapshot, in the order of time: the complex sample of each
         antenna, in the order of the array. Rows with the same time are a
         measurement at the same frequency and place: some hundred independent
         snapshots (the signal's bandwidth sets the minimum interval). Metres
         east, north and up; radians clockwise from north. Unusable rows and
         measurements are omitted and counted.
--array  frequency_max_hz = 9.5e9   # highest measured frequency
         forward_deg = 0.0          # forward axis of the array, clockwise from
                                    # the platform's heading
         sector_deg = [0.0, 360.0]  # sector covered by the antennas, clockwise
                                    # from the forward axis
         transmitters = \"off\"       # number at the same time, if known; off:
                                    # estimated
         criterion = \"mdl\"          # or \"aic\": detects weak transmitters
                                    # earlier, and sometimes one too many
         phase_sigma_deg = 0.0      # phase error of an antenna after
                                    # calibration
         [[antenna]]                # for each antenna, in the order of the
                                    # samples
         right_m = 0.0
         forward_m = 0.05
--out    time_s,emitter_id,bearing_rad,sigma_rad,px,py,pz,heading_rad,
         frequency_hz,pulse_interval_s
         a row per bearing, in the form of `koseki locate`. emitter_id is empty:
         frequency and direction identify the transmitter.

The method is MUSIC (docs/bearing-measurement.md). An ambiguous bearing is
omitted: a line of antennas cannot distinguish left from right, unless
sector_deg selects a side.";

/// `koseki bearings`.
#[derive(Debug, Args)]
pub(crate) struct MeasureBearings {
    /// Snapshots: a CSV file in the order of time
    #[arg(long, value_name = "FILE")]
    pub(crate) snapshots: PathBuf,
    /// Geometry and settings of the array: a TOML file
    #[arg(long, value_name = "FILE")]
    pub(crate) array: PathBuf,
    /// File for the bearings
    #[arg(long, value_name = "FILE")]
    pub(crate) out: PathBuf,
    /// Print the summary as a JSON object
    #[arg(long)]
    pub(crate) json: bool,
}
