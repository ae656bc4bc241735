//! Sentences of AIS in lines, with what stands around them.
//!
//! Text before a sentence that is no [`Envelope`] is skipped: the checksum decides whether a sentence is whole.

use aivdm::Sentence;
use aivdm::error::NmeaError;

use super::counters::AisRejection;
use crate::nmea::{Envelope, LINE_OCTETS_MAX};

/// A line with a sentence of AIS.
#[derive(Debug)]
pub(super) struct AisLine<'a> {
    /// The sentence, whose checksum is right.
    pub(super) sentence: Sentence<'a>,
    /// Time of receipt as the line states it, UTC, nanoseconds since 1970.
    pub(super) received_ns: Option<i64>,
    /// Number of the group of sentences in its tag block, else the receiving station.
    pub(super) station: Option<&'a str>,
    /// Whether a tag block had a wrong sum and was not used.
    pub(super) has_wrong_tag: bool,
}

impl<'a> AisLine<'a> {
    /// Reads a line; `None` of an empty line, a comment, or another sentence.
    pub(super) fn parse(line: &'a [u8]) -> Result<Option<Self>, AisRejection> {
        let line = line.trim_ascii();
        if line.is_empty() || line.starts_with(b"#") || line.starts_with(b"//") {
            return Ok(None);
        }
        let text = std::str::from_utf8(line)
            .ok()
            .filter(|text| text.len() <= LINE_OCTETS_MAX);
        let text = text.ok_or(AisRejection::Text)?;
        // The last one: a sentence that was cut may stand before it.
        let start = text.rfind(['!', '$']).ok_or(AisRejection::NoSentence)?;
        let (before, text) = text.split_at(start);
        let name = text[1..].split([',', '*']).next().unwrap_or_default();
        if !(name.len() == 5 && (name.ends_with("VDM") || name.ends_with("VDO"))) {
            return Ok(None);
        }
        let sentence = Sentence::parse(text).map_err(rejection)?;
        let behind = text
            .split_once('*')
            .and_then(|(_, sum)| sum.get(2..))
            .unwrap_or_default();
        let envelope = Envelope::of(before, behind);
        Ok(Some(Self {
            sentence,
            received_ns: envelope.received_ns,
            // Only the first sentence of a group need name the station.
            station: envelope.group.or(envelope.station),
            has_wrong_tag: envelope.has_wrong_tag,
        }))
    }
}

fn rejection(error: NmeaError) -> AisRejection {
    match error {
        NmeaError::MalformedSentence => AisRejection::Partial,
        NmeaError::ChecksumMismatch { .. } => AisRejection::Checksum,
        NmeaError::InvalidArmorChar => AisRejection::Payload,
        _ => AisRejection::Fields,
    }
}

#[cfg(test)]
mod tests {
    use frames::time::NS_PER_S;

    use super::*;

    const SENTENCE: &str = "!AIVDM,1,1,,B,177KQJ5000G?tO`K>RA1wUbN0TKH,0*5C";
    const NEW_YEAR_2020_NS: i64 = 1_577_836_800 * NS_PER_S;

    fn tag(text: &str) -> String {
        let sum = text.bytes().fold(0, |sum, octet| sum ^ octet);
        format!("\\{text}*{sum:02X}\\")
    }

    fn stated(line: &str) -> (Option<i64>, Option<String>, bool) {
        let found = AisLine::parse(line.as_bytes()).unwrap().unwrap();
        assert_eq!(found.sentence.payload, b"177KQJ5000G?tO`K>RA1wUbN0TKH");
        (found.received_ns, found.station.map(str::to_owned), found.has_wrong_tag)
    }

    #[test]
    fn times_and_stations_stand_before_and_behind_sentences() {
        let new_year = Some(NEW_YEAR_2020_NS);
        let of = |station: &str| Some(station.to_owned());
        for (line, received_ns, station) in [
            (SENTENCE.to_owned(), None, None),
            (
                format!("{}{SENTENCE}\r\n", tag("s:2573135,c:1577836800")),
                new_year,
                of("2573135"),
            ),
            (format!("{}{SENTENCE}", tag("c:1577836800000,s:x")), new_year, of("x")),
            (
                format!("{}{SENTENCE}", tag("g:1-2-73874,n:157036,s:r003669945")),
                None,
                of("73874"),
            ),
            (format!("2020-01-01 00:00:00 {SENTENCE}"), new_year, None),
            (format!("2020-01-01T00:00:00Z,{SENTENCE}"), new_year, None),
            (
                format!("2020-01-01 00:00:00.25\t{SENTENCE}"),
                new_year.map(|ns| ns + NS_PER_S / 4),
                None,
            ),
            (format!("1577836800 {SENTENCE}"), new_year, None),
            (
                format!("1577836800.5,{SENTENCE}"),
                new_year.map(|ns| ns + NS_PER_S / 2),
                None,
            ),
            (
                format!("1577836801\t{}{SENTENCE}", tag("s:x,c:1577836800")),
                new_year,
                of("x"),
            ),
            (format!("1577836800\t{}{SENTENCE}", tag("s:x")), new_year, of("x")),
            (format!("{SENTENCE},r003669945,1577836800"), new_year, of("r003669945")),
            (
                format!("{SENTENCE},s29400,d-093,T50.4618,b003669710,1577836800"),
                new_year,
                of("b003669710"),
            ),
            (format!("7,18:{SENTENCE}"), None, None),
            (format!("!AIVDM,1,1,,B,177K{SENTENCE}"), None, None),
        ] {
            assert_eq!(stated(&line), (received_ns, station, false), "{line}");
        }
    }

    #[test]
    fn a_tag_block_with_a_wrong_sum_is_not_used() {
        for before in ["\\s:x,c:1577836800*00\\", "\\s:x,c:1577836800\\", "s:x*00\\", "\\"] {
            assert_eq!(stated(&format!("{before}{SENTENCE}")), (None, None, true), "{before}");
        }
    }

    #[test]
    fn other_lines_are_none_and_faults_have_reasons() {
        for line in [
            "",
            "  \r\n",
            "# a comment",
            "// !AIVDM",
            "$GPHDT,274.07,T*03",
            "!AIABM,1",
            "$AITXT,01,01,91,FREQ*30",
        ] {
            assert!(AisLine::parse(line.as_bytes()).unwrap().is_none(), "{line}");
        }
        let long = format!("{SENTENCE}{}", ",0".repeat(600));
        for (line, reason) in [
            ("no sentence", AisRejection::NoSentence),
            (
                "!AIVDM,1,1,,B,177KQJ5000G?tO`K>RA1wUbN0TKH,0*5D",
                AisRejection::Checksum,
            ),
            ("!AIVDM,1,1,,B,177KQJ5000G?tO`K>RA1wUbN0TKH,0", AisRejection::Partial),
            ("!AIVDM,1,1,,B,177KQJ5000G?tO`K>RA1wUbN0TKH,0*5", AisRejection::Partial),
            ("!AIVDM,1,1*57", AisRejection::Fields),
            ("!AIVDM,1,2,,B,177KQJ5000G?tO`K>RA1wUbN0TKH,0*5F", AisRejection::Fields),
            ("!AIVDM,1,1,,B,177KQJ5000G?tO`K>RA1wUbN0TKH,6*5A", AisRejection::Fields),
            ("!AIVDM,1,1,,B,177KQJ5000G?tO~K>RA1wUbN0TKH,0*42", AisRejection::Payload),
            (&long, AisRejection::Text),
        ] {
            assert_eq!(AisLine::parse(line.as_bytes()).unwrap_err(), reason, "{line}");
        }
        assert_eq!(AisLine::parse(b"\xff\xfe!").unwrap_err(), AisRejection::Text);
    }
}
