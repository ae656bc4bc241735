//! States of moving platforms as CSV rows.
//!
//! `time_s,sensor_id,px,py,pz` and, if known, `vx,vy,vz`, `heading_rad`, `pitch_rad`, `roll_rad`, `position_sigma_m`,
//! `heading_sigma_rad`, `velocity_sigma_mps`, `pitch_sigma_rad` and `roll_sigma_rad`: metres in the system frame,
//! metres per second, radians (heading clockwise from north, nose above the horizon, right wing below the horizon).
//! `sensor_id` is the sensor on the platform. Every column but `time_s` may be absent, and every value empty: a
//! compass gives rows of headings. Every number has as many decimals as needed to read back the same value.

use std::io::Read;

use csv_table::{Cells, Column, CsvError, Table};
use messages::{PlatformState, platform_state_bits as bits};

use crate::cells::{SensorId, Time};
use crate::columns::columns;
use crate::rows::{Columns, RowReader, RowWriter};
use crate::time_base::TimeBase;

/// Writes states of platforms.
pub type PlatformStateWriter<W> = RowWriter<PlatformState, W>;
/// Reads states of platforms.
pub type PlatformStateReader<R> = RowReader<R, PlatformStateColumns>;

columns! {
    /// Places of the columns of states.
    PlatformStatePlaces of PlatformState: |row|
    time: Column = "time_s" => Time(row.time_ns),
    sensor: Option<Column> = "sensor_id" => SensorId(row.source),
    position: Option<[Column; 3]> = ["px", "py", "pz"] => position(row),
    velocity: Option<[Column; 3]> = ["vx", "vy", "vz"] => velocity(row),
    heading: Option<Column> = "heading_rad" => known(row, bits::HEADING, row.heading_rad),
    pitch: Option<Column> = "pitch_rad" => known(row, bits::ATTITUDE, row.pitch_rad),
    roll: Option<Column> = "roll_rad" => known(row, bits::ATTITUDE, row.roll_rad),
    position_sigma: Option<Column> = "position_sigma_m" => known(row, bits::POSITION_SIGMA, row.position_sigma_m),
    heading_sigma: Option<Column> = "heading_sigma_rad" => known(row, bits::HEADING_SIGMA, row.heading_sigma_rad),
    velocity_sigma: Option<Column> = "velocity_sigma_mps" => known(row, bits::VELOCITY_SIGMA, row.velocity_sigma_mps),
    pitch_sigma: Option<Column> = "pitch_sigma_rad" => known(row, bits::ATTITUDE_SIGMA, row.pitch_sigma_rad),
    roll_sigma: Option<Column> = "roll_sigma_rad" => known(row, bits::ATTITUDE_SIGMA, row.roll_sigma_rad),
}

fn position(state: &PlatformState) -> [Option<f64>; 3] {
    let is_known = state.valid & bits::NO_POSITION == 0;
    state.position_m.map(|place_m| is_known.then_some(place_m))
}

fn velocity(state: &PlatformState) -> [Option<f64>; 3] {
    state
        .velocity_mps
        .map(|speed_mps| known(state, bits::VELOCITY, speed_mps))
}

fn known(state: &PlatformState, bit: u16, value: f64) -> Option<f64> {
    (state.valid & bit != 0).then_some(value)
}

/// Columns of states of platforms.
#[derive(Debug)]
pub struct PlatformStateColumns {
    base: TimeBase,
    at: PlatformStatePlaces,
}

impl<R: Read> PlatformStateReader<R> {
    /// Reads the header line. Times of rows count from `first_day_ns` (UTC, nanoseconds), or from 1970.
    ///
    /// # Errors
    /// [`CsvError`] if the column of the time is missing or the input fails.
    pub fn new(input: R, first_day_ns: i64) -> Result<Self, CsvError> {
        let table = Table::new(input)?;
        let columns = PlatformStateColumns {
            base: TimeBase::new(first_day_ns),
            at: PlatformStatePlaces::find(&table)?,
        };
        Ok(Self { table, columns })
    }
}

impl Columns for PlatformStateColumns {
    type Value = PlatformState;

    fn read(&mut self, row: Cells<'_>) -> Result<PlatformState, CsvError> {
        let at = &self.at;
        let id = match at.sensor.map(|column| row.text(column)).transpose()?.flatten() {
            Some(_) => row.whole::<u16>(at.sensor.expect("the column has a text"))?,
            None => 0,
        };
        let position = together(row, at.position)?;
        let velocity = together(row, at.velocity)?;
        let tilt = together(row, at.pitch.zip(at.roll).map(|(pitch, roll)| [pitch, roll]))?;
        let sigma = |column: Option<Column>| column.map_or(Ok(None), |column| positive(row, column));
        let heading = at.heading.map_or(Ok(None), |column| row.number_or_empty(column))?;
        let (position_sigma, heading_sigma) = (sigma(at.position_sigma)?, sigma(at.heading_sigma)?);
        let velocity_sigma = sigma(at.velocity_sigma)?;
        let tilt_sigmas = sigma(at.pitch_sigma)?.zip(sigma(at.roll_sigma)?);
        let flag = |is_set: bool, bit: u16| if is_set { bit } else { 0 };
        let [pitch_rad, roll_rad] = tilt.unwrap_or_default();
        let (pitch_sigma_rad, roll_sigma_rad) = tilt_sigmas.unwrap_or_default();
        Ok(PlatformState {
            time_ns: self.base.utc_ns(row, at.time)?,
            position_m: position.unwrap_or_default(),
            velocity_mps: velocity.unwrap_or_default(),
            heading_rad: heading.unwrap_or_default(),
            pitch_rad,
            roll_rad,
            position_sigma_m: position_sigma.unwrap_or_default(),
            heading_sigma_rad: heading_sigma.unwrap_or_default(),
            velocity_sigma_mps: velocity_sigma.unwrap_or_default(),
            pitch_sigma_rad,
            roll_sigma_rad,
            source: id.saturating_sub(1),
            valid: flag(position.is_none(), bits::NO_POSITION)
                | flag(velocity.is_some(), bits::VELOCITY)
                | flag(heading.is_some(), bits::HEADING)
                | flag(tilt.is_some(), bits::ATTITUDE)
                | flag(position_sigma.is_some(), bits::POSITION_SIGMA)
                | flag(heading_sigma.is_some(), bits::HEADING_SIGMA)
                | flag(velocity_sigma.is_some(), bits::VELOCITY_SIGMA)
                | flag(tilt_sigmas.is_some(), bits::ATTITUDE_SIGMA),
            ..PlatformState::default()
        })
    }
}

/// Values that are given together or not at all.
pub(crate) fn together<const N: usize>(
    row: Cells<'_>,
    columns: Option<[Column; N]>,
) -> Result<Option<[f64; N]>, CsvError> {
    let Some(columns) = columns else { return Ok(None) };
    let mut values = [0.0; N];
    let mut given = 0;
    let mut empty = None;
    for (value, column) in values.iter_mut().zip(columns) {
        match row.number_or_empty(column)? {
            Some(number) => {
                *value = number;
                given += 1;
            }
            None => empty = Some(column),
        }
    }
    match empty {
        None => Ok(Some(values)),
        Some(column) if given > 0 => Err(row.error(
            column,
            "is empty where others that belong to it are given; give all or none",
        )),
        Some(_) => Ok(None),
    }
}

pub(crate) fn positive(row: Cells<'_>, column: Column) -> Result<Option<f64>, CsvError> {
    match row.number_or_empty(column)? {
        Some(sigma) if sigma > 0.0 => Ok(Some(sigma)),
        Some(_) => Err(row.error(column, "must be greater than 0; a standard deviation is")),
        None => Ok(None),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rows::Row as _;

    fn read(text: &str) -> Vec<Result<PlatformState, String>> {
        let reader = PlatformStateReader::new(text.as_bytes(), 0).unwrap();
        reader.map(|row| row.map_err(|error| error.to_string())).collect()
    }

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
        let rows = "2.5,2,0.1,-2,3,,,,0.5,,,,,,,\n2.5,2,0.1,-2,3,1,0,0.25,0.5,,,,0,,,\n";
        let expected = format!("{}\n{rows}", PlatformState::columns());
        assert_eq!(String::from_utf8(writer.into_inner()).unwrap(), expected);
    }

    #[test]
    fn what_is_written_is_read_again_exactly() {
        let whole = PlatformState {
            time_ns: 2_500_000_000,
            position_m: [0.1, -2.0, 1.0 / 3.0],
            velocity_mps: [1.0, 0.0, 0.25],
            heading_rad: 0.5,
            pitch_rad: 0.01,
            roll_rad: -0.17,
            position_sigma_m: 2.0,
            heading_sigma_rad: 0.005,
            velocity_sigma_mps: 0.1,
            pitch_sigma_rad: 0.004,
            roll_sigma_rad: 0.006,
            valid: bits::NO_POSITION - 1,
            ..PlatformState::default()
        };
        let compass = PlatformState {
            time_ns: 1,
            heading_rad: 6.0,
            valid: bits::HEADING | bits::NO_POSITION,
            ..PlatformState::default()
        };
        let mut writer = PlatformStateWriter::begin(Vec::new(), 0).unwrap();
        writer.write(&whole).unwrap();
        writer.write(&compass).unwrap();
        let text = String::from_utf8(writer.into_inner()).unwrap();
        let found: Vec<_> = read(&text).into_iter().map(Result::unwrap).collect();
        assert_eq!(found, [whole, compass]);
    }

    #[test]
    fn what_cannot_be_meant_is_refused_with_place_and_remedy() {
        for (row, expected) in [
            ("1,2,,3,0.1,0.1", "column py: \"\" is empty where others"),
            ("1,1,2,3,,0.1", "column pitch_rad: \"\" is empty where others"),
            ("1,x,2,3,0.1,0.1", "column px: \"x\""),
        ] {
            let found = read(&format!("time_s,px,py,pz,pitch_rad,roll_rad\n{row}\n"));
            let error = found[0].as_ref().unwrap_err();
            assert!(error.contains(expected), "{error}");
        }
        let found = read("time_s,heading_rad,heading_sigma_rad\n1,2,0\n");
        let error = found[0].as_ref().unwrap_err();
        assert!(
            error.contains("column heading_sigma_rad: \"0\" must be greater than 0"),
            "{error}"
        );
    }
}
