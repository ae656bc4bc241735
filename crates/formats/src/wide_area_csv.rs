//! Reports of wide-area sensors as CSV rows (FM-6).
//!
//! Columns: `time_s` of the observation, `arrival_s` (absolute, not before `time_s`), position and velocity of the
//! targets' centre, their `count`, and optionally `route`: earlier places, oldest first, east and north of each
//! joined with `|`. Only the first place of the route, the origin, is kept. This reader rejects only malformed rows;
//! the user of the report checks plausibility.

use std::io::Read;

use csv_table::{Cells, Column, CsvError, Table};
use observations::WideAreaReport;

use crate::cells::{CellList, Time};
use crate::columns::columns;
use crate::rows::{Columns, RowReader, RowWriter};
use crate::time_base::TimeBase;

/// Most numbers of a route.
const ROUTE_MAX: usize = 2000;

/// Reads wide-area reports.
pub type WideAreaReader<R> = RowReader<R, WideAreaColumns>;
/// Writer of wide-area reports. Values read back are equal to the last bit, except the route.
pub type WideAreaWriter<W> = RowWriter<WideAreaReport, W>;

columns! {
    /// Places of the columns of wide-area reports.
    WideAreaPlaces of WideAreaReport: |row|
    time: Column = "time_s" => Time(row.time_ns),
    arrival: Column = "arrival_s" => Time(row.arrival_ns),
    position: [Column; 3] = ["x", "y", "z"] => row.position_m,
    velocity: [Column; 3] = ["vx", "vy", "vz"] => row.velocity_mps,
    count: Column = "count" => row.targets,
    route: Option<Column> = "route" => row.origin_m.map(CellList),
}

/// Columns of wide-area reports.
#[derive(Debug)]
pub struct WideAreaColumns {
    base: TimeBase,
    at: WideAreaPlaces,
}

impl<R: Read> WideAreaReader<R> {
    /// Reads the header line. Times of rows count from `first_day_ns` (UTC, nanoseconds), or from 1970.
    ///
    /// # Errors
    /// [`CsvError`] if a column is missing or the input fails.
    pub fn new(input: R, first_day_ns: i64) -> Result<Self, CsvError> {
        let table = Table::new(input)?;
        let columns = WideAreaColumns {
            base: TimeBase::new(first_day_ns),
            at: WideAreaPlaces::find(&table)?,
        };
        Ok(Self { table, columns })
    }
}

impl Columns for WideAreaColumns {
    type Value = WideAreaReport;

    fn read(&mut self, row: Cells<'_>) -> Result<WideAreaReport, CsvError> {
        let at = &self.at;
        let (position_m, velocity_mps) = (row.numbers(at.position)?, row.numbers(at.velocity)?);
        Ok(WideAreaReport {
            time_ns: self.base.utc_ns(row, at.time)?,
            arrival_ns: self.base.utc_ns(row, at.arrival)?,
            position_m,
            velocity_mps,
            targets: row.whole(at.count)?,
            origin_m: origin(row, at.route)?,
        })
    }
}

/// The first place of a route.
fn origin(row: Cells<'_>, column: Option<Column>) -> Result<Option<[f64; 2]>, CsvError> {
    let (Some(column), Some(text)) = (column, row.text(column)?) else {
        return Ok(None);
    };
    let fault = || {
        row.error(
            column,
            "is no route; write east and north of each place in metres, like 100|-200|150|-180",
        )
    };
    let (mut origin_m, mut numbers) = ([0.0; 2], 0);
    for part in text.split('|') {
        let number = part.trim().parse::<f64>().ok().filter(|number| number.is_finite());
        let number = number.filter(|_| numbers < ROUTE_MAX).ok_or_else(fault)?;
        if let Some(place) = origin_m.get_mut(numbers) {
            *place = number;
        }
        numbers += 1;
    }
    if numbers % 2 == 1 {
        return Err(fault());
    }
    Ok(Some(origin_m))
}

#[cfg(test)]
mod tests {
    use messages::StageTimes;
    use observations::Sampled;

    use super::*;

    const HEADER: &str = "time_s,arrival_s,x,y,z,vx,vy,vz,count,route\n";

    fn read(rows: &str) -> Vec<Result<WideAreaReport, String>> {
        let text = format!("{HEADER}{rows}");
        let reader = WideAreaReader::new(text.as_bytes(), 1_000).unwrap();
        reader.map(|row| row.map_err(|error| error.to_string())).collect()
    }

    #[test]
    fn what_was_written_is_read_again() {
        let report = WideAreaReport {
            time_ns: 8_000_001_000,
            arrival_ns: 16_500_001_000,
            position_m: [-812.5, 43e3, 0.1],
            velocity_mps: [1.5, -180.0, 0.0],
            targets: 2,
            origin_m: Some([-9e4, 0.3]),
        };
        let without = WideAreaReport {
            origin_m: None,
            targets: 0,
            ..report
        };
        let mut writer = WideAreaWriter::begin(Vec::new(), 1_000).unwrap();
        writer.write(&report).unwrap();
        writer.write(&without).unwrap();
        for report in [report, without] {
            assert_eq!(
                WideAreaReport::of_sample(&report.sample(3, StageTimes::default())),
                Some(report)
            );
        }
        let text = String::from_utf8(writer.into_inner()).unwrap();
        let rows = text.strip_prefix(HEADER).unwrap();
        assert!(
            rows.starts_with("8,16.5,-812.5,43000,0.1,1.5,-180,0,2,-90000|0.3\n"),
            "{rows}"
        );
        assert_eq!(read(rows), [Ok(report), Ok(without)]);
    }

    #[test]
    fn the_route_and_its_column_may_be_missing() {
        let plain = "time_s,arrival_s,x,y,z,vx,vy,vz,count\n0,8,1,2,3,4,5,6,7\n";
        let rows: Vec<_> = WideAreaReader::new(plain.as_bytes(), 0).unwrap().collect();
        assert_eq!(rows.len(), 1);
        assert_eq!(rows[0].as_ref().unwrap().origin_m, None);
    }

    #[test]
    fn what_is_no_report_is_refused_with_line_and_column() {
        for (row, expected) in [
            ("0,8,1,2,3,4,5,6,-1,", "line 2, column count"),
            ("0,8,1,2,3,4,5,6,2.5,", "line 2, column count"),
            ("0,8,1,2,3,4,5,6,,", "line 2, column count"),
            ("0,8,1,nan,3,4,5,6,2,", "line 2, column y"),
            ("0,,1,2,3,4,5,6,2,", "line 2, column arrival_s"),
            ("0,8,1,2,3,4,5,6,2,5", "line 2, column route"),
            ("0,8,1,2,3,4,5,6,2,5|here", "line 2, column route"),
            ("0,8,1,2", "line 2: 4 values"),
        ] {
            let [Err(found)] = &read(row)[..] else { panic!("{row}") };
            assert!(found.starts_with(expected), "{row}: {found}");
        }
    }
}
