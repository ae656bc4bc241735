//! Any bytes whatever: no panic, no endless loop, no byte lost; and what was packed is unpacked.

use formats::containers::Container;
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::{Index, select};

use super::forge::{
    Order, capture_of, enhanced, ethernet, final_frame, interface, ipv4, ipv4_fragment, ipv6, section, simple, udp,
    unpack, unpack_as, usual,
};

/// A recording of some kind that holds these payloads, in this order.
fn packed(kind: usize, payloads: &[Vec<u8>]) -> Vec<u8> {
    let cooked = |payload: &Vec<u8>| [vec![0; 14], vec![0x86, 0xDD], ipv6(17, &udp(payload))].concat();
    let tagged = |payload: &Vec<u8>| ethernet(0x8100, &[vec![0, 1, 8, 0], ipv4(17, &udp(payload))].concat());
    let of_all = |make: &dyn Fn(&Vec<u8>) -> Vec<u8>| payloads.iter().map(make).collect::<Vec<_>>();
    match kind {
        0 => capture_of(1, &of_all(&|payload| usual(payload))),
        1 => capture_of(113, &of_all(&cooked)),
        2 => capture_of(1, &of_all(&tagged)),
        3 => of_all(&|payload| final_frame(7, payload)).concat(),
        4 => {
            let order = Order::Big;
            let begin = [section(order), interface(order, 1, 0, &[(9, &[9])])].concat();
            let blocks = of_all(&|payload| enhanced(order, 0, 77, &usual(payload)));
            [begin, blocks.concat()].concat()
        }
        5 => {
            let order = Order::Little;
            let begin = [section(order), interface(order, 101, 0, &[])].concat();
            let blocks = of_all(&|payload| {
                let packet = ipv4(17, &udp(payload));
                simple(order, &packet, packet.len())
            });
            [begin, blocks.concat()].concat()
        }
        _ => {
            let numbered = payloads.iter().zip(0..);
            let fragments = numbered.flat_map(|(payload, number)| {
                let datagram = udp(payload);
                let (first, last) = datagram.split_at(8);
                [(first, 0x2000), (last, 1)].map(|(part, place)| ipv4_fragment(17, number, place, part))
            });
            capture_of(228, &fragments.collect::<Vec<_>>())
        }
    }
}

const KINDS: usize = 7;

proptest! {
    #[test]
    fn arbitrary_bytes_are_read_to_their_end(
        bytes in vec(any::<u8>(), 0..400),
        container in select(Container::ALL.to_vec()),
    ) {
        unpack(&bytes);
        unpack_as(container, &bytes);
    }

    /// Behind the header of a capture, so that the bytes are taken for records, blocks or packets.
    #[test]
    fn arbitrary_bytes_in_a_capture_are_read_to_their_end(
        bytes in vec(any::<u8>(), 0..200),
        link_type in select(vec![0, 1, 101, 105, 108, 113, 228, 229, 276]),
        kind in 0..KINDS,
    ) {
        unpack(&capture_of(link_type, &[bytes.clone(), bytes.clone()]));
        unpack(&[packed(kind, &[]), bytes].concat());
    }

    #[test]
    fn what_was_packed_is_unpacked(
        payloads in vec(vec(any::<u8>(), 1..60), 1..8),
        kind in 0..KINDS,
    ) {
        let found = unpack(&packed(kind, &payloads));
        prop_assert_eq!(found.payloads(), payloads);
        prop_assert_eq!(found.skipped, vec![]);
    }

    #[test]
    fn a_damaged_recording_is_read_to_its_end(
        payloads in vec(vec(any::<u8>(), 1..60), 1..8),
        kind in 0..KINDS,
        damage in vec((any::<Index>(), any::<u8>()), 1..6),
        kept in any::<Index>(),
        container in select(Container::ALL.to_vec()),
    ) {
        let mut bytes = packed(kind, &payloads);
        for (place, octet) in damage {
            let place = place.index(bytes.len());
            bytes[place] = octet;
        }
        unpack(&bytes);
        unpack_as(container, &bytes);
        bytes.truncate(kept.index(bytes.len()) + 1);
        unpack(&bytes);
    }
}
