//! pcap: byte orders, resolutions, and recordings that were cut.

use formats::containers::{Container, ContainerCounts, Reason, TimeStamp};

use super::forge::{BLOCK, Order, capture, cut_record, pcap, record, unpack, unpack_as, usual};

const MICROSECONDS: u32 = 0xA1B2_C3D4;
const NANOSECONDS: u32 = 0xA1B2_3C4D;

fn utc(ns: i64) -> Option<TimeStamp> {
    Some(TimeStamp::Utc { ns })
}

#[test]
fn every_byte_order_and_resolution_gives_the_same() {
    for order in [Order::Big, Order::Little] {
        for (magic, fraction) in [(MICROSECONDS, 250_000), (NANOSECONDS, 250_000_000)] {
            let records = [
                record(order, 1_463_482_332, fraction, &usual(BLOCK)),
                record(order, 1_463_482_333, 0, &usual(&[BLOCK, BLOCK].concat())),
            ];
            let bytes = pcap(order, magic, 1, &records);
            assert_eq!(Container::detect(&bytes), Container::Pcap);
            let found = unpack(&bytes);
            let expected = [
                (BLOCK.to_vec(), utc(1_463_482_332_250_000_000)),
                ([BLOCK, BLOCK].concat(), utc(1_463_482_333_000_000_000)),
            ];
            assert_eq!(found.datagrams, expected, "{order:?} {magic:X}");
            let expected = ContainerCounts {
                datagrams: 2,
                datagram_octets: 12,
                // The file's header; twice the record's, Ethernet's, IPv4's and UDP's.
                framing_octets: 24 + 2 * (16 + 14 + 20 + 8),
                ..ContainerCounts::default()
            };
            assert_eq!((found.counts, found.skipped), (expected, vec![]));
        }
    }
}

#[test]
fn records_of_the_modified_variant_have_eight_more_octets() {
    let mut long = record(Order::Little, 5, 0, &usual(BLOCK));
    long.splice(16..16, [0; 8]);
    let bytes = pcap(Order::Little, 0xA1B2_CD34, 1, &[long.clone(), long[..30].to_vec()]);
    let found = unpack(&bytes);
    assert_eq!(found.datagrams, [(BLOCK.to_vec(), utc(5_000_000_000))]);
    let cut = Reason::FileCut {
        needed: long.len(),
        available: 30,
    };
    assert_eq!(found.skipped, [(24 + long.len(), cut)]);
}

#[test]
fn seconds_keep_microseconds() {
    let stamp = TimeStamp::Utc {
        ns: 1_463_482_332_508_910_000,
    };
    assert_eq!(stamp.seconds(), 1_463_482_332.508_91);
    assert_eq!(TimeStamp::Utc { ns: -1_500_000_000 }.seconds(), -1.5);
}

/// However much of the last record is missing, everything before it is used, and the message says where it is.
#[test]
fn a_recording_cut_anywhere_keeps_what_is_before() {
    let whole = capture(&[usual(BLOCK), usual(BLOCK)]);
    let second = 24 + 16 + usual(BLOCK).len();
    for length in second + 1..whole.len() {
        let found = unpack(&whole[..length]);
        assert_eq!(found.payloads(), [BLOCK]);
        let needed = if length < second + 12 { 16 } else { whole.len() - second };
        let cut = Reason::FileCut {
            needed,
            available: length - second,
        };
        assert_eq!(found.skipped, [(second, cut)]);
        assert_eq!(found.counts.damages, 1);
    }
    let found = unpack(&whole[..whole.len() - 1]);
    assert_eq!(
        found.skipped[0].1.to_string(),
        "the recording ends 61 octets into 62 that belong together: it was cut short, or is damaged"
    );
}

#[test]
fn a_length_without_end_ends_the_recording() {
    let mut bytes = capture(&[usual(BLOCK)]);
    bytes.extend([0xFF; 40]);
    let found = unpack(&bytes);
    assert_eq!(found.payloads(), [BLOCK]);
    assert!(matches!(
        found.reasons()[..],
        [Reason::FileCut {
            needed: 0x1_0000_000F,
            available: 40
        }]
    ));
}

/// What the capture did not keep matters only if it is part of the payload.
#[test]
fn a_packet_cut_in_its_padding_is_whole() {
    let order = Order::Little;
    let frame = usual(BLOCK);
    let records = [
        cut_record(order, 1, 0, &frame, 60),
        cut_record(order, 2, 0, &frame[..frame.len() - 1], 60),
        cut_record(order, 3, 0, &frame[..12], 60),
    ];
    let found = unpack(&pcap(order, MICROSECONDS, 1, &records));
    assert_eq!(found.payloads(), [BLOCK]);
    let cut = |captured| Reason::PacketCut { captured, original: 60 };
    assert_eq!(found.reasons(), [cut(frame.len() - 1), cut(12)]);
    assert_eq!(found.counts.packets_refused, 2);
}

#[test]
fn the_description_of_the_check_sequence_is_no_part_of_the_link_type() {
    let records = [record(Order::Little, 1, 0, &usual(BLOCK))];
    let bytes = pcap(Order::Little, MICROSECONDS, 0x4400_0001, &records);
    assert_eq!(unpack(&bytes).payloads(), [BLOCK]);
}

#[test]
fn what_is_no_capture_is_refused_as_one() {
    let expected = Container::Pcap;
    let found = unpack_as(Container::Pcap, BLOCK);
    assert_eq!(found.skipped, [(0, Reason::OtherContainer { expected })]);
    assert_eq!(found.counts.octets_skipped, 4);
    assert_eq!(unpack_as(Container::Pcap, &[]).counts, ContainerCounts::default());
}

#[test]
fn raw_blocks_are_one_datagram_without_time() {
    let bytes = BLOCK.repeat(3);
    assert_eq!(Container::detect(&bytes), Container::Raw);
    let found = unpack(&bytes);
    assert_eq!((found.datagrams, found.skipped), (vec![(bytes, None)], vec![]));
    assert_eq!(unpack(&[]).counts, ContainerCounts::default());
}

#[test]
fn kinds_have_names() {
    for kind in Container::ALL {
        assert_eq!(kind.to_string().parse(), Ok(kind));
    }
    let line = "PCAP".parse::<Container>().unwrap_err().to_string();
    assert_eq!(
        line,
        "\"PCAP\" is no kind of recording; there are raw, pcap, pcapng, final, gps and hex"
    );
}
