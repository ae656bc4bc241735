//! Hexadecimal text: times, notations, damage, and what is none.

use std::fmt::Write as _;

use formats::containers::{Container, ContainerCounts, Reason, TimeStamp};
use formats::foreign::Foreign;
use formats::recording::RecordingBytes;
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::Index;

use super::forge::{BLOCK, unpack, unpack_as};

fn of_day(ns: i64) -> Option<TimeStamp> {
    Some(TimeStamp::TimeOfDay { ns })
}

fn utc(ns: i64) -> Option<TimeStamp> {
    Some(TimeStamp::Utc { ns })
}

/// The only datagram of a text that is one line.
fn only(line: &str) -> (Vec<u8>, Option<TimeStamp>) {
    assert_eq!(Container::detect(line.as_bytes()), Container::Hex, "{line}");
    let found = unpack(line.as_bytes());
    assert_eq!((found.datagrams.len(), &found.skipped[..]), (1, &[][..]), "{line}");
    found.datagrams[0].clone()
}

#[test]
fn a_line_is_a_datagram_with_an_optional_time() {
    let time = 1_620_114_891;
    let exact = 827_123_456;
    for (line, expected) in [
        ("300004AB", None),
        ("30 00 04 ab", None),
        ("\u{feff}  300004AB\r\n", None),
        ("1620114891.827123456 300004AB", utc(time * 1_000_000_000 + exact)),
        ("1620114891.8271234569 30 0004 AB", utc(time * 1_000_000_000 + exact)),
        ("1620114891 300004AB", utc(time * 1_000_000_000)),
        ("1620114891.5,300004AB", utc(time * 1_000_000_000 + 500_000_000)),
        ("28491.5;300004AB", of_day(28_491_500_000_000)),
        ("12\t300004AB", of_day(12_000_000_000)),
        ("0 300004AB", of_day(0)),
        ("86400.5 300004AB", of_day(86_400_500_000_000)),
        ("86401 300004AB", utc(86_401_000_000_000)),
        (
            "2021-05-04T07:54:51.827123456Z 300004AB",
            utc(time * 1_000_000_000 + exact),
        ),
        (
            "2021-05-04T07:54:51.827123456 300004AB",
            utc(time * 1_000_000_000 + exact),
        ),
        ("2021-05-04 07:54:51 300004AB", utc(time * 1_000_000_000)),
        ("2021-05-04T09:54:51+02:00, 30 00 04 AB", utc(time * 1_000_000_000)),
        ("07:54:51.5 300004AB", of_day(28_491_500_000_000)),
    ] {
        assert_eq!(only(line), (BLOCK.to_vec(), expected), "{line}");
    }
}

#[test]
fn octets_that_could_be_a_time_are_octets_where_they_are_data_blocks() {
    // The first word is the category, and a number of seconds; behind it is no data block.
    assert_eq!(only("30 00 04 AB"), (BLOCK.to_vec(), None));
    // The first word is no octet of the block behind it.
    assert_eq!(only("48 30 00 04 AB"), (BLOCK.to_vec(), of_day(48_000_000_000)));
    let several = only("300004AB300004AB");
    assert_eq!(several, (BLOCK.repeat(2), None));
}

#[test]
fn comments_are_framing_and_other_lines_are_skipped() {
    let text = "# a log\n\n1.5 300004AB\n2.5 300004A\nno octets at all\n3.5 300004AB\n4.5 99\n5.5 300004AB\n";
    let found = unpack(text.as_bytes());
    let expected = [
        (BLOCK.to_vec(), of_day(1_500_000_000)),
        (BLOCK.to_vec(), of_day(3_500_000_000)),
        (vec![0x99], of_day(4_500_000_000)),
        (BLOCK.to_vec(), of_day(5_500_000_000)),
    ];
    assert_eq!(found.datagrams, expected);
    let line = |beginning: &str| Reason::HexLine {
        beginning: beginning.to_owned(),
    };
    assert_eq!(
        found.skipped,
        [(22, line("2.5 300004A")), (34, line("no octets at all"))]
    );
    assert_eq!(
        found.counts,
        ContainerCounts {
            datagrams: 4,
            datagram_octets: 13,
            framing_octets: text.len() as u64 - 13 - 29,
            octets_skipped: 29,
            damages: 2,
            ..ContainerCounts::default()
        }
    );
    assert_eq!(
        RecordingBytes::new(text.as_bytes()).survey().foreign(text.as_bytes()),
        None
    );
}

#[test]
fn other_texts_are_none() {
    for (text, kind) in [
        // A dump that is cut into lines of equal length.
        (
            "30001bAB0000000000000000\n000000000000000000000000\n000000\n",
            Foreign::Hex,
        ),
        (
            "8D4840D6202CC371C32CE0576098\n8D4840D6202CC371C32CE0576098\n",
            Foreign::Hex,
        ),
        ("*8D4840D6202CC371C32CE0576098;\n", Foreign::ModeS),
        ("MSG,3,1,1,4CA2D6,1,2020/01/01,12:00:00.000\n", Foreign::Sbs),
        ("time_s,x\n1,2\n3,4\n", Foreign::Csv),
        ("000003 000003\n", Foreign::Hex),
        ("1.5 300004AB\nbut mostly\nother\nlines\n", Foreign::Text),
    ] {
        assert_eq!(Container::detect(text.as_bytes()), Container::Raw, "{text}");
        assert_eq!(
            RecordingBytes::new(text.as_bytes()).survey().foreign(text.as_bytes()),
            Some(kind),
            "{text}"
        );
    }
    assert_eq!(Container::detect(b"300004AB\xff\n"), Container::Raw);
    for text in [&b"300004AB\n"[..], b"12.5 300004AB\n"] {
        let taken_for_another = RecordingBytes::new(text).in_container(Container::Raw).survey();
        assert_eq!(taken_for_another.foreign(text), Some(Foreign::Hex));
    }
}

fn digits(octets: &[u8], blanks: bool) -> String {
    octets.iter().fold(String::new(), |mut text, octet| {
        write!(text, "{octet:02x}{}", if blanks { " " } else { "" }).unwrap();
        text
    })
}

proptest! {
    #[test]
    fn what_was_written_is_read(
        lines in vec((0_i64..4_000_000_000_000_000_000, vec(any::<u8>(), 1..60), any::<bool>()), 1..8),
        is_timed in any::<bool>(),
    ) {
        let (mut text, mut expected) = (String::new(), Vec::new());
        for (ns, body, blanks) in lines {
            let block = [&[48, 0, body.len() as u8 + 3], &body[..]].concat();
            if is_timed {
                write!(text, "{}.{:09} ", ns / 1_000_000_000, ns % 1_000_000_000).unwrap();
            }
            writeln!(text, "{}", digits(&block, blanks)).unwrap();
            let time = if ns < 86_401_000_000_000 { of_day(ns) } else { utc(ns) };
            expected.push((block, time.filter(|_| is_timed)));
        }
        let found = unpack(text.as_bytes());
        prop_assert_eq!(found.datagrams, expected);
        prop_assert_eq!(found.skipped, vec![]);
    }

    #[test]
    fn any_text_is_read_to_its_end(text in "([0-9a-fA-F.:TZ, \t#-]{0,30}\n){0,9}", junk in vec(any::<u8>(), 0..9)) {
        let bytes = [text.as_bytes(), &junk, text.as_bytes()].concat();
        unpack(&bytes);
        unpack_as(Container::Hex, &bytes);
    }

    #[test]
    fn a_damaged_text_is_read_to_its_end(damage in vec((any::<Index>(), any::<u8>()), 1..6), kept in any::<Index>()) {
        let mut bytes = "2021-05-04T07:54:51.8Z 30 00 04 AB\n12.5 300004AB\n".repeat(4).into_bytes();
        for (place, octet) in damage {
            let place = place.index(bytes.len());
            bytes[place] = octet;
        }
        bytes.truncate(kept.index(bytes.len()) + 1);
        unpack(&bytes);
        unpack_as(Container::Hex, &bytes);
    }
}
