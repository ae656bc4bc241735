//! The final format: times, trailers, and the way back after damage.

use formats::containers::{Container, ContainerCounts, Reason, TimeStamp};

use super::forge::{BLOCK, final_frame, unpack, unpack_as};

fn time_of_day(ns: i64) -> Option<TimeStamp> {
    Some(TimeStamp::TimeOfDay { ns })
}

#[test]
fn frames_give_their_blocks_and_their_time_of_day() {
    // 22:00:01.25
    let bytes = [final_frame(7_920_125, BLOCK), final_frame(7_920_126, &BLOCK.repeat(2))].concat();
    assert_eq!(Container::detect(&bytes), Container::Final);
    let found = unpack(&bytes);
    let expected = [
        (BLOCK.to_vec(), time_of_day(79_201_250_000_000)),
        (BLOCK.repeat(2), time_of_day(79_201_260_000_000)),
    ];
    assert_eq!(found.datagrams, expected);
    assert_eq!(found.datagrams[0].1.unwrap().seconds(), 79_201.25);
    let expected = ContainerCounts {
        datagrams: 2,
        datagram_octets: 12,
        framing_octets: 24,
        ..ContainerCounts::default()
    };
    assert_eq!((found.counts, found.skipped), (expected, vec![]));
}

/// A wrong length, or a broken trailer: the reader goes on behind the next trailer.
#[test]
fn after_damage_the_next_trailer_leads_back() {
    let frame = final_frame(0, BLOCK);
    let with = |place: usize, octet: u8| {
        let mut changed = frame.clone();
        changed[place] = octet;
        changed
    };
    let around = |damaged: Vec<u8>| [frame.clone(), damaged, frame.clone(), frame.clone()].concat();
    // A length too great by one: up to its own trailer.
    let found = unpack(&around(with(1, 17)));
    assert_eq!(found.payloads(), [BLOCK; 3]);
    assert_eq!(found.skipped, [(16, Reason::Trailer { length: 17 })]);
    assert_eq!(found.counts.octets_skipped, 16);
    // A length beyond the end of the recording.
    let found = unpack(&around(with(0, 0xFF)));
    assert_eq!(found.payloads(), [BLOCK; 3]);
    assert_eq!(found.skipped, [(16, Reason::Trailer { length: 0xFF10 })]);
    // A broken trailer: up to the next one, and the frame that it ends is lost too.
    let found = unpack(&around(with(15, 0)));
    assert_eq!(found.payloads(), [BLOCK; 2]);
    assert_eq!(found.skipped, [(16, Reason::Trailer { length: 16 })]);
    assert_eq!(found.counts.octets_skipped, 32);
    // Lengths that hold neither header nor trailer.
    for length in [0, 11] {
        let found = unpack(&around(with(1, length)));
        assert_eq!(found.payloads(), [BLOCK; 3], "{length}");
    }
}

#[test]
fn four_octets_of_a_trailer_within_the_blocks_are_blocks() {
    let payload = [0xA5; 9];
    assert_eq!(unpack(&final_frame(0, &payload)).payloads(), [payload]);
}

#[test]
fn a_recording_cut_anywhere_keeps_what_is_before() {
    let whole = final_frame(0, BLOCK).repeat(2);
    for length in 17..whole.len() {
        let found = unpack(&whole[..length]);
        assert_eq!(found.payloads(), [BLOCK]);
        let needed = if length == 17 { 12 } else { 16 };
        let cut = Reason::FileCut {
            needed,
            available: length - 16,
        };
        assert_eq!(found.skipped, [(16, cut)]);
    }
}

#[test]
fn what_has_no_trailer_is_not_of_this_format() {
    assert_eq!(
        Container::detect(&[0, 12, 0, 0, 0, 0, 0, 0, 1, 2, 3, 4]),
        Container::Raw
    );
    let expected = Container::Final;
    let found = unpack_as(Container::Final, BLOCK);
    assert_eq!(found.skipped, [(0, Reason::OtherContainer { expected })]);
}
