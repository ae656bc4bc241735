//! One record, written item by item: for senders that know their category and must not allocate.
//!
//! The sender gives numbers and widths, as the category's document lays an item out; the writer joins the bits, sets
//! the FSPEC as short as the last item allows, and in debug builds checks what the table knows: that an item exists in
//! the edition, that items come in the profile's order, and that each has the octets its layout asks for.
//!
//! ```
//! use asterix::{RecordWriter, categories::CAT034_V1_29};
//!
//! let uap = CAT034_V1_29.uap();
//! let mut record = RecordWriter::new(&CAT034_V1_29);
//! record.item(uap.frn("010")).bits(0x14, 8).bits(0x0A, 8); // SAC, SIC
//! record.item(uap.frn("000")).bits(1, 8);
//! assert_eq!(record.finish(), [0b1100_0000, 0x14, 0x0A, 1]);
//! ```

use super::bits::{fspec_octet, put};
use super::table::{Category, Frn, MAX_FSPEC_OCTETS};

/// The octets that are reserved for a record when the writer is made; a longer one makes it grow once.
const RESERVED_OCTETS: usize = 256;

/// Writes one record after the other, each from its first item to [`finish`](Self::finish).
#[derive(Debug, Clone)]
pub struct RecordWriter {
    table: &'static Category,
    /// The items begun and finished.
    items: Vec<u8>,
    /// Bits written into `items`.
    bits: usize,
    /// Bit FRN − 1 for each item.
    present: u64,
    /// Where the item being written begins in `items`, for the check of its length.
    begin: usize,
    /// The last record, FSPEC first.
    record: Vec<u8>,
}

impl RecordWriter {
    /// A writer of records of this edition.
    pub fn new(table: &'static Category) -> Self {
        Self {
            table,
            items: Vec::with_capacity(RESERVED_OCTETS),
            bits: 0,
            present: 0,
            begin: 0,
            record: Vec::with_capacity(MAX_FSPEC_OCTETS + RESERVED_OCTETS),
        }
    }

    /// The edition that is written.
    pub fn table(&self) -> &'static Category {
        self.table
    }

    /// Begins an item; its content follows. Items come in the order of their field reference numbers.
    pub fn item(&mut self, frn: Frn) -> &mut Self {
        self.check_item();
        let bit = 1u64 << (frn.get() - 1);
        debug_assert!(
            self.present < bit,
            "{}: FRN {} after a later one",
            self.table,
            frn.get()
        );
        debug_assert!(
            self.table.uap().item(frn).is_some(),
            "{}: no item at FRN {}",
            self.table,
            frn.get()
        );
        self.present |= bit;
        self.begin = self.items.len();
        self
    }

    /// Appends the low `width` bits of `number`, which has no others.
    pub fn bits(&mut self, number: u64, width: usize) -> &mut Self {
        let at = self.bits;
        self.bits += width;
        self.items.resize(self.bits.div_ceil(8), 0);
        put(&mut self.items, at, width, number);
        self
    }

    /// Appends a number in two's complement that `width` bits can hold.
    pub fn signed(&mut self, number: i64, width: usize) -> &mut Self {
        debug_assert!(number == number << (64 - width) >> (64 - width));
        self.bits(number as u64 & u64::MAX >> (64 - width), width)
    }

    /// Appends an extended item of one-octet parts, of seven bits each: the first, and as many more as are needed for
    /// all that are not zero.
    pub fn extended(&mut self, parts: &[u8]) -> &mut Self {
        let last = parts.iter().rposition(|part| *part != 0).unwrap_or(0);
        for (i, part) in parts[..=last].iter().enumerate() {
            self.bits(u64::from(*part), 7).bits(u64::from(i < last), 1);
        }
        self
    }

    /// Appends the FSPEC of a compound item, with bit i of `present` for the subitem at position i from 0; their
    /// contents follow in the same order.
    pub fn subitems(&mut self, present: u64) -> &mut Self {
        for octet in fspec(present) {
            self.bits(u64::from(octet), 8);
        }
        self
    }

    /// Ends the record and gives its octets; the next item begins another.
    pub fn finish(&mut self) -> &[u8] {
        self.check_item();
        self.record.clear();
        self.record.extend(fspec(self.present));
        self.record.extend_from_slice(&self.items);
        self.items.clear();
        (self.bits, self.present, self.begin) = (0, 0, 0);
        &self.record
    }

    /// Whether the item before is whole: its octets where the edition fixes their number, else full octets.
    fn check_item(&self) {
        debug_assert!(
            self.bits.is_multiple_of(8),
            "{}: an item ends within an octet",
            self.table
        );
        let Some(index) = self.present.checked_ilog2() else {
            return;
        };
        let item = self.table.uap().item(Frn(index as u8 + 1));
        let octets = item.and_then(|item| item.fixed_octets).map(usize::from);
        debug_assert!(
            octets.is_none_or(|octets| octets == self.items.len() - self.begin),
            "{}: item at FRN {} has {} octets",
            self.table,
            index + 1,
            self.items.len() - self.begin
        );
    }
}

/// The octets of an FSPEC, at least one: bit i of `present` for position i.
fn fspec(present: u64) -> impl Iterator<Item = u8> {
    let count = (u64::BITS - present.leading_zeros()).div_ceil(7).max(1) as usize;
    (0..count).map(move |i| fspec_octet((present >> (7 * i)) as u8, i + 1 < count))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::categories::CAT062_V1_18;
    use crate::{Block, Mode, NamedRecord, Value};

    fn frn(name: &str) -> Frn {
        CAT062_V1_18.uap().frn(name)
    }

    #[test]
    fn bits_join_across_octets_and_the_fspec_is_short() {
        let mut record = RecordWriter::new(&CAT062_V1_18);
        record.item(frn("010")).bits(1, 8).bits(2, 8);
        record.item(frn("185")).signed(-1, 16).signed(5, 16);
        record.item(frn("060")).bits(0b001, 3).bits(0, 1).bits(0o1234, 12);
        let expected = [0b1000_0011, 0b0100_0000, 1, 2, 0xFF, 0xFF, 0, 5, 0x22, 0x9C];
        assert_eq!(record.finish(), expected);
        record.item(frn("010")).bits(3, 8).bits(4, 8);
        assert_eq!(record.finish(), [0x80, 3, 4], "nothing is left of the record before");
    }

    #[test]
    fn extended_items_end_with_the_last_part_that_says_something() {
        let mut record = RecordWriter::new(&CAT062_V1_18);
        record.item(frn("080")).extended(&[0b100_0000, 0, 0b000_0001, 0]);
        assert_eq!(record.finish(), [0x01, 0b0000_0100, 0b1000_0001, 0x01, 0b0000_0010]);
        record.item(frn("080")).extended(&[0, 0, 0]);
        assert_eq!(record.finish(), [0x01, 0x04, 0x00]);
    }

    #[test]
    fn compound_items_are_read_back() {
        let mut record = RecordWriter::new(&CAT062_V1_18);
        record
            .item(frn("290"))
            .subitems(1 << 1 | 1 << 9)
            .bits(7, 8)
            .bits(255, 8);
        let octets = record.finish();
        let bytes = [&[62, 0, 3 + octets.len() as u8], octets].concat();
        let block = Block {
            category: 62,
            offset: 0,
            bytes: &bytes,
        };
        let read = block.records(&CAT062_V1_18, Mode::Strict).next().unwrap().unwrap();
        let named = NamedRecord::new(&read);
        assert_eq!(named.get(&["290", "PSR"]), Some(&Value::Quantity(1.75)));
        assert_eq!(named.get(&["290", "MLT"]), Some(&Value::Quantity(63.75)));
    }

    #[test]
    #[should_panic(expected = "after a later one")]
    #[cfg(debug_assertions)]
    fn items_out_of_order_are_noticed() {
        let mut record = RecordWriter::new(&CAT062_V1_18);
        record.item(frn("185")).bits(0, 32);
        record.item(frn("010"));
    }

    #[test]
    #[should_panic(expected = "has 3 octets")]
    #[cfg(debug_assertions)]
    fn items_of_another_length_are_noticed() {
        let mut record = RecordWriter::new(&CAT062_V1_18);
        record.item(frn("010")).bits(0, 24);
        record.finish();
    }
}
