//! Parts of a recording that gave no datagram: why, and their sum.

use super::{Container, RecordedDatagram};

/// A part of a recording that gave no datagram.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("byte {offset}: {why}")]
pub struct Skipped {
    /// Offset of its start: for a captured packet behind its record's header, otherwise of its first byte.
    pub offset: usize,
    /// Number of bytes; for fragments, of all captured fragments.
    pub octets: usize,
    /// Why.
    pub why: Reason,
}

/// Why a part of a recording gave no datagram.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Reason {
    /// The recording is not of the given kind.
    #[error("this is no {expected} recording; leave the kind to be found out, or name another")]
    OtherContainer {
        /// The given kind.
        expected: Container,
    },
    /// The recording ends in the middle of something.
    #[error(
        "the recording ends {available} octets into {needed} that belong together: it was cut short, or is damaged"
    )]
    FileCut {
        /// The bytes that the packet, block or frame takes.
        needed: usize,
        /// The bytes there are.
        available: usize,
    },
    /// A pcapng block with an impossible length, or with two that differ: where the next begins is unknown.
    #[error("pcapng block of {length} octets with {trailing:?} at its end: nothing from here on can be read")]
    BlockLength {
        /// The length at the begin of the block.
        length: usize,
        /// The length at the end of the block, if readable.
        trailing: Option<usize>,
    },
    /// A pcapng section without a byte-order mark.
    #[error("pcapng section with byte-order mark {mark:08X}, expected 1A2B3C4D: nothing from here on can be read")]
    ByteOrder {
        /// Bytes that stand in its place.
        mark: u32,
    },
    /// A pcapng block with a contradiction between content and length.
    #[error("pcapng block of type {block_type:#X} with content that does not fit its {octets} octets")]
    BlockContent {
        /// The type.
        block_type: u32,
        /// Number of its bytes.
        octets: usize,
    },
    /// A pcapng block of a type that is not known.
    #[error("pcapng block of type {block_type:#X}, which is not known")]
    BlockType {
        /// The type.
        block_type: u32,
    },
    /// A packet of an interface that its pcapng section does not describe.
    #[error("packet of interface {interface}, of which the section describes {described}")]
    Interface {
        /// The interface's number, from 0.
        interface: u32,
        /// The interfaces there are.
        described: usize,
    },
    /// A frame of the final format without its trailer.
    #[error("frame of {length} octets, the header's 8 and the trailer's 4 included, without the trailer A5A5A5A5")]
    Trailer {
        /// The length it gives.
        length: usize,
    },
    /// A data block of a gps recording with an impossible length.
    #[error(
        "data block of {length} octets, expected 4 to 4096: what follows up to the next data blocks cannot be read"
    )]
    GpsBlock {
        /// The length it gives.
        length: usize,
    },
    /// A line of hexadecimal text that is no datagram.
    #[error("line {beginning:?}, expected pairs of hexadecimal digits, with or without a time before them")]
    HexLine {
        /// The first characters.
        beginning: String,
    },
    /// A packet from a link with unsupported headers.
    #[error("packet of link type {link_type}; known are 0, 1, 101, 108, 113, 228, 229 and 276")]
    LinkType {
        /// The number of the link type.
        link_type: i32,
    },
    /// A packet of which the capture kept the begin only.
    #[error("packet of {original} octets, of which the capture kept {captured}; capture whole packets")]
    PacketCut {
        /// The bytes that were captured.
        captured: usize,
        /// The bytes that came.
        original: usize,
    },
    /// A packet with headers that contradict each other or the packet's length.
    #[error("packet of {captured} octets whose {layer} header is invalid")]
    Header {
        /// The protocol.
        layer: &'static str,
        /// The packet's bytes.
        captured: usize,
    },
    /// A frame that carries neither IPv4 nor IPv6.
    #[error("frame of protocol {ether_type:#06X}, not IPv4 (0x0800) or IPv6 (0x86DD)")]
    EtherType {
        /// Its EtherType.
        ether_type: u16,
    },
    /// An IEEE 802.3 frame that is no unnumbered information, or of a protocol that is surely another.
    #[error("802.3 frame for service access point {service:#04X} with control field {control:#04X}, no ASTERIX")]
    LogicalLink {
        /// The destination's service access point.
        service: u8,
        /// The control field.
        control: u8,
    },
    /// An IP packet that is not UDP.
    #[error("IP packet of protocol {protocol}, not UDP (17)")]
    Transport {
        /// The protocol's number.
        protocol: u8,
    },
    /// Fragments of an IP packet of which others are missing or contradict them.
    #[error("IP packet that is not complete; fragments captured: {fragments}")]
    Fragments {
        /// The fragments that were captured.
        fragments: usize,
    },
}

impl Reason {
    /// Reason in a few words, the same for all parts skipped for the same reason: to count them by.
    pub fn label(&self) -> &'static str {
        match self {
            Self::OtherContainer { .. } => "other container",
            Self::FileCut { .. } => "recording cut short",
            Self::BlockLength { .. } | Self::ByteOrder { .. } => "damaged pcapng",
            Self::BlockContent { .. } => "damaged pcapng block",
            Self::BlockType { .. } => "unknown pcapng block",
            Self::Interface { .. } => "unknown interface",
            Self::Trailer { .. } => "damaged frame",
            Self::GpsBlock { .. } => "impossible block length",
            Self::HexLine { .. } => "line without octets",
            Self::LinkType { .. } => "unknown link type",
            Self::PacketCut { .. } => "packet not captured whole",
            Self::Header { .. } => "impossible header",
            Self::EtherType { .. } | Self::LogicalLink { .. } | Self::Transport { .. } => "other protocol",
            Self::Fragments { .. } => "incomplete fragments",
        }
    }
}

/// Sums over a recording: every byte is in a datagram, in something skipped, or framing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct ContainerCounts {
    /// Datagrams given.
    pub datagrams: u64,
    /// Datagrams that were put together from fragments.
    pub datagrams_joined: u64,
    /// The bytes of all datagrams.
    pub datagram_octets: u64,
    /// Headers, padding, trailers, and blocks of a capture that hold no packets.
    pub framing_octets: u64,
    /// Bytes skipped.
    pub octets_skipped: u64,
    /// Packets of other protocols.
    pub packets_other: u64,
    /// Packets captured only partly, with impossible headers, or from an unsupported link.
    pub packets_refused: u64,
    /// IP packets of which fragments are missing.
    pub packets_incomplete: u64,
    /// Places where the recording itself is damaged, cut short or not known.
    pub damages: u64,
}

impl ContainerCounts {
    /// Returns label, description and value of each counter.
    pub fn entries(&self) -> [(&'static str, &'static str, u64); 9] {
        [
            ("datagrams", "datagrams given", self.datagrams),
            (
                "datagrams_joined",
                "datagrams put together from fragments",
                self.datagrams_joined,
            ),
            ("datagram_octets", "octets of all datagrams", self.datagram_octets),
            (
                "framing_octets",
                "octets of headers, padding and trailers",
                self.framing_octets,
            ),
            ("octets_skipped", "bytes skipped", self.octets_skipped),
            ("packets_other", "packets of other protocols", self.packets_other),
            (
                "packets_refused",
                "packets not captured whole, or with impossible headers or an unknown link",
                self.packets_refused,
            ),
            (
                "packets_incomplete",
                "IP packets of which fragments are missing",
                self.packets_incomplete,
            ),
            (
                "damages",
                "places where the recording is damaged, cut short or not known",
                self.damages,
            ),
        ]
    }

    /// Counts a datagram for which `octets` of the recording were used up.
    pub(super) fn datagram(&mut self, datagram: &RecordedDatagram<'_>, octets: usize) {
        self.datagrams += 1;
        self.datagram_octets += datagram.bytes.len() as u64;
        self.framing_octets += (octets - datagram.bytes.len()) as u64;
    }

    /// Counts a skipped part and the framing bytes around the part.
    pub(super) fn skip(&mut self, skipped: Skipped, framing_octets: u64) -> Skipped {
        self.framing_octets += framing_octets;
        self.octets_skipped += skipped.octets as u64;
        *match skipped.why {
            Reason::EtherType { .. } | Reason::LogicalLink { .. } | Reason::Transport { .. } => &mut self.packets_other,
            Reason::LinkType { .. } | Reason::PacketCut { .. } | Reason::Header { .. } | Reason::Interface { .. } => {
                &mut self.packets_refused
            }
            Reason::Fragments { .. } => &mut self.packets_incomplete,
            Reason::OtherContainer { .. }
            | Reason::FileCut { .. }
            | Reason::BlockLength { .. }
            | Reason::ByteOrder { .. }
            | Reason::BlockContent { .. }
            | Reason::BlockType { .. }
            | Reason::Trailer { .. }
            | Reason::GpsBlock { .. }
            | Reason::HexLine { .. } => &mut self.damages,
        } += 1;
        skipped
    }
}
