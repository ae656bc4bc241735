//! Lines of another hour.

use std::io::Write as _;

use jiff::civil::{self, DateTime};
use jiff::{SignedDuration, tz::TimeZone};

use super::line::{SbsLine, SbsTime};

/// Places (from 0) of the two dates of a message, each before its time of day.
const DATES: [usize; 2] = [6, 8];

/// Time of a stamp, nanoseconds since 1970 in its own zone; `None` where date or time of day is missing.
pub fn stamped_ns(stamp: SbsTime) -> Option<i64> {
    let at = date_time(stamp)?.to_zoned(TimeZone::UTC).ok()?;
    i64::try_from(at.timestamp().as_nanosecond()).ok()
}

/// Appends `line` to `out` with its two times `by_ns` nanoseconds later; whether there was a time to move. Times are
/// written to the millisecond, as receivers do.
pub fn moved_line(line: &[u8], by_ns: i64, out: &mut Vec<u8>) -> bool {
    let Ok(SbsLine::Message(message)) = SbsLine::parse(line) else {
        out.extend_from_slice(line);
        return false;
    };
    let moved = [message.received, message.written].map(|stamp| {
        let by = SignedDuration::from_nanos(by_ns);
        date_time(stamp)?.checked_add(by).ok()
    });
    for (place, value) in line.split(|octet| *octet == b',').enumerate() {
        if place > 0 {
            out.push(b',');
        }
        let of_date = DATES.iter().position(|date| *date == place);
        let of_time = DATES.iter().position(|date| date + 1 == place);
        // Writing to a vector cannot fail.
        let _ = match (
            of_date.and_then(|which| moved[which]),
            of_time.and_then(|which| moved[which]),
        ) {
            (Some(at), _) => write!(out, "{:04}/{:02}/{:02}", at.year(), at.month(), at.day()),
            (_, Some(at)) => {
                let milliseconds = at.subsec_nanosecond() / 1_000_000;
                write!(
                    out,
                    "{:02}:{:02}:{:02}.{milliseconds:03}",
                    at.hour(),
                    at.minute(),
                    at.second()
                )
            }
            _ => out.write_all(value),
        };
    }
    moved.iter().any(Option::is_some)
}

fn date_time(stamp: SbsTime) -> Option<DateTime> {
    let date = stamp.date?;
    let day = civil::Date::new(
        date.year.try_into().ok()?,
        date.month.try_into().ok()?,
        date.day.try_into().ok()?,
    )
    .ok()?;
    let since_midnight = SignedDuration::from_nanos(stamp.time_of_day_ns?);
    day.to_datetime(civil::Time::midnight())
        .checked_add(since_midnight)
        .ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    const LINE: &str =
        "MSG,3,1,1,4CA2D6,1,2016/12/31,23:59:59.500,2016/12/31,23:59:59.750,,37000,,,51.5,-0.5,,,0,0,0,0\r\n";

    fn moved(line: &str, by_ns: i64) -> (bool, String) {
        let mut out = Vec::new();
        let has_moved = moved_line(line.as_bytes(), by_ns, &mut out);
        (has_moved, String::from_utf8(out).unwrap())
    }

    #[test]
    fn both_times_move_and_nothing_else_does() {
        let (has_moved, line) = moved(LINE, 1_000_000_000);
        assert!(has_moved);
        let expected =
            "MSG,3,1,1,4CA2D6,1,2017/01/01,00:00:00.500,2017/01/01,00:00:00.750,,37000,,,51.5,-0.5,,,0,0,0,0\r\n";
        assert_eq!(line, expected);
        assert_eq!(moved(&line, -1_000_000_000).1, LINE);
    }

    #[test]
    fn lines_without_times_stay() {
        for line in [
            "STA,,5,179,400AE7,10103,2008/11/28,14:58:51.153,2008/11/28,14:58:51.153,RM\n",
            "junk\n",
            "\n",
        ] {
            assert_eq!(moved(line, 5), (false, line.to_owned()));
        }
    }

    #[test]
    fn a_stamp_is_a_time_since_1970() {
        let Ok(SbsLine::Message(message)) = SbsLine::parse(LINE.as_bytes()) else {
            panic!()
        };
        assert_eq!(stamped_ns(message.received), Some(1_483_228_799_500_000_000));
        assert_eq!(stamped_ns(SbsTime::default()), None);
    }
}
