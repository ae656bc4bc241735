//! Fixes as rows (FM-7).

use std::io::{self, Write};

use frames::SystemFrame;
use locating::EmitterReport;

/// Writes a row: positions in millimetres, and velocities precise enough for the same accuracy over an hour; with a
/// frame the output in degrees, too, in centimetres.
///
/// # Errors
/// If the writer fails.
pub(super) fn write(out: &mut impl Write, report: &EmitterReport, frame: Option<&SystemFrame>) -> io::Result<()> {
    let (raw, output) = (&report.raw, &report.output);
    let [x, y, z] = output.position_m;
    let [vx, vy, vz] = output.velocity_mps;
    csv_table::write_time(out, report.time_ns)?;
    write!(out, ",{},{x:.3},{y:.3},{z:.3},{vx:.6},{vy:.6},{vz:.6}", report.number)?;
    write!(
        out,
        ",{:.3},{},{}",
        raw.variance_m2(),
        output.stage.word(),
        u8::from(output.is_selected)
    )?;
    let [raw_x, raw_y] = raw.position_m;
    let [raw_vx, raw_vy] = raw.velocity_mps;
    let p = &raw.covariance;
    write!(
        out,
        ",{raw_x:.3},{raw_y:.3},{:.3},{:.3},{:.3}",
        p[(0, 0)],
        p[(0, 1)],
        p[(1, 1)]
    )?;
    write!(
        out,
        ",{raw_vx:.6},{raw_vy:.6},{},{}",
        raw.motion.word(),
        u8::from(raw.is_agreed)
    )?;
    if let Some(frame) = frame {
        let place = frame.to_geodetic(output.position_m);
        write!(out, ",{:.7},{:.7}", place.latitude_deg(), place.longitude_deg())?;
    }
    writeln!(out)
}
