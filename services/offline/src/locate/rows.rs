//! Fixes as rows (FM-7).

use csv_table::{write_decimals, write_time, write_whole};
use frames::SystemFrame;
use locating::EmitterReport;

/// Decimals of positions and their variances, of velocities, and of degrees: millimetres; the same accuracy over an
/// hour; centimetres.
const METRES: usize = 3;
const VELOCITY: usize = 6;
const DEGREES: usize = 7;

/// Appends a row; with a frame, the output in degrees, too.
pub(super) fn append(row: &mut Vec<u8>, report: &EmitterReport, frame: Option<&SystemFrame>) {
    // A vector takes everything.
    let _ = write(row, report, frame);
}

fn write(row: &mut Vec<u8>, report: &EmitterReport, frame: Option<&SystemFrame>) -> std::io::Result<()> {
    let (raw, output) = (&report.raw, &report.output);
    write_time(row, report.time_ns)?;
    row.push(b',');
    write_whole(row, report.number.into())?;
    numbers(row, &output.position_m, METRES)?;
    numbers(row, &output.velocity_mps, VELOCITY)?;
    numbers(row, &[raw.variance_m2()], METRES)?;
    word(row, output.stage.word());
    word(row, digit(output.is_selected));
    numbers(row, &raw.position_m, METRES)?;
    let p = &raw.covariance;
    numbers(row, &[p[(0, 0)], p[(0, 1)], p[(1, 1)]], METRES)?;
    numbers(row, &raw.velocity_mps, VELOCITY)?;
    word(row, raw.motion.word());
    word(row, digit(raw.is_agreed));
    if let Some(frame) = frame {
        let place = frame.to_geodetic(output.position_m);
        numbers(row, &[place.latitude_deg(), place.longitude_deg()], DEGREES)?;
    }
    row.push(b'\n');
    Ok(())
}

fn numbers(row: &mut Vec<u8>, values: &[f64], decimals: usize) -> std::io::Result<()> {
    values.iter().try_for_each(|value| {
        row.push(b',');
        write_decimals(row, *value, decimals)
    })
}

fn word(row: &mut Vec<u8>, word: &str) {
    row.push(b',');
    row.extend_from_slice(word.as_bytes());
}

fn digit(is_set: bool) -> &'static str {
    if is_set { "1" } else { "0" }
}
