//! Decoder of blocks with counters, for receivers and players of recordings.

use super::block::{Block, Blocks, blocks};
use super::error::Error;
use super::mode::Mode;
use super::record::{Record, Records};
use super::registry;
use super::table::Category;

/// Iterator over the records of datagrams or files; uses the table of each block's category, and counts records and
/// errors.
///
/// An error ends its block, not the iteration: earlier records remain valid, the rest of the block is skipped and
/// counted, and the next block follows. Only an impossible block length ends the iteration. The iterator returns
/// every error; callers may ignore errors, because the counters contain their sums.
#[derive(Debug, Clone)]
pub struct Decoder {
    tables: [Option<&'static Category>; 256],
    mode: Mode,
    counts: DecoderCounts,
}

impl Decoder {
    /// A decoder with the default edition of every category there is a table for.
    pub fn new(mode: Mode) -> Self {
        let mut tables = [None; 256];
        for table in registry::defaults() {
            tables[usize::from(table.number)] = Some(table);
        }
        Self {
            tables,
            mode,
            counts: DecoderCounts::default(),
        }
    }

    /// Reads a category with this edition's table instead of the default.
    pub fn with_table(mut self, table: &'static Category) -> Self {
        self.tables[usize::from(table.number)] = Some(table);
        self
    }

    /// Counts of the blocks and records met so far.
    pub fn counts(&self) -> &DecoderCounts {
        &self.counts
    }

    /// The records of a datagram, or of a whole file of blocks. Offsets count from the begin of `bytes`.
    pub fn records<'d, 'a>(&'d mut self, bytes: &'a [u8]) -> DecodedRecords<'d, 'a> {
        self.records_of(blocks(bytes), bytes.len())
    }

    /// Returns the records of the blocks that are found in `length` bytes. Offsets are those of the blocks.
    pub fn records_of<'d, 'a, B>(&'d mut self, blocks: B, length: usize) -> DecodedRecords<'d, 'a, B>
    where
        B: Iterator<Item = Result<Block<'a>, Error>>,
    {
        DecodedRecords {
            decoder: self,
            blocks,
            length,
            records: None,
        }
    }

    /// Returns the records of one block.
    pub fn block_records<'d, 'a>(
        &'d mut self,
        block: Block<'a>,
    ) -> DecodedRecords<'d, 'a, impl Iterator<Item = Result<Block<'a>, Error>> + use<'a>> {
        self.records_of(std::iter::once(Ok(block)), block.bytes.len())
    }
}

/// Blocks, records and bytes that a [`Decoder`] met. Every byte it was given belongs to a record, to a block header
/// or to `octets_skipped`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct DecoderCounts {
    /// Blocks with a possible length.
    pub blocks: u64,
    /// Records read.
    pub records: u64,
    /// Times the bytes ended in something that is no block.
    pub blocks_refused: u64,
    /// Blocks skipped for want of a table.
    pub blocks_without_table: u64,
    /// Blocks of which the rest was skipped after an error in a record.
    pub blocks_cut: u64,
    /// Bytes skipped for one of these three reasons.
    pub octets_skipped: u64,
    /// Records with an extended item longer than in its edition.
    pub records_extended: u64,
    /// The bytes of such extensions.
    pub unknown_extension_octets: u64,
}

impl DecoderCounts {
    /// Returns label, description and value of each counter.
    pub fn entries(&self) -> [(&'static str, &'static str, u64); 8] {
        [
            ("blocks", "data blocks with a possible length", self.blocks),
            ("records", "records read", self.records),
            (
                "blocks_refused",
                "times the bytes ended in something that is no block",
                self.blocks_refused,
            ),
            (
                "blocks_without_table",
                "blocks skipped for want of a table",
                self.blocks_without_table,
            ),
            (
                "blocks_cut",
                "blocks with a rest skipped after an error in a record",
                self.blocks_cut,
            ),
            (
                "octets_skipped",
                "octets skipped in refused, unknown and cut blocks",
                self.octets_skipped,
            ),
            (
                "records_extended",
                "records with an item that goes on beyond its edition",
                self.records_extended,
            ),
            (
                "unknown_extension_octets",
                "octets of items beyond their edition",
                self.unknown_extension_octets,
            ),
        ]
    }
}

/// The iterator that [`Decoder::records`] returns.
#[derive(Debug)]
pub struct DecodedRecords<'d, 'a, B = Blocks<'a>> {
    decoder: &'d mut Decoder,
    blocks: B,
    length: usize,
    records: Option<Records<'a>>,
}

impl<'a, B> Iterator for DecodedRecords<'_, 'a, B>
where
    B: Iterator<Item = Result<Block<'a>, Error>>,
{
    type Item = Result<Record<'a>, Error>;

    #[inline]
    fn next(&mut self) -> Option<Self::Item> {
        loop {
            if let Some(records) = &mut self.records
                && let Some(record) = records.next()
            {
                count_record(&mut self.decoder.counts, &record, records);
                return Some(record);
            }
            if let Err(error) = self.next_block()? {
                return Some(Err(error));
            }
        }
    }
}

impl<'a, B> DecodedRecords<'_, 'a, B>
where
    B: Iterator<Item = Result<Block<'a>, Error>>,
{
    /// Moves to the next block; `None` at the end of the bytes.
    fn next_block(&mut self) -> Option<Result<(), Error>> {
        let counts = &mut self.decoder.counts;
        self.records = None;
        let block = match self.blocks.next()? {
            Ok(block) => block,
            Err(error) => {
                counts.blocks_refused += 1;
                counts.octets_skipped += (self.length - error.offset()) as u64;
                return Some(Err(error));
            }
        };
        counts.blocks += 1;
        let Some(table) = self.decoder.tables[usize::from(block.category)] else {
            counts.blocks_without_table += 1;
            counts.octets_skipped += block.body().len() as u64;
            return Some(Err(Error::NoTable {
                offset: block.offset,
                category: block.category,
            }));
        };
        self.records = Some(block.records(table, self.decoder.mode));
        Some(Ok(()))
    }
}

fn count_record(counts: &mut DecoderCounts, record: &Result<Record<'_>, Error>, records: &Records<'_>) {
    match record {
        Ok(record) => {
            counts.records += 1;
            counts.records_extended += u64::from(record.unknown_extension_octets() > 0);
            counts.unknown_extension_octets += record.unknown_extension_octets() as u64;
        }
        Err(_) => {
            counts.blocks_cut += 1;
            counts.octets_skipped += records.octets_skipped() as u64;
        }
    }
}
