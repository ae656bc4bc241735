//! `koseki bearings`.

use std::path::PathBuf;

use clap::Args;

pub(super) const BEARINGS_EXAMPLES: &str = "\
Examples:
  koseki bearings --snapshots flight.csv --array array.toml --out bearings.csv
  koseki bearings --snapshots flight.csv --array array.toml --out bearings.csv --json
  koseki locate --bearings bearings.csv --out fixes.csv            where the transmitters are

FILE     time_s,px,py,pz,heading_rad,frequency_hz,re_1,im_1,re_2,im_2,…   a row per snapshot, in the order of time: the
         complex sample of each antenna, in the order of the array. Rows of one time are one measurement, of one frequency
         and place: some hundred snapshots, as far apart as the signal's bandwidth makes them independent. Metres east,
         north and up; radians clockwise from north. Rows and measurements that cannot be used are left out and counted.
--array  frequency_max_hz = 9.5e9       # highest frequency that is measured
         forward_deg = 0.0              # forward axis of the array, clockwise from the platform's heading
         sector_deg = [0.0, 360.0]      # where the antennas hear, clockwise from the forward axis
         transmitters = \"off\"           # how many at once, where it is known; off: estimated
         criterion = \"mdl\"              # or \"aic\", which finds weak ones earlier, and one too many now and then
         phase_sigma_deg = 0.0          # what calibration leaves of an antenna's phase error
         [[antenna]]                    # one for each, in the order of the samples
         right_m = 0.0
         forward_m = 0.05
--out    time_s,emitter_id,bearing_rad,sigma_rad,px,py,pz,heading_rad,frequency_hz,pulse_interval_s   a row per bearing, as
         `koseki locate` reads them. emitter_id is empty: who transmits is found from frequency and direction.

The method is MUSIC (docs/bearing-measurement.md). A bearing with another one that explains the snapshots as well is left
out: antennas in a line hear left and right alike, unless sector_deg says which side is meant.";

/// `koseki bearings`.
#[derive(Debug, Args)]
pub(crate) struct MeasureBearings {
    /// Snapshots: a CSV file in the order of time
    #[arg(long, value_name = "FILE")]
    pub(crate) snapshots: PathBuf,
    /// Geometry of the array, and how it is used: a TOML file
    #[arg(long, value_name = "FILE")]
    pub(crate) array: PathBuf,
    /// File for the bearings
    #[arg(long, value_name = "FILE")]
    pub(crate) out: PathBuf,
    /// Print what was read and found as one JSON object
    #[arg(long)]
    pub(crate) json: bool,
}
