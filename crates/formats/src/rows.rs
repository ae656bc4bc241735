//! Rows of text: how any kind of them is read and written.
//!
//! A kind of row defines its columns and its values ([`Row`]), or the construction of a value from columns
//! ([`Columns`]); everything else is common to all kinds. Times are seconds since midnight (UTC) of the first day,
//! exact to the nanosecond. Values read back are equal, to the last bit unless a kind rounds.

use std::fmt;
use std::io::{self, Read, Write};
use std::marker::PhantomData;
use std::str::FromStr;

use csv_table::{Cells, CsvError, Table};
use observations::sensor_id;

/// A value that is written as a row.
pub trait Row {
    /// Names of the columns, separated by commas.
    fn columns() -> String;

    /// Writes the values in the order of the columns, separated by commas, without an end of line.
    ///
    /// # Errors
    /// If `out` fails.
    fn write(&self, out: &mut impl Write, reference: &Reference) -> io::Result<()>;
}

/// Origin of the times and names of the sources in a file.
#[derive(Clone, Debug, Default)]
pub struct Reference {
    first_day_ns: i64,
    sensor_ids: Vec<u32>,
}

impl Reference {
    /// Writes a time (UTC, nanoseconds) in seconds since the first day.
    ///
    /// # Errors
    /// If `out` fails.
    pub fn write_time(&self, out: &mut impl Write, time_ns: i64) -> io::Result<()> {
        csv_table::write_time(out, self.since_first_day_ns(time_ns))
    }

    /// Time (UTC, nanoseconds) since the first day, nanoseconds.
    pub(crate) fn since_first_day_ns(&self, time_ns: i64) -> i64 {
        time_ns.saturating_sub(self.first_day_ns)
    }

    /// Id under which the file shows source number `source`.
    pub fn sensor_id(&self, source: u16) -> u32 {
        let own = self.sensor_ids.get(usize::from(source)).copied();
        own.unwrap_or_else(|| sensor_id(source))
    }
}

/// Time since 1970, nanoseconds, that is shown as date and time of day (UTC), as in `2016-05-10T22:00:00.25Z`.
#[derive(Clone, Copy, Debug)]
pub struct Utc(pub i64);

/// Time since 1970, nanoseconds, as [`Utc`] with three decimals, as in `2016-05-10T22:00:00.250Z`: all texts have one
/// width, and sort as the times do.
#[derive(Clone, Copy, Debug)]
pub struct Milliseconds(pub i64);

impl fmt::Display for Milliseconds {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ms = self.0.div_euclid(1_000_000);
        let whole = Utc(ms.div_euclid(1_000) * 1_000_000_000).to_string();
        write!(f, "{}.{:03}Z", whole.trim_end_matches('Z'), ms.rem_euclid(1_000))
    }
}

/// Nanoseconds of a day.
const DAY_NS: i64 = 86_400_000_000_000;

impl fmt::Display for Utc {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (year, month, day) = date(self.0.div_euclid(DAY_NS));
        let of_day_ns = self.0.rem_euclid(DAY_NS);
        let (of_day_s, mut rest) = (of_day_ns / 1_000_000_000, of_day_ns % 1_000_000_000);
        let (hours, minutes, seconds) = (of_day_s / 3_600, of_day_s / 60 % 60, of_day_s % 60);
        write!(f, "{year:04}-{month:02}-{day:02}T{hours:02}:{minutes:02}:{seconds:02}")?;
        if rest > 0 {
            let mut width = 9;
            while rest % 10 == 0 {
                rest /= 10;
                width -= 1;
            }
            write!(f, ".{rest:0width$}")?;
        }
        f.write_str("Z")
    }
}

/// Returns year, month and day of a day since 1970, in the Gregorian calendar: days are counted from a first of March,
/// so that the leap day is the last of its year, within periods of 400 years (Hinnant, "chrono-compatible low-level
/// date algorithms").
fn date(day: i64) -> (i64, i64, i64) {
    /// Days of 400 years.
    const PERIOD: i64 = 146_097;
    /// From 0000-03-01 to 1970-01-01.
    const OFFSET: i64 = 719_468;
    let (period, of_period) = ((day + OFFSET).div_euclid(PERIOD), (day + OFFSET).rem_euclid(PERIOD));
    let year = (of_period - of_period / 1_460 + of_period / 36_524 - of_period / 146_096) / 365;
    let of_year = of_period - (365 * year + year / 4 - year / 100);
    let march_month = (5 * of_year + 2) / 153;
    let day = of_year - (153 * march_month + 2) / 5 + 1;
    let month = if march_month < 10 {
        march_month + 3
    } else {
        march_month - 9
    };
    (year + 400 * period + i64::from(month <= 2), month, day)
}

impl FromStr for Utc {
    type Err = jiff::Error;

    fn from_str(text: &str) -> Result<Self, jiff::Error> {
        csv_table::zoned_ns(text).map(Self)
    }
}

/// Writes rows of one kind.
#[derive(Debug)]
pub struct RowWriter<T, W> {
    writer: W,
    /// The row being written: the writer gets each row in a single call.
    row: Vec<u8>,
    reference: Reference,
    kind: PhantomData<fn(&T)>,
}

impl<T: Row, W: Write> RowWriter<T, W> {
    /// Writes the header line; times will be counted from `first_day_ns` (UTC, nanoseconds).
    ///
    /// # Errors
    /// If `writer` fails.
    pub fn begin(mut writer: W, first_day_ns: i64) -> io::Result<Self> {
        writeln!(writer, "{}", T::columns())?;
        Ok(Self::resume(writer, first_day_ns))
    }

    /// Continues a file that already has its header line.
    pub fn resume(writer: W, first_day_ns: i64) -> Self {
        Self {
            writer,
            row: Vec::new(),
            reference: Reference {
                first_day_ns,
                sensor_ids: Vec::new(),
            },
            kind: PhantomData,
        }
    }

    /// Shows source number n as `sensor_ids[n]` instead of [`sensor_id`]: for sources that have ids of their own in
    /// files.
    #[must_use]
    pub fn with_sensor_ids(mut self, sensor_ids: Vec<u32>) -> Self {
        self.reference.sensor_ids = sensor_ids;
        self
    }

    /// Writes one row.
    ///
    /// # Errors
    /// If the writer fails.
    pub fn write(&mut self, row: &T) -> io::Result<()> {
        self.row.clear();
        row.write(&mut self.row, &self.reference)?;
        self.row.push(b'\n');
        self.writer.write_all(&self.row)
    }

    /// Flushes the writer.
    ///
    /// # Errors
    /// If it fails.
    pub fn flush(&mut self) -> io::Result<()> {
        self.writer.flush()
    }

    /// Returns the writer.
    pub fn get_ref(&self) -> &W {
        &self.writer
    }

    /// The writer, not flushed.
    pub fn into_inner(self) -> W {
        self.writer
    }
}

/// The columns of a table that values are read from.
pub trait Columns {
    /// A row's value.
    type Value;

    /// Makes a value of a row.
    ///
    /// # Errors
    /// If the row does not hold one.
    fn read(&mut self, cells: Cells<'_>) -> Result<Self::Value, CsvError>;
}

/// Reads values, row by row.
///
/// After an error in a row, the caller may request the next row.
#[derive(Debug)]
pub struct RowReader<R, C> {
    pub(crate) table: Table<R>,
    pub(crate) columns: C,
}

impl<R: Read, C> RowReader<R, C> {
    /// Line, from 1, of the row read last, or of the header.
    pub fn line(&self) -> u64 {
        self.table.line()
    }
}

impl<R: Read, C: Columns> Iterator for RowReader<R, C> {
    type Item = Result<C::Value, CsvError>;

    fn next(&mut self) -> Option<Self::Item> {
        let row = self.table.next_row()?;
        Some(row.and_then(|cells| self.columns.read(cells)))
    }
}

#[cfg(test)]
mod tests {
    use jiff::Timestamp;
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn dates_are_those_of_the_calendar(time_ns in any::<i64>(), tens in 0_u32..18) {
            let time_ns = time_ns / 10_i64.pow(tens) * 10_i64.pow(tens);
            let calendar = Timestamp::from_nanosecond(time_ns.into()).unwrap();
            prop_assert_eq!(Utc(time_ns).to_string(), calendar.to_string());
            prop_assert_eq!(Utc(time_ns).to_string().parse::<Utc>().unwrap().0, time_ns);
        }
    }
}
