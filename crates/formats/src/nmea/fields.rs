//! Fields of sentences.

use std::str::Split;

use super::sentence::NmeaFault;

const NS_PER_S: f64 = 1e9;
/// Metres per second of a knot.
pub(super) const KNOT_MPS: f64 = 1852.0 / 3600.0;

/// The fields of a sentence, one after the other.
pub(super) struct Fields<'a> {
    rest: Split<'a, char>,
    /// Number, from 1, of the field read last; 0 before the first.
    pub(super) place: usize,
}

impl<'a> Fields<'a> {
    pub(super) fn of(text: &'a str) -> Self {
        Self {
            rest: text.split(','),
            place: 0,
        }
    }

    /// The next field; empty beyond the last.
    pub(super) fn text(&mut self) -> &'a str {
        self.place += 1;
        self.rest.next().unwrap_or_default().trim()
    }

    /// A number between two bounds; `None` of an empty field.
    pub(super) fn number(&mut self, low: f64, high: f64) -> Result<Option<f64>, NmeaFault> {
        let text = self.text();
        if text.is_empty() {
            return Ok(None);
        }
        let plain = text
            .bytes()
            .all(|octet| octet.is_ascii_digit() || matches!(octet, b'.' | b'-' | b'+'));
        let number: f64 = text.parse().map_err(|_| NmeaFault::Field)?;
        match plain && (low..=high).contains(&number) {
            true => Ok(Some(number)),
            false => Err(NmeaFault::Field),
        }
    }

    /// An angle in degrees, as radians.
    pub(super) fn angle(&mut self, low_deg: f64, high_deg: f64) -> Result<Option<f64>, NmeaFault> {
        Ok(self.number(low_deg, high_deg)?.map(f64::to_radians))
    }

    /// An angle in degrees with its side, as radians towards the east.
    pub(super) fn eastward(&mut self) -> Result<Option<f64>, NmeaFault> {
        let angle = self.angle(0.0, 180.0)?;
        match (angle, self.text()) {
            (None, _) => Ok(None),
            (Some(angle), "E") => Ok(Some(angle)),
            (Some(angle), "W") => Ok(Some(-angle)),
            _ => Err(NmeaFault::Field),
        }
    }

    /// Time of day, nanoseconds; a leap second counts as the next one.
    pub(super) fn time_of_day_ns(&mut self) -> Result<Option<i64>, NmeaFault> {
        let text = self.text();
        if text.is_empty() {
            return Ok(None);
        }
        let (whole, part) = text.split_once('.').unwrap_or((text, ""));
        let digits = |text: &str| text.bytes().all(|octet| octet.is_ascii_digit());
        if whole.len() != 6 || !digits(whole) || !digits(part) || part.len() > 9 {
            return Err(NmeaFault::Field);
        }
        let two = |at: usize| whole[at..at + 2].parse::<i64>().map_err(|_| NmeaFault::Field);
        let (hours, minutes, seconds) = (two(0)?, two(2)?, two(4)?);
        if hours > 23 || minutes > 59 || seconds > 60 {
            return Err(NmeaFault::Field);
        }
        let part_s: f64 = format!("0.{part}0").parse().map_err(|_| NmeaFault::Field)?;
        let seconds_ns = ((hours * 60 + minutes) * 60 + seconds) * NS_PER_S as i64;
        Ok(Some(seconds_ns + (part_s * NS_PER_S).round() as i64))
    }

    /// Latitude or longitude with its hemisphere, degrees; `whole` digits are degrees.
    pub(super) fn coordinate(&mut self, whole: usize, [plus, minus]: [&str; 2]) -> Result<Option<f64>, NmeaFault> {
        let text = self.text();
        if text.is_empty() {
            self.text();
            return Ok(None);
        }
        let digits = text.bytes().all(|octet| octet.is_ascii_digit() || octet == b'.');
        let (degrees, minutes) = text
            .split_at_checked(whole)
            .filter(|_| digits)
            .ok_or(NmeaFault::Field)?;
        let degrees: f64 = degrees.parse().map_err(|_| NmeaFault::Field)?;
        let minutes: f64 = minutes.parse().map_err(|_| NmeaFault::Field)?;
        if minutes >= 60.0 {
            return Err(NmeaFault::Field);
        }
        let value = degrees + minutes / 60.0;
        match self.text() {
            side if side == plus => Ok(Some(value)),
            side if side == minus => Ok(Some(-value)),
            _ => Err(NmeaFault::Field),
        }
    }

    /// Date, as days since 1970.
    pub(super) fn date(&mut self) -> Result<Option<i64>, NmeaFault> {
        let text = self.text();
        if text.is_empty() {
            return Ok(None);
        }
        if text.len() != 6 || !text.bytes().all(|octet| octet.is_ascii_digit()) {
            return Err(NmeaFault::Field);
        }
        let two = |at: usize| text[at..at + 2].parse::<i64>().map_err(|_| NmeaFault::Field);
        let (day, month, year) = (two(0)?, two(2)?, two(4)?);
        let year = if year >= 80 { 1900 + year } else { 2000 + year };
        if !(1..=12).contains(&month) || !(1..=days_of(month, year)).contains(&day) {
            return Err(NmeaFault::Field);
        }
        Ok(Some(days_since_1970(day, month, year)))
    }
}

fn days_of(month: i64, year: i64) -> i64 {
    let is_leap = year % 4 == 0 && (year % 100 != 0 || year % 400 == 0);
    match month {
        2 => 28 + i64::from(is_leap),
        4 | 6 | 9 | 11 => 30,
        _ => 31,
    }
}

/// Days of the Gregorian calendar (H. Hinnant, "chrono-compatible low-level date algorithms").
fn days_since_1970(day: i64, month: i64, year: i64) -> i64 {
    let year = if month <= 2 { year - 1 } else { year };
    let (era, of_era) = (year.div_euclid(400), year.rem_euclid(400));
    let of_year = (153 * ((month + 9) % 12) + 2) / 5 + day - 1;
    era * 146_097 + of_era * 365 + of_era / 4 - of_era / 100 + of_year - 719_468
}
