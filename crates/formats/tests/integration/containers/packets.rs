//! From packets to payloads: links, tags, IP and UDP, logical link control, fragments.

use formats::containers::{FRAGMENTED_MAX, Reason, TimeStamp};

use super::forge::{
    BLOCK, capture, capture_of, ethernet, ipv4, ipv4_fragment, ipv6, ipv6_fragment, udp, unpack, usual,
};

/// One packet of a link, and what it gives.
fn of_link(link_type: u32, packet: &[u8]) -> Result<Vec<u8>, Reason> {
    let mut found = unpack(&capture_of(link_type, &[packet.to_vec()]));
    match (found.datagrams.pop(), found.skipped.pop()) {
        (Some((bytes, _)), None) => Ok(bytes),
        (None, Some((offset, why))) => {
            assert_eq!(offset, 40);
            Err(why)
        }
        other => panic!("{other:?}"),
    }
}

fn of_ethernet(packet: &[u8]) -> Result<Vec<u8>, Reason> {
    of_link(1, packet)
}

#[test]
fn both_versions_of_ip_carry_udp() {
    assert_eq!(of_ethernet(&usual(BLOCK)).unwrap(), BLOCK);
    assert_eq!(of_ethernet(&ethernet(0x86DD, &ipv6(17, &udp(BLOCK)))).unwrap(), BLOCK);
    // IPv4 with an option of four bytes, IPv6 with eight bytes of destination options.
    let mut with_option = ipv4(17, &udp(BLOCK));
    with_option[0] = 0x46;
    with_option[3] += 4;
    with_option.splice(20..20, [1, 1, 1, 0]);
    assert_eq!(of_ethernet(&ethernet(0x0800, &with_option)).unwrap(), BLOCK);
    let options = [vec![17, 0, 1, 4, 0, 0, 0, 0], udp(BLOCK)].concat();
    assert_eq!(of_ethernet(&ethernet(0x86DD, &ipv6(60, &options))).unwrap(), BLOCK);
}

/// Ethernet pads frames to 60 bytes, and some captures keep the check sequence behind them.
#[test]
fn padding_is_no_payload() {
    let mut padded = usual(BLOCK);
    padded.resize(64, 0xEE);
    assert_eq!(of_ethernet(&padded).unwrap(), BLOCK);
    let mut padded = ethernet(7, &[0x20, 0x20, 3]);
    padded.extend(BLOCK);
    padded.resize(60, 0xEE);
    assert_eq!(of_ethernet(&padded).unwrap(), BLOCK);
    // UDP may be shorter than the IP packet around it.
    let datagram = [udp(BLOCK), vec![0xEE; 3]].concat();
    assert_eq!(of_ethernet(&ethernet(0x0800, &ipv4(17, &datagram))).unwrap(), BLOCK);
}

#[test]
fn tags_of_virtual_networks_are_stepped_over() {
    let ip = ipv4(17, &udp(BLOCK));
    let inner = [vec![0x00, 0x07, 0x08, 0x00], ip].concat();
    let outer = [vec![0x00, 0x09, 0x81, 0x00], inner.clone()].concat();
    assert_eq!(of_ethernet(&ethernet(0x8100, &inner)).unwrap(), BLOCK);
    for tag in [0x8100, 0x88A8, 0x9100] {
        assert_eq!(of_ethernet(&ethernet(tag, &outer)).unwrap(), BLOCK);
    }
    let tagged_802_3 = [&[0, 7, 0, 7, 0x20, 0x20, 3], BLOCK, &[0; 30]].concat();
    assert_eq!(of_ethernet(&ethernet(0x8100, &tagged_802_3)).unwrap(), BLOCK);
    let only_a_tag = Reason::Header {
        layer: "VLAN",
        captured: 16,
    };
    assert_eq!(of_ethernet(&ethernet(0x8100, &[0, 7])), Err(only_a_tag));
}

#[test]
fn every_known_link_leads_to_the_same_payload() {
    let (v4, v6) = (ipv4(17, &udp(BLOCK)), ipv6(17, &udp(BLOCK)));
    let cooked = [vec![0; 14], vec![0x08, 0x00], v4.clone()].concat();
    let cooked_2 = [vec![0x86, 0xDD], vec![0; 18], v6.clone()].concat();
    let cases = [
        (0, [vec![2, 0, 0, 0], v4.clone()].concat()),
        (0, [vec![0, 0, 0, 30], v6.clone()].concat()),
        (108, [vec![0, 0, 0, 2], v4.clone()].concat()),
        (101, v4.clone()),
        (101, v6.clone()),
        (228, v4),
        (229, v6),
        (113, cooked),
        (276, cooked_2),
    ];
    for (link_type, packet) in cases {
        assert_eq!(of_link(link_type, &packet).unwrap(), BLOCK, "{link_type}");
    }
    assert_eq!(of_link(105, &usual(BLOCK)), Err(Reason::LinkType { link_type: 105 }));
    // A cooked capture of frames without EtherType: its number is no length.
    let bare = [vec![0; 14], vec![0, 4, 0x20, 0x20, 3], BLOCK.to_vec()].concat();
    assert_eq!(of_link(113, &bare), Err(Reason::EtherType { ether_type: 4 }));
}

#[test]
fn other_protocols_are_counted_and_are_no_damage() {
    let spanning_tree = [&[0x42, 0x42, 3], BLOCK].concat();
    let numbered = [&[0x20, 0x20, 0, 0], BLOCK].concat();
    let packets = [
        ethernet(0x0806, &[0; 46]),
        ethernet(0x0800, &ipv4(6, &[0; 20])),
        ethernet(0x86DD, &ipv6(58, &[0; 8])),
        ethernet(spanning_tree.len() as u16, &spanning_tree),
        ethernet(numbered.len() as u16, &numbered),
        usual(BLOCK),
    ];
    let found = unpack(&capture(&packets));
    assert_eq!(found.payloads(), [BLOCK]);
    let expected = [
        Reason::EtherType { ether_type: 0x0806 },
        Reason::Transport { protocol: 6 },
        Reason::Transport { protocol: 58 },
        Reason::LogicalLink {
            service: 0x42,
            control: 3,
        },
        Reason::LogicalLink {
            service: 0x20,
            control: 0,
        },
    ];
    assert_eq!(found.reasons(), expected);
    assert!(expected.iter().all(|why| why.label() == "other protocol"));
    assert_eq!((found.counts.packets_other, found.counts.damages), (5, 0));
}

#[test]
fn headers_that_cannot_be_are_refused() {
    let with = |place: usize, octet: u8| {
        let mut packet = usual(BLOCK);
        packet[place] = octet;
        packet
    };
    let cases = [
        (vec![1, 2, 3], "Ethernet"),
        (with(14, 0x44), "IP"), // a header of four words
        (with(14, 0x75), "IP"), // version 7
        (with(17, 33), "IP"),   // longer by one octet than the frame
        (with(17, 19), "IP"),   // shorter than its own header
        (with(39, 13), "UDP"),  // longer than the packet
        (with(39, 7), "UDP"),   // shorter than its own header
        (ethernet(100, BLOCK), "802.3"),
        (ethernet(2, BLOCK), "802.2"),
    ];
    for (packet, layer) in cases {
        let captured = packet.len();
        assert_eq!(of_ethernet(&packet), Err(Reason::Header { layer, captured }));
    }
    for (link_type, layer) in [
        (0, "loopback"),
        (113, "Linux cooked"),
        (276, "Linux cooked"),
        (101, "IP"),
    ] {
        assert_eq!(of_link(link_type, &[]), Err(Reason::Header { layer, captured: 0 }));
    }
}

/// 24 bytes of payload and 8 of UDP in fragments of 16 and 16, for either version of IP.
fn fragments(identification: u16, payload: &[u8]) -> [[Vec<u8>; 2]; 2] {
    let datagram = udp(payload);
    let (first, last) = datagram.split_at(16);
    let number = u32::from(identification);
    [
        [
            ethernet(0x0800, &ipv4_fragment(17, identification, 0x2000, first)),
            ethernet(0x0800, &ipv4_fragment(17, identification, 2, last)),
        ],
        [
            ethernet(0x86DD, &ipv6_fragment(number, 0, true, first)),
            ethernet(0x86DD, &ipv6_fragment(number, 2, false, last)),
        ],
    ]
}

#[test]
fn fragments_are_put_together_in_any_order() {
    let payload = BLOCK.repeat(6);
    for [first, last] in fragments(1, &payload) {
        for packets in [[first.clone(), last.clone()], [last.clone(), first.clone()]] {
            let bytes = capture(&[packets[0].clone(), usual(BLOCK), packets[1].clone()]);
            let found = unpack(&bytes);
            // The time is that of the first fragment to come.
            let time = |seconds: i64| {
                Some(TimeStamp::Utc {
                    ns: seconds * 1_000_000_000,
                })
            };
            assert_eq!(found.datagrams, [(BLOCK.to_vec(), time(2)), (payload.clone(), time(1))]);
            assert_eq!((found.counts.datagrams_joined, found.skipped.len()), (1, 0));
        }
    }
}

#[test]
fn fragments_of_different_datagrams_do_not_mix() {
    let (even, odd) = (BLOCK.repeat(6), BLOCK.repeat(7));
    let [[first_a, last_a], _] = fragments(1, &even);
    let [[first_b, last_b], _] = fragments(2, &odd);
    let found = unpack(&capture(&[first_a, first_b, last_b, last_a]));
    assert_eq!(found.payloads(), [&odd, &even]);
}

#[test]
fn incomplete_fragments_are_counted_at_the_end() {
    let [[first, last], _] = fragments(1, &BLOCK.repeat(6));
    let found = unpack(&capture(&[first.clone(), first.clone()]));
    assert_eq!(found.skipped, [(40, Reason::Fragments { fragments: 2 })]);
    assert_eq!(found.counts.octets_skipped, 2 * first.len() as u64);
    assert_eq!(found.counts.packets_incomplete, 1);
    // A second end that contradicts the first.
    let longer = ethernet(0x0800, &ipv4_fragment(17, 1, 2, &[0; 32]));
    let found = unpack(&capture(&[last, longer]));
    assert_eq!(found.reasons(), [Reason::Fragments { fragments: 2 }]);
    // Complete, and no UDP datagram.
    let damaged = [
        ethernet(0x0800, &ipv4_fragment(17, 1, 0x2000, &[0xFF; 8])),
        ethernet(0x0800, &ipv4_fragment(17, 1, 1, &[0xFF; 8])),
    ];
    let found = unpack(&capture(&damaged));
    assert_eq!(found.reasons(), [Reason::Fragments { fragments: 2 }]);
}

#[test]
fn only_so_many_datagrams_are_kept_open() {
    let payload = BLOCK.repeat(6);
    let begun: Vec<Vec<u8>> = (0..=FRAGMENTED_MAX as u16)
        .map(|number| fragments(number, &payload)[0][0].clone())
        .collect();
    let ends = [1, FRAGMENTED_MAX as u16].map(|number| fragments(number, &payload)[0][1].clone());
    let found = unpack(&capture(&[begun, ends.to_vec()].concat()));
    // The oldest had to go for the last; two are completed, the others never.
    assert_eq!(found.payloads(), [&payload, &payload]);
    assert_eq!(found.skipped.len(), FRAGMENTED_MAX - 1);
    assert_eq!(found.skipped[0], (40, Reason::Fragments { fragments: 1 }));
}
