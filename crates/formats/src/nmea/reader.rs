//! Bytes to states of the platform.

use std::f64::consts::{PI, TAU};

use frames::Geodetic;
use platform::Navigation;

use super::fields::{Fields, KNOT_MPS};
use super::refusal::NmeaRefusal;
use super::sentence::{NmeaCounts, NmeaFault, SENTENCE_OCTETS_MAX, SentenceKind, framed};

const NS_PER_S: f64 = 1e9;
const NS_PER_DAY: i64 = 86_400 * NS_PER_S as i64;
/// Longest time between two headings for a rate of turn, nanoseconds.
const RATE_OVER_MAX_NS: i64 = 5 * NS_PER_S as i64;
/// Age of a fix up to which a velocity without a time belongs to it, nanoseconds.
const FIX_AGE_MAX_NS: i64 = 2 * NS_PER_S as i64;
/// Age of a true heading up to which magnetic ones beside it are not read, nanoseconds.
const TRUE_HEADING_AGE_MAX_NS: u64 = 10 * NS_PER_S as u64;

/// Settings of a reader.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NmeaSettings {
    /// Standard deviation of the delay until a sentence without a time is received, seconds.
    pub receipt_sigma_s: f64,
    /// Standard deviation of headings, radians.
    pub heading_sigma_rad: f64,
}

/// Reader of a stream of sentences.
#[derive(Clone, Debug)]
pub struct NmeaReader {
    settings: NmeaSettings,
    line: Vec<u8>,
    /// The line is longer than any sentence; its rest is skipped.
    is_skipping: bool,
    counts: NmeaCounts,
    refused: NmeaRefusal,
    /// Latest stated time, UTC, nanoseconds.
    stated_ns: Option<i64>,
    /// Time of the latest fix, and its time of receipt.
    fix: Option<(i64, Option<i64>)>,
    /// Height of the latest GGA above the ellipsoid, metres.
    height_m: f64,
    /// Time and angle of the latest heading without a stated time.
    heading: Option<(i64, f64)>,
    /// Time of the latest heading of an instrument that finds true north by itself.
    true_heading_ns: Option<i64>,
}

impl NmeaReader {
    /// Makes a reader.
    pub fn new(settings: NmeaSettings) -> Self {
        Self {
            settings,
            line: Vec::with_capacity(SENTENCE_OCTETS_MAX),
            is_skipping: false,
            counts: NmeaCounts::default(),
            refused: NmeaRefusal::default(),
            stated_ns: None,
            fix: None,
            height_m: 0.0,
            heading: None,
            true_heading_ns: None,
        }
    }

    /// Counts of sentences.
    pub fn counts(&self) -> NmeaCounts {
        self.counts
    }

    /// The sentence that was refused last; `None` if none was.
    pub fn refused(&self) -> Option<&NmeaRefusal> {
        (self.counts.refused() > 0).then_some(&self.refused)
    }

    /// Takes bytes of a stream, received at `received_ns` (UTC, nanoseconds). Sentences may begin and end anywhere.
    pub fn take(&mut self, bytes: &[u8], received_ns: Option<i64>, mut each: impl FnMut(Navigation)) {
        for octet in bytes {
            match octet {
                b'\n' | b'\r' => self.end_line(received_ns, &mut each),
                b'$' if !self.line.is_empty() => {
                    // A sentence begins within another, which was cut.
                    self.refuse_begun(NmeaFault::Partial);
                    self.line.push(*octet);
                }
                b'$' => {
                    self.is_skipping = false;
                    self.line.push(*octet);
                }
                _ if self.is_skipping => {}
                _ if self.line.len() >= SENTENCE_OCTETS_MAX => {
                    self.refuse_begun(NmeaFault::TooLong);
                    self.is_skipping = true;
                }
                _ => self.line.push(*octet),
            }
        }
    }

    /// The stream has ended, or its datagram: what has begun is a sentence, or was cut.
    pub fn end(&mut self, received_ns: Option<i64>, mut each: impl FnMut(Navigation)) {
        self.end_line(received_ns, &mut each);
    }

    fn end_line(&mut self, received_ns: Option<i64>, each: &mut impl FnMut(Navigation)) {
        self.is_skipping = false;
        if self.line.is_empty() {
            return;
        }
        let line = std::mem::take(&mut self.line);
        self.refused.place = 0;
        match self.sentence(&line, received_ns) {
            Ok(Some(state)) => {
                self.counts.used += 1;
                each(state);
            }
            Ok(None) => self.counts.other += 1,
            Err(fault) => self.refuse(fault, &line),
        }
        self.line = line;
        self.line.clear();
    }

    /// Refuses what has come of a line.
    fn refuse_begun(&mut self, fault: NmeaFault) {
        let line = std::mem::take(&mut self.line);
        self.refused.place = 0;
        self.refuse(fault, &line);
        self.line = line;
        self.line.clear();
    }

    fn refuse(&mut self, fault: NmeaFault, line: &[u8]) {
        self.counts.count(fault);
        let refused = &mut self.refused;
        refused.fault = fault;
        refused.line.clear();
        refused.line.extend_from_slice(line);
    }

    fn sentence(&mut self, line: &[u8], received_ns: Option<i64>) -> Result<Option<Navigation>, NmeaFault> {
        let Some((kind, text)) = framed(line)? else {
            return Ok(None);
        };
        let mut fields = Fields::of(text);
        let read = match kind {
            SentenceKind::Gga => self.gga(&mut fields, received_ns),
            SentenceKind::Gll => self.gll(&mut fields, received_ns),
            SentenceKind::Rmc => self.rmc(&mut fields, received_ns),
            SentenceKind::Vtg => self.vtg(&mut fields, received_ns),
            SentenceKind::Hdt => self.hdt(&mut fields, received_ns),
            SentenceKind::Ths => self.ths(&mut fields, received_ns),
            SentenceKind::Hdg if self.has_true_heading(received_ns) => return Ok(None),
            SentenceKind::Hdg => match self.hdg(&mut fields, received_ns).transpose() {
                Some(read) => read,
                None => return Ok(None),
            },
            SentenceKind::Pashr => self.pashr(&mut fields, received_ns),
        };
        if let Ok(Navigation {
            time_ns,
            heading_rad: Some(_),
            ..
        }) = read
            && kind != SentenceKind::Hdg
        {
            self.true_heading_ns = Some(time_ns);
        }
        self.refused.place = fields.place;
        read.map(Some)
    }

    fn gga(&mut self, fields: &mut Fields<'_>, received_ns: Option<i64>) -> Result<Navigation, NmeaFault> {
        let time_of_day = fields.time_of_day_ns()?;
        let latitude = fields.coordinate(2, ["N", "S"])?;
        let longitude = fields.coordinate(3, ["E", "W"])?;
        let quality = fields.text();
        if quality.is_empty() || quality == "0" {
            return Err(NmeaFault::NoFix);
        }
        let (_satellites, _dilution) = (fields.text(), fields.text());
        let above_sea = fields.number(-1e4, 1e5)?;
        let _unit = fields.text();
        let separation = fields.number(-200.0, 200.0)?.unwrap_or(0.0);
        let height_m = above_sea.map_or(self.height_m, |above_sea| above_sea + separation);
        let (latitude, longitude) = latitude.zip(longitude).ok_or(NmeaFault::NoFix)?;
        let place = Geodetic::from_degrees(latitude, longitude, height_m).map_err(|_| NmeaFault::Field)?;
        let time_ns = self.day(time_of_day.ok_or(NmeaFault::NoFix)?, received_ns)?;
        self.height_m = height_m;
        self.fix = Some((time_ns, received_ns));
        Ok(Navigation {
            time_ns,
            place: Some(place),
            ..Navigation::default()
        })
    }

    fn gll(&mut self, fields: &mut Fields<'_>, received_ns: Option<i64>) -> Result<Navigation, NmeaFault> {
        let latitude = fields.coordinate(2, ["N", "S"])?;
        let longitude = fields.coordinate(3, ["E", "W"])?;
        let time_of_day = fields.time_of_day_ns()?;
        if fields.text() != "A" {
            return Err(NmeaFault::NoFix);
        }
        let (latitude, longitude) = latitude.zip(longitude).ok_or(NmeaFault::NoFix)?;
        let place = Geodetic::from_degrees(latitude, longitude, self.height_m).map_err(|_| NmeaFault::Field)?;
        let time_ns = self.day(time_of_day.ok_or(NmeaFault::NoFix)?, received_ns)?;
        self.fix = Some((time_ns, received_ns));
        Ok(Navigation {
            time_ns,
            place: Some(place),
            ..Navigation::default()
        })
    }

    fn rmc(&mut self, fields: &mut Fields<'_>, received_ns: Option<i64>) -> Result<Navigation, NmeaFault> {
        let time_of_day = fields.time_of_day_ns()?;
        if fields.text() != "A" {
            return Err(NmeaFault::NoFix);
        }
        let latitude = fields.coordinate(2, ["N", "S"])?;
        let longitude = fields.coordinate(3, ["E", "W"])?;
        let speed = fields.number(0.0, 2000.0)?;
        let course = fields.angle(0.0, 360.0)?;
        let date = fields.date()?;
        let time_of_day = time_of_day.ok_or(NmeaFault::NoFix)?;
        let (latitude, longitude) = latitude.zip(longitude).ok_or(NmeaFault::NoFix)?;
        let place = Geodetic::from_degrees(latitude, longitude, self.height_m).map_err(|_| NmeaFault::Field)?;
        let time_ns = match date {
            Some(days) => {
                let time_ns = days * NS_PER_DAY + time_of_day;
                // A receiver whose count of weeks has wrapped states a date of 20 years ago.
                let is_near = |now_ns: i64| time_ns.abs_diff(now_ns) <= NS_PER_DAY.unsigned_abs();
                if !received_ns.is_none_or(is_near) {
                    return Err(NmeaFault::NoDate);
                }
                self.note(time_of_day, time_ns);
                time_ns
            }
            None => self.day(time_of_day, received_ns)?,
        };
        self.fix = Some((time_ns, received_ns));
        Ok(Navigation {
            time_ns,
            place: Some(place),
            velocity_mps: velocity(speed, course),
            ..Navigation::default()
        })
    }

    fn vtg(&mut self, fields: &mut Fields<'_>, received_ns: Option<i64>) -> Result<Navigation, NmeaFault> {
        let course = fields.angle(0.0, 360.0)?;
        let [_true, _magnetic, _unit] = [fields.text(), fields.text(), fields.text()];
        let knots = fields.number(0.0, 2000.0)?;
        let [_unit, _kilometres, _unit_too, mode] = [fields.text(), fields.text(), fields.text(), fields.text()];
        if mode == "N" {
            return Err(NmeaFault::NoFix);
        }
        let (fix_ns, fix_received_ns) = self.fix.ok_or(NmeaFault::NoDate)?;
        let age_ns = received_ns
            .zip(fix_received_ns)
            .map_or(0, |(now, then)| now.saturating_sub(then));
        if age_ns > FIX_AGE_MAX_NS {
            return Err(NmeaFault::NoFix);
        }
        let velocity_mps = velocity(knots, course).ok_or(NmeaFault::NoFix)?;
        Ok(Navigation {
            time_ns: fix_ns,
            velocity_mps: Some(velocity_mps),
            ..Navigation::default()
        })
    }

    fn hdt(&mut self, fields: &mut Fields<'_>, received_ns: Option<i64>) -> Result<Navigation, NmeaFault> {
        let heading = fields.angle(0.0, 360.0)?;
        // The name of the sentence implies true north; some devices leave the letter out.
        if !matches!(fields.text(), "T" | "") {
            return Err(NmeaFault::Field);
        }
        self.heading(heading, received_ns)
    }

    /// Whether an instrument finds true north: a magnetic compass beside it is the less accurate one.
    fn has_true_heading(&self, received_ns: Option<i64>) -> bool {
        let now_ns = received_ns.or(self.stated_ns);
        let age_ns = self
            .true_heading_ns
            .zip(now_ns)
            .map(|(then_ns, now_ns)| now_ns.abs_diff(then_ns));
        age_ns.is_some_and(|age_ns| age_ns <= TRUE_HEADING_AGE_MAX_NS)
    }

    /// A magnetic heading becomes a true one by its deviation and the variation of the place; `None` without these.
    fn hdg(&mut self, fields: &mut Fields<'_>, received_ns: Option<i64>) -> Result<Option<Navigation>, NmeaFault> {
        let magnetic = fields.angle(0.0, 360.0)?;
        let deviation = fields.eastward()?.unwrap_or(0.0);
        let Some(variation) = fields.eastward()? else {
            return Ok(None);
        };
        let heading = magnetic.map(|magnetic| (magnetic + deviation + variation).rem_euclid(TAU));
        self.heading(heading, received_ns).map(Some)
    }

    fn ths(&mut self, fields: &mut Fields<'_>, received_ns: Option<i64>) -> Result<Navigation, NmeaFault> {
        let heading = fields.angle(0.0, 360.0)?;
        match fields.text() {
            "A" | "E" | "M" | "S" => self.heading(heading, received_ns),
            _ => Err(NmeaFault::NoFix),
        }
    }

    fn pashr(&mut self, fields: &mut Fields<'_>, received_ns: Option<i64>) -> Result<Navigation, NmeaFault> {
        let time_of_day = fields.time_of_day_ns()?;
        let heading = fields.angle(0.0, 360.0)?;
        let _true = fields.text();
        let roll = fields.angle(-180.0, 180.0)?;
        let pitch = fields.angle(-90.0, 90.0)?;
        let _heave = fields.text();
        let [roll_sigma, pitch_sigma, heading_sigma] = [
            fields.angle(0.0, 180.0)?,
            fields.angle(0.0, 180.0)?,
            fields.angle(0.0, 180.0)?,
        ];
        let time_ns = self.day(time_of_day.ok_or(NmeaFault::NoFix)?, received_ns)?;
        let tilt_rad = pitch.zip(roll).map(|(pitch, roll)| [pitch, roll]);
        if heading.is_none() && tilt_rad.is_none() {
            return Err(NmeaFault::NoFix);
        }
        let positive = |sigma: Option<f64>| sigma.filter(|sigma| *sigma > 0.0);
        Ok(Navigation {
            time_ns,
            heading_rad: heading,
            tilt_rad,
            heading_sigma_rad: positive(heading_sigma),
            tilt_sigmas_rad: positive(pitch_sigma)
                .zip(positive(roll_sigma))
                .map(|(pitch, roll)| [pitch, roll]),
            ..Navigation::default()
        })
    }

    /// A heading without a time.
    fn heading(&mut self, heading: Option<f64>, received_ns: Option<i64>) -> Result<Navigation, NmeaFault> {
        let heading_rad = heading.ok_or(NmeaFault::NoFix)?;
        let time_ns = received_ns.or(self.stated_ns).ok_or(NmeaFault::NoDate)?;
        let rate = self.heading.map_or(0.0, |(before_ns, before_rad)| {
            let over_ns = time_ns.saturating_sub(before_ns);
            let arc = (heading_rad - before_rad + PI).rem_euclid(TAU) - PI;
            match (1..=RATE_OVER_MAX_NS).contains(&over_ns) {
                true => arc / (over_ns as f64 / NS_PER_S),
                false => 0.0,
            }
        });
        self.heading = Some((time_ns, heading_rad));
        let late = rate * self.settings.receipt_sigma_s;
        Ok(Navigation {
            time_ns,
            heading_rad: Some(heading_rad),
            heading_sigma_rad: Some(self.settings.heading_sigma_rad.hypot(late)),
            ..Navigation::default()
        })
    }

    /// The time of a time of day, of the day that brings it nearest to what is known of the time.
    fn day(&mut self, time_of_day_ns: i64, received_ns: Option<i64>) -> Result<i64, NmeaFault> {
        let near_ns = received_ns.or(self.stated_ns).ok_or(NmeaFault::NoDate)?;
        let midnight_ns = near_ns.div_euclid(NS_PER_DAY) * NS_PER_DAY;
        let days = [-NS_PER_DAY, 0, NS_PER_DAY].map(|days| midnight_ns.saturating_add(days + time_of_day_ns));
        let nearest = days.into_iter().min_by_key(|time_ns| time_ns.abs_diff(near_ns));
        let time_ns = nearest.ok_or(NmeaFault::NoDate)?;
        self.note(time_of_day_ns, time_ns);
        Ok(time_ns)
    }

    fn note(&mut self, time_of_day_ns: i64, time_ns: i64) {
        self.counts.leap_seconds += u64::from(time_of_day_ns >= NS_PER_DAY);
        self.stated_ns = Some(time_ns);
    }
}

/// East and north. A platform at rest has no course.
fn velocity(knots: Option<f64>, course: Option<f64>) -> Option<[f64; 2]> {
    let speed_mps = knots? * KNOT_MPS;
    match course {
        Some(course) => Some([speed_mps * course.sin(), speed_mps * course.cos()]),
        None => (speed_mps < 0.5).then_some([0.0; 2]),
    }
}
