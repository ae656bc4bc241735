//! Captures in the older format: a file header, and packets behind headers of 16 bytes.
//!
//! The magic number determines the byte order of all headers and the unit of fractions of a second (micro- or
//! nanoseconds).

use pcap_parser::{PcapHeader, parse_pcap_frame, parse_pcap_frame_be, parse_pcap_frame_modified, parse_pcap_header};

use super::packet::Packet;
use super::skipped::{Reason, Skipped};
use super::{Container, NS_PER_S, TimeStamp};

/// The bytes of the header of each packet.
const RECORD_OCTETS: usize = 16;
/// The same, in the variant of some Linux systems of the nineties.
const RECORD_OCTETS_MODIFIED: usize = 24;
/// The bits of the link type that hold its number; the others describe the check sequence behind frames.
const LINK_TYPE_BITS: i32 = 0xFFFF;

/// Whether the bytes begin with a file header.
pub(super) fn begins(bytes: &[u8]) -> bool {
    parse_pcap_header(bytes).is_ok()
}

/// The packets of a capture.
#[derive(Debug)]
pub(super) struct PcapPackets<'a> {
    bytes: &'a [u8],
    /// None where the bytes are no capture.
    header: Option<PcapHeader>,
    position: usize,
}

impl<'a> PcapPackets<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        let (header, position) = match parse_pcap_header(bytes) {
            Ok((rest, header)) => (Some(header), bytes.len() - rest.len()),
            Err(_) => (None, 0),
        };
        Self {
            bytes,
            header,
            position,
        }
    }

    pub(super) fn position(&self) -> usize {
        self.position
    }

    pub(super) fn next(&mut self) -> Option<Result<Packet<'a>, Skipped>> {
        let rest = &self.bytes[self.position..];
        if rest.is_empty() {
            return None;
        }
        let Some(header) = &self.header else {
            let expected = Container::Pcap;
            return Some(Err(self.skip_rest(Reason::OtherContainer { expected })));
        };
        let parsed = match (header.is_bigendian(), header.is_modified_format()) {
            (true, _) => parse_pcap_frame_be(rest),
            (false, false) => parse_pcap_frame(rest),
            (false, true) => parse_pcap_frame_modified(rest),
        };
        let Ok((behind, record)) = parsed else {
            let why = self.cut(rest);
            return Some(Err(self.skip_rest(why)));
        };
        self.position = self.bytes.len() - behind.len();
        let fraction_ns = if header.is_nanosecond_precision() { 1 } else { 1000 };
        Some(Ok(Packet {
            interface: 0,
            link_type: header.network.0 & LINK_TYPE_BITS,
            time_stamp: Some(TimeStamp::Utc {
                ns: i64::from(record.ts_sec) * NS_PER_S + i64::from(record.ts_usec) * fraction_ns,
            }),
            offset: self.position - record.data.len(),
            bytes: record.data,
            original_octets: record.origlen as usize,
        }))
    }

    /// The only way in which the next record can fail: it takes more bytes than there are.
    fn cut(&self, rest: &[u8]) -> Reason {
        let header = self.header.as_ref();
        let is_big_endian = header.is_some_and(PcapHeader::is_bigendian);
        let record = match header.is_some_and(PcapHeader::is_modified_format) {
            true => RECORD_OCTETS_MODIFIED,
            false => RECORD_OCTETS,
        };
        let captured = rest.get(8..12).map_or(0, |octets| {
            let octets = [octets[0], octets[1], octets[2], octets[3]];
            match is_big_endian {
                true => u32::from_be_bytes(octets),
                false => u32::from_le_bytes(octets),
            }
        });
        Reason::FileCut {
            needed: record + captured as usize,
            available: rest.len(),
        }
    }

    fn skip_rest(&mut self, why: Reason) -> Skipped {
        let offset = std::mem::replace(&mut self.position, self.bytes.len());
        Skipped {
            offset,
            octets: self.bytes.len() - offset,
            why,
        }
    }
}
