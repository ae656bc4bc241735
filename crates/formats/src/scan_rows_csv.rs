//! Detections together with scans that had none, as CSV rows (FM-6).
//!
//! A table of detections shows a scan without detections only as a gap between two scan numbers. Before the first
//! detection and after the last one no gap shows it, although a tracker has to know that the sensor looked and found
//! nothing. A row of the kind `none` states such a scan: its time, its sensor and its number. `detection_id` and the
//! position of the sensor may be empty; measured values and standard deviations must be.
//!
//! Tables of others state detections by named columns ([`crate::named_columns`]), without such scans.

use std::io::{self, Read, Write};

use csv_table::{Cells, Column, CsvError, Table};

use crate::cells::{Cell as _, Time};
use crate::detections_csv::{DetectionColumns, RepliedDetection};
use crate::named_columns::detections::{NamedDetections, has_named_detections};
use crate::plane::{InPlane, Plane};
use crate::rows::{Columns, Reference, Row, RowReader};
use observations::Detection;

/// The kind of a row that states a scan without detections.
pub const NONE: &str = "none";

/// Reads detections and scans without any.
pub type ScanRowReader<R> = RowReader<R, ScanRowColumns>;

/// A row of a table of detections.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "nearly all rows are detections")]
pub enum ScanRow {
    /// A detection.
    Detection(Detection),
    /// A scan without detections.
    Empty(EmptyScan),
}

/// A scan without detections.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EmptyScan {
    /// Number of the sensor in its files.
    pub sensor_id: u32,
    /// Number of the scan.
    pub scan: u32,
    /// Time of the scan, UTC, nanoseconds.
    pub time_ns: i64,
}

/// Columns that a row of the kind `none` fills, the first ones of the table.
const NONE_COLUMNS: usize = 5;

/// Row of a table of detections with the values of transponders.
#[derive(Clone, Copy, Debug)]
pub struct RepliedScanRow(pub ScanRow);

impl Row for RepliedScanRow {
    fn columns() -> String {
        RepliedDetection::columns()
    }

    fn write(&self, out: &mut impl Write, reference: &Reference) -> io::Result<()> {
        let empty = match &self.0 {
            ScanRow::Detection(detection) => return RepliedDetection(*detection).write(out, reference),
            ScanRow::Empty(empty) => empty,
        };
        Time(empty.time_ns).write(out, reference)?;
        write!(out, ",{},{},,{NONE}", empty.sensor_id, empty.scan)?;
        let rest = Self::columns().split(',').skip(NONE_COLUMNS).count();
        (0..rest).try_for_each(|_| out.write_all(b","))
    }
}

/// Columns of detections.
#[derive(Debug)]
pub struct ScanRowColumns {
    layout: Layout,
    /// The plane of a table in metres, which states no places in degrees.
    plane: Plane,
}

/// How a table states detections.
#[derive(Debug)]
#[expect(clippy::large_enum_variant, reason = "there is one for a table")]
enum Layout {
    /// In columns of its own (FM-6).
    Own(OwnColumns),
    /// By named columns.
    Named(NamedDetections),
}

/// Columns of detections, and those that a scan without detections needs.
#[derive(Debug)]
struct OwnColumns {
    detections: DetectionColumns,
    time: Column,
    sensor: Column,
    scan: Column,
    kind: Column,
    /// Measured values and standard deviations.
    measured: [Column; 8],
}

impl<R: Read> ScanRowReader<R> {
    /// Reads the header line. Times of rows count from `first_day_ns` (UTC, nanoseconds), or from 1970.
    ///
    /// # Errors
    /// [`CsvError`] if a column is missing or the input fails.
    pub fn new(input: R, first_day_ns: i64) -> Result<Self, CsvError> {
        let table = Table::new(input)?;
        let layout = match has_named_detections(&table) {
            true => Layout::Named(NamedDetections::find(&table, first_day_ns)?),
            false => Layout::Own(OwnColumns::find(&table, first_day_ns)?),
        };
        let columns = ScanRowColumns {
            layout,
            plane: Plane::Open,
        };
        Ok(Self { table, columns })
    }

    /// As [`Self::new`], for a table that continues others of the same sensors: its scans must have numbers.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn with_scans(input: R, first_day_ns: i64) -> Result<Self, CsvError> {
        let reader = Self::new(input, first_day_ns)?;
        match &reader.columns.layout {
            Layout::Named(named) if named.scan.is_none() => Err(reader.table.missing("scan")),
            _ => Ok(reader),
        }
    }

    /// Counts rows without a sensor to the sensor of this number, instead of 1.
    pub fn set_sensor(&mut self, sensor_id: u32) {
        if let Layout::Named(named) = &mut self.columns.layout {
            named.sensor_id = sensor_id;
        }
    }
}

impl OwnColumns {
    fn find<R: Read>(table: &Table<R>, first_day_ns: i64) -> Result<Self, CsvError> {
        Ok(Self {
            detections: DetectionColumns::find(table, first_day_ns)?,
            time: table.required("time_s")?,
            sensor: table.required("sensor_id")?,
            scan: table.required("scan")?,
            kind: table.required("kind")?,
            measured: table.all(["m0", "m1", "m2", "m3", "s0", "s1", "s2", "s3"])?,
        })
    }
}

impl InPlane for ScanRowColumns {
    fn plane(&mut self) -> &mut Plane {
        match &mut self.layout {
            Layout::Own(_) => &mut self.plane,
            Layout::Named(named) => &mut named.plane,
        }
    }
}

impl Columns for ScanRowColumns {
    type Value = ScanRow;

    fn read(&mut self, row: Cells<'_>) -> Result<ScanRow, CsvError> {
        match &mut self.layout {
            Layout::Own(own) => own.read(row),
            Layout::Named(named) => named.read(row).map(ScanRow::Detection),
        }
    }
}

impl OwnColumns {
    fn read(&mut self, row: Cells<'_>) -> Result<ScanRow, CsvError> {
        if row.text(self.kind)? != Some(NONE) {
            return self.detections.read(row).map(ScanRow::Detection);
        }
        for column in self.measured {
            if row.text(column)?.is_some() {
                let what = "is measured, but a row of the kind none has no detection; leave it empty or write its kind";
                return Err(row.error(column, what));
            }
        }
        Ok(ScanRow::Empty(EmptyScan {
            sensor_id: row.whole(self.sensor)?,
            scan: row.whole(self.scan)?,
            time_ns: self.detections.base.utc_ns(row, self.time)?,
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(rows: &str) -> Vec<Result<ScanRow, String>> {
        let header = "time_s,sensor_id,scan,detection_id,kind,m0,m1,m2,m3,s0,s1,s2,s3,px,py,pz,truth_id";
        let text = format!("{header}\n{rows}");
        let reader = ScanRowReader::new(text.as_bytes(), 1_000).unwrap();
        reader.map(|row| row.map_err(|error| error.to_string())).collect()
    }

    #[test]
    fn a_written_row_of_a_scan_without_detections_is_read_again() {
        let empty = ScanRow::Empty(EmptyScan {
            sensor_id: 3,
            scan: 70,
            time_ns: 1_000_002_500,
        });
        let mut writer = crate::rows::RowWriter::begin(Vec::new(), 1_000).unwrap();
        writer.write(&RepliedScanRow(empty)).unwrap();
        let text = writer.into_inner();
        let widths = text
            .split(|octet| *octet == b'\n')
            .take(2)
            .map(|line| line.split(|octet| *octet == b',').count());
        assert_eq!(widths.clone().min(), widths.max());
        let found: Vec<_> = ScanRowReader::new(&text[..], 1_000)
            .unwrap()
            .map(Result::unwrap)
            .collect();
        assert_eq!(found, [empty]);
    }

    #[test]
    fn a_scan_without_detections_is_a_row_beside_the_others() {
        let rows = "2.5,1,3,,none,,,,,,,,,,,,\n3,1,4,0,position2,1,2,,,5,5,,,0,0,0,\n4,2,9,7,none,,,,,,,,,0,0,0,-1\n";
        let found: Vec<_> = read(rows).into_iter().map(Result::unwrap).collect();
        let empty = |sensor_id, scan, time_ns| {
            ScanRow::Empty(EmptyScan {
                sensor_id,
                scan,
                time_ns,
            })
        };
        assert_eq!(
            [found[0], found[2]],
            [empty(1, 3, 2_500_001_000), empty(2, 9, 4_000_001_000)]
        );
        assert!(matches!(found[1], ScanRow::Detection(detection) if detection.scan == 4));
    }

    #[test]
    fn what_cannot_be_meant_is_refused_with_place_and_remedy() {
        for (row, expected) in [
            (
                "2,1,3,0,none,5,,,,,,,,,,,",
                "column m0: \"5\" is measured, but a row of the kind none",
            ),
            ("2,1,3,0,none,,,,,,,,9,,,,", "column s3: \"9\" is measured"),
            ("2,1,,0,none,,,,,,,,,,,,", "column scan: \"\" is no whole number"),
            (",1,3,0,none,,,,,,,,,,,,", "column time_s: \"\" is empty"),
            (
                "2,1,3,0,nothing,,,,,,,,,,,,",
                "column kind: \"nothing\" is no kind of detection; write one of position2",
            ),
        ] {
            let [found] = &read(row)[..] else { panic!("{row}") };
            let text = found.as_ref().unwrap_err();
            assert!(text.starts_with("line 2, ") && text.contains(expected), "{text}");
        }
    }
}
