//! Frames in a stream of octets.
//!
//! Receivers pass frames on in forms without a standard; the sources are the programs that write them (dump1090 and
//! its successors, jet1090) and the manual of the Mode-S Beast. The reader accepts all of them and needs no choice:
//!
//! - Beast: an escape octet 0x1a, the kind, six octets of ticks, the signal level and the frame, in which each 0x1a is
//!   doubled. No text contains an escape octet.
//! - Lines: `*HEX;`, `@` with twelve digits of ticks, `<` with ticks and two digits of signal level, HEX alone, a time
//!   in seconds since 1970 and HEX, or JSON with `timestamp` and `frame`.
//!
//! After damage, the reader continues at the next escape octet or line. What lies between is refused as a line or, in
//! a stream that has had a message of Beast, counted by its octets. The memory of the reader is one line.

use frames::time::NS_PER_S;
use serde::Deserialize;

use super::frame::ModeSFrame;
use super::refusal::ModeSRefusal;

/// Longest line, octets.
pub const LINE_OCTETS_MAX: usize = 4096;

/// Octet before each message of Beast.
const ESCAPE: u8 = 0x1a;
/// Octets of a message of Beast before its frame: kind, ticks, signal level.
const BEAST_HEAD: usize = 8;
/// Kinds of messages of Beast without a frame: status, position, and identity of the receiver.
const OTHER_KINDS: [u8; 4] = [b'4', b'5', 0xe3, 0xe4];
/// Hexadecimal digits of ticks.
const TICK_DIGITS: usize = 12;
/// Ticks that mark a frame without any, as writers of Beast do: none, and results of multilateration or UAT.
const NO_TICKS: [u64; 3] = [0, 0xff00_4d4c_4154, 0xff00_4d4c_4155];
/// Latest time of a line, seconds since 1970: what nanoseconds in 64 bits can hold.
const TIME_MAX_S: i64 = 9_000_000_000;

/// Time stamp of a frame in its stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrameStamp {
    /// None.
    None,
    /// Ticks of 12 MHz since the receiver's start, 48 bits.
    Ticks(u64),
    /// UTC, nanoseconds since 1970.
    Utc(i64),
}

/// What stands in the stream.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Framed {
    /// A frame with its time stamp.
    Frame(ModeSFrame, FrameStamp),
    /// A message without a frame of Mode S.
    Other,
    /// A frame that cannot be read.
    Refused(ModeSRefusal),
}

/// Reader of the frames of one stream.
#[derive(Clone, Debug)]
pub struct FrameReader {
    /// What has come of the line, or of the message of Beast after its escape octet.
    begun: Vec<u8>,
    state: State,
    /// Whether a message of Beast has come.
    is_beast: bool,
    damaged_octets: u64,
}

/// Where in the stream the next octet stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    Line,
    /// In a line that is too long.
    LongLine,
    /// Between messages of Beast, or in one that is not read.
    Outside,
    /// In a message of Beast.
    Message,
    /// Behind an escape octet, outside or in a message.
    Escape {
        inside: bool,
    },
}

#[derive(Deserialize)]
struct JsonLine<'a> {
    timestamp: Option<f64>,
    frame: &'a str,
}

impl Default for FrameReader {
    /// A reader at the beginning of a stream.
    fn default() -> Self {
        Self {
            begun: Vec::with_capacity(LINE_OCTETS_MAX),
            state: State::Line,
            is_beast: false,
            damaged_octets: 0,
        }
    }
}

impl FrameReader {
    /// Octets between messages of Beast, which belong to none.
    pub fn damaged_octets(&self) -> u64 {
        self.damaged_octets
    }

    /// Takes octets of the stream. Frames may begin and end anywhere.
    pub fn take(&mut self, octets: &[u8], each: &mut impl FnMut(Framed)) {
        for octet in octets {
            self.state = match self.state {
                State::Line | State::LongLine => self.take_of_line(*octet, each),
                State::Escape { inside } => self.take_escaped(*octet, inside, each),
                State::Outside if *octet == ESCAPE => State::Escape { inside: false },
                State::Outside => {
                    self.damaged_octets += 1;
                    if b"\r\n".contains(octet) {
                        State::Line
                    } else {
                        State::Outside
                    }
                }
                State::Message if *octet == ESCAPE => State::Escape { inside: true },
                State::Message => self.take_of_message(*octet, each),
            };
        }
    }

    /// The stream has ended: what has begun is a line, or was cut.
    pub fn end(&mut self, each: &mut impl FnMut(Framed)) {
        match self.state {
            State::Line => self.end_line(each),
            State::Message | State::Escape { inside: true } => each(Framed::Refused(ModeSRefusal::Cut)),
            State::LongLine | State::Outside | State::Escape { .. } => {}
        }
        self.begun.clear();
        self.state = State::Line;
        self.is_beast = false;
    }

    fn take_of_line(&mut self, octet: u8, each: &mut impl FnMut(Framed)) -> State {
        match octet {
            ESCAPE => {
                self.damaged_octets += self.begun.len() as u64;
                self.begun.clear();
                return State::Escape { inside: false };
            }
            b'\n' | b'\r' => self.end_line(each),
            _ if self.state == State::LongLine => return State::LongLine,
            b';' if self.begun.first().is_some_and(|first| b"*@<".contains(first)) => self.end_line(each),
            _ if self.begun.len() == LINE_OCTETS_MAX => {
                each(Framed::Refused(ModeSRefusal::LineLength));
                self.begun.clear();
                return State::LongLine;
            }
            _ => self.begun.push(octet),
        }
        State::Line
    }

    fn end_line(&mut self, each: &mut impl FnMut(Framed)) {
        let line = self.begun.trim_ascii();
        match framed(line) {
            _ if line.is_empty() => {}
            Ok(framed) => each(framed),
            Err(_) if self.is_beast => self.damaged_octets += line.len() as u64,
            Err(refusal) => each(Framed::Refused(refusal)),
        }
        self.begun.clear();
    }

    /// Takes the octet behind an escape octet: another one of these, or the kind of the next message.
    fn take_escaped(&mut self, octet: u8, inside: bool, each: &mut impl FnMut(Framed)) -> State {
        if octet == ESCAPE && inside {
            return self.take_of_message(octet, each);
        }
        if inside {
            each(Framed::Refused(ModeSRefusal::Cut));
            self.begun.clear();
        }
        match octet {
            b'1'..=b'3' => {
                self.begun.push(octet);
                State::Message
            }
            _ if OTHER_KINDS.contains(&octet) => {
                each(Framed::Other);
                State::Outside
            }
            _ => {
                self.damaged_octets += 2;
                State::Outside
            }
        }
    }

    fn take_of_message(&mut self, octet: u8, each: &mut impl FnMut(Framed)) -> State {
        self.begun.push(octet);
        let (head, frame) = self.begun.split_at(BEAST_HEAD.min(self.begun.len()));
        let octets = match head[0] {
            b'1' => 2,
            b'2' => ModeSFrame::SHORT,
            _ => ModeSFrame::LONG,
        };
        if frame.len() < octets {
            return State::Message;
        }
        let ticks = head[1..7].iter().fold(0, |ticks, octet| ticks << 8 | u64::from(*octet));
        each(ModeSFrame::new(frame).map_or(Framed::Other, |frame| Framed::Frame(frame, stamp(ticks))));
        self.begun.clear();
        self.is_beast = true;
        State::Outside
    }
}

fn stamp(ticks: u64) -> FrameStamp {
    match NO_TICKS.contains(&ticks) {
        true => FrameStamp::None,
        false => FrameStamp::Ticks(ticks),
    }
}

/// What stands in a line without its end.
fn framed(line: &[u8]) -> Result<Framed, ModeSRefusal> {
    let begins_with_ticks = |skipped: usize| {
        let (ticks, rest) = line[1..].split_at_checked(TICK_DIGITS).ok_or(ModeSRefusal::Length)?;
        let frame = rest.get(skipped..).ok_or(ModeSRefusal::Length)?;
        of_hex(frame, stamp(hex(ticks)? as u64))
    };
    match line.first().copied().unwrap_or_default() {
        b'*' => of_hex(&line[1..], FrameStamp::None),
        b'@' => begins_with_ticks(0),
        b'<' => begins_with_ticks(2),
        b'{' => of_json(line),
        _ => {
            let is_between = |octet: &u8| b" \t,".contains(octet);
            let mut words = line.split(is_between).filter(|word| !word.is_empty());
            match (words.next(), words.next(), words.next()) {
                (Some(frame), None, None) => of_hex(frame, FrameStamp::None),
                (Some(time), Some(frame), None) => of_hex(frame, FrameStamp::Utc(utc_ns(time)?)),
                _ => Err(ModeSRefusal::Line),
            }
        }
    }
}

fn of_json(line: &[u8]) -> Result<Framed, ModeSRefusal> {
    let line: JsonLine<'_> = serde_json::from_slice(line).map_err(|_| ModeSRefusal::Line)?;
    let stamp = match line.timestamp {
        None => FrameStamp::None,
        // The bounds refuse NaN, too.
        Some(time_s) if (0.0..=TIME_MAX_S as f64).contains(&time_s) => {
            FrameStamp::Utc(time_s as i64 * NS_PER_S + frames::time::ns(time_s.fract()))
        }
        Some(_) => return Err(ModeSRefusal::Time),
    };
    of_hex(line.frame.as_bytes(), stamp)
}

/// A frame in hexadecimal digits; four digits are a reply of Mode A or C.
fn of_hex(digits: &[u8], stamp: FrameStamp) -> Result<Framed, ModeSRefusal> {
    let digits = digits.trim_ascii();
    let octets = match digits.len() {
        4 => return hex(digits).map(|_| Framed::Other),
        14 => ModeSFrame::SHORT,
        28 => ModeSFrame::LONG,
        _ if digits.iter().all(u8::is_ascii_hexdigit) => return Err(ModeSRefusal::Length),
        _ => return Err(ModeSRefusal::Character),
    };
    let bits = hex(digits)?.to_be_bytes();
    let frame = ModeSFrame::new(&bits[bits.len() - octets..]).ok_or(ModeSRefusal::Length)?;
    Ok(Framed::Frame(frame, stamp))
}

fn hex(digits: &[u8]) -> Result<u128, ModeSRefusal> {
    digits.iter().try_fold(0, |bits, digit| {
        let digit = (*digit as char).to_digit(16).ok_or(ModeSRefusal::Character)?;
        Ok(bits << 4 | u128::from(digit))
    })
}

/// Seconds since 1970 with at most nine decimals, exactly.
fn utc_ns(text: &[u8]) -> Result<i64, ModeSRefusal> {
    let text = std::str::from_utf8(text).map_err(|_| ModeSRefusal::Time)?;
    let (whole, fraction) = text.split_once('.').unwrap_or((text, "0"));
    let number = |digits: &str, length_max: usize| {
        let is_plain = digits.len() <= length_max && digits.bytes().all(|digit| digit.is_ascii_digit());
        digits
            .parse::<i64>()
            .ok()
            .filter(|_| is_plain)
            .ok_or(ModeSRefusal::Time)
    };
    let whole_s = number(whole, 10).and_then(|whole_s| match whole_s {
        0..=TIME_MAX_S => Ok(whole_s),
        _ => Err(ModeSRefusal::Time),
    })?;
    Ok(whole_s * NS_PER_S + number(fraction, 9)? * 10i64.pow(9 - fraction.len() as u32))
}
