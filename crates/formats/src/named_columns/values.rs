//! Values of cells: numbers, times, flags and texts as programs write them.
//!
//! Nothing is stated by an empty cell, nor by the words with which programs mark an absent value.

use csv_table::{Cells, Column, CsvError};
use jiff::civil::{DateTime, Time};

use super::header::Field;
use crate::rows::Utc;

/// Words for an absent value, in any case.
const ABSENT: [&str; 5] = ["nan", "null", "none", "na", "n/a"];
/// Numbers that count milliseconds since 1970: from 1973 to 2103.
const MILLISECONDS: std::ops::Range<f64> = 1e11..4.2e12;
const NS_PER_MS: i64 = 1_000_000;

/// The text of a cell; `None` if it states nothing.
pub(super) fn text<'r>(row: &'r Cells<'_>, column: impl Into<Option<Column>>) -> Result<Option<&'r str>, CsvError> {
    let text = row.text(column)?;
    Ok(text.filter(|text| !ABSENT.iter().any(|word| word.eq_ignore_ascii_case(text))))
}

/// The number of a cell in the unit of its quantity; `None` if it states nothing.
pub(super) fn number(row: &Cells<'_>, field: Option<Field>) -> Result<Option<f64>, CsvError> {
    let Some(field) = field else { return Ok(None) };
    match text(row, field.column)? {
        Some(_) => Ok(row.number_or_empty(field.column)?.map(|value| value * field.scale)),
        None => Ok(None),
    }
}

/// A whole number as text, without the decimals that programs add to columns with absent values: `1174.0` is `1174`.
pub(super) fn digits<'r>(row: &'r Cells<'_>, field: Option<Field>) -> Result<Option<&'r str>, CsvError> {
    let Some(field) = field else { return Ok(None) };
    let found = text(row, field.column)?;
    Ok(found.map(|text| text.strip_suffix(".0").unwrap_or(text)))
}

/// A flag; `None` if the cell states nothing.
pub(super) fn flag(row: &Cells<'_>, field: Option<Field>) -> Result<Option<bool>, CsvError> {
    let Some(field) = field else { return Ok(None) };
    let Some(word) = text(row, field.column)? else {
        return Ok(None);
    };
    let is_in = |words: [&str; 5]| words.iter().any(|known| known.eq_ignore_ascii_case(word));
    if is_in(["true", "1", "yes", "t", "y"]) {
        Ok(Some(true))
    } else if is_in(["false", "0", "no", "f", "n"]) {
        Ok(Some(false))
    } else {
        Err(row.error(field.column, "is neither true nor false"))
    }
}

/// Form of a time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TimeForm {
    /// Seconds, or hours, minutes and seconds, since midnight.
    OfDay,
    /// Seconds or milliseconds since 1970.
    Since1970,
    /// Date and time of day (ISO 8601) with a zone.
    Zoned,
    /// Date and time of day (ISO 8601) without a zone.
    Unzoned,
}

/// Time of a cell: nanoseconds since 1970, or since midnight for a time of day, and the form.
pub(super) fn time(row: &Cells<'_>, column: Column) -> Result<(i64, TimeForm), CsvError> {
    let Some(text) = text(row, column)? else {
        return Err(row.error(column, "states no time; write a time, or leave the row out"));
    };
    if text.contains(':') {
        return clock(text).ok_or_else(|| row.error(column, "is no time; write one like 2016-01-12T13:02:11.5Z"));
    }
    let as_number = row.number_or_empty(column).ok().flatten();
    if as_number.is_some_and(|number| MILLISECONDS.contains(&number)) {
        let whole = text.parse::<i64>().ok().and_then(|ms| ms.checked_mul(NS_PER_MS));
        let rounded = || (as_number.unwrap_or_default() * NS_PER_MS as f64) as i64;
        return Ok((whole.unwrap_or_else(rounded), TimeForm::Since1970));
    }
    if as_number.is_none() && text.contains(['-', '/']) {
        return Err(row.error(
            column,
            "is no time; write date and time of day like 2016-01-12T13:02:11.5Z",
        ));
    }
    let time_ns = row.utc_ns(column, 0)?;
    let form = match crate::time_base::is_since_1970(time_ns) {
        true => TimeForm::Since1970,
        false => TimeForm::OfDay,
    };
    Ok((time_ns, form))
}

/// Reads a time with colons. The calendar's reader skips a zone that is none of its own, so a time counts as one
/// without a zone only if it has none of the characters of a zone.
fn clock(text: &str) -> Option<(i64, TimeForm)> {
    if let Ok(Utc(time_ns)) = text.parse::<Utc>() {
        return Some((time_ns, TimeForm::Zoned));
    }
    let is_plain = |text: &str| {
        text.bytes()
            .all(|octet| octet.is_ascii_digit() || b":.".contains(&octet))
    };
    if is_plain(text) {
        let of_day = text.parse::<Time>().ok()?.duration_since(Time::midnight());
        return Some((i64::try_from(of_day.as_nanos()).ok()?, TimeForm::OfDay));
    }
    let (_, of_day) = text.split_once(['T', 't', ' '])?;
    let stated = is_plain(of_day).then(|| text.parse::<DateTime>().ok()).flatten()?;
    let since_1970 = stated.duration_since(DateTime::constant(1970, 1, 1, 0, 0, 0, 0));
    let time_ns = i64::try_from(since_1970.as_nanos()).ok()?;
    Some((time_ns, TimeForm::Unzoned))
}

#[cfg(test)]
mod tests {
    use csv_table::Table;

    use super::*;

    fn time_of(text: &str) -> Option<(i64, TimeForm)> {
        let written = format!("time,other\n{text},1\n");
        let mut table = Table::new(written.as_bytes()).unwrap();
        let column = table.required("time").unwrap();
        let row = table.next_row().unwrap().unwrap();
        time(&row, column).ok()
    }

    #[test]
    fn times_are_read_in_every_form() {
        const AT_NS: i64 = 1_452_603_731_218_000_000;
        for (text, time_ns, form) in [
            ("2016-01-12 13:02:11.218", AT_NS, TimeForm::Unzoned),
            ("2016-01-12T13:02:11.218", AT_NS, TimeForm::Unzoned),
            ("2016-01-12T13:02:11.218Z", AT_NS, TimeForm::Zoned),
            ("2016-01-12 15:02:11.218+02:00", AT_NS, TimeForm::Zoned),
            ("2016-01-12T08:02:11.218-05:00", AT_NS, TimeForm::Zoned),
            ("1452603731.218", AT_NS, TimeForm::Since1970),
            ("1452603731218", AT_NS, TimeForm::Since1970),
            ("46931.218", 46_931_218_000_000, TimeForm::OfDay),
            ("13:02:11.218", 46_931_218_000_000, TimeForm::OfDay),
            ("0", 0, TimeForm::OfDay),
            ("1452603731218.0", AT_NS, TimeForm::Since1970),
        ] {
            let (found_ns, found) = time_of(text).unwrap_or_else(|| panic!("{text}"));
            assert!((found_ns - time_ns).abs() < 300, "{text}: {found_ns}");
            assert_eq!(found, form, "{text}");
        }
    }

    #[test]
    fn other_texts_are_no_times() {
        for text in [
            "",
            "nan",
            "None",
            "noon",
            "2016-01-12",
            "12/01/2016 13:02:11",
            "2016-13-12 13:02:11",
            "2016-01-12T13:02:11[Europe/Berlin]",
            "2016-01-12 13:02:11 PM",
            "2016-01-12 13:02:11 CET",
            "25:02:11",
            "1e30",
            "5e9",
            "inf",
            ":",
        ] {
            assert_eq!(time_of(text), None, "{text}");
        }
    }
}
