//! Parser of a line.

use std::fmt;
use std::ops::RangeInclusive;
use std::str::FromStr;

use messages::{Callsign, IdentityText};

pub(crate) const M_PER_FT: f64 = 0.3048;
pub(crate) const MPS_PER_KT: f64 = 1852.0 / 3600.0;
/// Values that a message must have: up to the times. Those that are missing at the end are empty.
const VALUES_MIN: usize = 10;
/// Values that have a meaning; some programs append more.
const VALUES_MAX: usize = 22;
/// Characters of a value that an error shows.
const SHOWN_MAX: usize = 40;

/// Altitudes that transponders can code, feet: from the lowest to the highest of both codings.
pub(crate) const ALTITUDE_FT: RangeInclusive<f64> = -1_500.0..=126_750.0;
/// Speeds that transponders can code, knots, with some margin for slow additions.
pub(crate) const SPEED_KT: RangeInclusive<f64> = 0.0..=6_000.0;
/// Vertical rates that transponders can code, feet per minute.
pub(crate) const VERTICAL_RATE_FTPMIN: RangeInclusive<f64> = -32_640.0..=32_640.0;

/// One line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SbsLine {
    /// `MSG`: something that an aircraft sent.
    Message(SbsMessage),
    /// Something that happened at the receiver.
    Other(OtherKind),
}

/// Message of an aircraft, with the content of a single transmission.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SbsMessage {
    /// Number of the transmission, 1 to 8: identification, surface position, airborne position, velocity, altitude,
    /// altitude and code, air to air, all-call.
    pub transmission: u8,
    /// 24-bit address of the aircraft.
    pub address: u32,
    /// Time of receipt, by the receiver's clock.
    pub received: SbsTime,
    /// Time at which the line was written, by the computer's clock.
    pub written: SbsTime,
    /// Callsign, padded with blanks.
    pub callsign: Option<Callsign>,
    /// Pressure altitude, metres.
    pub altitude_m: Option<f64>,
    /// Ground speed, metres per second.
    pub ground_speed_mps: Option<f64>,
    /// Direction of motion over ground, radians clockwise from north.
    pub track_rad: Option<f64>,
    /// Latitude and longitude, radians.
    pub position_rad: Option<[f64; 2]>,
    /// Rate of climb, metres per second.
    pub vertical_rate_mps: Option<f64>,
    /// Mode 3/A code. Receivers write 0000 for an unknown code; 0000 is therefore treated as unknown.
    pub mode_3a: Option<u16>,
    /// Whether the code has changed lately.
    pub alert: Option<bool>,
    /// Whether the code is one of an emergency.
    pub emergency: Option<bool>,
    /// Whether the pilot has pressed the identification button.
    pub identifies: Option<bool>,
    /// Whether the aircraft reports itself on the ground.
    pub on_ground: Option<bool>,
}

impl SbsMessage {
    /// Time of day in the receiver's zone, nanoseconds: of reception, else of writing.
    pub fn stamped_ns(&self) -> Option<i64> {
        self.received.time_of_day_ns.or(self.written.time_of_day_ns)
    }
}

/// A date and a time of day, of an unknown zone, each of which may be missing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SbsTime {
    /// The date.
    pub date: Option<Date>,
    /// Time of day, nanoseconds since midnight.
    pub time_of_day_ns: Option<i64>,
}

/// A date, not checked against the lengths of months.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Date {
    /// The year.
    pub year: u16,
    /// The month, 1 to 12.
    pub month: u8,
    /// The day of the month, 1 to 31.
    pub day: u8,
}

/// Kinds of line without data about aircraft.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OtherKind {
    /// `SEL`: the user has selected an aircraft.
    Selection,
    /// `ID`: a callsign is shown for the first time.
    Identification,
    /// `AIR`: an aircraft is shown for the first time.
    Aircraft,
    /// `STA`: an aircraft's line in the window has changed its state.
    Status,
    /// `CLK`: the user has clicked.
    Click,
}

/// Why a line was rejected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum LineRejection {
    /// The line is not text.
    Text,
    /// The line is of no known kind.
    Kind,
    /// The line has too few values.
    Length,
    /// The number of the transmission is not 1 to 8.
    Transmission,
    /// The address is not six hexadecimal digits.
    Address,
    /// A date or time is none.
    Time,
    /// The callsign is not one.
    Callsign,
    /// The altitude cannot be.
    Altitude,
    /// The speed or track cannot be.
    Velocity,
    /// The position is not on the globe, or half of it is missing.
    Position,
    /// The vertical rate cannot be.
    VerticalRate,
    /// The Mode 3/A code is not four octal digits.
    Code,
    /// A flag is no number.
    Flag,
}

/// Fault of a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SbsError<'a> {
    /// Why it was rejected.
    pub rejection: LineRejection,
    /// Place of the value in the line, from 1; 0 if the line as a whole is wrong.
    pub place: usize,
    /// The value as written, or the line.
    pub value: &'a str,
}

impl std::error::Error for SbsError<'_> {}

impl fmt::Display for SbsError<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let shown: String = self.value.chars().take(SHOWN_MAX).collect();
        match self.place {
            0 => write!(f, "line {shown:?} {}", self.rejection.sentence()),
            place => write!(f, "value {place} {shown:?} {}", self.rejection.sentence()),
        }
    }
}

impl LineRejection {
    /// Every reason, in the order of its code.
    pub const ALL: [Self; 13] = [
        Self::Text,
        Self::Kind,
        Self::Length,
        Self::Transmission,
        Self::Address,
        Self::Time,
        Self::Callsign,
        Self::Altitude,
        Self::Velocity,
        Self::Position,
        Self::VerticalRate,
        Self::Code,
        Self::Flag,
    ];

    /// Returns the fault, and the permitted values.
    pub fn sentence(self) -> &'static str {
        match self {
            Self::Text => "is not UTF-8 text",
            Self::Kind => "is none of MSG, SEL, ID, AIR, STA and CLK",
            Self::Length => "has fewer than the 10 values of a message",
            Self::Transmission => "is no transmission; 1 to 8 are",
            Self::Address => "is no address of six hexadecimal digits",
            Self::Time => "is no date like 2026/03/04, or no time like 07:08:09.250",
            Self::Callsign => "is no callsign of up to eight letters and digits",
            Self::Altitude => "is no altitude of -1500 to 126750 ft",
            Self::Velocity => "is no speed of 0 to 6000 kt, or no track of 0 to 360 degrees",
            Self::Position => "is no latitude of -90 to 90 with a longitude of -180 to 180 degrees",
            Self::VerticalRate => "is no vertical rate of -32640 to 32640 ft/min",
            Self::Code => "is no code of up to four octal digits",
            Self::Flag => "is no flag: 0 for no, another whole number for yes",
        }
    }
}

impl SbsLine {
    /// Reads a line without its end.
    ///
    /// # Errors
    /// [`SbsError`] for the first value that cannot be meant; then nothing of the line is used.
    pub fn parse(line: &[u8]) -> Result<Self, SbsError<'_>> {
        let text = std::str::from_utf8(line).map_err(|_| SbsError {
            rejection: LineRejection::Text,
            place: 0,
            value: "",
        })?;
        let mut values = LineValues {
            line: text,
            found: [""; VALUES_MAX],
        };
        let mut count = 0;
        for (place, value) in values.found.iter_mut().zip(text.split(',')) {
            *place = value.trim();
            count += 1;
        }
        let other = match values.found[0] {
            "MSG" if count < VALUES_MIN => return Err(values.whole(LineRejection::Length)),
            "MSG" => return values.message().map(Self::Message),
            "SEL" => OtherKind::Selection,
            "ID" => OtherKind::Identification,
            "AIR" => OtherKind::Aircraft,
            "STA" => OtherKind::Status,
            "CLK" => OtherKind::Click,
            _ => return Err(values.whole(LineRejection::Kind)),
        };
        Ok(Self::Other(other))
    }
}

/// The values of a line, without blanks around them.
struct LineValues<'a> {
    line: &'a str,
    found: [&'a str; VALUES_MAX],
}

impl<'a> LineValues<'a> {
    fn message(&self) -> Result<SbsMessage, SbsError<'a>> {
        let transmission = self.required(2, LineRejection::Transmission, |text| {
            text.parse().ok().filter(|kind| (1..=8).contains(kind))
        })?;
        let speed_kt = self.number(13, LineRejection::Velocity, SPEED_KT)?;
        let altitude_ft = self.number(12, LineRejection::Altitude, ALTITUDE_FT)?;
        let rate_ftpmin = self.number(17, LineRejection::VerticalRate, VERTICAL_RATE_FTPMIN)?;
        let track_degrees = self.number(14, LineRejection::Velocity, 0.0..=360.0)?;
        Ok(SbsMessage {
            transmission,
            address: self.required(5, LineRejection::Address, address)?,
            received: self.stamp(7)?,
            written: self.stamp(9)?,
            callsign: self.optional(11, LineRejection::Callsign, callsign)?,
            altitude_m: altitude_ft.map(|altitude| altitude * M_PER_FT),
            ground_speed_mps: speed_kt.map(|speed| speed * MPS_PER_KT),
            track_rad: track_degrees.map(f64::to_radians),
            position_rad: self.position()?,
            vertical_rate_mps: rate_ftpmin.map(|rate| rate * M_PER_FT / 60.0),
            mode_3a: self.optional(18, LineRejection::Code, code)?.filter(|code| *code != 0),
            alert: self.flag(19)?,
            emergency: self.flag(20)?,
            identifies: self.flag(21)?,
            on_ground: self.flag(22)?,
        })
    }

    fn position(&self) -> Result<Option<[f64; 2]>, SbsError<'a>> {
        let latitude = self.number(15, LineRejection::Position, -90.0..=90.0)?;
        let longitude = self.number(16, LineRejection::Position, -180.0..=180.0)?;
        match (latitude, longitude) {
            (Some(latitude), Some(longitude)) => Ok(Some([latitude.to_radians(), longitude.to_radians()])),
            (None, None) => Ok(None),
            (None, Some(_)) => Err(self.error(15, LineRejection::Position)),
            (Some(_), None) => Err(self.error(16, LineRejection::Position)),
        }
    }

    /// The date at `place` and the time behind it.
    fn stamp(&self, place: usize) -> Result<SbsTime, SbsError<'a>> {
        Ok(SbsTime {
            date: self.optional(place, LineRejection::Time, date)?,
            time_of_day_ns: self.optional(place + 1, LineRejection::Time, time_of_day_ns)?,
        })
    }

    fn flag(&self, place: usize) -> Result<Option<bool>, SbsError<'a>> {
        let flag = |text: &str| text.parse::<i32>().ok().map(|number| number != 0);
        self.optional(place, LineRejection::Flag, flag)
    }

    fn number(
        &self,
        place: usize,
        rejection: LineRejection,
        limits: RangeInclusive<f64>,
    ) -> Result<Option<f64>, SbsError<'a>> {
        // Limits refuse NaN and infinity too.
        let number = |text: &str| text.parse().ok().filter(|number| limits.contains(number));
        self.optional(place, rejection, number)
    }

    /// The value at `place`, `None` if it is empty.
    fn optional<T>(
        &self,
        place: usize,
        rejection: LineRejection,
        read: impl FnOnce(&str) -> Option<T>,
    ) -> Result<Option<T>, SbsError<'a>> {
        match self.found[place - 1] {
            "" => Ok(None),
            _ => self.required(place, rejection, read).map(Some),
        }
    }

    fn required<T>(
        &self,
        place: usize,
        rejection: LineRejection,
        read: impl FnOnce(&str) -> Option<T>,
    ) -> Result<T, SbsError<'a>> {
        read(self.found[place - 1]).ok_or_else(|| self.error(place, rejection))
    }

    fn error(&self, place: usize, rejection: LineRejection) -> SbsError<'a> {
        SbsError {
            rejection,
            place,
            value: self.found[place - 1],
        }
    }

    fn whole(&self, rejection: LineRejection) -> SbsError<'a> {
        SbsError {
            rejection,
            place: 0,
            value: self.line,
        }
    }
}

/// Addresses that no aircraft has, which some programs mark with a tilde, are none here.
fn address(text: &str) -> Option<u32> {
    let number = IdentityText::ADDRESS.read(text);
    number.filter(|_| text.len() == IdentityText::ADDRESS.digits)
}

/// A callsign, padded with blanks.
pub(crate) fn callsign(text: &str) -> Option<Callsign> {
    let mut callsign = *b"        ";
    callsign.get_mut(..text.len())?.copy_from_slice(text.as_bytes());
    let fits = |octet: u8| octet.is_ascii_uppercase() || octet.is_ascii_digit() || octet == b' ';
    text.bytes().all(fits).then_some(callsign)
}

fn code(text: &str) -> Option<u16> {
    IdentityText::MODE_3A.read(text).map(|code| code as u16)
}

fn date(text: &str) -> Option<Date> {
    let mut parts = text.split('/');
    let date = Date {
        year: whole(parts.next()?, 4)?,
        month: whole(parts.next()?, 2)?,
        day: whole(parts.next()?, 2)?,
    };
    let fits = (1..=12).contains(&date.month) && (1..=31).contains(&date.day);
    (fits && parts.next().is_none()).then_some(date)
}

fn time_of_day_ns(text: &str) -> Option<i64> {
    let (clock, fraction) = text.split_once('.').unwrap_or((text, "0"));
    let mut parts = clock.split(':');
    let mut next = |limit: i64| whole::<i64>(parts.next()?, 2).filter(|part| *part < limit);
    let seconds = (next(24)? * 60 + next(60)?) * 60 + next(60)?;
    let digits = u32::try_from(fraction.len()).ok().filter(|digits| *digits <= 9)?;
    let fraction_ns = whole::<i64>(fraction, 9)? * 10i64.pow(9 - digits);
    parts.next().is_none().then_some(seconds * 1_000_000_000 + fraction_ns)
}

/// A number of at most `digits_max` digits and nothing else.
fn whole<T: FromStr>(text: &str, digits_max: usize) -> Option<T> {
    let plain = text.len() <= digits_max && text.bytes().all(|octet| octet.is_ascii_digit());
    text.parse().ok().filter(|_| plain)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn message(line: &str) -> SbsMessage {
        match SbsLine::parse(line.as_bytes()) {
            Ok(SbsLine::Message(message)) => message,
            other => panic!("{line}: {other:?}"),
        }
    }

    #[test]
    fn an_airborne_position_has_position_altitude_and_flags() {
        let found = message(
            "MSG,3,1,1,3C1A2B,1,2026/03/04,07:08:09.250,2026/03/04,07:08:09.500,,31000,,,48.25,-11.5,,,0,-1,0,0",
        );
        let day = Date {
            year: 2026,
            month: 3,
            day: 4,
        };
        let stamp = |ms: i64| SbsTime {
            date: Some(day),
            time_of_day_ns: Some(((7 * 3600 + 8 * 60 + 9) * 1000 + ms) * 1_000_000),
        };
        let expected = SbsMessage {
            transmission: 3,
            address: 0x3c_1a2b,
            received: stamp(250),
            written: stamp(500),
            altitude_m: Some(9_448.8),
            position_rad: Some([48.25f64.to_radians(), (-11.5f64).to_radians()]),
            alert: Some(false),
            emergency: Some(true),
            identifies: Some(false),
            on_ground: Some(false),
            ..SbsMessage::default()
        };
        assert!((found.altitude_m.unwrap() - 9_448.8).abs() < 1e-9);
        let found = SbsMessage {
            altitude_m: expected.altitude_m,
            ..found
        };
        assert_eq!(found, expected);
    }

    #[test]
    fn a_velocity_is_in_metres_and_radians() {
        let found = message("MSG,4,1,2,3c1a2b,3,,,,,,,100,90.0,,,-600,,,,,");
        assert!((found.ground_speed_mps.unwrap() - 51.444_444).abs() < 1e-5);
        assert!((found.track_rad.unwrap() - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
        assert!((found.vertical_rate_mps.unwrap() + 3.048).abs() < 1e-12);
        assert_eq!((found.received, found.on_ground), (SbsTime::default(), None));
    }

    #[test]
    fn lines_may_have_blanks_and_be_cut_short_or_long() {
        let found = message("MSG,1, 0,  0,3C1A2B, 0,2026/03/04,07:08:09.250,,,ABC12   ");
        assert_eq!(found.callsign, Some(*b"ABC12   "));
        let found = message("MSG,6,1,1,3C1A2B,1,,,,,,,,,,,,0417,0,0,0,0,extra,0.5");
        assert_eq!((found.mode_3a, found.on_ground), (Some(0o417), Some(false)));
        assert_eq!(message("MSG,6,1,1,3C1A2B,1,,,,,,,,,,,,0000,,,,").mode_3a, None);
        assert_eq!(message("MSG,8,1,1,3C1A2B,1,,,,,,,,,,,,,,,,1").on_ground, Some(true));
    }

    #[test]
    fn other_kinds_are_known() {
        for (line, kind) in [
            (
                "SEL,,1,2,3C1A2B,3,2026/03/04,07:08:09.250,,,ABC12",
                OtherKind::Selection,
            ),
            ("ID ,,1,2,3C1A2B,3", OtherKind::Identification),
            ("AIR,,1", OtherKind::Aircraft),
            ("STA,,1,2,3C1A2B,3,,,,,RM", OtherKind::Status),
            ("CLK,,1,-1,,-1", OtherKind::Click),
        ] {
            assert_eq!(SbsLine::parse(line.as_bytes()), Ok(SbsLine::Other(kind)), "{line}");
        }
    }

    #[test]
    fn what_cannot_be_meant_is_rejected_with_place_and_reason() {
        const GOOD: [&str; VALUES_MAX] = [
            "MSG", "3", "1", "1", "3C1A2B", "1", "", "", "", "", "", "", "", "", "51.5", "-1.0", "", "", "", "", "", "",
        ];
        message(&GOOD.join(","));
        for (place, value, rejection) in [
            (2, "9", LineRejection::Transmission),
            (2, "", LineRejection::Transmission),
            (5, "", LineRejection::Address),
            (5, "~3C1A2B", LineRejection::Address),
            (5, "3C1A2G", LineRejection::Address),
            (5, "+3C1A2", LineRejection::Address),
            (7, "04/03/2026", LineRejection::Time),
            (7, "2026/13/01", LineRejection::Time),
            (8, "24:00:00.000", LineRejection::Time),
            (8, "12:00", LineRejection::Time),
            (8, "12:00:00.0000000001", LineRejection::Time),
            (8, "12:00:00.-5", LineRejection::Time),
            (10, "12:00:60", LineRejection::Time),
            (11, "NINECHARS", LineRejection::Callsign),
            (11, "A?B", LineRejection::Callsign),
            (12, "130000", LineRejection::Altitude),
            (12, "NaN", LineRejection::Altitude),
            (13, "-1", LineRejection::Velocity),
            (14, "361", LineRejection::Velocity),
            (15, "90.1", LineRejection::Position),
            (15, "", LineRejection::Position),
            (16, "", LineRejection::Position),
            (16, "inf", LineRejection::Position),
            (17, "1e9", LineRejection::VerticalRate),
            (18, "7800", LineRejection::Code),
            (18, "01234", LineRejection::Code),
            (19, "x", LineRejection::Flag),
            (22, "0.5", LineRejection::Flag),
        ] {
            let mut values = GOOD;
            values[place - 1] = value;
            let line = values.join(",");
            let error = SbsLine::parse(line.as_bytes()).unwrap_err();
            assert_eq!(
                error,
                SbsError {
                    rejection,
                    place,
                    value
                },
                "{line}"
            );
        }
        let whole = |line: &'static [u8]| SbsLine::parse(line).unwrap_err();
        assert_eq!(whole(b"").rejection, LineRejection::Kind);
        assert_eq!(whole(b"MLAT,3,1,1,3C1A2B").rejection, LineRejection::Kind);
        assert_eq!(whole(b"MSG,3,1,1,3C1A2B,1,,,").rejection, LineRejection::Length);
        assert_eq!(whole(b"MSG,3,1,1,\xff").rejection, LineRejection::Text);
        let text = SbsLine::parse(b"MSG,3,1,1,3C1A2B,1,,,,,,99,,,100,0")
            .unwrap_err()
            .to_string();
        assert_eq!(
            text,
            "value 15 \"100\" is no latitude of -90 to 90 with a longitude of -180 to 180 degrees"
        );
    }

    #[test]
    fn every_reason_stands_at_the_place_of_its_code() {
        for (place, rejection) in LineRejection::ALL.into_iter().enumerate() {
            assert_eq!(rejection as usize, place);
        }
    }

    proptest! {
        #[test]
        fn any_octets_are_a_line_or_an_error(octets in prop::collection::vec(any::<u8>(), 0..200)) {
            let _ = SbsLine::parse(&octets);
        }

        #[test]
        fn any_values_are_a_message_or_an_error(values in prop::collection::vec("[-+.:/0-9a-fA-F]{0,8}", 0..25)) {
            let _ = SbsLine::parse(format!("MSG,3,,,ABCDEF,{}", values.join(",")).as_bytes()).map_err(|error| error.to_string());
        }

        #[test]
        fn times_of_day_are_read_to_the_last_digit(ms in 0i64..86_400_000) {
            let (seconds, rest) = (ms / 1000, ms % 1000);
            let text = format!("{:02}:{:02}:{:02}.{rest:03}", seconds / 3600, seconds / 60 % 60, seconds % 60);
            prop_assert_eq!(time_of_day_ns(&text), Some(ms * 1_000_000));
        }
    }
}
