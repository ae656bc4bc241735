//! States of moving platforms as CSV rows.
//!
//! `time_s,sensor_id,px,py,pz` and, if known, `vx,vy,vz`, `heading_rad`, `pitch_rad`, `roll_rad`, `position_sigma_m`
//! and `heading_sigma_rad`: metres in the system frame, metres per second, radians (heading clockwise from north,
//! nose above the horizon, right wing below the horizon). `sensor_id` is the sensor on the platform. Every number has
//! as many decimals as needed to read back the same value.

use messages::{PlatformState, platform_state_bits as bits};

use crate::cells::{SensorId, Time};
use crate::columns::columns;
use crate::rows::RowWriter;

/// Writes states of platforms.
pub type PlatformStateWriter<W> = RowWriter<PlatformState, W>;

columns! {
    PlatformState: |row|
    "time_s" => Time(row.time_ns),
    "sensor_id" => SensorId(row.source),
    ["px", "py", "pz"] => row.position_m,
    ["vx", "vy", "vz"] => row.velocity_mps.map(|speed_mps| known(row, bits::VELOCITY, speed_mps)),
    "heading_rad" => known(row, bits::HEADING, row.heading_rad),
    "pitch_rad" => known(row, bits::ATTITUDE, row.pitch_rad),
    "roll_rad" => known(row, bits::ATTITUDE, row.roll_rad),
    "position_sigma_m" => known(row, bits::POSITION_SIGMA, row.position_sigma_m),
    "heading_sigma_rad" => known(row, bits::HEADING_SIGMA, row.heading_sigma_rad),
}

fn known(state: &PlatformState, bit: u16, value: f64) -> Option<f64> {
    (state.valid & bit != 0).then_some(value)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rows::Row as _;

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
