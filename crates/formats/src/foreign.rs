//! Kinds of files that are given as recordings of ASTERIX and are none.
//!
//! Raw data blocks have no mark, so that any file could be raw data blocks. Two letters of text are a length of some
//! ten thousand bytes, so that a long text even is a sequence of blocks. Text is therefore recognised first: the length
//! of a block of ASTERIX begins with a byte that no text contains. Other kinds are looked for where little of the file
//! can be decoded: a data block may look like any of them
//! ([`RecordingSurvey::foreign`](crate::recording::RecordingSurvey::foreign)).

use std::fmt;

use crate::containers::{gps, hexadecimal};
use crate::text::{MARK, TEXT_BYTES, text};

/// Lines, or frames, in a row that make a kind certain.
const ENOUGH: usize = 3;
/// Lines at the beginning of a text among which comments and sentences of other kinds may stand.
const LINES_BEFORE: usize = 20;

/// Kind of a file that is no ASTERIX.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Foreign {
    /// No byte.
    Empty,
    /// Recording of all topics.
    Mcap,
    /// Recording of RASS tools, taken for another container.
    Gps,
    /// File of `gzip`.
    Gzip,
    /// Binary frames of transponder receivers.
    Beast,
    /// Sentences of the automatic identification system of ships.
    Ais,
    /// Other sentences of NMEA 0183.
    Nmea,
    /// Lines of transponder receivers.
    Sbs,
    /// Mode S frames as hexadecimal text.
    ModeS,
    /// Data as hexadecimal text, with lines that are no data blocks, or taken for another container.
    Hex,
    /// JSON.
    Json,
    /// XML.
    Xml,
    /// Table of text.
    Csv,
    /// Text in units of two bytes.
    Utf16,
    /// Other text.
    Text,
}

impl Foreign {
    /// Kind of a file that could not be decoded; `None` where that is not known.
    pub fn of(bytes: &[u8]) -> Option<Self> {
        match bytes {
            [] => Some(Self::Empty),
            [0x89, b'M', b'C', b'A', b'P', ..] => Some(Self::Mcap),
            [0x1f, 0x8b, 0x08, ..] => Some(Self::Gzip),
            [0xff, 0xfe, ..] | [0xfe, 0xff, ..] if is_utf16(bytes) => Some(Self::Utf16),
            _ => Self::as_text(bytes).or_else(|| {
                let kinds = [(Self::Beast, is_beast(bytes)), (Self::Gps, gps::begins(bytes))];
                kinds.into_iter().find_map(|(kind, is_it)| is_it.then_some(kind))
            }),
        }
    }

    /// Kind of a file that is text; `None` if it is none.
    pub fn as_text(bytes: &[u8]) -> Option<Self> {
        let text = text(bytes).filter(|_| !bytes.is_empty())?;
        // With times, the lines of a hexadecimal recording are not digits alone.
        match hexadecimal::begins(bytes) {
            true => Some(Self::Hex),
            false => Some(Self::of_text(text.trim_start_matches(MARK))),
        }
    }

    fn of_text(text: &str) -> Self {
        let mut lines = text.lines().map(str::trim).filter(|line| !line.is_empty());
        let is_ais = |line: &str| ["!AIVD", "!BSVD", "!ABVD"].iter().any(|head| line.contains(head));
        // Receivers at sea write the sentences of all their devices, and loggers write a head.
        if lines.clone().take(LINES_BEFORE).any(is_ais) {
            return Self::Ais;
        }
        let first = lines.find(|line| !line.starts_with('#')).unwrap_or_default();
        let is_hex = |line: &str| line.bytes().all(|letter| letter.is_ascii_hexdigit() || letter == b' ');
        let mode_s = |line: &str| {
            let frame = line
                .strip_prefix(['*', '@', '<'])
                .and_then(|line| line.strip_suffix(';'));
            frame.is_some_and(|frame| frame.len() >= 4 && is_hex(frame))
        };
        if first.starts_with(['$', '!']) && first.contains(',') {
            Self::Nmea
        } else if first.starts_with('<') && first.contains('>') {
            Self::Xml
        } else if ["MSG,", "SEL,", "ID,", "AIR,", "STA,", "CLK,"]
            .iter()
            .any(|head| first.starts_with(head))
        {
            Self::Sbs
        } else if mode_s(first) {
            Self::ModeS
        } else if first.starts_with(['{', '[']) {
            Self::Json
        } else if first.len() >= 6 && is_hex(first) {
            Self::Hex
        } else if first.contains(',') && lines.take(ENOUGH).all(|line| line.contains(',')) {
            Self::Csv
        } else {
            Self::Text
        }
    }
}

impl fmt::Display for Foreign {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Empty => "the file is empty",
            Self::Mcap => "it is a recording of all topics (MCAP), which `koseki recording` and `koseki replay` read",
            Self::Gps => "it is a .gps recording (2,200 octets, then data blocks with 10 octets behind each), which is read as the container gps",
            Self::Gzip => "it is compressed by gzip: unpack it",
            Self::Beast => "it is a recording of Beast frames (Mode S), which `koseki open` reads: [source.recorded] format = \"mode-s\"",
            Self::Ais => "it is a log of AIS (ships), which `koseki open` reads: [source.recorded] format = \"ais\"",
            Self::Nmea => "it is a log of NMEA 0183 sentences: `koseki open` reads the targets of a radar (TTM, TLL), and a [[platform]] takes states of own ship live",
            Self::Sbs => "it is an SBS log (BaseStation), which `koseki open` reads: [source.recorded] format = \"sbs\"",
            Self::ModeS => "it is a log of Mode S frames as text (AVR), which `koseki open` reads: [source.recorded] format = \"mode-s\"",
            Self::Hex => "it is hexadecimal text; lines of whole data blocks are read as the container hex, and `koseki open` reads Mode S frames with times: turn other text into octets, as `xxd -r -p` does",
            Self::Json => "it is JSON; `koseki open` reads aircraft of readsb, Mode S frames and Remote ID, `koseki encode` records of ASTERIX",
            Self::Xml => "it is XML; `koseki open` reads events of Cursor on Target",
            Self::Csv => "it is a table of text, which `koseki open` and `koseki fuse` read if a row has a time and a position",
            Self::Utf16 => "it is text in UTF-16: save it as UTF-8",
            Self::Text => "it is text",
        })
    }
}

/// Returns whether most units of two bytes behind the byte order mark are letters of the first 256.
fn is_utf16(bytes: &[u8]) -> bool {
    let high = usize::from(bytes[0] == 0xff);
    let units = bytes[2..bytes.len().min(TEXT_BYTES)].chunks_exact(2);
    let (of_all, latin) = (
        units.len(),
        units.filter(|unit| unit[high] == 0 && unit[1 - high] != 0).count(),
    );
    2 * latin > of_all
}

/// Whether some frames follow each other: an escape, a kind, and so many bytes, of which each escape is there twice.
fn is_beast(bytes: &[u8]) -> bool {
    const ESCAPE: u8 = 0x1a;
    let mut at = 0;
    for _ in 0..ENOUGH {
        let Some([ESCAPE, kind]) = bytes.get(at..at + 2) else {
            return false;
        };
        // Time, signal level, and the message.
        let octets = match kind {
            b'1' => 6 + 1 + 2,
            b'2' => 6 + 1 + 7,
            b'3' => 6 + 1 + 14,
            _ => return false,
        };
        at += 2;
        for _ in 0..octets {
            at += match bytes.get(at..at + 2) {
                Some([ESCAPE, ESCAPE]) => 2,
                _ => 1,
            };
        }
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kinds_are_told_by_their_beginning() {
        let beast = [
            &b"\x1a3"[..],
            &[0; 21],
            b"\x1a1",
            &[7; 9],
            b"\x1a2",
            &[1, 0x1a, 0x1a],
            &[2; 12],
        ]
        .concat();
        let mut gps = vec![0xee; 2_200];
        for length in [9_u8, 30, 12] {
            gps.extend([48, 0, length]);
            gps.extend(vec![1; usize::from(length) - 3 + 10]);
        }
        let utf16: Vec<u8> = "\u{feff}time_s,x\n1,2\n"
            .encode_utf16()
            .flat_map(u16::to_le_bytes)
            .collect();
        let cases: [(&[u8], Option<Foreign>); 24] = [
            (b"", Some(Foreign::Empty)),
            (b"\x89MCAP0\r\n\x01", Some(Foreign::Mcap)),
            (b"\x1f\x8b\x08\0", Some(Foreign::Gzip)),
            (&beast, Some(Foreign::Beast)),
            (&beast[..30], None),
            (&gps, Some(Foreign::Gps)),
            (&gps[..2_260], None),
            (b"!AIVDM,1,1,,A,13u?etPv2;0n:dDPwUM1U1Cb069D,0*24\n", Some(Foreign::Ais)),
            (b"\\s:station,c:1*5A\\!BSVDM,1,1,,A,13u,0*24\n", Some(Foreign::Ais)),
            (b"MSG,3,1,1,4CA2D6,1,2020/01/01,12:00:00.000\n", Some(Foreign::Sbs)),
            (
                b"*8D4840D6202CC371C32CE0576098;\n*02E197B00179C3;\n",
                Some(Foreign::ModeS),
            ),
            (b"\n30 00 08 80 01 02 03 04\n", Some(Foreign::Hex)),
            (b"{\"category\": 48}\n", Some(Foreign::Json)),
            ("\u{feff}{\"category\": 48}\n".as_bytes(), Some(Foreign::Json)),
            (b"time_s,track\n1,2\n3,4\n", Some(Foreign::Csv)),
            (b"# a log\n!AIVDM,1,1,,A,13u?,0*24\n", Some(Foreign::Ais)),
            (
                b"$PGHP,1,2020,1,1,0,0,0,0,338,2,,1,2D*2C\n!AIVDM,1,1,,A,1,0*24\n",
                Some(Foreign::Ais),
            ),
            (b"$GPRMC,1,A,,,,,,,,,*00\n$GPGGA,2*00\n", Some(Foreign::Nmea)),
            (b"<?xml version='1.0'?>\n<event/>\n", Some(Foreign::Xml)),
            (b"# receiver 1\nMSG,3,1,1,4CA2D6,1\n", Some(Foreign::Sbs)),
            (&utf16, Some(Foreign::Utf16)),
            (b"MSG,1,1,1,4CA2D6,1,,,,,K\xe9LM123\n", Some(Foreign::Sbs)),
            ("root:x:0:0:Ω\n".as_bytes(), Some(Foreign::Text)),
            (&[48, 0, 8, 0x80, 1, 2, 3, 4], None),
        ];
        for (bytes, expected) in cases {
            assert_eq!(Foreign::of(bytes), expected, "{:?}", String::from_utf8_lossy(bytes));
        }
        // A character of several bytes at the edge of the examined bytes.
        let long = [&vec![b'x'; TEXT_BYTES - 1][..], "Ω and more".as_bytes()].concat();
        assert_eq!(Foreign::of(&long), Some(Foreign::Text));
    }

    #[test]
    fn long_texts_are_no_gps_recordings() {
        // Behind byte 2,200 their letters are lengths of blocks that follow each other up to the end.
        for (line, kind) in [
            (
                &b"MSG,3,1,1,4CA2D6,1,2020/01/01,12:00:00.000,,,,,,,,\n"[..],
                Foreign::Sbs,
            ),
            (b"{\"hex\": \"abcd01\", \"lat\": 50.0}\n", Foreign::Json),
            (b"!AIVDM,1,1,,A,13u?etPv2;0n:dDPwUM1U1Cb069D,0*24\n", Foreign::Ais),
            (
                b"$GPRMC,123519,A,4807.038,N,01131.000,E,022.4,084.4,230394,003.1,W*6A\n",
                Foreign::Nmea,
            ),
            (b"*8D4840D6202CC371C32CE0576098;\n", Foreign::ModeS),
            (b"1620114891.8 8D4840D6202CC371C32CE0576098\n", Foreign::Text),
            (b"8D4840D6202CC371C32CE0576098\n", Foreign::Hex),
            (b"1.5,4,abc,8D4840D6202CC371C32CE0576098\n", Foreign::Csv),
        ] {
            for length in [40_000, 200_000, 1_000_000] {
                let text = line.repeat(length / line.len());
                assert_eq!(Foreign::of(&text), Some(kind), "{}", String::from_utf8_lossy(line));
            }
        }
    }
}
