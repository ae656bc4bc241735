//! gps recordings: times, damage, and what is none.

use formats::containers::{Container, ContainerCounts, Reason, TimeStamp};
use formats::foreign::Foreign;
use formats::recording::RecordingBytes;
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::Index;

use super::forge::{BLOCK, gps, gps_block, unpack, unpack_as};

const HEADER: usize = 2_200;
/// A block and its ten octets.
const PIECE: usize = 14;

fn time_of_day(ns: i64) -> Option<TimeStamp> {
    Some(TimeStamp::TimeOfDay { ns })
}

#[test]
fn blocks_have_the_time_of_day_behind_them() {
    // 22:00:01 and 1/128 s; a number that is no time of day.
    let bytes = gps(&[gps_block(79_201 * 128 + 1, BLOCK), gps_block(86_400 * 128, BLOCK)]);
    assert_eq!(Container::detect(&bytes), Container::Gps);
    let found = unpack(&bytes);
    let expected = [
        (BLOCK.to_vec(), time_of_day(79_201_007_812_500)),
        (BLOCK.to_vec(), None),
    ];
    assert_eq!(found.datagrams, expected);
    let expected = ContainerCounts {
        datagrams: 2,
        datagram_octets: 8,
        framing_octets: 2_220,
        ..ContainerCounts::default()
    };
    assert_eq!((found.counts, found.skipped), (expected, vec![]));
    assert_eq!(RecordingBytes::new(&bytes).survey().foreign(&bytes), None);
    let raw = RecordingBytes::new(&bytes).in_container(Container::Raw).survey();
    assert_eq!(raw.foreign(&bytes), Some(Foreign::Gps), "taken for another container");
}

#[test]
fn a_single_block_up_to_the_end_is_enough_and_a_part_of_one_is_not() {
    let bytes = gps(&[gps_block(0, BLOCK)]);
    assert_eq!(unpack(&bytes).payloads(), [BLOCK]);
    for octets in [0, 1, HEADER, HEADER + 1, HEADER + PIECE - 1] {
        assert_eq!(Container::detect(&bytes[..octets]), Container::Raw, "{octets}");
    }
    // Categories without a table are counted behind known ones.
    let unknown = gps_block(0, &[99, 0, 4, 1]);
    let known = gps_block(0, BLOCK);
    let found = unpack(&gps(&[known.clone(), known.clone(), known, unknown.clone()]));
    assert_eq!(found.payloads().len(), 4);
    assert_eq!(Container::detect(&gps(&[unknown])), Container::Raw);
}

#[test]
fn bare_blocks_and_texts_are_none() {
    // The length of the blocks makes byte 2,200 a block with ten octets behind it.
    let long = [
        &[48, 0, 100][..],
        &[48, 0, 4, 0xAB, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0].repeat(7)[..97],
    ]
    .concat();
    assert_eq!(Container::detect(&long.repeat(30)), Container::Raw);
    let text = "\n\t\t and so on".repeat(1_000);
    assert_eq!(Container::detect(text.as_bytes()), Container::Raw);
}

#[test]
fn behind_an_impossible_length_the_next_blocks_lead_back() {
    let piece = gps_block(7, BLOCK);
    let with = |high: u8, low: u8| {
        let mut changed = piece.clone();
        changed[1..3].copy_from_slice(&[high, low]);
        let around = [vec![piece.clone(); 3], vec![changed], vec![piece.clone(); 3]];
        unpack(&gps(&around.concat()))
    };
    for (high, low, length) in [(0, 3, 3), (0, 0, 0), (0x20, 0x20, 0x2020)] {
        let found = with(high, low);
        assert_eq!(found.payloads(), [BLOCK; 6]);
        assert_eq!(found.skipped, [(HEADER + 3 * PIECE, Reason::GpsBlock { length })]);
        assert_eq!(found.counts.octets_skipped, PIECE as u64);
    }
    // A possible length beyond the end, and nothing behind it.
    let last = [piece[..1].to_vec(), vec![0x0F, 0xFF], piece[3..].to_vec()].concat();
    let found = unpack(&gps(&[vec![piece.clone(); 3], vec![last]].concat()));
    let cut = Reason::FileCut {
        needed: 0x0FFF + 10,
        available: PIECE,
    };
    assert_eq!(found.skipped, [(HEADER + 3 * PIECE, cut)]);
}

#[test]
fn a_recording_cut_anywhere_keeps_what_is_before() {
    let whole = gps(&vec![gps_block(0, BLOCK); 4]);
    let begin = HEADER + 3 * PIECE;
    for length in begin + 1..whole.len() {
        let found = unpack(&whole[..length]);
        assert_eq!(found.payloads(), [BLOCK; 3]);
        let available = length - begin;
        let needed = if available < 3 { 13 } else { PIECE };
        assert_eq!(found.skipped, [(begin, Reason::FileCut { needed, available })]);
    }
}

#[test]
fn what_is_shorter_than_the_header_or_has_no_blocks_is_another_container() {
    let expected = Container::Gps;
    for bytes in [vec![1; 100], vec![0; 3_000]] {
        let found = unpack_as(Container::Gps, &bytes);
        assert_eq!(
            found.reasons(),
            [Reason::OtherContainer { expected }],
            "{}",
            bytes.len()
        );
    }
}

proptest! {
    #[test]
    fn what_was_packed_is_unpacked(blocks in vec((0_u32..86_400 * 128, vec(any::<u8>(), 1..60)), 1..8)) {
        let blocks: Vec<(u32, Vec<u8>)> = blocks
            .into_iter()
            .map(|(ticks, body)| (ticks, [&[48, 0, body.len() as u8 + 3], &body[..]].concat()))
            .collect();
        let pieces: Vec<_> = blocks.iter().map(|(ticks, block)| gps_block(*ticks, block)).collect();
        let found = unpack(&gps(&pieces));
        let expected = blocks.into_iter().map(|(ticks, block)| (block, time_of_day(i64::from(ticks) * 7_812_500)));
        prop_assert_eq!(found.datagrams, expected.collect::<Vec<_>>());
        prop_assert_eq!(found.skipped, vec![]);
    }

    #[test]
    fn a_damaged_recording_is_read_to_its_end(
        bodies in vec(vec(any::<u8>(), 1..60), 1..8),
        damage in vec((any::<Index>(), any::<u8>()), 1..6),
        kept in any::<Index>(),
    ) {
        let piece = |body: &Vec<u8>| gps_block(1, &[&[62, 0, body.len() as u8 + 3], &body[..]].concat());
        let mut bytes = gps(&bodies.iter().map(piece).collect::<Vec<_>>());
        for (place, octet) in damage {
            let place = HEADER + place.index(bytes.len() - HEADER);
            bytes[place] = octet;
        }
        bytes.truncate(HEADER + kept.index(bytes.len() - HEADER) + 1);
        unpack(&bytes);
        unpack_as(Container::Gps, &bytes);
    }
}
