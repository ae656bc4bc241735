//! Where the times of a table count from: a midnight, or 1970.

use csv_table::{Cells, Column, CsvError, TimeForm};

/// Returns whether a time, nanoseconds, is beyond all times since a midnight: such a time counts from 1970.
pub fn is_since_1970(time_ns: i64) -> bool {
    /// As many days as seconds in 64 bits give exactly to the nanosecond.
    const DAYS_MAX: i64 = 50;
    time_ns > DAYS_MAX * frames::time::NS_PER_DAY
}

/// Time base of the rows of a table: that of the first row is the one of all.
#[derive(Debug)]
pub(crate) struct TimeBase {
    first_day_ns: i64,
    /// `true` if times count from 1970, and not from the first day; `None` before the first row.
    since_1970: Option<bool>,
}

impl TimeBase {
    /// The base of a table whose times count from `first_day_ns` (UTC, nanoseconds), or from 1970.
    pub(crate) fn new(first_day_ns: i64) -> Self {
        Self {
            first_day_ns,
            since_1970: None,
        }
    }

    /// Returns the time in a column, UTC, nanoseconds: in seconds, in a foreign column in any form.
    ///
    /// # Errors
    /// If the value is no time, or counts from elsewhere than that of the first row.
    pub(crate) fn utc_ns(&mut self, row: Cells<'_>, column: Column) -> Result<i64, CsvError> {
        match row.utc_ns(column, self.first_day_ns) {
            Err(_) if column.is_foreign() => self.any_utc_ns(row, column),
            time_ns => self.on_base(row, column, time_ns?),
        }
    }

    /// Returns the time in a column, in any form, UTC, nanoseconds.
    ///
    /// # Errors
    /// As [`Self::utc_ns`].
    pub(crate) fn any_utc_ns(&mut self, row: Cells<'_>, column: Column) -> Result<i64, CsvError> {
        let (stated_ns, form) = row.any_time(column)?;
        let time_ns = match form {
            TimeForm::OfDay => self.first_day_ns.saturating_add(stated_ns),
            TimeForm::Since1970 | TimeForm::Zoned | TimeForm::Unzoned => stated_ns,
        };
        self.on_base(row, column, time_ns)
    }

    /// Returns a time of a column, UTC, nanoseconds, if it counts from where that of the first row does.
    ///
    /// # Errors
    /// If it counts from elsewhere.
    fn on_base(&mut self, row: Cells<'_>, column: Column, time_ns: i64) -> Result<i64, CsvError> {
        let is_far = is_since_1970(time_ns.saturating_sub(self.first_day_ns));
        if *self.since_1970.get_or_insert(is_far) != is_far {
            let reason =
                "does not count from where the first row counts; count all times from midnight or all from 1970";
            return Err(row.error(column, reason));
        }
        Ok(time_ns)
    }
}
