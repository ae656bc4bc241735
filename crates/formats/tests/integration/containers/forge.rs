//! Recordings made by hand, byte by byte, from the documents of each layer.

use formats::containers::{Container, ContainerCounts, Datagrams, Reason, TimeStamp, datagrams};

/// What the tests send: one data block of category 048 with one byte of body.
pub(crate) const BLOCK: &[u8] = &[48, 0, 4, 0xAB];

/// A layout of numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Order {
    Big,
    Little,
}

impl Order {
    pub(crate) fn u16(self, value: u16) -> [u8; 2] {
        match self {
            Self::Big => value.to_be_bytes(),
            Self::Little => value.to_le_bytes(),
        }
    }

    pub(crate) fn u32(self, value: u32) -> [u8; 4] {
        match self {
            Self::Big => value.to_be_bytes(),
            Self::Little => value.to_le_bytes(),
        }
    }
}

/// A pcap file: magic number, version 2.4, zone and accuracy 0, limit, link type.
pub(crate) fn pcap(order: Order, magic: u32, link_type: u32, records: &[Vec<u8>]) -> Vec<u8> {
    let mut bytes = order.u32(magic).to_vec();
    bytes.extend(order.u16(2));
    bytes.extend(order.u16(4));
    bytes.extend([0; 8]);
    bytes.extend(order.u32(65_535));
    bytes.extend(order.u32(link_type));
    bytes.extend(records.concat());
    bytes
}

/// A packet in a pcap file.
pub(crate) fn record(order: Order, seconds: u32, fraction: u32, packet: &[u8]) -> Vec<u8> {
    cut_record(order, seconds, fraction, packet, packet.len())
}

/// A packet of which less was captured than it had.
pub(crate) fn cut_record(order: Order, seconds: u32, fraction: u32, packet: &[u8], original: usize) -> Vec<u8> {
    let lengths = [packet.len() as u32, original as u32];
    let numbers = [seconds, fraction, lengths[0], lengths[1]];
    let mut bytes: Vec<u8> = numbers.iter().flat_map(|number| order.u32(*number)).collect();
    bytes.extend(packet);
    bytes
}

/// A little-endian capture of Ethernet frames, one per second from 1 on.
pub(crate) fn capture(packets: &[Vec<u8>]) -> Vec<u8> {
    capture_of(1, packets)
}

/// The same from another link.
pub(crate) fn capture_of(link_type: u32, packets: &[Vec<u8>]) -> Vec<u8> {
    let seconds = 1..;
    let records: Vec<Vec<u8>> = seconds
        .zip(packets)
        .map(|(seconds, packet)| record(Order::Little, seconds, 0, packet))
        .collect();
    pcap(Order::Little, 0xA1B2_C3D4, link_type, &records)
}

/// A block of a pcapng file: type, length, content padded to four bytes, length.
pub(crate) fn ng_block(order: Order, block_type: u32, content: &[u8]) -> Vec<u8> {
    let padded = content.len().next_multiple_of(4);
    let length = order.u32(padded as u32 + 12);
    let mut bytes = order.u32(block_type).to_vec();
    bytes.extend(length);
    bytes.extend(content);
    bytes.resize(8 + padded, 0);
    bytes.extend(length);
    bytes
}

/// Begin of a section of unknown length.
pub(crate) fn section(order: Order) -> Vec<u8> {
    let mut content = order.u32(0x1A2B_3C4D).to_vec();
    content.extend(order.u16(1));
    content.extend(order.u16(0));
    content.extend([0xFF; 8]);
    ng_block(order, 0x0A0D_0D0A, &content)
}

/// An interface; options are pairs of code and value.
pub(crate) fn interface(order: Order, link_type: u16, snap_octets: u32, options: &[(u16, &[u8])]) -> Vec<u8> {
    let mut content = order.u16(link_type).to_vec();
    content.extend([0; 2]);
    content.extend(order.u32(snap_octets));
    for (code, value) in options {
        content.extend(order.u16(*code));
        content.extend(order.u16(value.len() as u16));
        content.extend(*value);
        content.resize(content.len().next_multiple_of(4), 0);
    }
    if !options.is_empty() {
        content.extend([0; 4]);
    }
    ng_block(order, 1, &content)
}

/// An enhanced packet.
pub(crate) fn enhanced(order: Order, interface: u32, stamp: u64, packet: &[u8]) -> Vec<u8> {
    let length = packet.len() as u32;
    let numbers = [interface, (stamp >> 32) as u32, stamp as u32, length, length];
    let mut content: Vec<u8> = numbers.iter().flat_map(|number| order.u32(*number)).collect();
    content.extend(packet);
    ng_block(order, 6, &content)
}

/// A simple packet, of which at most `kept` bytes are there.
pub(crate) fn simple(order: Order, packet: &[u8], kept: usize) -> Vec<u8> {
    let mut content = order.u32(packet.len() as u32).to_vec();
    content.extend(&packet[..kept]);
    ng_block(order, 3, &content)
}

/// A frame of the final format.
pub(crate) fn final_frame(hundredths: u32, payload: &[u8]) -> Vec<u8> {
    let length = payload.len() as u16 + 12;
    let time = hundredths.to_be_bytes();
    let mut bytes = length.to_be_bytes().to_vec();
    bytes.extend([7, 3, 0, time[1], time[2], time[3]]);
    bytes.extend(payload);
    bytes.extend([0xA5; 4]);
    bytes
}

/// A gps recording of blocks with their ten octets.
pub(crate) fn gps(pieces: &[Vec<u8>]) -> Vec<u8> {
    [vec![0; 2_200], pieces.concat()].concat()
}

/// A block of a gps recording, with its time in 1/128 s.
pub(crate) fn gps_block(ticks: u32, block: &[u8]) -> Vec<u8> {
    let [_, high, middle, low] = ticks.to_be_bytes();
    [block, &[0, 1, 2, 0, 0, 0, high, middle, low, 1]].concat()
}

/// An Ethernet frame.
pub(crate) fn ethernet(ether_type: u16, payload: &[u8]) -> Vec<u8> {
    let mut bytes = vec![1, 0, 0x5E, 1, 2, 3, 0, 1, 2, 3, 4, 5];
    bytes.extend(ether_type.to_be_bytes());
    bytes.extend(payload);
    bytes
}

/// A UDP datagram from port 1000 to port 2000, without checksum.
pub(crate) fn udp(payload: &[u8]) -> Vec<u8> {
    let mut bytes = [1000u16, 2000, payload.len() as u16 + 8, 0]
        .map(u16::to_be_bytes)
        .concat();
    bytes.extend(payload);
    bytes
}

/// An IPv4 packet, or a fragment of one: `place` holds its offset in units of eight bytes, and with the bit 0x2000
/// that more follow.
pub(crate) fn ipv4_fragment(protocol: u8, identification: u16, place: u16, payload: &[u8]) -> Vec<u8> {
    let mut bytes = vec![0x45, 0];
    bytes.extend((payload.len() as u16 + 20).to_be_bytes());
    bytes.extend(identification.to_be_bytes());
    bytes.extend(place.to_be_bytes());
    bytes.extend([16, protocol, 0, 0, 10, 0, 0, 1, 239, 1, 2, 3]);
    bytes.extend(payload);
    bytes
}

/// A whole IPv4 packet.
pub(crate) fn ipv4(protocol: u8, payload: &[u8]) -> Vec<u8> {
    ipv4_fragment(protocol, 0, 0, payload)
}

/// A whole IPv6 packet; `next` is what its header announces.
pub(crate) fn ipv6(next: u8, payload: &[u8]) -> Vec<u8> {
    let mut bytes = vec![0x60, 0, 0, 0];
    bytes.extend((payload.len() as u16).to_be_bytes());
    bytes.extend([next, 16]);
    bytes.extend([0xFD; 16]);
    bytes.extend([0xFF; 16]);
    bytes.extend(payload);
    bytes
}

/// The IPv6 header of a fragment, and the fragment.
pub(crate) fn ipv6_fragment(identification: u32, units: u16, more: bool, payload: &[u8]) -> Vec<u8> {
    let mut extension = vec![17, 0];
    extension.extend((units << 3 | u16::from(more)).to_be_bytes());
    extension.extend(identification.to_be_bytes());
    extension.extend(payload);
    ipv6(44, &extension)
}

/// The frame in which most data blocks travel: Ethernet, IPv4, UDP.
pub(crate) fn usual(payload: &[u8]) -> Vec<u8> {
    ethernet(0x0800, &ipv4(17, &udp(payload)))
}

/// Everything a recording gave.
#[derive(Debug, PartialEq)]
pub(crate) struct Unpacked {
    pub(crate) datagrams: Vec<(Vec<u8>, Option<TimeStamp>)>,
    pub(crate) skipped: Vec<(usize, Reason)>,
    pub(crate) counts: ContainerCounts,
}

impl Unpacked {
    /// The bytes of the datagrams.
    pub(crate) fn payloads(&self) -> Vec<&[u8]> {
        self.datagrams.iter().map(|(bytes, _)| bytes.as_slice()).collect()
    }

    /// Why parts were skipped.
    pub(crate) fn reasons(&self) -> Vec<Reason> {
        self.skipped.iter().map(|(_, why)| why.clone()).collect()
    }
}

/// Unpacks a recording of the kind that its bytes tell.
pub(crate) fn unpack(bytes: &[u8]) -> Unpacked {
    unpack_from(datagrams(bytes), bytes)
}

/// Unpacks a recording of a kind that is given.
pub(crate) fn unpack_as(container: Container, bytes: &[u8]) -> Unpacked {
    unpack_from(Datagrams::new(container, bytes), bytes)
}

/// Unpacks everything, and checks what must hold for any bytes.
fn unpack_from(mut source: Datagrams<'_>, bytes: &[u8]) -> Unpacked {
    let (mut given, mut skipped) = (Vec::new(), Vec::new());
    for piece in source.by_ref() {
        match piece {
            Ok(datagram) => {
                if let std::borrow::Cow::Borrowed(octets) = datagram.bytes {
                    assert_eq!(&bytes[datagram.offset..][..octets.len()], octets);
                }
                given.push((datagram.bytes.into_owned(), datagram.time_stamp));
            }
            Err(part) => {
                assert!(
                    part.offset + part.octets <= bytes.len() || part.why.label() == "incomplete fragments",
                    "{part:?}"
                );
                assert!(part.to_string().starts_with(&format!("byte {}: ", part.offset)));
                assert!(!part.why.label().is_empty());
                skipped.push((part.offset, part.why));
            }
        }
    }
    assert!(source.next().is_none(), "the end is the end");
    let counts = *source.counts();
    assert_eq!(counts.datagrams, given.len() as u64);
    assert_eq!(
        counts.datagram_octets,
        given.iter().map(|(bytes, _)| bytes.len() as u64).sum::<u64>()
    );
    assert_eq!(
        counts.datagram_octets + counts.framing_octets + counts.octets_skipped,
        bytes.len() as u64,
        "{counts:?}"
    );
    let causes = counts.packets_other + counts.packets_refused + counts.packets_incomplete + counts.damages;
    assert_eq!(causes, skipped.len() as u64, "{counts:?}");
    Unpacked {
        datagrams: given,
        skipped,
        counts,
    }
}
