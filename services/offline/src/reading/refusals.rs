//! Skipped rows, and the reasons.

use std::collections::BTreeMap;
use std::fmt;
use std::path::Path;

use csv_table::CsvError;
use frames::time::NS_PER_DAY;

use crate::files::InputError;

/// Maximum number of refused rows shown with place and value.
const SHOWN_MAX: usize = 5;

/// A step back by more is the midnight after which a clock begins again, nanoseconds.
pub(crate) const MIDNIGHT_STEP_NS: i64 = NS_PER_DAY / 2;
/// Remedy for such a step.
pub(crate) const MIDNIGHT_REMEDY: &str = "times count on across midnight: add 86400 to the times of the next day";

/// Place of a row in a file, each counted from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RowPlace {
    /// Line of a table.
    Line(u64),
    /// Record of a recording.
    Record(u64),
}

impl fmt::Display for RowPlace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Line(line) => write!(f, "line {line}"),
            Self::Record(record) => write!(f, "record {record}"),
        }
    }
}

/// Skipped rows.
#[derive(Clone, Debug, Default)]
pub struct SkippedRows {
    /// Rows by reason.
    pub by_reason: BTreeMap<String, u64>,
    /// The first skipped rows, with file, line, value and remedy.
    pub first: Vec<String>,
}

impl SkippedRows {
    /// Returns the value of a row of `file` if the row is readable; else counts the row as skipped.
    ///
    /// # Errors
    /// If the whole file cannot be read.
    pub fn usable<T>(&mut self, file: &Path, row: Result<T, CsvError>) -> Result<Option<T>, InputError> {
        match row {
            Ok(value) => Ok(Some(value)),
            Err(error) => self.skip(file, error).map(|()| None),
        }
    }

    /// Counts a row of `file` as skipped, for this reason.
    ///
    /// # Errors
    /// If the whole file cannot be read.
    pub(super) fn skip(&mut self, file: &Path, error: CsvError) -> Result<(), InputError> {
        if !error.is_of_row() {
            return Err(InputError::new(file, error));
        }
        self.unreadable(file, &error);
        Ok(())
    }

    fn unreadable(&mut self, file: &Path, error: &CsvError) {
        let reason = match error {
            CsvError::Value { column, .. } => format!("column {column}"),
            CsvError::Quotes { .. } => "quotation marks".to_owned(),
            _ => "number of values".to_owned(),
        };
        self.add(reason, file, error);
    }

    /// Counts a row with a time out of order: its line, and the name of the column of times.
    pub fn out_of_order(&mut self, file: &Path, (line, column): (u64, &str), what: &str) {
        let said = format!("line {line}, column {column}: {what}");
        self.add("order of time".to_owned(), file, said);
    }

    /// Counts a readable row that was rejected later, with its place in the file.
    pub fn refused(&mut self, reason: &str, file: &Path, place: RowPlace, why: impl std::fmt::Display) {
        self.add(reason.to_owned(), file, format!("{place}: {why}"));
    }

    /// Counts rows that were rejected when all rows had been read.
    pub fn refused_at_end(&mut self, reason: &str, why: String) {
        self.by_reason
            .entry(reason.to_owned())
            .and_modify(|rows| *rows += 1)
            .or_insert(1);
        if self.first.len() < SHOWN_MAX {
            self.first.push(why);
        }
    }

    /// Counts a value that has no separate row.
    pub fn count(&mut self, reason: &str) {
        self.count_all(reason, 1);
    }

    /// Counts this number of values that have no separate rows.
    pub(crate) fn count_all(&mut self, reason: &str, values: u64) {
        if values > 0 {
            *self.by_reason.entry(reason.to_owned()).or_default() += values;
        }
    }

    /// Returns the number of skipped rows.
    pub fn rows(&self) -> u64 {
        self.by_reason.values().sum()
    }

    /// Returns text lines; empty if no row was skipped.
    pub fn as_text(&self) -> String {
        if self.by_reason.is_empty() {
            return String::new();
        }
        let reasons = self
            .by_reason
            .iter()
            .map(|(reason, rows)| format!("{rows} for {reason}"));
        let mut text = format!(
            "left out: {} rows, {}\n",
            self.rows(),
            reasons.collect::<Vec<_>>().join(", ")
        );
        for said in &self.first {
            text += &format!("  {said}\n");
        }
        text
    }

    fn add(&mut self, reason: String, file: &Path, said: impl std::fmt::Display) {
        *self.by_reason.entry(reason).or_default() += 1;
        if self.first.len() < SHOWN_MAX {
            self.first.push(format!("{}: {said}", file.display()));
        }
    }
}
