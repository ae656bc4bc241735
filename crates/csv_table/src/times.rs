//! Times as programs write them: seconds, milliseconds, dates, hours of the day.

use jiff::Timestamp;
use jiff::civil::{DateTime, Time};

use crate::cells::TIME_MAX_S;
use crate::{Cells, Column, CsvError};

/// Numbers that count milliseconds since 1970: from 1973 to 2103.
const MILLISECONDS: std::ops::Range<f64> = 1e11..4.2e12;
const NS_PER_MS: i64 = 1_000_000;

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

/// Reads a date and time of day with a zone (RFC 3339) as nanoseconds since 1970. Decimals of a second beyond the ninth
/// are cut: the format allows any number of them.
///
/// # Errors
/// If the text is no such time.
pub fn zoned_ns(text: &str) -> Result<i64, jiff::Error> {
    /// Decimals of a nanosecond.
    const DECIMALS: usize = 9;
    let cut = text.split_once('.').and_then(|(whole, rest)| {
        let decimals = rest.bytes().take_while(u8::is_ascii_digit).count();
        (decimals > DECIMALS).then(|| format!("{whole}.{}{}", &rest[..DECIMALS], &rest[decimals..]))
    });
    let time_ns = cut.as_deref().unwrap_or(text).parse::<Timestamp>()?.as_nanosecond();
    Ok(i64::try_from(time_ns).unwrap_or(i64::MAX))
}

impl Cells<'_> {
    /// Time of a cell in any form: nanoseconds since 1970, or since midnight for a time of day, and the form.
    ///
    /// # Errors
    /// If the value is no time.
    pub fn any_time(&self, column: Column) -> Result<(i64, TimeForm), CsvError> {
        let Some(text) = self.stated(column)? else {
            return Err(self.error(column, "states no time; write a time, or leave the row out"));
        };
        if text.contains(':') {
            return clock(text).ok_or_else(|| self.error(column, "is no time; write one like 2016-01-12T13:02:11.5Z"));
        }
        let as_number = self.number_or_empty(column).ok().flatten();
        if as_number.is_some_and(|number| MILLISECONDS.contains(&number)) {
            let whole = text.parse::<i64>().ok().and_then(|ms| ms.checked_mul(NS_PER_MS));
            let rounded = || (as_number.unwrap_or_default() * NS_PER_MS as f64) as i64;
            return Ok((whole.unwrap_or_else(rounded), TimeForm::Since1970));
        }
        if as_number.is_none() && text.contains(['-', '/']) {
            return Err(self.error(
                column,
                "is no time; write date and time of day like 2016-01-12T13:02:11.5Z",
            ));
        }
        let time_ns = self.utc_ns(column, 0)?;
        let form = match time_ns > frames::time::ns(TIME_MAX_S) {
            true => TimeForm::Since1970,
            false => TimeForm::OfDay,
        };
        Ok((time_ns, form))
    }
}

/// Reads a time with colons. The calendar's reader skips a zone that is none of its own, so a time counts as one
/// without a zone only if it has none of the characters of a zone.
fn clock(text: &str) -> Option<(i64, TimeForm)> {
    if let Ok(time_ns) = zoned_ns(text) {
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
    use super::*;
    use crate::Table;

    fn time_of(text: &str) -> Option<(i64, TimeForm)> {
        let written = format!("time,other\n{text},1\n");
        let mut table = Table::new(written.as_bytes()).unwrap();
        let column = table.required("time").unwrap();
        let row = table.next_row().unwrap().unwrap();
        row.any_time(column).ok()
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
