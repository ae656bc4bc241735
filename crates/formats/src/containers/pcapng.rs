//! Captures in the newer format: blocks with their length at both ends, in sections of either byte order.
//!
//! A section describes its interfaces, each with a link type and a resolution of time stamps, before packets that
//! refer to interfaces by number. This module finds the blocks by their two lengths, which must agree, so that damage
//! within a block affects only this block; the parser reads the content of blocks.
//!
//! Time stamps are calculated here, because the parser's helpers support no resolutions in powers of two and read the
//! offset in one byte order only.

use pcap_parser::traits::PcapNGPacketBlock;
use pcap_parser::{
    BOM_MAGIC, Block, CB_MAGIC, DCB_MAGIC, DSB_MAGIC, EPB_MAGIC, EnhancedPacketBlock, IDB_MAGIC, ISB_MAGIC,
    InterfaceDescriptionBlock, NRB_MAGIC, OptionCode, PIB_MAGIC, SHB_MAGIC, SJE_MAGIC, SPB_MAGIC, SimplePacketBlock,
    parse_block_be, parse_block_le,
};

use super::packet::Packet;
use super::skipped::{Reason, Skipped};
use super::{Container, NS_PER_S, TimeStamp};

/// Type, length, and length once more.
const BLOCK_OCTETS_MIN: usize = 12;
/// The longest block to be parsed. A packet has 64 kB; the parser's list of options takes some ten times the memory
/// of the options themselves, so that a longer block is no packet but an attack.
const BLOCK_OCTETS_MAX: usize = 1 << 20;
/// Types of blocks without packets: names, statistics, a journal, secrets, processes, and vendors' types.
const WITHOUT_PACKETS: [u32; 7] = [
    NRB_MAGIC, ISB_MAGIC, SJE_MAGIC, DSB_MAGIC, PIB_MAGIC, CB_MAGIC, DCB_MAGIC,
];
/// Offset of the packet in its block, bytes.
const ENHANCED_DATA_AT: usize = 28;
const SIMPLE_DATA_AT: usize = 12;
/// The resolution of time stamps of interfaces that do not give one: microseconds.
const RESOLUTION_DEFAULT: u8 = 6;

/// Whether the bytes begin with a section.
pub(super) fn begins(bytes: &[u8]) -> bool {
    number(bytes, 0, false) == Some(SHB_MAGIC) && byte_order(bytes).is_ok()
}

/// The packets of a capture.
#[derive(Debug)]
pub(super) struct PcapngPackets<'a> {
    bytes: &'a [u8],
    position: usize,
    big_endian: bool,
    interfaces: Vec<CaptureInterface>,
}

/// Interface that packets refer to.
#[derive(Debug, Clone, Copy)]
struct CaptureInterface {
    link_type: i32,
    /// The most bytes kept of a packet; 0 for no limit.
    snap_octets: u32,
    /// As sent: a negative power of ten, or with the highest bit set of two.
    resolution: u8,
    offset_s: i64,
}

impl<'a> PcapngPackets<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self {
            bytes,
            position: 0,
            big_endian: false,
            interfaces: Vec::new(),
        }
    }

    pub(super) fn position(&self) -> usize {
        self.position
    }

    /// Blocks up to the next packet, or the next that is damaged.
    pub(super) fn next(&mut self) -> Option<Result<Packet<'a>, Skipped>> {
        while self.position < self.bytes.len() {
            let begin = self.position;
            let (block_type, block) = match self.next_block(&self.bytes[begin..]) {
                Ok(found) => found,
                Err(why) => {
                    self.position = self.bytes.len();
                    return Some(Err(self.skipped(begin, why)));
                }
            };
            self.position += block.len();
            match self.read(block_type, block, begin) {
                Ok(Some(packet)) => return Some(Ok(packet)),
                Ok(None) => {}
                Err(why) => return Some(Err(self.skipped(begin, why))),
            }
        }
        None
    }

    /// The type and all bytes of the block at the begin of `rest`.
    ///
    /// # Errors
    /// If the bytes are no block, which ends the recording.
    fn next_block(&mut self, rest: &'a [u8]) -> Result<(u32, &'a [u8]), Reason> {
        let cut = |needed| Reason::FileCut {
            needed,
            available: rest.len(),
        };
        if !begins(rest) && self.position == 0 {
            let expected = Container::PcapNg;
            return Err(Reason::OtherContainer { expected });
        }
        // The type of a section reads the same in both byte orders.
        if number(rest, 0, false) == Some(SHB_MAGIC) && rest.len() >= BLOCK_OCTETS_MIN {
            self.big_endian = byte_order(rest).map_err(|mark| Reason::ByteOrder { mark })?;
        }
        let number = |at| number(rest, at, self.big_endian);
        let (Some(block_type), Some(length)) = (number(0), number(4)) else {
            return Err(cut(BLOCK_OCTETS_MIN));
        };
        let length = length as usize;
        if length < BLOCK_OCTETS_MIN {
            let trailing = None;
            return Err(Reason::BlockLength { length, trailing });
        }
        let block = rest.get(..length).ok_or_else(|| cut(length))?;
        let trailing = number(length - 4).map(|length| length as usize);
        if trailing != Some(length) {
            return Err(Reason::BlockLength { length, trailing });
        }
        Ok((block_type, block))
    }

    /// Reads a block: returns its packet, if any, or stores its data about later packets.
    fn read(&mut self, block_type: u32, block: &'a [u8], begin: usize) -> Result<Option<Packet<'a>>, Reason> {
        if WITHOUT_PACKETS.contains(&block_type) {
            return Ok(None);
        }
        if ![SHB_MAGIC, IDB_MAGIC, EPB_MAGIC, SPB_MAGIC].contains(&block_type) {
            return Err(Reason::BlockType { block_type });
        }
        let damaged = || Reason::BlockContent {
            block_type,
            octets: block.len(),
        };
        if block.len() > BLOCK_OCTETS_MAX {
            return Err(damaged());
        }
        let parse = if self.big_endian {
            parse_block_be
        } else {
            parse_block_le
        };
        match parse(block) {
            Ok((_, Block::SectionHeader(_))) => self.interfaces.clear(),
            Ok((_, Block::InterfaceDescription(interface))) => {
                self.interfaces.push(CaptureInterface::new(&interface, self.big_endian));
            }
            Ok((_, Block::EnhancedPacket(packet))) => return self.enhanced(&packet, block, begin).map(Some),
            Ok((_, Block::SimplePacket(packet))) => return self.simple(&packet, block, begin).map(Some),
            _ => return Err(damaged()),
        }
        Ok(None)
    }

    fn enhanced(&self, packet: &EnhancedPacketBlock<'a>, block: &'a [u8], begin: usize) -> Result<Packet<'a>, Reason> {
        let interface = self.interface(packet.if_id)?;
        let stamp = u64::from(packet.ts_high) << 32 | u64::from(packet.ts_low);
        let kept = packet.packet_data().len();
        Ok(Packet {
            interface: packet.if_id,
            link_type: interface.link_type,
            time_stamp: interface.time_stamp(stamp),
            offset: begin + ENHANCED_DATA_AT,
            bytes: &block[ENHANCED_DATA_AT..][..kept],
            original_octets: packet.origlen as usize,
        })
    }

    /// Reads a simple packet: of the first interface, without a time stamp, and with a captured length known only
    /// from the interface's limit.
    fn simple(&self, packet: &SimplePacketBlock<'a>, block: &'a [u8], begin: usize) -> Result<Packet<'a>, Reason> {
        let interface = self.interface(0)?;
        let limit = match interface.snap_octets {
            0 => usize::MAX,
            octets => octets as usize,
        };
        let kept = packet.packet_data().len().min(limit);
        Ok(Packet {
            interface: 0,
            link_type: interface.link_type,
            time_stamp: None,
            offset: begin + SIMPLE_DATA_AT,
            bytes: &block[SIMPLE_DATA_AT..][..kept],
            original_octets: packet.origlen as usize,
        })
    }

    fn interface(&self, number: u32) -> Result<&CaptureInterface, Reason> {
        self.interfaces.get(number as usize).ok_or(Reason::Interface {
            interface: number,
            described: self.interfaces.len(),
        })
    }

    /// The part since `begin`, as skipped.
    fn skipped(&self, begin: usize, why: Reason) -> Skipped {
        Skipped {
            offset: begin,
            octets: self.position - begin,
            why,
        }
    }
}

impl CaptureInterface {
    fn new(block: &InterfaceDescriptionBlock<'_>, big_endian: bool) -> Self {
        let option = |code| block.options.iter().find(|option| option.code == code);
        let resolution = option(OptionCode::IfTsresol).and_then(|option| option.as_bytes().ok()?.first().copied());
        let offset = option(OptionCode::IfTsoffset).and_then(|option| option.as_bytes().ok()?.try_into().ok());
        Self {
            link_type: block.linktype.0,
            snap_octets: block.snaplen,
            resolution: resolution.unwrap_or(RESOLUTION_DEFAULT),
            offset_s: match offset {
                None => 0,
                Some(octets) if big_endian => i64::from_be_bytes(octets),
                Some(octets) => i64::from_le_bytes(octets),
            },
        }
    }

    /// Nothing where the time is farther than 292 years from 1970.
    fn time_stamp(&self, stamp: u64) -> Option<TimeStamp> {
        let exponent = u32::from(self.resolution & 0x7F);
        let units_per_s = match self.resolution & 0x80 {
            0 => 10u128.checked_pow(exponent),
            _ => 1u128.checked_shl(exponent),
        };
        let since_offset_ns = i64::try_from(u128::from(stamp) * NS_PER_S as u128 / units_per_s?).ok()?;
        let ns = self.offset_s.checked_mul(NS_PER_S)?.checked_add(since_offset_ns)?;
        Some(TimeStamp::Utc { ns })
    }
}

/// Whether the section at the begin of `block` is big-endian.
///
/// # Errors
/// Bytes in place of the byte-order mark.
fn byte_order(block: &[u8]) -> Result<bool, u32> {
    match number(block, 8, false).unwrap_or(0) {
        BOM_MAGIC => Ok(false),
        mark if mark.swap_bytes() == BOM_MAGIC => Ok(true),
        mark => Err(mark),
    }
}

fn number(bytes: &[u8], at: usize, big_endian: bool) -> Option<u32> {
    let octets = bytes.get(at..at + 4)?.try_into().ok()?;
    Some(match big_endian {
        true => u32::from_be_bytes(octets),
        false => u32::from_le_bytes(octets),
    })
}
