//! Data blocks: category, length, body.

use super::error::Error;
use super::record::{Mode, Records};
use super::table::Category;

/// The octets of a block header: category and length.
pub const HEADER_OCTETS: usize = 3;

/// One data block within the bytes it was found in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Block<'a> {
    /// The category of its records.
    pub category: u8,
    /// Where it begins in the bytes passed to [`blocks`], or in what they are a part of.
    pub offset: usize,
    /// All its octets, with the header.
    pub bytes: &'a [u8],
}

impl<'a> Block<'a> {
    /// The octets behind the header.
    pub fn body(&self) -> &'a [u8] {
        &self.bytes[HEADER_OCTETS..]
    }

    /// The records, read with one edition's table. The caller has chosen a table of the block's category.
    pub fn records(&self, table: &'static Category, mode: Mode) -> Records<'a> {
        Records::new(self, table, mode)
    }
}

/// The data blocks in a datagram or a file of blocks.
///
/// A block whose length can not be right is an error and the end: nothing in the format marks where the next one
/// begins.
pub fn blocks(bytes: &[u8]) -> Blocks<'_> {
    blocks_at(0, bytes)
}

/// The same for bytes that are a part of something, from its octet `begin` on: offsets of blocks, records and errors
/// count from the begin of the whole.
pub fn blocks_at(begin: usize, bytes: &[u8]) -> Blocks<'_> {
    Blocks { begin, bytes, at: 0 }
}

/// The iterator that [`blocks`] returns.
#[derive(Debug, Clone)]
pub struct Blocks<'a> {
    begin: usize,
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Iterator for Blocks<'a> {
    type Item = Result<Block<'a>, Error>;

    fn next(&mut self) -> Option<Self::Item> {
        let rest = &self.bytes[self.at..];
        if rest.is_empty() {
            return None;
        }
        let block = first_block(rest, self.begin + self.at);
        self.at = match &block {
            Ok(block) => self.at + block.bytes.len(),
            Err(_) => self.bytes.len(),
        };
        Some(block)
    }
}

fn first_block(rest: &[u8], offset: usize) -> Result<Block<'_>, Error> {
    let available = rest.len();
    let &[category, high, low, ..] = rest else {
        return Err(Error::HeaderTruncated { offset, available });
    };
    let length = usize::from(u16::from_be_bytes([high, low]));
    if length < HEADER_OCTETS {
        return Err(Error::BlockLength {
            offset,
            category,
            length,
        });
    }
    let Some(bytes) = rest.get(..length) else {
        return Err(Error::BlockTruncated {
            offset,
            category,
            length,
            available,
        });
    };
    Ok(Block {
        category,
        offset,
        bytes,
    })
}
