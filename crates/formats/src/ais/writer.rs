//! Messages of ships as sentences: what a simulated receiver of AIS sends.
//!
//! Positions are of type 1 (class A) and 18 (class B), static data of type 5 and 24 (parts A and B), laid out by tables
//! 48, 52, 70, 74 and 75 of recommendation ITU-R M.1371-5. Six bits make a character of the payload (IEC 61162-1), and
//! a sentence has at most 60 of them: static data of class A come in two sentences.
//!
//! Values are rounded to the steps of the messages, and cut to their ranges; values that are not available have the
//! codes for that. Not simulated: rate of turn, voyage (draught, destination, time of arrival), and the state of the
//! radio, which are sent as not available.

use std::fmt::Write as _;

/// Characters of a payload in a sentence.
const PART_MAX: usize = 60;
/// Parts of a degree in which coordinates are sent.
const PER_DEGREE: f64 = 600_000.0;

/// Class of a ship's equipment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AisClass {
    /// Ships that have to carry AIS.
    A,
    /// Other ships.
    B,
}

/// Report of a position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AisPosition {
    /// Number of the station.
    pub mmsi: u32,
    /// Class of its equipment.
    pub class: AisClass,
    /// Latitude and longitude of the antenna, degrees.
    pub position_deg: [f64; 2],
    /// Whether the position is better than 10 m.
    pub is_accurate: bool,
    /// Speed over ground, knots.
    pub speed_kt: f64,
    /// Course over ground, degrees from true north.
    pub course_deg: f64,
    /// True heading, degrees; `None` without a compass.
    pub heading_deg: Option<f64>,
    /// Second of the minute at which the position was measured, 0 to 59.
    pub second: u8,
    /// Navigation status, 0 to 15; of class A only.
    pub navigation: u8,
}

/// Static data.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AisStaticData<'a> {
    /// Number of the station.
    pub mmsi: u32,
    /// Class of its equipment.
    pub class: AisClass,
    /// Name, up to 20 characters of ASCII from space to `_`.
    pub name: &'a str,
    /// Call sign, up to 7 such characters.
    pub callsign: &'a str,
    /// Type of ship and cargo, 0 to 255.
    pub ship_type: u8,
    /// Distances from the antenna to bow and stern, 0 to 511 m, to port and starboard, 0 to 63 m.
    pub distances_m: [u16; 4],
}

impl AisPosition {
    /// Appends the report, as received on `channel` (`A` or `B`).
    pub fn write(&self, channel: char, out: &mut String) {
        let mut bits = Bits::default();
        let speed = (self.speed_kt * 10.0).round().clamp(0.0, 1022.0) as u64;
        let course = (self.course_deg * 10.0).round().rem_euclid(3600.0) as u64;
        let heading = self
            .heading_deg
            .map_or(511, |degrees| degrees.round().rem_euclid(360.0) as u64);
        let [latitude, longitude] = self
            .position_deg
            .map(|degrees| (degrees * PER_DEGREE).round() as i64 as u64);
        let (is_accurate, second) = (u64::from(self.is_accurate), u64::from(self.second.min(59)));
        let moving = [
            (speed, 10),
            (is_accurate, 1),
            (longitude, 28),
            (latitude, 27),
            (course, 12),
            (heading, 9),
            (second, 6),
        ];
        match self.class {
            AisClass::A => {
                const NO_RATE_OF_TURN: u64 = 0x80;
                bits.head(1, self.mmsi);
                bits.all(&[(u64::from(self.navigation.min(15)), 4), (NO_RATE_OF_TURN, 8)]);
                bits.all(&moving);
                // Manoeuvre, spare, integrity monitoring, state of the radio.
                bits.all(&[(0, 2), (0, 3), (0, 1), (0, 19)]);
            }
            AisClass::B => {
                const CARRIER_SENSE: u64 = 1;
                bits.head(18, self.mmsi);
                bits.all(&[(0, 8)]);
                bits.all(&moving);
                // Spare, carrier sense, display and other equipment, integrity monitoring, state of the radio.
                bits.all(&[(0, 2), (CARRIER_SENSE, 1), (0, 6), (0, 20)]);
            }
        }
        bits.write((channel, 0), out);
    }
}

impl AisStaticData<'_> {
    /// Appends the data, as received on `channel` (`A` or `B`); `sequence` (0 to 9) joins the sentences of a message.
    pub fn write(&self, channel: char, sequence: u8, out: &mut String) {
        let [bow, stern, port, starboard] = self.distances_m.map(u64::from);
        let size = [
            (bow.min(511), 9),
            (stern.min(511), 9),
            (port.min(63), 6),
            (starboard.min(63), 6),
        ];
        let ship_type = (u64::from(self.ship_type), 8);
        let mut bits = Bits::default();
        match self.class {
            AisClass::A => {
                const GPS: u64 = 1;
                bits.head(5, self.mmsi);
                // Version; number of the International Maritime Organization, not available.
                bits.all(&[(0, 2), (0, 30)]);
                bits.text(self.callsign, 7);
                bits.text(self.name, 20);
                bits.all(&[ship_type]);
                bits.all(&size);
                // Device, time of arrival (month, day, hour, minute), draught.
                bits.all(&[(GPS, 4), (0, 4), (0, 5), (24, 5), (60, 6), (0, 8)]);
                bits.text("", 20);
                bits.all(&[(1, 1), (0, 1)]);
                bits.write((channel, sequence), out);
            }
            AisClass::B => {
                bits.head(24, self.mmsi);
                bits.all(&[(0, 2)]);
                bits.text(self.name, 20);
                bits.write((channel, sequence), out);
                let mut bits = Bits::default();
                bits.head(24, self.mmsi);
                bits.all(&[(1, 2), ship_type]);
                // Vendor.
                bits.text("", 7);
                bits.text(self.callsign, 7);
                bits.all(&size);
                bits.all(&[(0, 6)]);
                bits.write((channel, sequence), out);
            }
        }
    }
}

/// Bits of a message, by six.
#[derive(Debug, Default)]
struct Bits {
    payload: String,
    pending: u8,
    pending_count: u32,
}

impl Bits {
    /// Type of message, no repetition, station.
    fn head(&mut self, kind: u64, mmsi: u32) {
        self.all(&[(kind, 6), (0, 2), (mmsi.into(), 30)]);
    }

    /// Appends values with their widths, the most significant bit first; negative values in two's complement.
    fn all(&mut self, fields: &[(u64, u32)]) {
        for (value, width) in fields {
            for place in (0..*width).rev() {
                self.pending = self.pending << 1 | (value >> place & 1) as u8;
                self.pending_count += 1;
                if self.pending_count == 6 {
                    self.payload.push(armoured(self.pending));
                    (self.pending, self.pending_count) = (0, 0);
                }
            }
        }
    }

    /// Appends a text in six-bit characters, padded with `@`, which is 0.
    fn text(&mut self, text: &str, length: usize) {
        let characters = text.bytes().map(|octet| match octet.to_ascii_uppercase() {
            octet @ b'@'..=b'_' => octet - b'@',
            octet @ b' '..=b'?' => octet,
            _ => b'?',
        });
        for character in characters.chain(std::iter::repeat(0)).take(length) {
            self.all(&[(character.into(), 6)]);
        }
    }

    /// Appends the sentences of the message.
    fn write(mut self, (channel, sequence): (char, u8), out: &mut String) {
        let fill = (6 - self.pending_count) % 6;
        self.all(&[(0, fill)]);
        let count = self.payload.len().div_ceil(PART_MAX);
        for (place, part) in self.payload.as_bytes().chunks(PART_MAX).enumerate() {
            let number = place + 1;
            let fill = if number == count { fill } else { 0 };
            let begin = out.len();
            // Writing into memory does not fail.
            let _ = match count {
                1 => write!(out, "!AIVDM,1,1,,{channel},"),
                _ => write!(out, "!AIVDM,{count},{number},{},{channel},", sequence % 10),
            };
            out.extend(part.iter().copied().map(char::from));
            let _ = write!(out, ",{fill}");
            let sum = out.bytes().skip(begin + 1).fold(0, |sum, octet| sum ^ octet);
            let _ = write!(out, "*{sum:02X}\r\n");
        }
    }
}

/// Character for six bits.
fn armoured(six: u8) -> char {
    char::from(if six < 40 { b'0' + six } else { b'`' + six - 40 })
}
