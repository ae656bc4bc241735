//! Measurements of emitters as CSV rows: bearings, arrival times and ready-made fixes (FM-7, FM-11).
//!
//! With a column `kind`, a table mixes `bearing`, `toa` and `tdoa` rows; an empty kind means `bearing`. A table
//! without this column has bearings ([`crate::bearings_csv`]), or fixes if it has no `bearing_rad` but `x`. Columns
//! that a row's kind does not use may be empty.
//!
//! - `toa`: `time_s,emitter_id,receiver,t_s,sigma_s,px,py,pz`: arrival at one receiver, by its clock;
//! - `tdoa`: `time_s,emitter_id,receiver,receiver_2,tdoa_s,sigma_s,px,py,pz,px_2,py_2,pz_2`: arrival at `receiver`
//!   minus arrival at `receiver_2`;
//! - both, of a reference emitter: `reference_x,reference_y,reference_z`;
//! - fixes: `time_s,emitter_id,x,y,z` and `Pxx,Pxy,Pyy` or `variance_m2`, the sum of both variances, or `sigma_m`, the
//!   standard deviation along each axis.
//!
//! Places may be in degrees ([`crate::plane`]), but for those of second receivers and of reference emitters; columns
//! may have other names and units ([`csv_table::NamedColumn`]).

use std::io::{self, Read, Write};

use csv_table::{Cells, Column, CsvError, Table};
use observations::{Arrival, ArrivalTime, EmitterMeasurement, ReadyFix, Receiver, ReceiverName};

use crate::bearings_csv::BearingPlaces;
use crate::cells::{Cell, Time};
use crate::columns::columns;
use crate::plane::{InPlane, Plane, Positions, SensorPlaces};
use crate::rows::{Columns, Reference, RowReader, RowWriter};
use crate::time_base::TimeBase;

/// Largest standard deviation of a usable time, seconds.
const SIGMA_MAX_S: f64 = 1.0;

/// Reads measurements of emitters.
pub type EmitterRowReader<R> = RowReader<R, EmitterColumns>;
/// Writer of arrival times. Values read back are equal to the last bit.
pub type ArrivalWriter<W> = RowWriter<Arrival, W>;
/// Writer of ready-made fixes. Values read back are equal to the last bit.
pub type FixWriter<W> = RowWriter<ReadyFix, W>;

/// Columns of measurements of emitters.
#[derive(Debug)]
pub struct EmitterColumns {
    base: TimeBase,
    plane: Plane,
    kind: Option<Column>,
    bearings: Option<BearingPlaces>,
    arrivals: Option<ArrivalPlaces>,
    fixes: Option<FixColumns>,
}

columns! {
    /// Places of the columns of arrival times.
    ArrivalPlaces of Arrival: |row|
    time: Column = "time_s" => Time(row.time_of_measurement_ns),
    emitter: Column = "emitter_id" => row.emitter_id,
    kind: Column = "kind" => if second(row).is_some() { "tdoa" } else { "toa" },
    receiver: Column = "receiver" => first(row).name,
    single: Option<Column> = "t_s" => second(row).is_none().then(|| time_s(row)),
    sigma: Column = "sigma_s" => row.sigma_s,
    position: SensorPlaces = SensorPlaces::METRES => first(row).position_m,
    receiver_2: Option<Column> = "receiver_2" => second(row).map(|second| second.name),
    position_2: Option<[Column; 3]> = ["px_2", "py_2", "pz_2"] => each(second(row).map(|second| second.position_m)),
    difference: Option<Column> = "tdoa_s" => second(row).is_some().then(|| time_s(row)),
    reference: Option<[Column; 3]> = ["reference_x", "reference_y", "reference_z"] => each(row.reference_m),
}

columns! {
    ReadyFix: |row|
    "time_s" => Time(row.time_of_measurement_ns),
    "emitter_id" => row.emitter_id,
    ["x", "y", "z"] => row.position_m,
    ["Pxx", "Pxy", "Pyy"] => row.covariance_m2,
}

impl Cell for ReceiverName {
    fn write(self, out: &mut impl Write, _: &Reference) -> io::Result<()> {
        write!(out, "{self}")
    }
}

/// The receiver of an arrival, or the first one of a difference.
fn first(arrival: &Arrival) -> Receiver {
    match arrival.time {
        ArrivalTime::At { receiver, .. } => receiver,
        ArrivalTime::Between { receivers, .. } => receivers[0],
    }
}

/// The second receiver of a difference.
fn second(arrival: &Arrival) -> Option<Receiver> {
    match arrival.time {
        ArrivalTime::At { .. } => None,
        ArrivalTime::Between { receivers, .. } => Some(receivers[1]),
    }
}

/// Time of arrival, or difference, seconds.
fn time_s(arrival: &Arrival) -> f64 {
    match arrival.time {
        ArrivalTime::At { t_s, .. } => t_s,
        ArrivalTime::Between { tdoa_s, .. } => tdoa_s,
    }
}

/// Values that are all stated, or none of them.
fn each(values: Option<[f64; 3]>) -> [Option<f64>; 3] {
    std::array::from_fn(|axis| values.map(|values| values[axis]))
}

/// Columns of ready-made fixes.
#[derive(Debug)]
struct FixColumns {
    time: Column,
    emitter: Column,
    position: FixPlaces,
    covariance: Option<[Column; 3]>,
    variance: Option<Column>,
    sigma: Option<Column>,
}

/// Columns of the place of a fix.
#[derive(Debug)]
enum FixPlaces {
    Metres([Column; 3]),
    Degrees(Positions, Option<Column>),
}

impl<R: Read> EmitterRowReader<R> {
    /// Reads the header line. Times of rows count from `first_day_ns` (UTC, nanoseconds), or from 1970.
    ///
    /// # Errors
    /// [`CsvError`] if a column is missing or the input fails.
    pub fn new(input: R, first_day_ns: i64) -> Result<Self, CsvError> {
        let table = Table::new(input)?;
        let has = |name| table.optional(name).map(|column| column.is_some());
        let kind = table.optional("kind")?;
        let has_arrivals = kind.is_some() && (has("t_s")? || has("tdoa_s")?);
        let has_fixes = kind.is_none() && !has("bearing_rad")? && (has("x")? || has("latitude")? && has("emitter_id")?);
        let has_bearings = has("bearing_rad")? || !has_arrivals && !has_fixes;
        let columns = EmitterColumns {
            base: TimeBase::new(first_day_ns),
            plane: Plane::Open,
            kind,
            bearings: has_bearings.then(|| BearingPlaces::find(&table)).transpose()?,
            arrivals: has_arrivals.then(|| arrival_places(&table)).transpose()?,
            fixes: has_fixes.then(|| FixColumns::find(&table)).transpose()?,
        };
        Ok(Self { table, columns })
    }

    /// Whether the table may have rows of reference emitters.
    pub fn has_references(&self) -> bool {
        let arrivals = self.columns.arrivals.as_ref();
        arrivals.is_some_and(|arrivals| arrivals.reference.is_some())
    }

    /// Whether the rows are ready-made fixes.
    pub fn has_fixes(&self) -> bool {
        self.columns.fixes.is_some()
    }
}

impl InPlane for EmitterColumns {
    fn plane(&mut self) -> &mut Plane {
        &mut self.plane
    }
}

impl Columns for EmitterColumns {
    type Value = EmitterMeasurement;

    fn read(&mut self, row: Cells<'_>) -> Result<EmitterMeasurement, CsvError> {
        if let Some(fixes) = &self.fixes {
            return Ok(EmitterMeasurement::Fix(fixes.read(
                row,
                &mut self.base,
                &mut self.plane,
            )?));
        }
        let Some(kind) = self.kind else {
            return self.bearing(row, None);
        };
        match row.text(kind)? {
            None | Some("bearing") => self.bearing(row, Some(kind)),
            Some(word @ ("toa" | "tdoa")) => {
                let arrivals = self.arrivals.as_ref().ok_or_else(|| missing(row, kind, word))?;
                let arrival = arrivals.read(row, word, (&mut self.base, &mut self.plane))?;
                Ok(EmitterMeasurement::Arrival(arrival))
            }
            Some(_) => Err(row.error(kind, "is no kind of measurement; there are bearing, toa and tdoa")),
        }
    }
}

impl EmitterColumns {
    fn bearing(&mut self, row: Cells<'_>, kind: Option<Column>) -> Result<EmitterMeasurement, CsvError> {
        match (&self.bearings, kind) {
            (None, Some(kind)) => Err(row.error(kind, "stands for a bearing, which needs the column bearing_rad")),
            (Some(bearings), _) => {
                let bearing = bearings.read(row, &mut self.base, &mut self.plane)?;
                Ok(EmitterMeasurement::Bearing(bearing))
            }
            (None, None) => unreachable!("without a kind a table has fixes or bearings"),
        }
    }
}

/// A row of this kind lacks the column of its time.
fn missing(row: Cells<'_>, column: Column, kind: &str) -> CsvError {
    let time = if kind == "toa" { "t_s" } else { "tdoa_s" };
    row.error(column, format!("needs the column {time}"))
}

/// Finds the columns of arrival times in the header of a table; a difference needs those of both receivers.
fn arrival_places<R: Read>(table: &Table<R>) -> Result<ArrivalPlaces, CsvError> {
    let places = ArrivalPlaces::find(table)?;
    if places.difference.is_some() {
        table.required("receiver_2")?;
        table.all(["px_2", "py_2", "pz_2"])?;
    }
    Ok(places)
}

impl ArrivalPlaces {
    fn read(
        &self,
        row: Cells<'_>,
        kind: &str,
        (base, plane): (&mut TimeBase, &mut Plane),
    ) -> Result<Arrival, CsvError> {
        let time = match kind {
            "toa" => self.single(row, plane)?,
            _ => self.difference(row, plane)?,
        };
        let time = time.ok_or_else(|| missing(row, self.kind, kind))?;
        Ok(Arrival {
            time_of_measurement_ns: base.utc_ns(row, self.time)?,
            emitter_id: row.whole(self.emitter)?,
            time,
            sigma_s: sigma(row, self.sigma)?,
            reference_m: self.reference(row)?,
        })
    }

    fn single(&self, row: Cells<'_>, plane: &mut Plane) -> Result<Option<ArrivalTime>, CsvError> {
        let Some(column) = self.single else { return Ok(None) };
        let receiver = receiver(row, self.receiver, self.position.read(row, plane)?.position_m)?;
        let t_s = row.time_s(column)?;
        Ok(Some(ArrivalTime::At { receiver, t_s }))
    }

    fn difference(&self, row: Cells<'_>, plane: &mut Plane) -> Result<Option<ArrivalTime>, CsvError> {
        let (Some(column), Some(name), Some(position)) = (self.difference, self.receiver_2, self.position_2) else {
            return Ok(None);
        };
        let receivers = [
            receiver(row, self.receiver, self.position.read(row, plane)?.position_m)?,
            receiver(row, name, row.numbers(position)?)?,
        ];
        if receivers[0].name == receivers[1].name {
            return Err(row.error(
                name,
                "is the same receiver as in column receiver; a difference needs two",
            ));
        }
        let tdoa_s = row.number(column)?;
        Ok(Some(ArrivalTime::Between { receivers, tdoa_s }))
    }

    /// Position of a reference emitter; `None` if all three values are empty.
    fn reference(&self, row: Cells<'_>) -> Result<Option<[f64; 3]>, CsvError> {
        let Some(columns) = self.reference else { return Ok(None) };
        let mut is_stated = false;
        for column in columns {
            is_stated |= row.text(column)?.is_some();
        }
        is_stated.then(|| row.numbers(columns)).transpose()
    }
}

impl FixColumns {
    fn find<R: Read>(table: &Table<R>) -> Result<Self, CsvError> {
        let (variance, sigma) = (table.optional("variance_m2")?, table.optional("sigma_m")?);
        let has_covariance = table.optional("Pxx")?.is_some() || variance.or(sigma).is_none();
        let position = match Positions::find(table)? {
            Some(degrees @ Positions::Degrees(_)) => FixPlaces::Degrees(degrees, table.optional("altitude_m")?),
            _ => FixPlaces::Metres(table.all(["x", "y", "z"])?),
        };
        Ok(Self {
            time: table.required("time_s")?,
            emitter: table.required("emitter_id")?,
            position,
            covariance: has_covariance.then(|| table.all(["Pxx", "Pxy", "Pyy"])).transpose()?,
            variance,
            sigma,
        })
    }

    fn read(&self, row: Cells<'_>, base: &mut TimeBase, plane: &mut Plane) -> Result<ReadyFix, CsvError> {
        Ok(ReadyFix {
            time_of_measurement_ns: base.utc_ns(row, self.time)?,
            emitter_id: row.whole(self.emitter)?,
            position_m: match &self.position {
                FixPlaces::Metres(columns) => {
                    plane.take_metres(row, columns[0])?;
                    row.numbers(*columns)?
                }
                FixPlaces::Degrees(degrees, height) => {
                    let height_m = row.number_or_empty(*height)?;
                    degrees.read(row, height_m, plane)?.position_m
                }
            },
            covariance_m2: self.covariance(row)?,
        })
    }

    fn covariance(&self, row: Cells<'_>) -> Result<[f64; 3], CsvError> {
        let is_needed = match self.covariance {
            Some([first, ..]) => row.text(first)?.is_none(),
            None => true,
        };
        if let Some(column) = self.variance.or(self.sigma).filter(|_| is_needed) {
            let stated = above_zero(row, column)?;
            let axis_m2 = if self.variance.is_some() {
                0.5 * stated
            } else {
                stated * stated
            };
            return Ok([axis_m2, 0.0, axis_m2]);
        }
        let Some([xx, xy, yy]) = self.covariance else {
            unreachable!("a table of fixes has one of both")
        };
        let covariance_m2 = [above_zero(row, xx)?, row.number(xy)?, above_zero(row, yy)?];
        let limit_m2 = (covariance_m2[0] * covariance_m2[2]).sqrt();
        match covariance_m2[1].abs() < limit_m2 {
            true => Ok(covariance_m2),
            false => Err(row.error(
                xy,
                format!("must lie between -{limit_m2} and {limit_m2}, the root of Pxx times Pyy"),
            )),
        }
    }
}

fn receiver(row: Cells<'_>, name: Column, position_m: [f64; 3]) -> Result<Receiver, CsvError> {
    let text = row.text(name)?.unwrap_or_default();
    let no_name = || row.error(name, "is no name; write 1 to 16 visible ASCII characters");
    Ok(Receiver {
        name: ReceiverName::new(text).ok_or_else(no_name)?,
        position_m,
    })
}

fn sigma(row: Cells<'_>, column: Column) -> Result<f64, CsvError> {
    match row.number(column)? {
        ..=0.0 => Err(row.error(column, "must be greater than 0; a standard deviation is, in seconds")),
        sigma if sigma > SIGMA_MAX_S => {
            let reason = format!("is more than {SIGMA_MAX_S}, which locates nothing; write seconds, not metres");
            Err(row.error(column, reason))
        }
        sigma => Ok(sigma),
    }
}

fn above_zero(row: Cells<'_>, column: Column) -> Result<f64, CsvError> {
    match row.number(column)? {
        ..=0.0 => Err(row.error(column, "must be greater than 0; a variance is, in square metres")),
        variance => Ok(variance),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEADER: &str = "time_s,emitter_id,kind,bearing_rad,sigma_rad,px,py,pz,receiver,receiver_2,px_2,py_2,pz_2,t_s,\
                          tdoa_s,sigma_s,reference_x,reference_y,reference_z";

    fn read(header: &str, rows: &str) -> Vec<Result<EmitterMeasurement, String>> {
        let text = format!("{header}\n{rows}");
        let reader = EmitterRowReader::new(text.as_bytes(), 1_000).unwrap();
        reader.map(|row| row.map_err(|error| error.to_string())).collect()
    }

    fn receiver(name: &str, position_m: [f64; 3]) -> Receiver {
        let name = ReceiverName::new(name).unwrap();
        Receiver { name, position_m }
    }

    #[test]
    fn kinds_are_read_side_by_side() {
        let rows = "1,7,,0.5,0.01,10,20,30,,,,,,,,,,,\n2,7,bearing,0.5,0.01,10,20,30,,,,,,,,,,,\n\
                    2.5,7,toa,,,1,2,3,north,,,,,2.5000125,,1e-8,,,\n\
                    3,8,tdoa,,,1,2,3,north,2,4,5,6,,-2e-5,1e-8,7,8,9\n";
        let found = read(HEADER, rows);
        assert!(matches!(found[0], Ok(EmitterMeasurement::Bearing(bearing)) if bearing.bearing_rad == 0.5));
        assert!(matches!(found[1], Ok(EmitterMeasurement::Bearing(_))));
        let single = Arrival {
            time_of_measurement_ns: 2_500_001_000,
            emitter_id: 7,
            time: ArrivalTime::At {
                receiver: receiver("north", [1.0, 2.0, 3.0]),
                t_s: 2.500_012_5,
            },
            sigma_s: 1e-8,
            reference_m: None,
        };
        assert_eq!(found[2], Ok(EmitterMeasurement::Arrival(single)));
        let difference = Arrival {
            time_of_measurement_ns: 3_000_001_000,
            emitter_id: 8,
            time: ArrivalTime::Between {
                receivers: [receiver("north", [1.0, 2.0, 3.0]), receiver("2", [4.0, 5.0, 6.0])],
                tdoa_s: -2e-5,
            },
            reference_m: Some([7.0, 8.0, 9.0]),
            ..single
        };
        assert_eq!(found[3], Ok(EmitterMeasurement::Arrival(difference)));
    }

    #[test]
    fn fixes_state_a_covariance_or_its_trace() {
        let fix = ReadyFix {
            time_of_measurement_ns: 1_000_001_000,
            emitter_id: 7,
            position_m: [1.0, 2.0, 3.0],
            covariance_m2: [4.0, 1.0, 9.0],
        };
        let both = "time_s,emitter_id,x,y,z,Pxx,Pxy,Pyy,variance_m2";
        let halves = ReadyFix {
            covariance_m2: [50.0, 0.0, 50.0],
            ..fix
        };
        for (header, row, expected) in [
            ("time_s,emitter_id,x,y,z,Pxx,Pxy,Pyy", "1,7,1,2,3,4,1,9", fix),
            ("time_s,emitter_id,x,y,z,variance_m2", "1,7,1,2,3,100", halves),
            (both, "1,7,1,2,3,4,1,9,100", fix),
            (both, "1,7,1,2,3,,,,100", halves),
        ] {
            assert_eq!(read(header, row), [Ok(EmitterMeasurement::Fix(expected))], "{header}");
        }
        let missing = EmitterRowReader::new("time_s,emitter_id,x,y,z\n".as_bytes(), 0).unwrap_err();
        assert!(missing.to_string().contains("column Pxx is missing"), "{missing}");
    }

    #[test]
    fn what_cannot_be_meant_is_refused_with_place_and_remedy() {
        for (row, expected) in [
            (
                "1,7,adoa,,,1,2,3,a,,,,,1,,1e-8,,,",
                "column kind: \"adoa\" is no kind of measurement",
            ),
            (
                "1,,toa,,,1,2,3,a,,,,,1,,1e-8,,,",
                "column emitter_id: \"\" is no whole number",
            ),
            ("1,7,toa,,,1,2,3,,,,,,1,,1e-8,,,", "column receiver: \"\" is no name"),
            ("1,7,toa,,,1,,3,a,,,,,1,,1e-8,,,", "column py: \"\" is empty"),
            ("1,7,toa,,,1,2,3,a,,,,,,,1e-8,,,", "column t_s: \"\" is empty"),
            (
                "1,7,toa,,,1,2,3,a,,,,,1,,0,,,",
                "column sigma_s: \"0\" must be greater than 0",
            ),
            (
                "1,7,toa,,,1,2,3,a,,,,,1,,20,,,",
                "column sigma_s: \"20\" is more than 1",
            ),
            (
                "1,7,toa,,,1,2,3,a,,,,,1,,1e-8,5,,6",
                "column reference_y: \"\" is empty",
            ),
            (
                "1,7,tdoa,,,1,2,3,a,a,4,5,6,,1e-6,1e-8,,,",
                "column receiver_2: \"a\" is the same receiver",
            ),
            (
                "1,7,tdoa,,,1,2,3,a,b,4,5,6,,NaN,1e-8,,,",
                "column tdoa_s: \"NaN\" is not finite",
            ),
            (
                "1,7,,,,1,2,3,a,b,4,5,6,,1e-6,1e-8,,,",
                "column bearing_rad: \"\" is empty",
            ),
        ] {
            let [Err(text)] = &read(HEADER, row)[..] else {
                panic!("{row}")
            };
            assert!(text.starts_with("line 2, ") && text.contains(expected), "{text}");
        }
        for (header, row, expected) in [
            (
                "time_s,emitter_id,kind,receiver,t_s,sigma_s,px,py,pz",
                "1,7,,a,1,1e-8,1,2,3",
                "bearing_rad",
            ),
            (
                "time_s,emitter_id,kind,receiver,t_s,sigma_s,px,py,pz",
                "1,7,tdoa,a,1,1e-8,1,2,3",
                "tdoa_s",
            ),
            (
                "time_s,emitter_id,kind,bearing_rad,sigma_rad,px,py,pz",
                "1,7,toa,1,0.1,1,2,3",
                "t_s",
            ),
            (
                "time_s,emitter_id,x,y,z,Pxx,Pxy,Pyy",
                "1,7,1,2,3,4,6,9",
                "between -6 and 6",
            ),
            (
                "time_s,emitter_id,x,y,z,variance_m2",
                "1,7,1,2,3,0",
                "must be greater than 0",
            ),
        ] {
            let [Err(text)] = &read(header, row)[..] else {
                panic!("{row}")
            };
            assert!(text.contains(expected), "{text}");
        }
    }

    #[test]
    fn what_is_written_is_read_again_exactly() {
        let receiver = |name, east_m| Receiver {
            name: ReceiverName::new(name).unwrap(),
            position_m: [east_m, 2.0 / 7.0, -3.0],
        };
        let single = Arrival {
            time_of_measurement_ns: 43_200_123_456_789,
            emitter_id: 7,
            time: ArrivalTime::At {
                receiver: receiver("north-east", 1.0 / 3.0),
                t_s: 43_200.123_456_789_01,
            },
            sigma_s: 0.1 / 3.0,
            reference_m: Some([1.0, -0.1, 3.0]),
        };
        let difference = Arrival {
            time: ArrivalTime::Between {
                receivers: [receiver("a", 4.0), receiver("b", -1e-3)],
                tdoa_s: -1.0 / 7e5,
            },
            reference_m: None,
            ..single
        };
        let fix = ReadyFix {
            time_of_measurement_ns: 5,
            emitter_id: 9,
            position_m: [1.0 / 3.0, -2.5, 0.0],
            covariance_m2: [4.0, -1.0 / 3.0, 9.0],
        };
        let mut arrivals = ArrivalWriter::begin(Vec::new(), 5).unwrap();
        arrivals.write(&single).unwrap();
        arrivals.write(&difference).unwrap();
        let mut fixes = FixWriter::begin(Vec::new(), 5).unwrap();
        fixes.write(&fix).unwrap();
        let read = |octets: Vec<u8>| -> Vec<EmitterMeasurement> {
            let reader = EmitterRowReader::new(&octets[..], 5).unwrap();
            reader.map(Result::unwrap).collect()
        };
        let expected = [single, difference].map(EmitterMeasurement::Arrival);
        assert_eq!(read(arrivals.into_inner()), expected);
        assert_eq!(read(fixes.into_inner()), [EmitterMeasurement::Fix(fix)]);
    }
}
