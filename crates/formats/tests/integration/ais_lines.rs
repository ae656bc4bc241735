//! Lines of AIS receivers: mixed streams, copies, times in lines, and any octets.

use std::f64::consts::{FRAC_PI_2, PI};

use formats::ais::{AisCounters, AisOutput, AisReader, AisRejection, AisSettings};
use proptest::prelude::*;
use test_support::{Dice, mutated};

use super::ais::{class_a, outputs, reader, target};

const S: i64 = 1_000_000_000;
const STATIC: [&str; 2] = [
    "!AIVDM,2,1,1,A,55?MbV02;H;s<HtKR20EHE:0@T4@Dn2222222216L961O5Gf0NSQEp6ClRp8,0*1C",
    "!AIVDM,2,2,1,A,88888888880,2*25",
];

fn with_sum(text: &str) -> String {
    let sum = text.bytes().skip(1).fold(0, |sum, octet| sum ^ octet);
    format!("{text}*{sum:02X}")
}

/// The two sentences of the static data on another channel or with another number.
fn parts(channel: &str, number: u8) -> [String; 2] {
    STATIC.map(|line| {
        let text = line[..line.len() - 3].replace(",1,A,", &format!(",{number},{channel},"));
        with_sum(&text)
    })
}

fn lines_of(counters: &AisCounters) -> u64 {
    let taken = counters.messages + counters.parts + counters.repeats + counters.others;
    taken + counters.rejected.iter().sum::<u64>()
}

/// Takes lines of several connections, each with its seconds of receipt; gives the number of statements.
fn statements(reader: &mut AisReader, lines: &[(u32, &str, i64)]) -> usize {
    let mut count = 0;
    for (connection, line, at_s) in lines {
        let _ = reader.take(*connection, line.as_bytes(), at_s * S, |_, output| {
            count += usize::from(matches!(output, AisOutput::Statement(_)));
        });
    }
    count
}

#[test]
fn parts_of_channels_connections_and_stations_do_not_mix() {
    let ([a1, a2], [b1, b2]) = (parts("A", 1), parts("B", 1));
    let mut reader = reader();
    // The copies are messages of their own, a quarter of a minute later each.
    let lines = [(0, &*a1, 0), (0, &*b1, 0), (1, &*a1, 0), (0, &*a2, 0)];
    assert_eq!(statements(&mut reader, &lines), 1);
    assert_eq!(
        statements(&mut reader, &[(0, &b2, 0), (1, &a2, 0)]),
        0,
        "whole, but copies"
    );
    assert_eq!((reader.counters().messages, reader.counters().repeats), (1, 2));
    assert_eq!((reader.counters().parts, reader.counters().unfinished), (3, 0));
    let tagged = |station: &str, line: &str| format!("\\{}\\{line}", &with_sum(&format!(" s:{station}"))[1..]);
    let stations = [tagged("x", &a1), tagged("y", &a1), tagged("x", &a2), tagged("y", &a2)];
    let lines: Vec<_> = stations.iter().map(|line| (0, line.as_str(), 20)).collect();
    assert_eq!(statements(&mut reader, &lines), 1);
    assert_eq!(
        (
            reader.counters().messages,
            reader.counters().repeats,
            reader.counters().unfinished
        ),
        (2, 3, 0)
    );
    assert_eq!(reader.counters().wrong_tags, 0);
}

#[test]
fn groups_of_tag_blocks_hold_together() {
    let tags =
        ["g:1-2-73874,s:x,c:1577836800*", "g:2-2-73874*"].map(|tag| with_sum(&format!(" {}", &tag[..tag.len() - 1])));
    let lines: Vec<String> = (0..2)
        .map(|part| format!("\\{}\\{}", &tags[part][1..], STATIC[part]))
        .collect();
    assert_eq!(
        statements(
            &mut reader(),
            &[(0, &lines[0], 1_577_836_800), (0, &lines[1], 1_577_836_801)]
        ),
        1
    );
}

#[test]
fn parts_of_another_message_or_too_late_end_the_first() {
    let [a1, a2] = parts("A", 1);
    let of_three = with_sum("!AIVDM,3,2,1,A,8888,0");
    for (lines, unfinished, order) in [
        (vec![(0, &*a1, 0), (0, &*a1, 0), (0, &*a2, 0)], 1, 0),
        (vec![(0, &*a2, 0)], 0, 1),
        (vec![(0, &*a1, 0), (0, &*of_three, 0), (0, &*a2, 0)], 1, 2),
        (vec![(0, &*a1, 0), (0, &*a2, 6)], 1, 1),
        (vec![(0, &*a1, 0), (0, &*a2, 5)], 0, 0),
    ] {
        let mut reader = reader();
        let count = statements(&mut reader, &lines);
        let counters = reader.counters();
        assert_eq!(
            (counters.unfinished, counters.rejected(AisRejection::Order)),
            (unfinished, order),
            "{lines:?}"
        );
        assert_eq!(
            (count, lines_of(counters)),
            (usize::from(order == 0), lines.len() as u64)
        );
    }
    let mut reader = reader();
    for connection in 0..100 {
        statements(&mut reader, &[(connection, &a1, 0)]);
    }
    assert_eq!(
        (reader.counters().parts, reader.counters().unfinished),
        (100, 36),
        "64 wait"
    );
}

#[test]
fn shorter_static_data_of_some_transponders_are_read() {
    let second = with_sum("!AIVDM,2,2,1,A,8888888888,0");
    assert_eq!(
        statements(&mut reader(), &[(0, STATIC[0], 0), (0, &second, 0)]),
        1,
        "420 bits"
    );
    let second = with_sum("!AIVDM,2,2,1,A,888888888,0");
    let mut reader = reader();
    assert_eq!(statements(&mut reader, &[(0, STATIC[0], 0), (0, &second, 0)]), 0);
    assert_eq!(reader.counters().rejected(AisRejection::Length), 1);
}

#[test]
fn copies_are_dropped_and_times_of_lines_count() {
    let line = class_a(|_| {});
    let mut reader = reader();
    let found = outputs(
        &mut reader,
        &[&format!("2020-01-01 00:00:16 {line}"), &format!("{line},r1,1577836825")],
        0,
    );
    assert_eq!(target(&found).time_of_day_ns, Some(15 * S));
    assert_eq!((found.len(), reader.counters().repeats), (2, 1));
    let found = outputs(&mut reader, &[&format!("1577836877 {line}")], 0);
    assert_eq!(
        target(&found).time_of_day_ns,
        Some(75 * S),
        "a minute later it is another"
    );
}

#[test]
fn every_line_is_counted_once() {
    let mut reader = reader();
    let short = with_sum("!AIVDM,1,1,,A,1000,0");
    let unknown = with_sum("!AIVDM,1,1,,A,l00000000000,0");
    let endless = with_sum(&format!("!AIVDM,1,1,,A,{},0", "1".repeat(400)));
    let lines = [
        STATIC[0],
        STATIC[1],
        "# comment",
        "",
        "$GPHDT,274.07,T*03",
        "junk",
        &short,
        &unknown,
        &endless,
    ];
    for line in lines {
        let _ = reader.take(0, line.as_bytes(), 0, |_, _| {});
    }
    let counters = reader.counters();
    assert_eq!((counters.messages, counters.parts, counters.others), (1, 1, 3));
    assert_eq!(
        (
            counters.rejected(AisRejection::Length),
            counters.rejected(AisRejection::Type)
        ),
        (2, 1)
    );
    assert_eq!(
        (counters.rejected(AisRejection::NoSentence), lines_of(counters)),
        (1, 9)
    );
    assert_eq!(counters.types[5], 1);
    let error = reader.take(0, short.as_bytes(), 0, |_, _| {}).unwrap_err().to_string();
    assert!(
        error.contains("AIVDM,1,1,,A,1000") && error.contains("shorter or longer"),
        "{error}"
    );
}

#[test]
fn a_hundred_thousand_mutated_sentences_are_taken() {
    let sources = [class_a(|_| {}), STATIC[0].to_owned(), STATIC[1].to_owned()];
    let others: Vec<&[u8]> = sources.iter().map(|line| line.as_bytes()).collect();
    let mut reader = AisReader::new(AisSettings { stations_max: 16 });
    let mut dice = Dice::new(7);
    for number in 0..100_000i64 {
        let source = dice.one_of(&others);
        let mut line = mutated(source, &others, &mut dice);
        // With a right sum, most reach the decoder.
        if dice.below(4) > 0 {
            let end = line.iter().position(|octet| *octet == b'*').unwrap_or(line.len());
            let sum = line[..end].iter().skip(1).fold(0, |sum, octet| sum ^ octet);
            line.truncate(end);
            line.extend_from_slice(format!("*{sum:02X}").as_bytes());
        }
        let _ = reader.take(dice.below(3) as u32, &line, number * S / 50, |_, _| {});
    }
    assert_eq!(lines_of(reader.counters()), 100_000);
    assert!(reader.counters().messages > 1000, "{:?}", reader.counters());
}

/// A sentence of any payload, type first.
fn any_sentence() -> impl Strategy<Value = String> {
    let characters = prop::collection::vec(prop::sample::select((0u8..64).collect::<Vec<_>>()), 1..200);
    (characters, 0u8..6, 1u8..4, 1u8..4, 0u8..3).prop_map(|(sixes, fill, parts, part, number)| {
        let armoured = sixes
            .iter()
            .map(|six| char::from(aivdm::string::sixbit_to_armor_char(*six)));
        let payload: String = armoured.collect();
        with_sum(&format!("!AIVDM,{parts},{part},{number},A,{payload},{fill}"))
    })
}

proptest! {
    #[test]
    fn any_payload_gives_finite_values(lines in prop::collection::vec(any_sentence(), 1..20), received_ns: i64) {
        let mut reader = AisReader::new(AisSettings { stations_max: 4 });
        for line in &lines {
            let _ = reader.take(0, line.as_bytes(), received_ns, |_, output| {
                let position = match output {
                    AisOutput::Target(found) | AisOutput::OwnShip(found) => found.geodetic.unwrap(),
                    AisOutput::Statement(stated) => match stated.station {
                        Some(station) => station.place_rad,
                        None => [f64::from(stated.size_m.unwrap_or_default()[0]) / 1e6; 2],
                    },
                };
                assert!(position[0].abs() <= FRAC_PI_2 && position[1].abs() <= PI, "{position:?}");
            });
        }
        prop_assert_eq!(lines_of(reader.counters()), lines.len() as u64);
    }

    #[test]
    fn any_octets_are_counted(
        lines in prop::collection::vec(prop::collection::vec(any::<u8>(), 0..80), 1..20),
        at: i64,
    ) {
        let mut reader = AisReader::new(AisSettings { stations_max: 4 });
        for line in &lines {
            let _ = reader.take(0, line, at, |_, _| {});
        }
        prop_assert_eq!(lines_of(reader.counters()), lines.len() as u64);
    }
}
