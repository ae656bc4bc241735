//! Writing captures, in the newer format.
//!
//! A capture is a section with a single interface; packets begin with the IP header and have stamps in nanoseconds.
//! Headers of IP and UDP are constructed from the addresses; the payload is unchanged.

use core::net::{IpAddr, SocketAddr};
use std::io;

use etherparse::PacketBuilder;
use pcap_parser::{BOM_MAGIC, EPB_MAGIC, IDB_MAGIC, Linktype, OptionCode, SHB_MAGIC};

/// Hops that made-up headers allow.
const HOPS: u8 = 64;
/// Resolution of stamps: this negative power of ten of a second.
const NANOSECONDS: u8 = 9;

/// Way of a datagram, as far as it is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DatagramRoute {
    /// Sender.
    pub from: SocketAddr,
    /// Receiver, or the group.
    pub to: SocketAddr,
    /// Time of receipt, UTC, nanoseconds; not before 1970.
    pub received_utc_ns: i64,
}

/// Beginning of a capture.
pub fn begin_capture() -> Vec<u8> {
    let mut out = Vec::new();
    // Version 1.0; how long the section becomes is not known.
    let version = 1_u32.to_le_bytes();
    block(
        SHB_MAGIC,
        &[&BOM_MAGIC.to_le_bytes(), &version, &(-1_i64).to_le_bytes()],
        &mut out,
    );
    let link = Linktype::RAW.0.to_le_bytes();
    let (no_limit, end) = ([0; 4], [0; 4]);
    let [code, _] = OptionCode::IfTsresol.0.to_le_bytes();
    block(
        IDB_MAGIC,
        &[&link, &no_limit, &[code, 0, 1, 0, NANOSECONDS, 0, 0, 0], &end],
        &mut out,
    );
    out
}

/// Appends the packet of a datagram to a capture.
///
/// # Errors
/// If the payload is longer than any datagram's, or the time is before 1970; nothing is appended.
pub fn capture(way: &DatagramRoute, payload: &[u8], out: &mut Vec<u8>) -> io::Result<()> {
    let builder = match (way.from.ip(), way.to.ip()) {
        (IpAddr::V4(from), IpAddr::V4(to)) => PacketBuilder::ipv4(from.octets(), to.octets(), HOPS),
        (from, to) => {
            let octets = |address| match address {
                IpAddr::V4(address) => address.to_ipv6_mapped().octets(),
                IpAddr::V6(address) => address.octets(),
            };
            PacketBuilder::ipv6(octets(from), octets(to), HOPS)
        }
    };
    let builder = builder.udp(way.from.port(), way.to.port());
    let mut packet = Vec::with_capacity(builder.size(payload.len()));
    builder.write(&mut packet, payload).map_err(io::Error::other)?;
    let stamp = u64::try_from(way.received_utc_ns).map_err(io::Error::other)?;
    let stamp = [((stamp >> 32) as u32).to_le_bytes(), (stamp as u32).to_le_bytes()].concat();
    let octets = (packet.len() as u32).to_le_bytes();
    let interface = [0; 4];
    block(EPB_MAGIC, &[&interface, &stamp, &octets, &octets, &packet], out);
    Ok(())
}

/// Appends a block: its length stands at both ends, and counts padding.
fn block(kind: u32, body: &[&[u8]], out: &mut Vec<u8>) {
    let octets: usize = body.iter().map(|part| part.len()).sum();
    let padded = octets.next_multiple_of(4);
    let length = (padded as u32 + 12).to_le_bytes();
    out.extend(kind.to_le_bytes());
    out.extend(length);
    body.iter().for_each(|part| out.extend_from_slice(part));
    out.resize(out.len() + padded - octets, 0);
    out.extend(length);
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::{Container, TimeStamp, datagrams};
    use super::*;

    fn address() -> impl Strategy<Value = SocketAddr> {
        any::<(IpAddr, u16)>().prop_map(SocketAddr::from)
    }

    proptest! {
        /// Any datagrams are read back unchanged, also from concatenated captures.
        #[test]
        fn what_is_written_is_read_back(
            sent in prop::collection::vec(
                (address(), address(), 0..i64::MAX, prop::collection::vec(any::<u8>(), 0..300)), 0..20),
            parts in 1usize..3,
            longest in prop::bool::ANY,
        ) {
            let mut octets = Vec::new();
            let mut sent = sent;
            if let (true, Some((.., payload))) = (longest, sent.first_mut()) {
                payload.resize(65_507, 0xA5);
            }
            for part in sent.chunks(sent.len().div_ceil(parts).max(1)) {
                octets.extend(begin_capture());
                for (from, to, received_utc_ns, payload) in part {
                    let way = DatagramRoute { from: *from, to: *to, received_utc_ns: *received_utc_ns };
                    capture(&way, payload, &mut octets).unwrap();
                }
            }
            prop_assert!(sent.is_empty() || Container::detect(&octets) == Container::PcapNg);
            let read = datagrams(&octets).map(|datagram| {
                let datagram = datagram.unwrap();
                (datagram.time_stamp, datagram.bytes.into_owned())
            });
            let read: Vec<_> = read.collect();
            let expected = sent.into_iter().map(|(_, _, ns, payload)| (Some(TimeStamp::Utc { ns }), payload));
            prop_assert_eq!(read, expected.collect::<Vec<_>>());
        }

        /// A capture that ends within a packet gives the earlier packets.
        #[test]
        fn a_torn_capture_gives_what_is_whole(payload in prop::collection::vec(any::<u8>(), 1..100), cut in 1usize..40) {
            let way = DatagramRoute {
                from: "192.0.2.1:8600".parse().unwrap(),
                to: "239.255.0.1:8600".parse().unwrap(),
                received_utc_ns: 1,
            };
            let mut octets = begin_capture();
            capture(&way, &payload, &mut octets).unwrap();
            capture(&way, &payload, &mut octets).unwrap();
            octets.truncate(octets.len() - cut);
            let whole: Vec<_> = datagrams(&octets).flatten().map(|datagram| datagram.bytes.into_owned()).collect();
            prop_assert_eq!(whole, [payload]);
        }
    }
}
