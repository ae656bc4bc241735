//! Tables of text: a header line with the columns' names, then a row per line.
//!
//! Columns are found by name, in any order; unused columns are ignored, so that files may contain more columns than a
//! reader needs. Values are separated by commas, with or without quotation marks around them; a quoted value ends in
//! its line, so that a stray mark spoils this line alone. Blanks around values, blank lines, a byte order mark and the
//! line ends of other systems are accepted.
//!
//! An error in a row of a large file must be easy to find. Every error therefore names the line (as counted by
//! editors), the column, the value, and the permitted values.

#![forbid(unsafe_code)]

mod digits;
mod number;
mod row;

use std::fmt::Display;
use std::io::{self, BufReader, Read};
use std::str::FromStr;

use thiserror::Error;

pub use digits::{write_decimals, write_plain, write_time, write_whole};
use row::{Row, RowRead};

/// The columns of a covariance of position and velocity, in the order of its upper triangle.
pub const COVARIANCE_COLUMNS: [&str; 21] = [
    "P00", "P01", "P02", "P03", "P04", "P05", "P11", "P12", "P13", "P14", "P15", "P22", "P23", "P24", "P25", "P33",
    "P34", "P35", "P44", "P45", "P55",
];

/// Longest time since a midnight, seconds: 46 days, the most that seconds in 64 bits give exactly to the nanosecond.
const TIME_MAX_S: f64 = 4e6;
/// Times that can only be UTC, seconds since 1970: from 1973 to 2103.
const UTC_S: std::ops::Range<f64> = 1e8..4.2e9;
/// Characters of a value that an error shows.
const SHOWN_MAX: usize = 40;

/// Why a table cannot be read.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum CsvError {
    /// The header lacks a column, or names it more than once.
    #[error("header: column {column} {fault}; the header is {header:?}")]
    Header {
        /// The column's name.
        column: &'static str,
        /// Fault of the column.
        fault: &'static str,
        /// The header as read.
        header: String,
    },

    /// Two columns of the header contradict each other.
    #[error("header: columns {first} and {second} {fault}")]
    Clash {
        /// The name of the column further to the left.
        first: String,
        /// The name of the other column.
        second: String,
        /// Why both cannot be read, and the remedy.
        fault: String,
    },

    /// A row has more or fewer values than the header has names.
    #[error("line {line}: {found} values, but the header names {expected} columns")]
    Length {
        /// The line, from 1.
        line: u64,
        /// Values in the row.
        found: usize,
        /// Names in the header.
        expected: usize,
    },

    /// The quotation marks of a value do not end in its line.
    #[error("line {line}: a value begins with a quotation mark and none ends it; write both, or none")]
    Quotes {
        /// The line, from 1.
        line: u64,
    },

    /// A value is invalid for its column.
    #[error("line {line}, column {column}: {value:?} {reason}")]
    Value {
        /// The line, from 1.
        line: u64,
        /// The column's name.
        column: &'static str,
        /// The value as read, or its beginning.
        value: String,
        /// Fault of the value, and the permitted values.
        reason: String,
    },

    /// The input failed.
    #[error("line {line}: {reason}")]
    Input {
        /// The line, from 1, that could not be read.
        line: u64,
        /// Why.
        reason: io::Error,
    },
}

impl CsvError {
    /// Returns this error with lines that count on from `lines`: for a table that is a part of another.
    #[must_use]
    pub fn after_lines(mut self, lines: u64) -> Self {
        match &mut self {
            Self::Length { line, .. } | Self::Quotes { line } | Self::Value { line, .. } | Self::Input { line, .. } => {
                *line += lines;
            }
            Self::Header { .. } | Self::Clash { .. } => {}
        }
        self
    }

    /// Whether one row is wrong, and those behind it can be read.
    pub fn is_of_row(&self) -> bool {
        matches!(self, Self::Length { .. } | Self::Quotes { .. } | Self::Value { .. })
    }
}

/// A table that is read row by row.
#[derive(Debug)]
pub struct Table<R> {
    input: BufReader<R>,
    header: Row,
    row: Row,
    /// Line, from 1, of the row read last.
    line: u64,
    failed: bool,
}

/// A column that the header names.
#[derive(Clone, Copy, Debug)]
pub struct Column {
    name: &'static str,
    place: usize,
}

/// The values of a row, as many as there are columns.
#[derive(Clone, Copy, Debug)]
pub struct Cells<'a> {
    line: u64,
    values: &'a Row,
}

impl<R: Read> Table<R> {
    /// Reads the header.
    ///
    /// # Errors
    /// If the input fails, or the quotation marks of a name do not end in their line.
    pub fn new(input: R) -> Result<Self, CsvError> {
        let mut table = Self {
            input: BufReader::new(input),
            header: Row::default(),
            row: Row::default(),
            line: 0,
            failed: false,
        };
        // Empty lines before the header are passed over.
        while table.read()? && table.row.is_empty() {}
        table.row.trim_byte_order_mark();
        table.header = std::mem::take(&mut table.row);
        Ok(table)
    }

    /// A column that must be there.
    ///
    /// # Errors
    /// If the header lacks the column, or names the column more than once.
    pub fn required(&self, name: &'static str) -> Result<Column, CsvError> {
        self.optional(name)?.ok_or_else(|| self.missing(name))
    }

    /// Names of the columns in the order of the header, without blanks around them.
    pub fn names(&self) -> impl Iterator<Item = &[u8]> {
        self.header.iter().map(<[u8]>::trim_ascii)
    }

    /// The column at a place of the header, from 0, that errors call `name`: for columns with several permitted names.
    /// `None` beyond the last column.
    pub fn column_at(&self, place: usize, name: &'static str) -> Option<Column> {
        (place < self.header.len()).then_some(Column { name, place })
    }

    /// The error that the header lacks a column.
    pub fn missing(&self, name: &'static str) -> CsvError {
        self.header_error(name, self.why_missing())
    }

    /// Reason why the first line lacks a column, as far as the line shows it.
    fn why_missing(&self) -> &'static str {
        let first = self.header.iter().next().unwrap_or_default();
        match first {
            [b'#', ..] => "is missing: the first line must be the header, not a comment",
            _ if self.header.len() == 1 && first.contains(&b';') => {
                "is missing: separate values by commas, not semicolons"
            }
            _ if self.header.len() == 1 && first.contains(&b'\t') => "is missing: separate values by commas, not tabs",
            [0xff, 0xfe, ..] | [0xfe, 0xff, ..] => "is missing: the file is UTF-16; save it as UTF-8",
            _ => "is missing",
        }
    }

    /// Columns that must all be there.
    ///
    /// # Errors
    /// If the header lacks a column, or names a column more than once.
    pub fn all<const N: usize>(&self, names: [&'static str; N]) -> Result<[Column; N], CsvError> {
        let mut columns = names.map(|name| Column { name, place: 0 });
        for column in &mut columns {
            *column = self.required(column.name)?;
        }
        Ok(columns)
    }

    /// A column that may be there.
    ///
    /// # Errors
    /// If the header names it more than once.
    pub fn optional(&self, name: &'static str) -> Result<Option<Column>, CsvError> {
        let mut places = self
            .header
            .iter()
            .enumerate()
            .filter(|(_, found)| found.trim_ascii() == name.as_bytes());
        let found = places.next().map(|(place, _)| Column { name, place });
        match places.next() {
            Some(_) => Err(self.header_error(name, "stands there more than once")),
            None => Ok(found),
        }
    }

    /// The next row, `None` at the end. After a row that could not be read the next one may be asked for.
    ///
    /// # Errors
    /// If the row has more or fewer values than the header has names, quotation marks without an end, or the input
    /// fails.
    pub fn next_row(&mut self) -> Option<Result<Cells<'_>, CsvError>> {
        if self.failed {
            return None;
        }
        loop {
            match self.read() {
                Ok(false) => return None,
                Ok(true) if self.row.is_blank() => {}
                Ok(true) => break,
                Err(error) => {
                    self.failed = !error.is_of_row();
                    return Some(Err(error));
                }
            }
        }
        let line = self.line;
        let (found, expected) = (self.row.len(), self.header.len());
        Some(match found == expected {
            true => Ok(Cells {
                line,
                values: &self.row,
            }),
            false => Err(CsvError::Length { line, found, expected }),
        })
    }

    /// The line, from 1, of the row read last, or of the header.
    pub fn line(&self) -> u64 {
        self.line
    }

    /// Reads the next line; `false` at the end.
    fn read(&mut self) -> Result<bool, CsvError> {
        let line = self.line + 1;
        let read = self.row.read(&mut self.input);
        let read = read.map_err(|reason| CsvError::Input { line, reason })?;
        if read == RowRead::End {
            return Ok(false);
        }
        self.line = line;
        match read {
            RowRead::Unclosed => Err(CsvError::Quotes { line }),
            _ => Ok(true),
        }
    }

    fn header_error(&self, column: &'static str, fault: &'static str) -> CsvError {
        let names: Vec<_> = self
            .header
            .iter()
            .map(|name| String::from_utf8_lossy(name.trim_ascii()))
            .collect();
        CsvError::Header {
            column,
            fault,
            header: shown(&names.join(","), 10 * SHOWN_MAX),
        }
    }
}

impl Column {
    /// The name that errors use.
    pub fn name(&self) -> &'static str {
        self.name
    }
}

impl Cells<'_> {
    /// Line of the row, from 1.
    pub fn line(&self) -> u64 {
        self.line
    }

    /// The value as text; `None` if it is empty or the column is not there.
    ///
    /// # Errors
    /// If it is not UTF-8.
    pub fn text(&self, column: impl Into<Option<Column>>) -> Result<Option<&str>, CsvError> {
        let Some(column) = column.into() else { return Ok(None) };
        let value = self.value(column);
        if value.is_empty() {
            return Ok(None);
        }
        match std::str::from_utf8(value) {
            Ok(text) => Ok(Some(text)),
            Err(_) => Err(self.error(column, "is not UTF-8 text")),
        }
    }

    /// A finite number.
    ///
    /// # Errors
    /// If the value is none.
    #[inline]
    pub fn number(&self, column: Column) -> Result<f64, CsvError> {
        match number::simple(self.value(column)) {
            Some(number) => Ok(number),
            None => self
                .unusual_number(column)?
                .ok_or_else(|| self.error(column, "is empty; write a number")),
        }
    }

    /// Finite numbers.
    ///
    /// # Errors
    /// If one of the values is none.
    pub fn numbers<const N: usize>(&self, columns: [Column; N]) -> Result<[f64; N], CsvError> {
        let mut numbers = [0.0; N];
        for (number, column) in numbers.iter_mut().zip(columns) {
            *number = self.number(column)?;
        }
        Ok(numbers)
    }

    /// A finite number, or `None` if the value is empty or the column is not there.
    ///
    /// # Errors
    /// If the value is something else.
    pub fn number_or_empty(&self, column: impl Into<Option<Column>>) -> Result<Option<f64>, CsvError> {
        let Some(column) = column.into() else { return Ok(None) };
        match number::simple(self.value(column)) {
            Some(number) => Ok(Some(number)),
            None => self.unusual_number(column),
        }
    }

    /// A number that is not only digits, or `None` if the value is empty.
    #[cold]
    #[inline(never)]
    fn unusual_number(&self, column: Column) -> Result<Option<f64>, CsvError> {
        let Some(text) = self.text(column)? else {
            return Ok(None);
        };
        match text.parse::<f64>() {
            Ok(number) if number.is_finite() => Ok(Some(number)),
            Ok(_) => Err(self.error(column, "is not finite; leave out rows without a value")),
            Err(_) => Err(self.error(column, "is no number; write one like -12.5")),
        }
    }

    /// A whole number that `T` can hold.
    ///
    /// # Errors
    /// If the value is none.
    pub fn whole<T: FromStr + TryFrom<u64>>(&self, column: Column) -> Result<T, CsvError> {
        let digits = number::whole(self.value(column));
        if let Some(Ok(number)) = digits.map(T::try_from) {
            return Ok(number);
        }
        let text = self.text(column)?.unwrap_or_default();
        let fault = || format!("is no whole number of the kind {}", std::any::type_name::<T>());
        text.parse().map_err(|_| self.error(column, fault()))
    }

    /// A time in seconds, at most 46 days to either side of 0.
    ///
    /// # Errors
    /// If the value is none.
    pub fn time_s(&self, column: Column) -> Result<f64, CsvError> {
        let seconds = self.seconds(column)?;
        if seconds.abs() > TIME_MAX_S {
            let reason = format!("is more than {TIME_MAX_S} s away; count from midnight (UTC) of the first day");
            return Err(self.error(column, reason));
        }
        Ok(seconds)
    }

    /// Nanoseconds since 1970 of a time in seconds, which counts from the midnight `first_day_ns` or from 1970.
    ///
    /// # Errors
    /// If the value is none.
    #[inline]
    pub fn utc_ns(&self, column: Column, first_day_ns: i64) -> Result<i64, CsvError> {
        let seconds = self.seconds(column)?;
        if seconds.abs() <= TIME_MAX_S {
            return Ok(first_day_ns.saturating_add(frames::time::ns(seconds)));
        }
        self.since_1970_ns(column, seconds)
    }

    /// A number that counts seconds; the refusal of a date or a time of day names what is read.
    #[inline]
    fn seconds(&self, column: Column) -> Result<f64, CsvError> {
        self.number(column)
            .map_err(|error| match self.value(column).contains(&b':') {
                true => self.error(
                    column,
                    "is no number; count seconds from midnight (UTC) of the first day",
                ),
                false => error,
            })
    }

    #[cold]
    #[inline(never)]
    fn since_1970_ns(&self, column: Column, seconds: f64) -> Result<i64, CsvError> {
        /// Digits of a second to the nanosecond.
        const DECIMALS: usize = 9;
        if !UTC_S.contains(&seconds) {
            let reason = format!(
                "is no time: count seconds from midnight (UTC) of the first day, up to {TIME_MAX_S}, or from 1970"
            );
            return Err(self.error(column, reason));
        }
        // Doubles are some hundred nanoseconds apart here.
        let (whole, decimals) = self
            .value(column)
            .split_at_checked(
                self.value(column)
                    .iter()
                    .position(|octet| *octet == b'.')
                    .unwrap_or(usize::MAX),
            )
            .unwrap_or((self.value(column), b""));
        let decimals = decimals.get(1..).unwrap_or_default();
        let mut digits = [b'0'; DECIMALS];
        digits
            .iter_mut()
            .zip(decimals)
            .for_each(|(place, digit)| *place = *digit);
        let parts = number::whole(whole).zip(number::whole(&digits));
        Ok(match parts {
            Some((whole, ns)) => whole as i64 * frames::time::NS_PER_S + ns as i64,
            None => frames::time::ns(seconds),
        })
    }

    /// The value without blanks around it.
    #[inline]
    fn value(&self, column: Column) -> &[u8] {
        let value = self.values.value(column.place);
        // Most values have no blank around them.
        match value {
            [] => value,
            [first, ..] if value[value.len() - 1].min(*first) > b' ' => value,
            _ => value.trim_ascii(),
        }
    }

    /// The error that the value of a column is, for this reason.
    pub fn error(&self, column: Column, reason: impl Display) -> CsvError {
        CsvError::Value {
            line: self.line,
            column: column.name,
            value: shown(&String::from_utf8_lossy(self.value(column)), SHOWN_MAX),
            reason: reason.to_string(),
        }
    }
}

fn shown(text: &str, characters_max: usize) -> String {
    match text.char_indices().nth(characters_max) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Returns the numbers of column `b`, or the errors.
    fn column_b(text: &[u8]) -> Vec<Result<f64, String>> {
        let mut table = Table::new(text).unwrap();
        let column = table.required("b").unwrap();
        let mut found = Vec::new();
        while let Some(row) = table.next_row() {
            found.push(
                row.and_then(|row| row.number(column))
                    .map_err(|error| error.to_string()),
            );
        }
        found
    }

    #[test]
    fn columns_are_found_by_name_whatever_the_line_ends() {
        for text in [
            "a,b\n1,2\n3,4\n",
            " a , b\r\n\r\n1,2\r\n \r\n3, 4",
            "\u{feff}b,c,a\n2,,1\n\n4,,3",
        ] {
            assert_eq!(column_b(text.as_bytes()), [Ok(2.0), Ok(4.0)], "{text:?}");
        }
        assert!(column_b(b"a,b").is_empty());
    }

    #[test]
    fn errors_name_line_column_value_and_remedy_and_reading_goes_on() {
        let text = b"a,b\r\n1,2\r\n\r\n1,x\r\n1\r\n1,inf\r\n1,\r\n1,\xff\r\n1,\"2\"\r\n1,\"2\r\n1,3";
        let expected = [
            Ok(2.0),
            Err("line 4, column b: \"x\" is no number; write one like -12.5"),
            Err("line 5: 1 values, but the header names 2 columns"),
            Err("line 6, column b: \"inf\" is not finite; leave out rows without a value"),
            Err("line 7, column b: \"\" is empty; write a number"),
            Err("line 8, column b: \"\u{fffd}\" is not UTF-8 text"),
            Ok(2.0),
            Err("line 10: a value begins with a quotation mark and none ends it; write both, or none"),
            Ok(3.0),
        ];
        assert_eq!(column_b(text), expected.map(|one| one.map_err(str::to_owned)));
    }

    #[test]
    fn a_header_that_lacks_or_repeats_a_column_is_refused() {
        let fault_of = |octets: &[u8]| Table::new(octets).unwrap().required("b").unwrap_err().to_string();
        let fault = |text: &str| fault_of(text.as_bytes());
        assert_eq!(fault("a,c\n"), "header: column b is missing; the header is \"a,c\"");
        assert_eq!(fault(""), "header: column b is missing; the header is \"\"");
        assert!(fault("b,a,b\n").contains("more than once"));
        assert!(fault("a;b\n1;2\n").contains("by commas, not semicolons"));
        assert!(fault("a\tb\n").contains("by commas, not tabs"));
        assert!(fault_of(b"\xff\xfea\0,\0b\0").contains("save it as UTF-8"));
        assert!(fault("# a table\na,b\n").contains("not a comment"));
    }

    #[test]
    fn times_are_exact_to_the_nanosecond() {
        let time = |text: &str| {
            let text = format!("b\n{text}\n");
            let mut table = Table::new(text.as_bytes()).unwrap();
            let column = table.required("b").unwrap();
            table
                .next_row()
                .unwrap()
                .unwrap()
                .utc_ns(column, 0)
                .map_err(|error| error.to_string())
        };
        assert_eq!(time("3999999.999999999"), Ok(3_999_999_999_999_999));
        assert_eq!(time("-0.000000001"), Ok(-1));
        assert_eq!(time("1620114891.123456789"), Ok(1_620_114_891_123_456_789));
        assert!(time("4000001").unwrap_err().contains("from midnight"));
    }

    #[test]
    fn times_count_from_a_midnight_or_from_1970() {
        const DAY_NS: i64 = 86_400_000_000_000;
        let time = |text: &str| {
            let text = format!("b\n{text}\n");
            let mut table = Table::new(text.as_bytes()).unwrap();
            let column = table.required("b").unwrap();
            let row = table.next_row().unwrap().unwrap();
            row.utc_ns(column, DAY_NS).map_err(|error| error.to_string())
        };
        assert_eq!(time("1.5"), Ok(DAY_NS + 1_500_000_000));
        assert_eq!(time("-3999999.999999999"), Ok(DAY_NS - 3_999_999_999_999_999));
        for (text, ns) in [
            ("1795880310", 1_795_880_310_000_000_000),
            ("1795880310.123456789", 1_795_880_310_123_456_789),
            (" \"1795880310.1234567891\" ", 1_795_880_310_123_456_789),
            ("1.5e9", 1_500_000_000_000_000_000),
        ] {
            assert_eq!(time(text), Ok(ns), "{text}");
        }
        assert!(
            time("2026-11-28T15:38:31Z")
                .unwrap_err()
                .contains("count seconds from midnight")
        );
        // Milliseconds, a date as digits, and a time of no clock.
        for text in ["1795880310123", "20261128", "-5e8"] {
            assert!(time(text).unwrap_err().contains("or from 1970"), "{text}");
        }
    }

    #[test]
    fn an_input_that_fails_ends_the_table() {
        struct Failing(&'static [u8]);
        impl Read for Failing {
            fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
                match self.0.read(buffer)? {
                    0 => Err(io::Error::other("unplugged")),
                    count => Ok(count),
                }
            }
        }
        let mut table = Table::new(Failing(b"b\n1\n2\n")).unwrap();
        assert!(table.next_row().unwrap().is_ok() && table.next_row().unwrap().is_ok());
        assert!(table.next_row().unwrap().unwrap_err().to_string().contains("unplugged"));
        assert!(table.next_row().is_none());
    }

    proptest! {
        #[test]
        fn any_octets_are_a_table_or_an_error(octets in prop::collection::vec(any::<u8>(), 0..200)) {
            let mut text = b"a,b\n".to_vec();
            text.extend(octets);
            let rows = column_b(&text).len();
            prop_assert!(rows <= text.iter().filter(|octet| **octet == b'\n').count());
        }
    }
}
