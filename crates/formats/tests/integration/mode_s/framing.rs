//! Streams: every form, any division, any damage.

use formats::mode_s::{FrameReader, FrameStamp, Framed, LINE_OCTETS_MAX, ModeSFrame, ModeSRefusal};
use proptest::prelude::*;

use super::*;

const HEX: &str = "8D4840D6202CC371C32CE0576098";

fn frame() -> ModeSFrame {
    ModeSFrame::new(&u128::from_str_radix(HEX, 16).unwrap().to_be_bytes()[2..]).unwrap()
}

fn framed(octets: &[u8]) -> (Vec<Framed>, u64) {
    let (mut found, mut reader) = (Vec::new(), FrameReader::default());
    reader.take(octets, &mut |framed| found.push(framed));
    reader.end(&mut |framed| found.push(framed));
    (found, reader.damaged_octets())
}

fn beast(kind: u8, ticks: u64, frame: &[u8]) -> Vec<u8> {
    let mut octets = vec![0x1a, kind];
    let body = [&ticks.to_be_bytes()[2..], &[0x1a], frame].concat();
    octets.extend(
        body.into_iter()
            .flat_map(|octet| vec![octet; if octet == 0x1a { 2 } else { 1 }]),
    );
    octets
}

fn hex(text: &str) -> Vec<u8> {
    let digit = |place: usize| u8::from_str_radix(&text[place..place + 2], 16).unwrap();
    (0..text.len()).step_by(2).map(digit).collect()
}

#[test]
fn every_form_of_a_line_gives_the_frame() {
    let ticks = FrameStamp::Ticks(0x1a_2b3c_4d5e);
    let utc = FrameStamp::Utc(1_717_664_319_147_975_000);
    for (line, stamp) in [
        (format!("*{HEX};"), FrameStamp::None),
        (format!("*{};\r\n", HEX.to_lowercase()), FrameStamp::None),
        (format!("@001A2B3C4D5E{HEX};\n"), ticks),
        (format!("<001A2B3C4D5E7F{HEX};\n"), ticks),
        (format!("@000000000000{HEX};\n"), FrameStamp::None),
        (format!("  {HEX}\n\n"), FrameStamp::None),
        (format!("1717664319.147975 {HEX}\n"), utc),
        (format!("1717664319.147975000,\t{HEX}"), utc),
        (format!("1717664319 {HEX}\n"), FrameStamp::Utc(1_717_664_319 * S)),
        (format!("{{\"frame\":\"{HEX}\",\"altitude\":null}}\n"), FrameStamp::None),
        (
            format!("{{\"timestamp\":1.5,\"frame\":\"{HEX}\",\"x\":[1,{{}}]}}\n"),
            FrameStamp::Utc(3 * S / 2),
        ),
    ] {
        assert_eq!(
            framed(line.as_bytes()),
            (vec![Framed::Frame(frame(), stamp)], 0),
            "{line}"
        );
    }
}

#[test]
fn what_is_no_frame_is_refused_by_reason() {
    let long = "A".repeat(LINE_OCTETS_MAX + 1);
    for (line, expected) in [
        ("*0000;", Framed::Other),
        ("*8D4840D6202CC371C32CE05760;", Framed::Refused(ModeSRefusal::Length)),
        ("@001A", Framed::Refused(ModeSRefusal::Length)),
        (
            "*8D4840D6202CC371C32CE057609G;",
            Framed::Refused(ModeSRefusal::Character),
        ),
        (
            "@00_A2B3C4D5E8D4840D6202CC371C32CE0576098;",
            Framed::Refused(ModeSRefusal::Character),
        ),
        ("one two three", Framed::Refused(ModeSRefusal::Line)),
        ("{\"timestamp\":1}", Framed::Refused(ModeSRefusal::Line)),
        (
            "{\"timestamp\":1e300,\"frame\":\"00\"}",
            Framed::Refused(ModeSRefusal::Time),
        ),
        ("-1 8D4840D6202CC371C32CE0576098", Framed::Refused(ModeSRefusal::Time)),
        (
            "99999999999 8D4840D6202CC371C32CE0576098",
            Framed::Refused(ModeSRefusal::Time),
        ),
        (&long, Framed::Refused(ModeSRefusal::LineLength)),
    ] {
        let text = format!("{line}\n*{HEX};\n");
        assert_eq!(
            framed(text.as_bytes()).0,
            [expected, Framed::Frame(frame(), FrameStamp::None)],
            "{line}"
        );
    }
}

#[test]
fn lines_go_on_after_an_escape_octet() {
    let good = Framed::Frame(frame(), FrameStamp::None);
    for damage in ["\x1a", "\x1a3", "\x1a4", "\x1a\x1a", "*8D48\x1a"] {
        let text = format!("*{HEX};\n{damage}\n{}", format!("*{HEX};\n").repeat(3));
        let (found, _) = framed(text.as_bytes());
        // What looks like a message of Beast takes a line with it.
        let good_ones = found.iter().filter(|found| **found == good).count();
        assert!((3..=4).contains(&good_ones), "{damage:?}: {found:?}");
    }
}

#[test]
fn beast_goes_on_after_damage() {
    let whole = beast(b'3', 77, &hex(HEX));
    let good = Framed::Frame(frame(), FrameStamp::Ticks(77));
    let read = |parts: &[&[u8]]| framed(&parts.concat());
    assert_eq!(read(&[&whole, &whole]), (vec![good, good], 0));
    // A cut frame, octets between, and a begin in the middle.
    assert_eq!(
        read(&[&whole[..7], &whole]),
        (vec![Framed::Refused(ModeSRefusal::Cut), good], 0)
    );
    assert_eq!(read(&[&whole, b"xyz\n", &whole]), (vec![good, good], 4));
    assert_eq!(read(&[&whole[14..], &whole]), (vec![good], whole.len() as u64 - 14));
    assert_eq!(
        read(&[&whole, &whole[..5]]),
        (vec![good, Framed::Refused(ModeSRefusal::Cut)], 0)
    );
    // Status of the receiver with its contents, Mode A, an escape octet before an unknown kind.
    let (found, damaged) = read(&[
        &whole,
        &beast(b'4', 5, &[1; 14]),
        &beast(b'1', 5, &[0; 2]),
        b"\x1a\x7f",
        &whole,
    ]);
    assert_eq!(found, [good, Framed::Other, Framed::Other, good]);
    assert!(damaged > 0);
    assert_eq!(read(&[&beast(b'2', 0, &[0x1a; 7])]).0.len(), 1);
}

proptest! {
    #[test]
    fn a_division_changes_nothing(
        ticks in prop::collection::vec((0u64..1 << 48, any::<[u8; 14]>(), any::<bool>()), 1..8),
        cuts in prop::collection::vec(any::<prop::sample::Index>(), 0..6),
    ) {
        let mut octets = Vec::new();
        for (ticks, frame, is_short) in &ticks {
            let (kind, length) = if *is_short { (b'2', 7) } else { (b'3', 14) };
            octets.extend(beast(kind, *ticks, &frame[..length]));
        }
        let (whole, damaged) = framed(&octets);
        prop_assert_eq!((whole.len(), damaged), (ticks.len(), 0));
        let mut cuts: Vec<usize> = cuts.iter().map(|cut| cut.index(octets.len())).collect();
        cuts.extend([0, octets.len()]);
        cuts.sort_unstable();
        let (mut found, mut reader) = (Vec::new(), FrameReader::default());
        for part in cuts.windows(2) {
            reader.take(&octets[part[0]..part[1]], &mut |framed| found.push(framed));
        }
        prop_assert_eq!(found, whole);
    }

    #[test]
    fn any_octets_are_counted_and_none_stops_the_reader(
        octets in prop::collection::vec(prop_oneof![
            4 => any::<u8>(),
            1 => Just(0x1au8),
            1 => prop::sample::select(b"*@<;\n{}123, .0fF\"".to_vec()),
        ], 0..600),
    ) {
        let (found, _) = framed(&octets);
        let mut reader = reader(Some(RECEIVER));
        reader.take(&octets, None, &mut |_| {});
        reader.end(None, &mut |_| {});
        let counters = reader.counters();
        prop_assert_eq!(counters.accepted + counters.other + counters.refused_sum(), found.len() as u64);
    }
}
