//! Snapshots of an antenna array as CSV rows (EL-1).
//!
//! `time_s,px,py,pz,heading_rad,frequency_hz,re_1,im_1,re_2,im_2,…`: a row per array snapshot, with the complex
//! sample of each antenna. Rows with the same time belong to the same measurement.

use std::f64::consts::TAU;
use std::io::{self, Read, Write};

use csv_table::{Cells, Column, CsvError, Table};
use observations::SnapshotBlock;

use crate::rows::{Columns, RowReader};
use crate::time_base::TimeBase;

/// Samples of all antennas at one time.
#[derive(Clone, Debug, PartialEq)]
pub struct ArraySnapshot {
    /// Time of the measurement, UTC, nanoseconds since 1970.
    pub time_ns: i64,
    /// Position of the platform east, north, up, metres.
    pub platform_m: [f64; 3],
    /// Heading of the platform, radians clockwise from north.
    pub heading_rad: f64,
    /// Frequency of the waves, hertz.
    pub frequency_hz: f64,
    /// Real and imaginary part of each antenna's sample, in the order of the array.
    pub samples: Vec<[f64; 2]>,
}

/// Reads snapshots.
pub type SnapshotReader<R> = RowReader<R, SnapshotColumns>;

/// Writes the header line of snapshots of so many antennas.
///
/// # Errors
/// If `out` fails.
pub fn write_header(out: &mut impl Write, antennas: usize) -> io::Result<()> {
    write!(out, "time_s,px,py,pz,heading_rad,frequency_hz")?;
    (1..=antennas).try_for_each(|antenna| write!(out, ",re_{antenna},im_{antenna}"))?;
    writeln!(out)
}

/// Writes the snapshots of a measurement, a row each; times count from `first_day_ns` (UTC, nanoseconds). Values read
/// back are equal to the last bit. A platform that the measurement does not state has empty values.
///
/// # Errors
/// If `out` fails.
pub fn write_rows(out: &mut impl Write, block: &SnapshotBlock, first_day_ns: i64) -> io::Result<()> {
    for samples in block.samples.chunks(usize::from(block.antennas)) {
        csv_table::write_time(out, block.time_ns.saturating_sub(first_day_ns))?;
        match block.platform_m {
            Some([east, north, up]) => write!(out, ",{east},{north},{up}")?,
            None => write!(out, ",,,")?,
        }
        match block.heading_rad {
            Some(heading_rad) => write!(out, ",{heading_rad}")?,
            None => write!(out, ",")?,
        }
        write!(out, ",{}", block.frequency_hz)?;
        samples.iter().flatten().try_for_each(|part| write!(out, ",{part}"))?;
        writeln!(out)?;
    }
    Ok(())
}

/// Columns of snapshots.
#[derive(Debug)]
pub struct SnapshotColumns {
    base: TimeBase,
    time: Column,
    platform: [Column; 3],
    heading: Column,
    frequency: Column,
    samples: Vec<[Column; 2]>,
}

impl<R: Read> SnapshotReader<R> {
    /// Reads the header line of snapshots of so many antennas. Times of rows count from `first_day_ns` (UTC,
    /// nanoseconds), or from 1970.
    ///
    /// # Errors
    /// [`CsvError`] if a column is missing or the input fails.
    pub fn new(input: R, first_day_ns: i64, antennas: usize) -> Result<Self, CsvError> {
        let table = Table::new(input)?;
        // Columns have names that live as long as the program: two short ones for each antenna, once.
        let named = |part: &str, antenna: usize| table.required(String::leak(format!("{part}_{antenna}")));
        let samples = (1..=antennas).map(|antenna| Ok([named("re", antenna)?, named("im", antenna)?]));
        let columns = SnapshotColumns {
            base: TimeBase::new(first_day_ns),
            time: table.required("time_s")?,
            platform: table.all(["px", "py", "pz"])?,
            heading: table.required("heading_rad")?,
            frequency: table.required("frequency_hz")?,
            samples: samples.collect::<Result<_, CsvError>>()?,
        };
        Ok(Self { table, columns })
    }
}

impl Columns for SnapshotColumns {
    type Value = ArraySnapshot;

    fn read(&mut self, row: Cells<'_>) -> Result<ArraySnapshot, CsvError> {
        let heading_rad = row.number(self.heading)?;
        if heading_rad.abs() > TAU {
            return Err(row.error(self.heading, "is more than a full turn; write radians, not degrees"));
        }
        let frequency_hz = row.number(self.frequency)?;
        if frequency_hz <= 0.0 {
            return Err(row.error(self.frequency, "must be greater than 0; a frequency is, in hertz"));
        }
        let samples = self.samples.iter().map(|columns| row.numbers(*columns));
        Ok(ArraySnapshot {
            time_ns: self.base.utc_ns(row, self.time)?,
            platform_m: row.numbers(self.platform)?,
            heading_rad,
            frequency_hz,
            samples: samples.collect::<Result<_, CsvError>>()?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_read_in_any_order_of_columns_and_faults_have_place_and_remedy() {
        let text = "im_2,re_2,time_s,px,py,pz,heading_rad,frequency_hz,re_1,im_1\n4,3,1.5,10,20,30,0.5,1e9,1,2\n\
                    4,3,1.5,10,20,30,90,1e9,1,2\n4,3,1.5,10,20,30,1,0,1,2\n4,x,1.5,10,20,30,1,1e9,1,2\n";
        let mut rows = SnapshotReader::new(text.as_bytes(), 1_000, 2).unwrap();
        let first = ArraySnapshot {
            time_ns: 1_500_001_000,
            platform_m: [10.0, 20.0, 30.0],
            heading_rad: 0.5,
            frequency_hz: 1e9,
            samples: vec![[1.0, 2.0], [3.0, 4.0]],
        };
        assert_eq!(rows.next().unwrap().unwrap(), first);
        for expected in [
            "line 3, column heading_rad: \"90\" is more than a full turn",
            "line 4, column frequency_hz: \"0\" must be",
            "line 5, column re_2: \"x\" is no number",
        ] {
            let error = rows.next().unwrap().unwrap_err().to_string();
            assert!(error.starts_with(expected), "{error}");
        }
        let error = SnapshotReader::new(text.as_bytes(), 0, 3).unwrap_err().to_string();
        assert!(error.contains("column re_3 is missing"), "{error}");
    }

    #[test]
    fn what_is_written_is_read_again_exactly() {
        let block = SnapshotBlock {
            time_ns: 1_500_001_000,
            total: 2,
            antennas: 2,
            frequency_hz: 1e9 / 3.0,
            platform_m: Some([1.0 / 3.0, -2.0, 3e3]),
            heading_rad: Some(0.1),
            samples: vec![[0.1, -0.2], [1e-7, 3.0], [4.0, 5.0], [-6.5, 7.0]],
            ..SnapshotBlock::default()
        };
        let mut octets = Vec::new();
        write_header(&mut octets, 2).unwrap();
        write_rows(&mut octets, &block, 1_000).unwrap();
        let rows: Vec<ArraySnapshot> = SnapshotReader::new(&octets[..], 1_000, 2)
            .unwrap()
            .map(Result::unwrap)
            .collect();
        assert_eq!(rows.len(), 2);
        for (row, samples) in rows.iter().zip(block.samples.chunks(2)) {
            assert_eq!((row.time_ns, row.frequency_hz), (block.time_ns, block.frequency_hz));
            assert_eq!(
                (Some(row.platform_m), Some(row.heading_rad)),
                (block.platform_m, block.heading_rad)
            );
            let read: Vec<[f32; 2]> = row.samples.iter().map(|parts| parts.map(|part| part as f32)).collect();
            assert_eq!(read, samples);
        }
    }
}
