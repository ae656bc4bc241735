//! Small pieces of text: times, shares, plurals.

use telemetry::table;

/// Date and time of day of a UTC time: `2016-05-10 22:13:05`.
pub(crate) fn date_time(utc_ns: i64) -> String {
    format(utc_ns, "%Y-%m-%d %H:%M:%S")
}

/// Time of day of a UTC time: `22:13:05`.
pub(crate) fn time_of_day(utc_ns: i64) -> String {
    format(utc_ns, "%H:%M:%S")
}

fn format(utc_ns: i64, how: &str) -> String {
    let time = jiff::Timestamp::from_nanosecond(utc_ns.into());
    time.map_or_else(|_| "-".to_owned(), |time| time.strftime(how).to_string())
}

/// How long something runs: `12 s`, `2:05 min`, `1:02:05 h`.
pub(crate) fn elapsed(ns: i64) -> String {
    let seconds = ns.max(0) / 1_000_000_000;
    let (minutes, hours) = (seconds / 60, seconds / 3600);
    match seconds {
        0..60 => format!("{seconds} s"),
        60..3600 => format!("{minutes}:{:02} min", seconds % 60),
        _ => format!("{hours}:{:02}:{:02} h", minutes % 60, seconds % 60),
    }
}

/// `1 report`, `1,234 reports`.
pub(crate) fn several(count: u64, thing: &str) -> String {
    let plural = if count == 1 { "" } else { "s" };
    format!("{} {thing}{plural}", table::count(count))
}

/// `once`, `twice`, `5 times`.
pub(crate) fn times(count: u64) -> String {
    match count {
        1 => "once".to_owned(),
        2 => "twice".to_owned(),
        _ => format!("{} times", table::count(count)),
    }
}

/// `text` in lines of at most `width` characters, broken at blanks; the last line ends with a line feed too.
pub(crate) fn wrapped(text: &str, width: usize) -> String {
    let mut lines = String::with_capacity(text.len() + 2);
    let mut length = 0;
    for word in text.split_whitespace() {
        let letters = word.chars().count();
        if length > 0 {
            let fits = length + 1 + letters <= width;
            lines.push(if fits { ' ' } else { '\n' });
            length = if fits { length + 1 } else { 0 };
        }
        lines.push_str(word);
        length += letters;
    }
    lines.push('\n');
    lines
}

/// A share from 0 to 1 as a percentage. A share just under 1, or just over 0, is not rounded to 100 or 0.
pub(crate) fn percent(share: f64) -> String {
    let shown = (share * 1000.0).round() / 10.0;
    if share < 1.0 && shown >= 100.0 {
        "> 99.9 %".to_owned()
    } else if share > 0.0 && shown <= 0.0 {
        "< 0.1 %".to_owned()
    } else {
        format!("{shown:.1} %")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces() {
        assert_eq!(date_time(1_462_917_600_000_000_000), "2016-05-10 22:00:00");
        assert_eq!(time_of_day(1_462_917_600_999_999_999), "22:00:00");
        let second = 1_000_000_000;
        assert_eq!(
            [0, 59, 125, 3725].map(|s| elapsed(s * second)),
            ["0 s", "59 s", "2:05 min", "1:02:05 h"]
        );
        assert_eq!(
            [0, 1, 1234].map(|n| several(n, "report")),
            ["0 reports", "1 report", "1,234 reports"]
        );
        assert_eq!(wrapped("one two µµ four", 6), "one\ntwo µµ\nfour\n");
        assert_eq!([1, 2, 3].map(times), ["once", "twice", "3 times"]);
        assert_eq!(
            [0.0, 0.000_1, 0.5, 0.999_9, 1.0].map(percent),
            ["0.0 %", "< 0.1 %", "50.0 %", "> 99.9 %", "100.0 %"]
        );
    }
}
