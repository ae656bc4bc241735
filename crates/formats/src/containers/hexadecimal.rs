//! Hexadecimal text: a datagram in each line, with an optional time before it.
//!
//! ```text
//! # a comment
//! 1620114891.827 30 00 0C F0 19 C9 02 …        seconds since 1970, UTC
//! 28491.827;30000CF019C902…                    seconds of the day
//! 2021-05-04T07:54:51.827Z 30000CF019C902…     ISO 8601; without an offset in UTC; also with a space for the T
//! 07:54:51.827 30000CF019C902…                 time of day
//! 30000CF019C902…                              no time
//! ```
//!
//! Octets are pairs of digits, with or without blanks between them. A time ends at a blank, a comma or a semicolon.
//! The first octets of a line could be a time in seconds, and a time could be octets: a line whose octets are all of
//! some data blocks has no time; digits alone are a time where the octets behind them are all of some data blocks.
//! Seconds are those of the day up to 86,400, the last second of a day with a leap second included.
//!
//! A text is taken for this format where most of its first lines are such datagrams of whole data blocks. Other
//! hexadecimal text, such as a dump that is cut into lines of equal length, is none.
//!
//! # Limits
//!
//! A datagram takes up to half of its line's length as memory. Offsets of records are those of the line in the text
//! plus octets within the datagram.

use asterix::{Block, blocks};
use jiff::Timestamp;
use jiff::civil::{DateTime, Time};
use jiff::tz::TimeZone;

use super::skipped::{Reason, Skipped};
use super::{NS_PER_S, RecordedDatagram, TimeStamp};

/// Lines at the beginning, without empty ones and comments, by which the format is recognised.
const LINES_LOOKED_AT: usize = 20;
/// Seconds of a day.
const DAY_S: i64 = 86_400;
/// Digits of a fraction of a second that count.
const FRACTION_DIGITS: usize = 9;
/// Characters of a line that is no datagram which are shown.
const SHOWN_MAX: usize = 24;
/// Characters that end a time.
const SEPARATORS: [char; 4] = [' ', '\t', ',', ';'];
/// Byte order mark.
const MARK: &[u8] = b"\xef\xbb\xbf";

/// Whether most of the first lines are datagrams of whole data blocks.
pub(crate) fn begins(bytes: &[u8]) -> bool {
    let (mut lines, mut good) = (0, 0);
    let text = bytes.strip_prefix(MARK).unwrap_or(bytes);
    let contents = text.split(|octet| *octet == b'\n').filter_map(content);
    for line in contents.take(LINES_LOOKED_AT) {
        // Whatever is no text ends the search at once.
        if !line
            .iter()
            .all(|octet| octet.is_ascii_graphic() || b" \t".contains(octet))
        {
            return false;
        }
        lines += 1;
        good += usize::from(datagram(line).is_some_and(|(octets, _)| are_blocks(&octets)));
    }
    good > 0 && 2 * good >= lines
}

/// The lines of a text.
#[derive(Debug)]
pub(super) struct HexLines<'a> {
    bytes: &'a [u8],
    position: usize,
}

impl<'a> HexLines<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, position: 0 }
    }

    pub(super) fn position(&self) -> usize {
        self.position
    }

    pub(super) fn next(&mut self) -> Option<Result<RecordedDatagram<'a>, Skipped>> {
        while self.position < self.bytes.len() {
            let begin = self.position;
            let rest = &self.bytes[begin..];
            let line = rest.split(|octet| *octet == b'\n').next().unwrap_or(rest);
            self.position += (line.len() + 1).min(rest.len());
            let line = if begin == 0 {
                line.strip_prefix(MARK).unwrap_or(line)
            } else {
                line
            };
            let Some(content) = content(line) else { continue };
            return Some(match datagram(content) {
                Some((octets, time_stamp)) => Ok(RecordedDatagram {
                    bytes: octets.into(),
                    time_stamp,
                    offset: begin,
                }),
                None => Err(Skipped {
                    offset: begin,
                    octets: self.position - begin,
                    why: Reason::HexLine {
                        beginning: beginning(content),
                    },
                }),
            });
        }
        None
    }
}

/// The content of a line; `None` for an empty one or a comment.
fn content(line: &[u8]) -> Option<&[u8]> {
    let line = line.trim_ascii();
    (!line.is_empty() && !line.starts_with(b"#")).then_some(line)
}

/// The octets of a line and its time.
fn datagram(line: &[u8]) -> Option<(Vec<u8>, Option<TimeStamp>)> {
    let whole = octets(line);
    match whole {
        Some(whole) if are_blocks(&whole) => Some((whole, None)),
        whole => timed(line).or_else(|| whole.map(|whole| (whole, None))),
    }
}

/// The octets behind a time. A time of digits alone needs data blocks behind it.
fn timed(line: &[u8]) -> Option<(Vec<u8>, Option<TimeStamp>)> {
    let (stated, time, rest) = stated_time(std::str::from_utf8(line).ok()?)?;
    let octets = octets(rest.as_bytes())?;
    let is_clear = !stated.bytes().all(|octet| octet.is_ascii_digit());
    (is_clear || are_blocks(&octets)).then_some((octets, Some(time)))
}

/// The text of a time at the beginning, its value, and what follows.
fn stated_time(line: &str) -> Option<(&str, TimeStamp, &str)> {
    let (first, rest) = line.split_once(SEPARATORS)?;
    let rest = rest.trim_start_matches(SEPARATORS);
    if let Some((second, behind)) = rest.split_once(SEPARATORS) {
        // A date and a time of day.
        let both = &line[..line.len() - rest.len() + second.len()];
        if let Some(time) = calendar_time(both) {
            return Some((both, time, behind));
        }
    }
    let time = seconds(first).or_else(|| calendar_time(first))?;
    Some((first, time, rest))
}

/// A time by ISO 8601: of a day in UTC, at an offset, or of a day that is not named.
fn calendar_time(text: &str) -> Option<TimeStamp> {
    // Digits without colons could be octets.
    if !text.contains(':') {
        return None;
    }
    let instant = text.parse::<Timestamp>().or_else(|_| {
        let date_time: DateTime = text.parse()?;
        date_time.to_zoned(TimeZone::UTC).map(|zoned| zoned.timestamp())
    });
    if let Ok(instant) = instant {
        let ns = i64::try_from(instant.as_nanosecond()).ok()?;
        return Some(TimeStamp::Utc { ns });
    }
    let of_day: Time = text.parse().ok()?;
    let ns = i64::try_from(of_day.duration_since(Time::midnight()).as_nanos()).ok()?;
    Some(TimeStamp::TimeOfDay { ns })
}

/// Seconds with an optional fraction, exactly.
fn seconds(text: &str) -> Option<TimeStamp> {
    let (whole, fraction) = text.split_once('.').unwrap_or((text, ""));
    let are_digits = |text: &str| text.bytes().all(|digit| digit.is_ascii_digit());
    if whole.is_empty() || !are_digits(whole) || !are_digits(fraction) {
        return None;
    }
    let digits = fraction.bytes().chain(std::iter::repeat(b'0')).take(FRACTION_DIGITS);
    let fraction_ns = digits.fold(0, |ns, digit| 10 * ns + i64::from(digit - b'0'));
    let whole_s: i64 = whole.parse().ok()?;
    let ns = whole_s.checked_mul(NS_PER_S)?.checked_add(fraction_ns)?;
    Some(match whole_s {
        ..=DAY_S => TimeStamp::TimeOfDay { ns },
        _ => TimeStamp::Utc { ns },
    })
}

/// Octets of pairs of digits; `None` for other text, and for a group of an odd number of digits.
fn octets(text: &[u8]) -> Option<Vec<u8>> {
    let mut octets = Vec::with_capacity(text.len() / 2);
    for group in text.split(u8::is_ascii_whitespace).filter(|group| !group.is_empty()) {
        let (pairs, []) = group.as_chunks::<2>() else {
            return None;
        };
        for [high, low] in pairs {
            let digit = |letter: u8| char::from(letter).to_digit(16);
            octets.push((digit(*high)? << 4 | digit(*low)?) as u8);
        }
    }
    (!octets.is_empty()).then_some(octets)
}

/// Whether data blocks fill these octets. Category 0 does not exist, and a block has a record.
fn are_blocks(octets: &[u8]) -> bool {
    let is_one = |block: &Block<'_>| block.category > 0 && !block.body().is_empty();
    !octets.is_empty() && blocks(octets).all(|block| block.is_ok_and(|block| is_one(&block)))
}

fn beginning(line: &[u8]) -> String {
    let text = String::from_utf8_lossy(&line[..line.len().min(4 * SHOWN_MAX)]);
    let shown: String = text.chars().take(SHOWN_MAX).collect();
    match shown.len() < text.len() || text.len() < line.len() {
        true => shown + "…",
        false => shown,
    }
}
