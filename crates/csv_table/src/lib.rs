//! Tables of text: a header line with the columns' names, then a row per line.
//!
//! Columns are found by name, in any order; unused columns are ignored, so that files may contain more columns than a
//! reader needs. A column that the header does not have under the reader's name is found under the names and in the
//! units of other programs ([`NamedColumn`]). Names are looked up once for a header; rows are read by places.
//!
//! Values are separated by commas, with or without quotation marks around them; a quoted value ends in its line, so
//! that a stray mark spoils this line alone. Blanks around values, blank lines, a byte order mark and the line ends of
//! other systems are accepted.
//!
//! An error in a row of a large file must be easy to find. Every error therefore names the line (as counted by
//! editors), the column, the value, and the permitted values.

#![forbid(unsafe_code)]

mod cells;
mod digits;
mod names;
mod number;
mod row;
mod times;

use std::io::{self, BufReader, Read};

use thiserror::Error;

pub use cells::{Cells, Column};
pub use digits::{write_decimals, write_plain, write_time, write_whole};
pub use names::{NamedColumn, SENSOR_COLUMNS, TARGET_COLUMNS, named_columns_help};
use row::{Row, RowRead};
pub use times::{TimeForm, zoned_ns};

/// The columns of a covariance of position and velocity, in the order of its upper triangle.
pub const COVARIANCE_COLUMNS: [&str; 21] = [
    "P00", "P01", "P02", "P03", "P04", "P05", "P11", "P12", "P13", "P14", "P15", "P22", "P23", "P24", "P25", "P33",
    "P34", "P35", "P44", "P45", "P55",
];

/// The columns of what is known without a manoeuvre: probability of straight flight, and the covariance of the
/// velocity in this case; probability of a constant climb rate, and its variance in this case.
pub const STEADY_COLUMNS: [&str; 6] = [
    "steady_weight",
    "steady_P33",
    "steady_P34",
    "steady_P44",
    "steady_climb_weight",
    "steady_P55",
];

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
    /// By place, the entry of the column's name, and this name as the list spells it.
    known: Vec<Option<(&'static NamedColumn, &'static str)>>,
    row: Row,
    /// Line, from 1, of the row read last.
    line: u64,
    failed: bool,
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
            known: Vec::new(),
            row: Row::default(),
            line: 0,
            failed: false,
        };
        // Empty lines before the header are passed over.
        while table.read()? && table.row.is_empty() {}
        table.row.trim_byte_order_mark();
        table.header = std::mem::take(&mut table.row);
        table.known = table.names().map(NamedColumn::find).collect();
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
        let mut columns = [Column::own("", 0); N];
        for (column, name) in columns.iter_mut().zip(names) {
            *column = self.required(name)?;
        }
        Ok(columns)
    }

    /// A column that may be there: that of exactly this name, else that of its quantity ([`NamedColumn`]), in the unit
    /// of `name`.
    ///
    /// # Errors
    /// If the header names it more than once.
    pub fn optional(&self, name: &'static str) -> Result<Option<Column>, CsvError> {
        match self.spelled(name)? {
            None => self.of_quantity(name),
            found => Ok(found),
        }
    }

    /// A column that may be there under exactly this name.
    ///
    /// # Errors
    /// If the header names it more than once.
    pub fn spelled(&self, name: &'static str) -> Result<Option<Column>, CsvError> {
        let mut places = self
            .header
            .iter()
            .enumerate()
            .filter(|(_, found)| found.trim_ascii() == name.as_bytes());
        let found = places.next().map(|(place, _)| Column::own(name, place));
        match places.next() {
            Some(_) => Err(self.header_error(name, "stands there more than once")),
            None => Ok(found),
        }
    }

    /// A column that may be there under any name of the quantity that `name` is of, in the unit of `name`.
    ///
    /// # Errors
    /// If two columns state the quantity.
    pub fn of_quantity(&self, name: &'static str) -> Result<Option<Column>, CsvError> {
        let known = NamedColumn::find(name.as_bytes());
        // Another name may differ from one of the list in marks only.
        let Some((asked, _)) = known.filter(|(_, known)| *known == name) else {
            return Ok(None);
        };
        let mut found: Option<Column> = None;
        for (place, known) in self.known.iter().enumerate() {
            let Some((entry, name)) = known.filter(|(entry, _)| entry.quantity == asked.quantity) else {
                continue;
            };
            let column = Column::foreign(name, place, [entry, asked].map(NamedColumn::place));
            if let Some(first) = found.replace(column) {
                let fault = "state one quantity; leave one of them out, or give it a name of your own";
                return Err(self.clash(first, column, fault));
            }
        }
        Ok(found)
    }

    /// Whether the header has a column of the quantity that `name` is of.
    pub fn states(&self, name: &'static str) -> bool {
        !matches!(self.of_quantity(name), Ok(None))
    }

    /// The error that two columns contradict each other.
    #[cold]
    pub fn clash(&self, first: Column, second: Column, fault: &str) -> CsvError {
        let name = |column: Column| {
            let found = self.names().nth(column.place()).unwrap_or_default();
            String::from_utf8_lossy(found).into_owned()
        };
        CsvError::Clash {
            first: name(first),
            second: name(second),
            fault: fault.to_owned(),
        }
    }

    /// Names of the columns without `read`, as in the header: first those of no quantity in the list.
    pub fn unread(&self, read: &[Option<Column>]) -> Vec<String> {
        let is_read = |place: usize| read.iter().flatten().any(|column| column.place() == place);
        let mut places: Vec<usize> = (0..self.header.len()).filter(|place| !is_read(*place)).collect();
        places.sort_by_key(|place| self.known[*place].is_some());
        let name = |place| {
            self.names()
                .nth(place)
                .map(|name| String::from_utf8_lossy(name).into_owned())
        };
        places.into_iter().filter_map(name).collect()
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

fn shown(text: &str, characters_max: usize) -> String {
    match text.char_indices().nth(characters_max) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text.to_owned(),
    }
}

#[cfg(test)]
mod tests;
