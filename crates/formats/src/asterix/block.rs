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
    /// Where it begins in the bytes passed to [`blocks`].
    pub offset: usize,
    /// All its octets, with the header.
    pub bytes: &'a [u8],
}

impl<'a> Block<'a> {
    /// The octets behind the header.
    pub fn body(&self) -> &'a [u8] {
        &self.bytes[HEADER_OCTETS..]
    }

    /// System area code and system identification code of its first record: who sent it. Item 010, which holds them, is
    /// the first of every category; `None` if the record has none.
    pub fn sender(&self) -> Option<(u8, u8)> {
        const FIRST_ITEM: u8 = 0x80;
        let body = self.body();
        let fspec_octets = body.iter().position(|octet| octet & 1 == 0)? + 1;
        match body.get(fspec_octets..)? {
            [sac, sic, ..] if body[0] & FIRST_ITEM != 0 => Some((*sac, *sic)),
            _ => None,
        }
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
    Blocks { bytes, at: 0 }
}

/// The iterator that [`blocks`] returns.
#[derive(Debug, Clone)]
pub struct Blocks<'a> {
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
        let block = first_block(rest, self.at);
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
