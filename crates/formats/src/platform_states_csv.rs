//! States of moving platforms as CSV rows.
//!
//! `time_s,sensor_id,px,py,pz` and, where known, `vx,vy,vz`, `heading_rad`, `pitch_rad`, `roll_rad`, `position_sigma_m`
//! and `heading_sigma_rad`: metres in the system frame, metres per second, radians (heading clockwise from north, nose
//! above the horizon, right wing below it). `sensor_id` is the sensor that the platform carries. Every number is
//! written with as many decimals as it takes to get it back.

use std::io::{self, Write};

use messages::{PlatformState, platform_state_bits as bits};

use crate::rows::{Reference, Row, RowWriter, write_exact};

/// Writes states of platforms.
pub type PlatformStateWriter<W> = RowWriter<PlatformState, W>;

impl Row for PlatformState {
    fn columns() -> String {
        "time_s,sensor_id,px,py,pz,vx,vy,vz,heading_rad,pitch_rad,roll_rad,position_sigma_m,heading_sigma_rad"
            .to_owned()
    }

    fn write(&self, out: &mut impl Write, reference: &Reference) -> io::Result<()> {
        let known = |bit: u16, value: f64| (self.valid & bit != 0).then_some(value);
        reference.write_time(out, self.time_ns)?;
        write!(out, ",{}", reference.sensor_id(self.source))?;
        write_exact(out, self.position_m)?;
        write_exact(out, self.velocity_mps.map(|speed_mps| known(bits::VELOCITY, speed_mps)))?;
        write_exact(
            out,
            [
                known(bits::HEADING, self.heading_rad),
                known(bits::ATTITUDE, self.pitch_rad),
                known(bits::ATTITUDE, self.roll_rad),
                known(bits::POSITION_SIGMA, self.position_sigma_m),
                known(bits::HEADING_SIGMA, self.heading_sigma_rad),
            ],
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_known_is_empty() {
        let known = PlatformState {
            time_ns: 2_500_000_000,
            position_m: [0.1, -2.0, 3.0],
            velocity_mps: [1.0, 0.0, 0.25],
            heading_rad: 0.5,
            source: 1,
            valid: bits::HEADING,
            ..PlatformState::default()
        };
        let mut writer = PlatformStateWriter::begin(Vec::new(), 0).unwrap();
        writer.write(&known).unwrap();
        let moving = PlatformState {
            valid: bits::HEADING | bits::VELOCITY | bits::HEADING_SIGMA,
            ..known
        };
        writer.write(&moving).unwrap();
        let rows = "2.5,2,0.1,-2,3,,,,0.5,,,,\n2.5,2,0.1,-2,3,1,0,0.25,0.5,,,,0\n";
        let expected = format!("{}\n{rows}", PlatformState::columns());
        assert_eq!(String::from_utf8(writer.into_inner()).unwrap(), expected);
    }
}
