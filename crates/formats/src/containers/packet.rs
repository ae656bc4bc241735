//! From a captured packet to the payload that may be data blocks: link, network, transport.

use core::net::IpAddr;

use etherparse::{
    EtherType, Ethernet2Slice, IpFragOffset, IpNumber, IpSlice, Ipv6ExtensionSlice, SingleVlanSlice, UdpSlice,
};

use super::TimeStamp;
use super::skipped::{Reason, Skipped};

/// The largest EtherType that is none, but the length of an IEEE 802.3 frame.
const FRAME_OCTETS_MAX: u16 = 1500;
/// Service access points of 802.2 that belong to other protocols for sure: spanning tree, SNAP, IPX, NetBIOS, ISO.
const OTHER_SERVICES: [u8; 5] = [0x42, 0xAA, 0xE0, 0xF0, 0xFE];
/// The control field of a frame that simply carries data: unnumbered information.
const UNNUMBERED_INFORMATION: u8 = 0x03;

/// Captured packet.
#[derive(Debug, Clone, Copy)]
pub(super) struct Packet<'a> {
    pub(super) interface: u32,
    pub(super) link_type: i32,
    pub(super) time_stamp: Option<TimeStamp>,
    /// Place of its first byte in the recording.
    pub(super) offset: usize,
    /// Bytes of it that were captured.
    pub(super) bytes: &'a [u8],
    /// The bytes it had.
    pub(super) original_octets: usize,
}

impl Packet<'_> {
    pub(super) fn skipped(&self, why: Reason) -> Skipped {
        Skipped {
            offset: self.offset,
            octets: self.bytes.len(),
            why,
        }
    }

    /// Place of a part of the packet in the recording.
    fn offset_of(&self, part: &[u8]) -> usize {
        self.offset + (part.as_ptr() as usize - self.bytes.as_ptr() as usize)
    }

    /// Returns the reason of a misfit between a header and its packet: a part of the packet is missing, or the header
    /// is invalid.
    fn unfit(&self, layer: &'static str) -> Reason {
        let captured = self.bytes.len();
        match self.original_octets {
            original if original > captured => Reason::PacketCut { captured, original },
            _ => Reason::Header { layer, captured },
        }
    }
}

/// Key that the fragments of one datagram have in common.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct FragmentKey {
    pub(super) interface: u32,
    pub(super) source: IpAddr,
    pub(super) destination: IpAddr,
    pub(super) identification: u32,
}

/// A part of a datagram.
#[derive(Debug)]
pub(super) struct Fragment<'a> {
    pub(super) key: FragmentKey,
    pub(super) offset: IpFragOffset,
    /// Whether it is not the last.
    pub(super) more: bool,
    pub(super) bytes: &'a [u8],
}

/// Payload of a packet.
#[derive(Debug)]
pub(super) enum PacketPayload<'a> {
    /// A datagram, and where it lies in the recording.
    Whole { bytes: &'a [u8], offset: usize },
    /// A part of a datagram.
    Fragment(Fragment<'a>),
}

/// The payload of a packet.
///
/// # Errors
/// If it has none that could be data blocks.
pub(super) fn payload<'a>(packet: &Packet<'a>) -> Result<PacketPayload<'a>, Reason> {
    let bytes = packet.bytes;
    let behind = |octets, layer| bytes.get(octets..).ok_or_else(|| packet.unfit(layer));
    match packet.link_type {
        // An address family in four bytes, in the byte order of the capturing machine; the IP header has the same
        // information.
        0 | 108 => ip(packet, behind(4, "loopback")?),
        1 => ethernet(packet),
        101 | 228 | 229 => ip(packet, bytes),
        // Linux captures of all interfaces have a special header with the EtherType at the end, or in a later version
        // at the beginning.
        113 => tagged(packet, ether_type(bytes, 14, packet)?, behind(16, "Linux cooked")?),
        276 => tagged(packet, ether_type(bytes, 0, packet)?, behind(20, "Linux cooked")?),
        link_type => Err(Reason::LinkType { link_type }),
    }
}

fn ether_type(bytes: &[u8], at: usize, packet: &Packet<'_>) -> Result<EtherType, Reason> {
    match bytes.get(at..at + 2) {
        Some(octets) => Ok(EtherType(u16::from_be_bytes([octets[0], octets[1]]))),
        None => Err(packet.unfit("Linux cooked")),
    }
}

fn ethernet<'a>(packet: &Packet<'a>) -> Result<PacketPayload<'a>, Reason> {
    let frame = Ethernet2Slice::from_slice_without_fcs(packet.bytes).map_err(|_| packet.unfit("Ethernet"))?;
    tagged(packet, frame.ether_type(), frame.payload_slice())
}

/// EtherType and payload behind the tags of virtual networks.
fn tagged<'a>(
    packet: &Packet<'a>,
    mut ether_type: EtherType,
    mut bytes: &'a [u8],
) -> Result<PacketPayload<'a>, Reason> {
    const TAGS: [EtherType; 3] = [
        EtherType::VLAN_TAGGED_FRAME,
        EtherType::PROVIDER_BRIDGING,
        EtherType::VLAN_DOUBLE_TAGGED_FRAME,
    ];
    while TAGS.contains(&ether_type) {
        let tag = SingleVlanSlice::from_slice(bytes).map_err(|_| packet.unfit("VLAN"))?;
        (ether_type, bytes) = (tag.ether_type(), tag.payload_slice());
    }
    match ether_type {
        EtherType::IPV4 | EtherType::IPV6 => ip(packet, bytes),
        // Cooked captures use the smallest numbers for links without EtherType; in a frame they are a length.
        EtherType(length) if packet.link_type == 1 && length <= FRAME_OCTETS_MAX => {
            let frame = bytes.get(..usize::from(length));
            logical_link(packet, frame.ok_or_else(|| packet.unfit("802.3"))?)
        }
        EtherType(ether_type) => Err(Reason::EtherType { ether_type }),
    }
}

fn logical_link<'a>(packet: &Packet<'a>, frame: &'a [u8]) -> Result<PacketPayload<'a>, Reason> {
    let &[service, _, control, ref bytes @ ..] = frame else {
        return Err(packet.unfit("802.2"));
    };
    if control != UNNUMBERED_INFORMATION || OTHER_SERVICES.contains(&service) {
        return Err(Reason::LogicalLink { service, control });
    }
    let offset = packet.offset_of(bytes);
    Ok(PacketPayload::Whole { bytes, offset })
}

fn ip<'a>(packet: &Packet<'a>, bytes: &'a [u8]) -> Result<PacketPayload<'a>, Reason> {
    let ip = IpSlice::from_slice(bytes).map_err(|_| packet.unfit("IP"))?;
    let payload = ip.payload().clone();
    if payload.ip_number != IpNumber::UDP {
        let protocol = payload.ip_number.0;
        return Err(Reason::Transport { protocol });
    }
    if payload.fragmented {
        let fragment = fragment(&ip, packet.interface, payload.payload);
        return fragment.map(PacketPayload::Fragment).ok_or_else(|| packet.unfit("IP"));
    }
    let bytes = udp(payload.payload).ok_or_else(|| packet.unfit("UDP"))?;
    let offset = packet.offset_of(bytes);
    Ok(PacketPayload::Whole { bytes, offset })
}

/// The payload of a UDP datagram, bounded by its length.
pub(super) fn udp(bytes: &[u8]) -> Option<&[u8]> {
    UdpSlice::from_slice(bytes).ok().map(|datagram| datagram.payload())
}

fn fragment<'a>(ip: &IpSlice<'a>, interface: u32, bytes: &'a [u8]) -> Option<Fragment<'a>> {
    let (identification, offset, more) = match ip {
        IpSlice::Ipv4(ip) => {
            let header = ip.header();
            let identification = u32::from(header.identification());
            (identification, header.fragments_offset(), header.more_fragments())
        }
        IpSlice::Ipv6(ip) => {
            let mut extensions = ip.extensions().clone().into_iter();
            let header = extensions.find_map(|extension| match extension {
                Ipv6ExtensionSlice::Fragment(header) if header.is_fragmenting_payload() => Some(header),
                _ => None,
            })?;
            (
                header.identification(),
                header.fragment_offset(),
                header.more_fragments(),
            )
        }
    };
    Some(Fragment {
        key: FragmentKey {
            interface,
            source: ip.source_addr(),
            destination: ip.destination_addr(),
            identification,
        },
        offset,
        more,
        bytes,
    })
}
