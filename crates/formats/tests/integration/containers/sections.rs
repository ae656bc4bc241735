//! pcapng: sections, interfaces, resolutions, and damaged blocks.

use formats::containers::{Container, Reason, TimeStamp};

use super::forge::{BLOCK, Order, enhanced, interface, ng_block, section, simple, udp, unpack, unpack_as, usual};
use super::forge::{ethernet, ipv4};

/// Code of an interface's resolution of time stamps.
const RESOLUTION: u16 = 9;
/// Code of an interface's offset of time stamps, in seconds.
const OFFSET: u16 = 14;

fn utc(ns: i64) -> Option<TimeStamp> {
    Some(TimeStamp::Utc { ns })
}

#[test]
fn sections_of_both_byte_orders_follow_each_other() {
    let mut bytes = Vec::new();
    for order in [Order::Little, Order::Big, Order::Little] {
        bytes.extend(section(order));
        bytes.extend(interface(order, 1, 0, &[]));
        bytes.extend(enhanced(order, 0, 1_463_482_332_508_910, &usual(BLOCK)));
    }
    assert_eq!(Container::detect(&bytes), Container::PcapNg);
    let found = unpack(&bytes);
    assert_eq!(
        found.datagrams,
        vec![(BLOCK.to_vec(), utc(1_463_482_332_508_910_000)); 3]
    );
    assert!(found.skipped.is_empty());
}

/// Interfaces differ in link, resolution and offset; each packet names its own.
#[test]
fn every_interface_has_its_link_and_its_clock() {
    for order in [Order::Big, Order::Little] {
        let offset = |seconds: i64| match order {
            Order::Big => seconds.to_be_bytes(),
            Order::Little => seconds.to_le_bytes(),
        };
        let (later, earlier) = (offset(1000), offset(-1));
        let ip = ipv4(17, &udp(BLOCK));
        let bytes = [
            section(order),
            interface(order, 1, 0, &[(2, b"eth0"), (RESOLUTION, &[9])]),
            interface(order, 101, 0, &[(RESOLUTION, &[0x80 | 10]), (OFFSET, &later)]),
            interface(order, 101, 0, &[(RESOLUTION, &[3]), (OFFSET, &earlier)]),
            interface(order, 101, 0, &[(RESOLUTION, &[99])]),
            interface(order, 101, 0, &[(RESOLUTION, &[0])]),
            enhanced(order, 1, 1536, &ip),
            enhanced(order, 0, 7_000_000_001, &usual(BLOCK)),
            enhanced(order, 2, 2500, &ip),
            enhanced(order, 3, 1, &ip),
            enhanced(order, 4, u64::MAX, &ip),
        ]
        .concat();
        let found = unpack(&bytes);
        assert!(found.payloads().iter().all(|payload| *payload == BLOCK));
        let stamps: Vec<_> = found.datagrams.iter().map(|(_, stamp)| *stamp).collect();
        // 1536 units of 1/1024 s; nanoseconds; milliseconds; 10^-99 s is no resolution; 2^64 s is no time.
        let expected = [
            utc(1_001_500_000_000),
            utc(7_000_000_001),
            utc(1_500_000_000),
            None,
            None,
        ];
        assert_eq!(stamps, expected, "{order:?}");
    }
}

#[test]
fn simple_packets_are_of_the_first_interface_and_bounded_by_its_limit() {
    let order = Order::Big;
    let frame = usual(&BLOCK.repeat(3));
    let limit = frame.len() - 6;
    let bytes = [
        section(order),
        interface(order, 1, limit as u32, &[]),
        simple(order, &usual(BLOCK), usual(BLOCK).len()),
        simple(order, &frame, limit),
    ]
    .concat();
    let found = unpack(&bytes);
    assert_eq!(found.datagrams, [(BLOCK.to_vec(), None)]);
    let cut = Reason::PacketCut {
        captured: limit,
        original: frame.len(),
    };
    assert_eq!(found.reasons(), [cut]);
}

#[test]
fn a_new_section_forgets_the_interfaces() {
    let order = Order::Little;
    let bytes = [
        section(order),
        interface(order, 1, 0, &[]),
        enhanced(order, 1, 0, &usual(BLOCK)),
        section(order),
        enhanced(order, 0, 0, &usual(BLOCK)),
        simple(order, &usual(BLOCK), usual(BLOCK).len()),
    ]
    .concat();
    let found = unpack(&bytes);
    let unknown = |interface, described| Reason::Interface { interface, described };
    assert_eq!(found.reasons(), [unknown(1, 1), unknown(0, 0), unknown(0, 0)]);
    assert_eq!(found.counts.packets_refused, 3);
}

/// Blocks without packets are framing, unknown ones are said; neither harms what follows.
#[test]
fn other_blocks_are_passed_over() {
    let order = Order::Little;
    let packet = enhanced(order, 0, 0, &usual(BLOCK));
    let begin = [section(order), interface(order, 1, 0, &[])].concat();
    let bytes = [
        begin.clone(),
        ng_block(order, 4, &[0; 4]),
        ng_block(order, 5, &[0; 12]),
        ng_block(order, 0xBAD, &[1, 2, 3, 4]),
        ng_block(order, 2, &[0; 20]),
        packet,
    ]
    .concat();
    let found = unpack(&bytes);
    assert_eq!(found.payloads(), [BLOCK]);
    let at = begin.len() + 16 + 24 + 16;
    assert_eq!(found.skipped, [(at, Reason::BlockType { block_type: 2 })]);
}

#[test]
fn damage_within_a_block_harms_this_block_only() {
    let order = Order::Little;
    let mut damaged = enhanced(order, 0, 0, &usual(BLOCK));
    let octets = damaged.len();
    damaged[20] = 0xFF; // more octets captured than the block has
    let good = enhanced(order, 0, 0, &usual(BLOCK));
    let begin = [section(order), interface(order, 1, 0, &[])].concat();
    let found = unpack(&[begin.clone(), damaged, good].concat());
    assert_eq!(found.payloads(), [BLOCK]);
    let content = Reason::BlockContent { block_type: 6, octets };
    assert_eq!(found.skipped, [(begin.len(), content)]);
}

/// Longer than any packet, and not worth the memory that its options would take.
#[test]
fn a_block_of_more_than_a_megabyte_is_not_parsed() {
    let order = Order::Little;
    let long = ng_block(order, 1, &vec![0; 1 << 20]);
    let begin = section(order);
    let rest = [interface(order, 1, 0, &[]), enhanced(order, 0, 0, &usual(BLOCK))].concat();
    let found = unpack(&[begin, long, rest].concat());
    assert_eq!(found.payloads(), [BLOCK]);
    assert!(matches!(
        found.reasons()[..],
        [Reason::BlockContent {
            block_type: 1,
            octets: 1_048_588
        }]
    ));
}

#[test]
fn lengths_that_cannot_be_end_the_recording() {
    let order = Order::Big;
    let begin = [
        section(order),
        interface(order, 1, 0, &[]),
        enhanced(order, 0, 0, &usual(BLOCK)),
    ]
    .concat();
    let block = enhanced(order, 0, 0, &usual(BLOCK));
    let with = |place: usize, octet: u8| {
        let mut changed = block.clone();
        changed[place] = octet;
        [begin.clone(), changed, block.clone()].concat()
    };
    let length = block.len();
    let cases = [
        (
            with(7, 8),
            Reason::BlockLength {
                length: 8,
                trailing: None,
            },
        ),
        (
            with(length - 1, 1),
            Reason::BlockLength {
                length,
                trailing: Some(1),
            },
        ),
        (
            with(5, 1),
            Reason::FileCut {
                needed: length + 0x1_0000,
                available: 2 * length,
            },
        ),
        (
            [begin.clone(), vec![0, 0, 0, 6, 0]].concat(),
            Reason::FileCut {
                needed: 12,
                available: 5,
            },
        ),
        (
            [begin.clone(), ng_block(order, 0x0A0D_0D0A, &[9; 16])].concat(),
            Reason::ByteOrder { mark: 0x0909_0909 },
        ),
    ];
    for (bytes, expected) in cases {
        let found = unpack(&bytes);
        assert_eq!(
            (found.payloads(), &found.skipped[..]),
            (vec![BLOCK], &[(begin.len(), expected)][..])
        );
    }
}

#[test]
fn a_recording_cut_anywhere_keeps_what_is_before() {
    let order = Order::Little;
    let begin = [
        section(order),
        interface(order, 1, 0, &[]),
        enhanced(order, 0, 0, &usual(BLOCK)),
    ]
    .concat();
    let whole = [begin.clone(), enhanced(order, 0, 0, &usual(BLOCK))].concat();
    for length in begin.len() + 1..whole.len() {
        let found = unpack(&whole[..length]);
        assert_eq!(found.payloads(), [BLOCK]);
        assert!(matches!(found.skipped[..], [(at, Reason::FileCut { .. })] if at == begin.len()));
    }
}

#[test]
fn what_is_no_capture_is_refused_as_one() {
    let expected = Container::PcapNg;
    let found = unpack_as(Container::PcapNg, &ethernet(0x0800, BLOCK));
    assert_eq!(found.skipped, [(0, Reason::OtherContainer { expected })]);
}

/// A block of category 010 can begin with the bytes of a section, but not with its byte-order mark.
#[test]
fn blocks_that_look_like_a_section_are_raw() {
    let mut block = vec![0x0A, 0x0D, 0x0D, 0x0A];
    block.resize(0x0D0D, 0);
    assert_eq!(Container::detect(&block), Container::Raw);
}
