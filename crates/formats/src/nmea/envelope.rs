//! What stands around a sentence in a line: tag blocks, times of loggers, stations.
//!
//! A sentence states neither when nor where it was received. Receivers, loggers and collecting centres add both, each
//! in a form of its own, before or behind the sentence:
//!
//! ```text
//! \s:2573135,c:1577836800*01\!BSVDM,1,1,,A,1…,0*5C      tag block of IEC 61162-450 and NMEA 0183 since 4.0
//! 2024-01-02 03:04:05,!AIVDM,1,1,,A,1…,0*5C             time of a logger, UTC; or seconds since 1970
//! !AIVDM,1,1,,A,1…,0*5C,r003669945,1577836800           station and time of the United States Coast Guard
//! ```
//!
//! Other text is skipped. A tag block with a wrong sum is not used; the sentence behind it has a sum of its own.

use frames::time::NS_PER_S;
use jiff::{civil::DateTime, tz::TimeZone};

use super::sentence::summed;

/// Longest line that is read, octets: a sentence of 82, a tag block of 80, and what stands behind them.
pub(crate) const LINE_OCTETS_MAX: usize = 1024;
/// Numbers above this one are milliseconds since 1970, not seconds.
const SECONDS_MAX: f64 = 40e9;
/// Times since 1970 that are meant as such, seconds: from the year 1973 to 2255.
const SINCE_1970_S: std::ops::Range<f64> = 1e8..9e9;

/// Time and station of a line.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Envelope<'a> {
    /// Time of receipt as the line states it, UTC, nanoseconds since 1970.
    pub(crate) received_ns: Option<i64>,
    /// Receiving station.
    pub(crate) station: Option<&'a str>,
    /// Number of the group of sentences.
    pub(crate) group: Option<&'a str>,
    /// Whether a tag block had a wrong sum and was not used.
    pub(crate) has_wrong_tag: bool,
}

impl<'a> Envelope<'a> {
    /// Reads the text before a sentence and the text behind its checksum.
    pub(crate) fn of(before: &'a str, behind: &'a str) -> Self {
        let mut found = Self::default();
        let before = match before.trim_end().strip_suffix('\\') {
            Some(tagged) => {
                let (before, tag) = tagged.rsplit_once('\\').unwrap_or_default();
                found.take_tag(tag);
                before
            }
            None => before,
        };
        found.received_ns = found.received_ns.or_else(|| logged_ns(before));
        found.take_behind(behind);
        found
    }

    fn take_tag(&mut self, tag: &'a str) {
        let Ok((tag, _)) = summed(tag) else {
            self.has_wrong_tag = true;
            return;
        };
        for (key, value) in tag.split(',').filter_map(|field| field.trim().split_once(':')) {
            match key {
                "c" => self.received_ns = since_1970_ns(value),
                "s" => self.station = Some(value),
                // Sentence number, number of sentences, number of the group.
                "g" => self.group = value.splitn(3, '-').nth(2),
                _ => {}
            }
        }
    }

    fn take_behind(&mut self, behind: &'a str) {
        for field in behind.split(',').map(str::trim) {
            let is_station = field.len() > 1 && field.starts_with(['r', 'b']);
            self.station = self.station.or(is_station.then_some(field));
            self.received_ns = self.received_ns.or_else(|| since_1970_ns(field));
        }
    }
}

/// Time that a logger wrote before a sentence: a date with a time of day, or seconds since 1970.
fn logged_ns(text: &str) -> Option<i64> {
    let text = text.trim_matches([' ', '\t', ',', ';', '[', ']']);
    if text.contains('-') {
        let at: DateTime = text.trim_end_matches('Z').parse().ok()?;
        let at = at.to_zoned(TimeZone::UTC).ok()?;
        return i64::try_from(at.timestamp().as_nanosecond()).ok();
    }
    since_1970_ns(text)
}

fn since_1970_ns(text: &str) -> Option<i64> {
    let is_plain = |octet: u8| octet.is_ascii_digit() || octet == b'.';
    let number: f64 = text.parse().ok().filter(|_| text.bytes().all(is_plain))?;
    let number_s = if number > SECONDS_MAX { number / 1e3 } else { number };
    SINCE_1970_S
        .contains(&number_s)
        .then(|| (number_s.floor() as i64) * NS_PER_S + (number_s.fract() * NS_PER_S as f64) as i64)
}
