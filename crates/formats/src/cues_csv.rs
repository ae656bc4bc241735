//! Cues as CSV rows (WA-12): where each sensor should look next.
//!
//! `made_s` is the time of the scan after which a cue was made, `time_s` that of the look; `x,y,z,vx,vy,vz` are the
//! predicted place and velocity, `longer_m` and `shorter_m` the half axes of the region to be searched, and
//! `orientation_rad` the direction of the longer one, clockwise from north.

use std::io::{self, Write};

use messages::Cue;

use crate::rows::{Reference, Row};

/// A cue for the sensor that files call `sensor_id`.
#[derive(Clone, Copy, Debug)]
pub struct CueRow {
    /// Sensor that is to look.
    pub sensor_id: u32,
    /// The cue; its source does not matter.
    pub cue: Cue,
}

impl Row for CueRow {
    fn columns() -> String {
        "made_s,time_s,sensor_id,sensor_track_id,x,y,z,vx,vy,vz,longer_m,shorter_m,orientation_rad".to_owned()
    }

    fn write(&self, out: &mut impl Write, reference: &Reference) -> io::Result<()> {
        let Self { sensor_id, cue } = self;
        reference.write_time(out, cue.made_ns)?;
        write!(out, ",")?;
        reference.write_time(out, cue.time_ns)?;
        write!(out, ",{sensor_id},{}", cue.track_number)?;
        let numbers = cue.position_m.iter().chain(&cue.velocity_mps).chain(&cue.half_axes_m);
        numbers.into_iter().try_for_each(|value| write!(out, ",{value:.3}"))?;
        write!(out, ",{:.6}", cue.orientation_rad)
    }
}
