//! Data blocks: category, length, body.

use super::error::Error;

/// The bytes of a block header: category and length.
pub const HEADER_OCTETS: usize = 3;

/// Data block within the bytes it was found in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Block<'a> {
    /// The category of its records.
    pub category: u8,
    /// Offset of the block's first byte in the bytes passed to [`blocks`], or in the recording that contains these
    /// bytes.
    pub offset: usize,
    /// All its bytes, with the header.
    pub bytes: &'a [u8],
}

impl<'a> Block<'a> {
    /// The bytes behind the header.
    pub fn body(&self) -> &'a [u8] {
        &self.bytes[HEADER_OCTETS..]
    }

    /// Returns the sender: system area code and system identification code of the first record. Item 010, which
    /// contains both, is the first item of every category; `None` if the record has no item 010.
    pub fn sender(&self) -> Option<(u8, u8)> {
        const FIRST_ITEM: u8 = 0x80;
        let body = self.body();
        let fspec_octets = body.iter().position(|octet| octet & 1 == 0)? + 1;
        match body.get(fspec_octets..)? {
            [sac, sic, ..] if body[0] & FIRST_ITEM != 0 => Some((*sac, *sic)),
            _ => None,
        }
    }
}

/// The data blocks in a datagram or a file of blocks.
///
/// An impossible block length is an error and ends the iteration: the format has no mark for the start of the next
/// block.
pub fn blocks(bytes: &[u8]) -> Blocks<'_> {
    blocks_at(0, bytes)
}

/// Data blocks in bytes that are a part of something, from its byte `begin` on: offsets of blocks, records and errors
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

/// Packs records into data blocks of a greatest size: to fill datagrams.
///
/// Records are appended to an open block until the next does not fit; then the full block is given out and the next
/// one begins. Two buffers take turns, so that a block can be sent while the next is open, and nothing is allocated
/// after the first two blocks.
///
/// ```
/// # use asterix::BlockWriter;
/// let mut blocks = BlockWriter::new(19, 10);
/// let record = [0xC0, 7, 1, 2];
/// assert_eq!(blocks.push(&record), Ok(None));
/// let full = [19, 0, 7, 0xC0, 7, 1, 2];
/// assert_eq!(blocks.push(&record), Ok(Some(&full[..])));
/// assert_eq!(blocks.finish(), Some(&full[..]));
/// assert_eq!(blocks.finish(), None);
/// ```
#[derive(Debug, Clone)]
pub struct BlockWriter {
    category: u8,
    octets_max: u16,
    /// Empty, or a header without length and at least one record.
    open: Vec<u8>,
    full: Vec<u8>,
}

/// A record that no block of the writer's greatest size can hold.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "category {category:03}: a record of {octets} octets does not fit a block of at most {octets_max}, \
     3 of them its header"
)]
pub struct RecordTooLong {
    /// The category.
    pub category: u8,
    /// The record's bytes.
    pub octets: usize,
    /// The most a block may have, with its header.
    pub octets_max: u16,
}

impl BlockWriter {
    /// A writer of blocks of this category, of at most `octets_max` bytes, the header's three included.
    pub fn new(category: u8, octets_max: u16) -> Self {
        Self {
            category,
            octets_max,
            open: Vec::new(),
            full: Vec::new(),
        }
    }

    /// Adds a record of at least one byte; returns the previous block if the record does not fit into it.
    ///
    /// # Errors
    /// If the record fits no block; nothing has changed then.
    pub fn push(&mut self, record: &[u8]) -> Result<Option<&[u8]>, RecordTooLong> {
        let room = usize::from(self.octets_max).saturating_sub(HEADER_OCTETS);
        if record.len() > room {
            return Err(RecordTooLong {
                category: self.category,
                octets: record.len(),
                octets_max: self.octets_max,
            });
        }
        let is_full = self.open.len() + record.len() > usize::from(self.octets_max);
        if is_full {
            self.close();
        }
        if self.open.is_empty() {
            self.open.extend([self.category, 0, 0]);
        }
        self.open.extend(record);
        Ok(is_full.then_some(&self.full))
    }

    /// Gives the open block, if it has a record.
    pub fn finish(&mut self) -> Option<&[u8]> {
        if self.open.is_empty() {
            return None;
        }
        self.close();
        Some(&self.full)
    }

    fn close(&mut self) {
        let [high, low] = (self.open.len() as u16).to_be_bytes(); // never more than `octets_max`
        self.open[1..HEADER_OCTETS].copy_from_slice(&[high, low]);
        std::mem::swap(&mut self.open, &mut self.full);
        self.open.clear();
    }
}
