//! Values of a row, by the columns in which they stand.

use std::fmt::Display;
use std::str::FromStr;

use crate::row::Row;
use crate::{CsvError, NamedColumn, SHOWN_MAX, number, shown};

/// Longest time since a midnight, seconds: 46 days, the most that seconds in 64 bits give exactly to the nanosecond.
pub(crate) const TIME_MAX_S: f64 = 4e6;
/// Times that can only be UTC, seconds since 1970: from 1973 to 2103.
const UTC_S: std::ops::Range<f64> = 1e8..4.2e9;
/// Words for an absent value, in any case.
const ABSENT: [&str; 5] = ["nan", "null", "none", "na", "n/a"];

/// A column that the header names.
#[derive(Clone, Copy, Debug)]
pub struct Column {
    name: &'static str,
    place: u32,
    /// Places in the list of the entries of the column and of the reader's name for its quantity; [`OWN`] if the column
    /// has this name. In place of the factor of its unit: columns are copied for each value.
    entries: [u16; 2],
}

/// In place of entries: the column has the reader's own name.
const OWN: [u16; 2] = [u16::MAX; 2];

/// The values of a row, as many as there are columns.
#[derive(Clone, Copy, Debug)]
pub struct Cells<'a> {
    pub(crate) line: u64,
    pub(crate) values: &'a Row,
}

impl Column {
    /// The column at a place of the header under the reader's name.
    pub(crate) fn own(name: &'static str, place: usize) -> Self {
        Self {
            name,
            place: place as u32,
            entries: OWN,
        }
    }

    /// The column at a place of the header under another name, with the places of both names in the list.
    pub(crate) fn foreign(name: &'static str, place: usize, entries: [u16; 2]) -> Self {
        Self {
            name,
            place: place as u32,
            entries,
        }
    }

    pub(crate) fn place(&self) -> usize {
        self.place as usize
    }

    /// The name that errors use.
    pub fn name(&self) -> &'static str {
        self.name
    }

    /// Whether the column was found by its quantity ([`Table::of_quantity`](crate::Table::of_quantity)), and not by the
    /// reader's own name for it.
    pub fn is_foreign(&self) -> bool {
        self.entries != OWN
    }

    /// Value of one unit of the column in the unit of the name under which it was asked for.
    pub fn scale(&self) -> f64 {
        match self.entries {
            OWN => 1.0,
            [found, asked] => NamedColumn::at(found).scale / NamedColumn::at(asked).scale,
        }
    }

    /// A number of the column in the unit of the reader.
    #[inline]
    fn in_unit(&self, number: f64) -> f64 {
        match self.is_foreign() {
            true => number * self.scale(),
            false => number,
        }
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

    /// The value as text; `None` if it states nothing: if it is empty or, in a foreign column, a word with which
    /// programs mark an absent value.
    ///
    /// # Errors
    /// If it is not UTF-8.
    pub fn stated(&self, column: impl Into<Option<Column>>) -> Result<Option<&str>, CsvError> {
        let Some(column) = column.into() else { return Ok(None) };
        let is_absent = |text: &&str| column.is_foreign() && ABSENT.iter().any(|word| word.eq_ignore_ascii_case(text));
        Ok(self.text(column)?.filter(|text| !is_absent(text)))
    }

    /// A finite number.
    ///
    /// # Errors
    /// If the value is none.
    #[inline]
    pub fn number(&self, column: Column) -> Result<f64, CsvError> {
        match number::simple(self.value(column)) {
            Some(number) => Ok(column.in_unit(number)),
            None => self.unusual_number(column)?.ok_or_else(|| self.no_number(column)),
        }
    }

    /// The error of a value that states no number.
    #[cold]
    fn no_number(&self, column: Column) -> CsvError {
        let reason = match self.value(column) {
            [] => "is empty; write a number",
            _ => "is not finite; leave out rows without a value",
        };
        self.error(column, reason)
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

    /// A finite number, or `None` if the value states nothing ([`Self::stated`]) or the column is not there.
    ///
    /// # Errors
    /// If the value is something else.
    pub fn number_or_empty(&self, column: impl Into<Option<Column>>) -> Result<Option<f64>, CsvError> {
        let Some(column) = column.into() else { return Ok(None) };
        let value = self.value(column);
        match number::simple(value) {
            Some(number) => Ok(Some(column.in_unit(number))),
            None if value.is_empty() => Ok(None),
            None => self.unusual_number(column),
        }
    }

    /// A number that is not only digits, or `None` if the value states nothing.
    #[cold]
    #[inline(never)]
    fn unusual_number(&self, column: Column) -> Result<Option<f64>, CsvError> {
        let Some(text) = self.stated(column)? else {
            return Ok(None);
        };
        match text.parse::<f64>() {
            Ok(number) if number.is_finite() => Ok(Some(column.in_unit(number))),
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
        let value = self.values.value(column.place());
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
