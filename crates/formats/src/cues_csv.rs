//! Cues as CSV rows (WA-12): where each sensor should look next.
//!
//! `made_s` is the time of the scan after which a cue was made, `time_s` that of the look; `x,y,z,vx,vy,vz` are the
//! predicted place and velocity, `longer_m` and `shorter_m` the half axes of the region to be searched, and
//! `orientation_rad` the direction of the longer one, clockwise from north.

use messages::Cue;

use crate::cells::{Rounded, Time};
use crate::columns::columns;

/// A cue for the sensor that files call `sensor_id`.
#[derive(Clone, Copy, Debug)]
pub struct CueRow {
    /// Sensor that is to look.
    pub sensor_id: u32,
    /// The cue; its source does not matter.
    pub cue: Cue,
}

columns! {
    CueRow: |row|
    "made_s" => Time(row.cue.made_ns),
    "time_s" => Time(row.cue.time_ns),
    "sensor_id" => row.sensor_id,
    "sensor_track_id" => row.cue.track_number,
    ["x", "y", "z"] => row.cue.position_m.map(|value| Rounded(value, 3)),
    ["vx", "vy", "vz"] => row.cue.velocity_mps.map(|value| Rounded(value, 3)),
    ["longer_m", "shorter_m"] => row.cue.half_axes_m.map(|value| Rounded(value, 3)),
    "orientation_rad" => Rounded(row.cue.orientation_rad, 6),
}
