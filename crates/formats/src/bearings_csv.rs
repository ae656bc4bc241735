//! Bearings as CSV rows (FM-7).
//!
//! `time_s,bearing_rad,sigma_rad,px,py,pz` and, if known, `emitter_id`, `heading_rad`, `frequency_hz` and
//! `pulse_interval_s`, or other names and units of these quantities ([`csv_table::NamedColumn`]). Without an
//! `emitter_id`, the direction finder does not distinguish emitters.
//!
//! In place of `px,py,pz`, the finder may stand at a latitude and a longitude; bearings are then from true north there,
//! and are turned into the plane of the run ([`crate::plane`]).

use std::f64::consts::TAU;
use std::io::Read;

use csv_table::{Cells, Column, CsvError, Table};
use observations::Bearing;

use crate::cells::Time;
use crate::columns::columns;
use crate::plane::{InPlane, Plane, SensorPlaces};
use crate::rows::{Columns, RowReader, RowWriter};
use crate::time_base::TimeBase;

/// Largest standard deviation of a usable direction, radians.
const SIGMA_MAX_RAD: f64 = 1.0;

/// Reads bearings.
pub type BearingReader<R> = RowReader<R, BearingColumns>;
/// Writer of bearings. Values read back are equal to the last bit.
pub type BearingWriter<W> = RowWriter<Bearing, W>;

columns! {
    /// Places of the columns of bearings.
    BearingPlaces of Bearing: |row|
    time: Column = "time_s" => Time(row.time_of_measurement_ns),
    emitter: Option<Column> = "emitter_id" => row.emitter_id,
    bearing: Column = "bearing_rad" => row.bearing_rad,
    sigma: Column = "sigma_rad" => row.sigma_rad,
    platform: SensorPlaces = SensorPlaces::METRES => row.platform_m,
    heading: Option<Column> = "heading_rad" => row.heading_rad,
    frequency: Option<Column> = "frequency_hz" => row.frequency_hz,
    pulse_interval: Option<Column> = "pulse_interval_s" => row.pulse_interval_s,
}

/// Columns of bearings.
#[derive(Debug)]
pub struct BearingColumns {
    base: TimeBase,
    plane: Plane,
    at: BearingPlaces,
}

impl<R: Read> BearingReader<R> {
    /// Reads the header line. Times of rows count from `first_day_ns` (UTC, nanoseconds), or from 1970.
    ///
    /// # Errors
    /// [`CsvError`] if a column is missing or the input fails.
    pub fn new(input: R, first_day_ns: i64) -> Result<Self, CsvError> {
        let table = Table::new(input)?;
        // A table that lacks it is none of emissions, most likely.
        table.required("emitter_id")?;
        let columns = BearingColumns {
            base: TimeBase::new(first_day_ns),
            plane: Plane::Open,
            at: BearingPlaces::find(&table)?,
        };
        Ok(Self { table, columns })
    }
}

impl InPlane for BearingColumns {
    fn plane(&mut self) -> &mut Plane {
        &mut self.plane
    }
}

impl Columns for BearingColumns {
    type Value = Bearing;

    fn read(&mut self, row: Cells<'_>) -> Result<Bearing, CsvError> {
        self.at.read(row, &mut self.base, &mut self.plane)
    }
}

impl BearingPlaces {
    /// Reads the bearing of a row, at a time of this base and a place in this plane.
    pub(crate) fn read(&self, row: Cells<'_>, base: &mut TimeBase, plane: &mut Plane) -> Result<Bearing, CsvError> {
        let time_of_measurement_ns = base.utc_ns(row, self.time)?;
        let emitter_id = match (self.emitter, row.stated(self.emitter)?) {
            (Some(column), Some(_)) => Some(row.whole(column)?),
            _ => None,
        };
        let platform = self.platform.read(row, plane)?;
        let frequency_hz = positive(row, self.frequency, "must be greater than 0; a frequency is, in hertz")?;
        let interval = "must be greater than 0; the time between pulses is, in seconds";
        let pulse_interval_s = positive(row, self.pulse_interval, interval)?;
        let heading_rad = match self.heading {
            Some(column) if row.stated(column)?.is_some() => Some(angle(row, column)?),
            _ => None,
        };
        Ok(Bearing {
            time_of_measurement_ns,
            emitter_id,
            bearing_rad: platform.direction([angle(row, self.bearing)?, 0.0])[0],
            sigma_rad: self.sigma(row)?,
            platform_m: platform.position_m,
            heading_rad,
            frequency_hz,
            pulse_interval_s,
        })
    }

    fn sigma(&self, row: Cells<'_>) -> Result<f64, CsvError> {
        match row.number(self.sigma)? {
            ..=0.0 => Err(row.error(self.sigma, "must be greater than 0; a standard deviation is")),
            sigma if sigma > SIGMA_MAX_RAD => {
                let remedy = unit(self.sigma);
                let reason = format!("is more than {SIGMA_MAX_RAD} rad, which is no direction; {remedy}");
                Err(row.error(self.sigma, reason))
            }
            sigma => Ok(sigma),
        }
    }
}

/// A number that may be missing; one that is not above 0 is refused for this reason.
fn positive(row: Cells<'_>, column: Option<Column>, reason: &str) -> Result<Option<f64>, CsvError> {
    let number = row.number_or_empty(column)?;
    match (column, number) {
        (Some(column), Some(..=0.0)) => Err(row.error(column, reason)),
        _ => Ok(number),
    }
}

/// A direction, radians.
pub(crate) fn angle(row: Cells<'_>, column: Column) -> Result<f64, CsvError> {
    match row.number(column)? {
        angle if angle.abs() > TAU => Err(row.error(column, format!("is more than a full turn; {}", unit(column)))),
        angle => Ok(angle),
    }
}

fn unit(column: Column) -> &'static str {
    match column.scale() == 1.0 {
        true => "write radians, not degrees",
        false => "write degrees",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEADER: &str = "time_s,emitter_id,bearing_rad,sigma_rad,px,py,pz,heading_rad,frequency_hz,pulse_interval_s";

    fn read(rows: &str) -> Vec<Result<Bearing, String>> {
        let text = format!("{HEADER}\n{rows}");
        let reader = BearingReader::new(text.as_bytes(), 1_000).unwrap();
        reader.map(|row| row.map_err(|error| error.to_string())).collect()
    }

    #[test]
    fn rows_are_read_with_and_without_what_may_be_unknown() {
        let found = read("2.5,7,1.5,0.02,10,20,3000,0.5,1.2e8,1e-3\n3,,-1.5,0.02,10,20,3000,,,\n");
        let first = Bearing {
            time_of_measurement_ns: 2_500_001_000,
            emitter_id: Some(7),
            bearing_rad: 1.5,
            sigma_rad: 0.02,
            platform_m: [10.0, 20.0, 3000.0],
            heading_rad: Some(0.5),
            frequency_hz: Some(1.2e8),
            pulse_interval_s: Some(1e-3),
        };
        assert_eq!(found[0], Ok(first));
        let second = Bearing {
            time_of_measurement_ns: 3_000_001_000,
            emitter_id: None,
            bearing_rad: -1.5,
            heading_rad: None,
            frequency_hz: None,
            pulse_interval_s: None,
            ..first
        };
        assert_eq!(found[1], Ok(second));
    }

    #[test]
    fn what_cannot_be_meant_is_refused_with_place_and_remedy() {
        for (row, expected) in [
            ("2,1.5,1,0.02,0,0,0,,,", "column emitter_id: \"1.5\" is no whole number"),
            (
                "2,1,270,0.02,0,0,0,,,",
                "column bearing_rad: \"270\" is more than a full turn; write radians",
            ),
            ("2,1,,0.02,0,0,0,,,", "column bearing_rad: \"\" is empty"),
            ("2,1,1,0,0,0,0,,,", "column sigma_rad: \"0\" must be greater than 0"),
            ("2,1,1,2,0,0,0,,,", "column sigma_rad: \"2\" is more than 1"),
            ("2,1,1,NaN,0,0,0,,,", "column sigma_rad: \"NaN\" is not finite"),
            ("2,1,1,0.02,0,,0,,,", "column py: \"\" is empty"),
            (
                "2,1,1,0.02,0,0,0,90,,",
                "column heading_rad: \"90\" is more than a full turn",
            ),
            (
                "2,1,1,0.02,0,0,0,,0,",
                "column frequency_hz: \"0\" must be greater than 0",
            ),
            (
                "2,1,1,0.02,0,0,0,,,-1",
                "column pulse_interval_s: \"-1\" must be greater than 0",
            ),
        ] {
            let [found] = &read(row)[..] else { panic!("{row}") };
            let text = found.as_ref().unwrap_err();
            assert!(text.starts_with("line 2, ") && text.contains(expected), "{text}");
        }
    }

    #[test]
    fn heading_and_frequency_may_be_missing_from_the_header() {
        let text = "time_s,emitter_id,bearing_rad,sigma_rad,px,py,pz\n1,2,3,0.1,4,5,6\n";
        let found: Vec<_> = BearingReader::new(text.as_bytes(), 0).unwrap().collect();
        assert_eq!(found.len(), 1);
        assert!(found[0].is_ok());
        let without = text.replace("sigma_rad", "sigma");
        let error = BearingReader::new(without.as_bytes(), 0).unwrap_err();
        assert!(error.to_string().contains("column sigma_rad is missing"));
    }

    #[test]
    fn what_is_written_is_read_again_exactly() {
        let first = Bearing {
            time_of_measurement_ns: 86_400_123_456_789,
            emitter_id: Some(7),
            bearing_rad: 1.0 / 3.0,
            sigma_rad: 0.1 + 0.2,
            platform_m: [-1e-3, 2.0 / 7.0, 3e5],
            heading_rad: Some(-0.7),
            frequency_hz: Some(9.41e9),
            pulse_interval_s: Some(0.1 / 3.0),
        };
        let second = Bearing {
            emitter_id: None,
            heading_rad: None,
            frequency_hz: None,
            pulse_interval_s: None,
            ..first
        };
        let mut writer = BearingWriter::begin(Vec::new(), 1_000).unwrap();
        for bearing in [first, second] {
            writer.write(&bearing).unwrap();
        }
        let written = writer.into_inner();
        let found: Vec<_> = BearingReader::new(&written[..], 1_000)
            .unwrap()
            .map(Result::unwrap)
            .collect();
        assert_eq!(found, [first, second]);
    }
}
