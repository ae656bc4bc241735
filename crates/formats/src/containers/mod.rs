//! Containers of ASTERIX recordings: a single iterator of datagrams for all kinds.
//!
//! # The containers
//!
//! A sensor sends its data blocks in datagrams, and a recording stores them in one of these ways:
//!
//! - *raw*: the blocks one after the other and nothing else (`.ast`, `.raw`). When a block came is lost;
//! - *pcap* and *pcapng*: captures of network packets, with headers of every layer around the blocks and a time stamp
//!   from the capturing machine;
//! - *final*: frames of a recorder, each with a length, the recorder's time of day and a trailer (`.ff`);
//! - *gps*: a header, and data blocks with the recorder's time of day behind each (`.gps`);
//! - *hex*: a datagram in each line of a text, as hexadecimal digits, with or without a time before them.
//!
//! File names are unreliable, so the content determines the kind: captures have magic numbers, and a frame of the
//! final format ends with four bytes A5 exactly at its stated length. Lines of text are octets of whole data blocks by
//! accident as little as blocks of known categories follow each other with ten octets between. Any other content is
//! treated as raw blocks, which have no mark.
//!
//! ```text
//! bytes ── Container::detect ──► pcap, pcapng ── packet ── link ── IP ── UDP ──┬──► Datagram
//!                            ├─► final ── frame ───────────────────────────────┤
//!                            ├─► gps ── block ─────────────────────────────────┤
//!                            ├─► hex ── line ──────────────────────────────────┤
//!                            └─► raw ──────────────────────────────────────────┘
//! ```
//!
//! # Datagrams in a capture
//!
//! The payload of a UDP datagram over IPv4 or IPv6, put together again where IP cut it into fragments, or the payload
//! of an IEEE 802.3 frame behind its three bytes of logical link control (DSAP, SSAP, unnumbered information), as
//! older radar networks send it. The length fields bound the payload, so the padding of short frames is cut. Tags of
//! virtual networks are stepped over. Everything else that a network carries is passed over and counted.
//!
//! # Damaged recordings
//!
//! The usual damage is a recording that ends within a packet: everything before the end is used. The same applies to
//! packets captured only partly. A frame of the final format without its trailer is skipped up to the next trailer, a
//! line that is no datagram up to the next line, and an impossible length in a gps recording up to the next blocks.
//! pcap and pcapng have no mark for the next packet, so that an impossible length ends the recording.
//! [`ContainerCounts`] accounts for every byte.
//!
//! # Limits
//!
//! Nothing here trusts a length. Memory beyond the caller's bytes is used for fragments, at most [`FRAGMENTED_MAX`]
//! datagrams of 64 kB, and for the octets of one line of text.
//!
//! # Sources
//!
//! draft-ietf-opsawg-pcap and draft-ietf-opsawg-pcapng for captures, the list of link types at tcpdump.org; IEEE 802.3
//! and 802.2 for frames with logical link control; RFC 768, 791 and 8200 for UDP and IP; the description of ASTERIX
//! Final in the developer guide of LuciadFusion; for gps recordings see the head of `gps.rs`.

use std::borrow::Cow;
use std::fmt;
use std::str::FromStr;

mod capture;
mod final_format;
mod fragments;
pub(crate) mod gps;
pub(crate) mod hexadecimal;
mod packet;
mod pcap;
mod pcapng;
mod pieces;
mod skipped;

pub use capture::{DatagramRoute, begin_capture, capture};
pub use fragments::FRAGMENTED_MAX;
pub use pieces::RecordedPieces;
pub use skipped::{ContainerCounts, Reason, Skipped};

use fragments::Fragments;
use packet::{Packet, PacketPayload};

/// Nanoseconds in a second.
const NS_PER_S: i64 = 1_000_000_000;

/// The datagrams in a recording of any kind.
pub fn datagrams(bytes: &[u8]) -> Datagrams<'_> {
    Datagrams::new(Container::detect(bytes), bytes)
}

/// Datagram of a recording, with data blocks if it is ASTERIX.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RecordedDatagram<'a> {
    /// Bytes of the datagram; owned only where they were put together from fragments, or from digits.
    pub bytes: Cow<'a, [u8]>,
    /// Time of recording, where the container states one.
    pub time_stamp: Option<TimeStamp>,
    /// Offset of the datagram's start in the recording; for fragments, the offset of the first captured fragment; for
    /// text, that of the line.
    pub offset: usize,
}

/// Time at which a datagram was recorded, by the recorder's clock.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TimeStamp {
    /// Nanoseconds since 1970-01-01, UTC.
    Utc {
        /// The nanoseconds.
        ns: i64,
    },
    /// Nanoseconds since a midnight that the recording does not name.
    TimeOfDay {
        /// The nanoseconds.
        ns: i64,
    },
}

impl TimeStamp {
    /// Nanoseconds since 1970 or midnight.
    pub fn ns(self) -> i64 {
        match self {
            Self::Utc { ns } | Self::TimeOfDay { ns } => ns,
        }
    }

    /// Seconds since 1970 or midnight; whole seconds and their fraction are brought together last, so that
    /// microseconds survive.
    pub fn seconds(self) -> f64 {
        let ns = self.ns();
        ns.div_euclid(NS_PER_S) as f64 + ns.rem_euclid(NS_PER_S) as f64 / NS_PER_S as f64
    }
}

/// A kind of recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Container {
    /// Data blocks and nothing else.
    Raw,
    /// A capture in the older format of libpcap.
    Pcap,
    /// A capture in the newer format, with sections and interfaces.
    PcapNg,
    /// Frames with length, time of day and trailer.
    Final,
    /// A header, and data blocks with ten octets behind each.
    Gps,
    /// Lines of hexadecimal digits.
    Hex,
}

impl Container {
    /// Every kind.
    pub const ALL: [Self; 6] = [Self::Raw, Self::Pcap, Self::PcapNg, Self::Final, Self::Gps, Self::Hex];

    /// The kind of a recording, by its first bytes.
    pub fn detect(bytes: &[u8]) -> Self {
        if pcapng::begins(bytes) {
            Self::PcapNg
        } else if pcap::begins(bytes) {
            Self::Pcap
        } else if final_format::begins(bytes) {
            Self::Final
        } else if hexadecimal::begins(bytes) {
            Self::Hex
        } else if gps::begins(bytes) {
            Self::Gps
        } else {
            Self::Raw
        }
    }

    /// Name in one word, which [`FromStr`] reads.
    pub fn word(self) -> &'static str {
        match self {
            Self::Raw => "raw",
            Self::Pcap => "pcap",
            Self::PcapNg => "pcapng",
            Self::Final => "final",
            Self::Gps => "gps",
            Self::Hex => "hex",
        }
    }
}

impl fmt::Display for Container {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.word())
    }
}

/// A text that names no kind of recording.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{found:?} is no kind of recording; there are raw, pcap, pcapng, final, gps and hex")]
pub struct ContainerError {
    /// Word that was given.
    pub found: String,
}

impl FromStr for Container {
    type Err = ContainerError;

    fn from_str(text: &str) -> Result<Self, ContainerError> {
        let named = Self::ALL.into_iter().find(|kind| kind.word() == text);
        named.ok_or_else(|| ContainerError { found: text.to_owned() })
    }
}

/// The iterator that [`datagrams`] returns: each datagram, and each part of the recording that gave none.
///
/// A skipped part does not end the iteration; callers may ignore it, because [`counts`](Self::counts) contains the
/// sums.
#[derive(Debug)]
pub struct Datagrams<'a> {
    container: Container,
    bytes: &'a [u8],
    source: ContainerReader<'a>,
    fragments: Fragments,
    counts: ContainerCounts,
    /// The octets before this one are in `counts`, or waiting in `fragments`.
    accounted: usize,
}

/// Iterator over the parts of a recording, from start to end, with a position.
#[derive(Debug)]
enum ContainerReader<'a> {
    Raw { bytes: &'a [u8], position: usize },
    Pcap(pcap::PcapPackets<'a>),
    PcapNg(pcapng::PcapngPackets<'a>),
    Final(final_format::Frames<'a>),
    Gps(gps::GpsBlocks<'a>),
    Hex(hexadecimal::HexLines<'a>),
}

/// A piece of a recording.
#[derive(Debug)]
enum ContainerPiece<'a> {
    Datagram(RecordedDatagram<'a>),
    Packet(Packet<'a>),
}

impl<'a> Datagrams<'a> {
    /// Returns the datagrams of a recording of this kind.
    pub fn new(container: Container, bytes: &'a [u8]) -> Self {
        let source = match container {
            Container::Raw => ContainerReader::Raw { bytes, position: 0 },
            Container::Pcap => ContainerReader::Pcap(pcap::PcapPackets::new(bytes)),
            Container::PcapNg => ContainerReader::PcapNg(pcapng::PcapngPackets::new(bytes)),
            Container::Final => ContainerReader::Final(final_format::Frames::new(bytes)),
            Container::Gps => ContainerReader::Gps(gps::GpsBlocks::new(bytes)),
            Container::Hex => ContainerReader::Hex(hexadecimal::HexLines::new(bytes)),
        };
        Self {
            container,
            bytes,
            source,
            fragments: Fragments::default(),
            counts: ContainerCounts::default(),
            accounted: 0,
        }
    }

    /// The kind of the recording.
    pub fn container(&self) -> Container {
        self.container
    }

    /// Returns the counts up to the present position.
    pub fn counts(&self) -> &ContainerCounts {
        &self.counts
    }

    /// Returns a packet's datagram; `None` while fragments of the datagram are missing.
    fn unpack(&mut self, packet: &Packet<'a>, octets: usize) -> Option<Result<RecordedDatagram<'a>, Skipped>> {
        let framing = (octets - packet.bytes.len()) as u64;
        match packet::payload(packet) {
            Ok(PacketPayload::Whole { bytes, offset }) => {
                let datagram = RecordedDatagram {
                    bytes: Cow::Borrowed(bytes),
                    time_stamp: packet.time_stamp,
                    offset,
                };
                self.counts.datagram(&datagram, octets);
                Some(Ok(datagram))
            }
            Ok(PacketPayload::Fragment(fragment)) => {
                self.counts.framing_octets += framing;
                let (datagram, octets) = match self.fragments.add(&fragment, packet)? {
                    Ok(joined) => joined,
                    Err(skipped) => return Some(Err(self.counts.skip(skipped, 0))),
                };
                self.counts.datagrams_joined += 1;
                self.counts.datagram(&datagram, octets);
                Some(Ok(datagram))
            }
            Err(why) => Some(Err(self.counts.skip(packet.skipped(why), framing))),
        }
    }

    /// Returns a datagram still incomplete at the end of the recording.
    fn finish(&mut self) -> Option<Result<RecordedDatagram<'a>, Skipped>> {
        self.counts.framing_octets += (self.bytes.len() - self.accounted) as u64;
        self.accounted = self.bytes.len();
        let skipped = self.fragments.give_up()?;
        Some(Err(self.counts.skip(skipped, 0)))
    }
}

impl<'a> Iterator for Datagrams<'a> {
    type Item = Result<RecordedDatagram<'a>, Skipped>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            let Some(piece) = self.source.next() else {
                return self.finish();
            };
            let octets = self.source.position() - self.accounted;
            self.accounted += octets;
            match piece {
                Ok(ContainerPiece::Datagram(datagram)) => {
                    self.counts.datagram(&datagram, octets);
                    return Some(Ok(datagram));
                }
                Ok(ContainerPiece::Packet(packet)) => {
                    if let Some(outcome) = self.unpack(&packet, octets) {
                        return Some(outcome);
                    }
                }
                Err(skipped) => {
                    let framing = (octets - skipped.octets) as u64;
                    return Some(Err(self.counts.skip(skipped, framing)));
                }
            }
        }
    }
}

impl<'a> ContainerReader<'a> {
    fn next(&mut self) -> Option<Result<ContainerPiece<'a>, Skipped>> {
        match self {
            Self::Raw { bytes, position } => {
                let begin = std::mem::replace(position, bytes.len());
                (begin < bytes.len()).then(|| {
                    Ok(ContainerPiece::Datagram(RecordedDatagram::of(
                        &bytes[begin..],
                        None,
                        begin,
                    )))
                })
            }
            Self::Pcap(packets) => packets.next().map(|packet| packet.map(ContainerPiece::Packet)),
            Self::PcapNg(packets) => packets.next().map(|packet| packet.map(ContainerPiece::Packet)),
            Self::Final(frames) => frames.next().map(|datagram| datagram.map(ContainerPiece::Datagram)),
            Self::Gps(blocks) => blocks.next().map(|datagram| datagram.map(ContainerPiece::Datagram)),
            Self::Hex(lines) => lines.next().map(|datagram| datagram.map(ContainerPiece::Datagram)),
        }
    }

    /// The bytes before this one have been given, or belong to no piece.
    fn position(&self) -> usize {
        match self {
            Self::Raw { position, .. } => *position,
            Self::Pcap(packets) => packets.position(),
            Self::PcapNg(packets) => packets.position(),
            Self::Final(frames) => frames.position(),
            Self::Gps(blocks) => blocks.position(),
            Self::Hex(lines) => lines.position(),
        }
    }
}

impl<'a> RecordedDatagram<'a> {
    fn of(bytes: &'a [u8], time_stamp: Option<TimeStamp>, offset: usize) -> Self {
        Self {
            bytes: Cow::Borrowed(bytes),
            time_stamp,
            offset,
        }
    }
}
