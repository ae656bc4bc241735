//! Writer of records, item by item, for senders of a fixed category that must not allocate.
//!
//! The sender supplies numbers for elements; the tables determine their positions, through [`Field`]. An item begins
//! as zeros of the least length of its layout, so that spare bits and missing elements are zero. An extended item
//! grows by the extensions needed for its elements. The FSPEC ends with the last item. Debug builds check that items
//! come in the profile's order and that numbers fit.
//!
//! ```
//! use asterix::categories::CAT034;
//! use asterix::field::{Elements, elements, whole};
//! use asterix::{RecordWriter, categories::CAT034_V1_29};
//!
//! const SOURCE: Elements<2> = elements(CAT034, "010", ["SAC", "SIC"]);
//! const MESSAGE_TYPE: Elements<1> = whole(CAT034, "000");
//!
//! let mut record = RecordWriter::new(&CAT034_V1_29);
//! record.write(&SOURCE, [0x14, 0x0A]);
//! record.write(&MESSAGE_TYPE, [1]);
//! assert_eq!(record.finish(), [0b1100_0000, 0x14, 0x0A, 1]);
//! ```

use super::bits::fspec_octet;
use super::field::{Elements, Field};
use super::table::{Category, Frn, Item, Layout, MAX_FSPEC_OCTETS, Uap, extent_of_part};

/// Bytes reserved for a record by a new writer; a longer record enlarges the buffer once.
const RESERVED_OCTETS: usize = 256;

/// Writes records in sequence, each from its first item to [`finish`](Self::finish).
#[derive(Debug, Clone)]
pub struct RecordWriter {
    table: &'static Category,
    uap: &'static Uap,
    /// The items begun and finished.
    items: Vec<u8>,
    /// Bit FRN − 1 for each item.
    present: u64,
    /// Offset in `items` of the item or subitem being written.
    begin: usize,
    /// True for an extended item.
    is_extended: bool,
    /// Offset in `items` of the compound item being written, and bit i for the subitem at position i + 1.
    compound: Option<(usize, u64)>,
    /// The last record, FSPEC first.
    record: Vec<u8>,
}

impl RecordWriter {
    /// A writer of records of this edition.
    pub fn new(table: &'static Category) -> Self {
        Self {
            table,
            uap: table.uap(),
            items: Vec::with_capacity(RESERVED_OCTETS),
            present: 0,
            begin: 0,
            is_extended: false,
            compound: None,
            record: Vec::with_capacity(MAX_FSPEC_OCTETS + RESERVED_OCTETS),
        }
    }

    /// The edition that is written.
    pub fn table(&self) -> &'static Category {
        self.table
    }

    /// Writes an item of these elements; see [`put`](Self::put).
    #[inline(always)]
    pub fn write<const N: usize>(&mut self, elements: &Elements<N>, numbers: [i64; N]) {
        self.item(elements.item);
        for (field, number) in elements.fields.into_iter().zip(numbers) {
            self.put(field, number);
        }
    }

    /// Begins an item of zeros, to be followed by its elements. Items come in the order of their field reference
    /// numbers.
    ///
    /// # Panics
    /// If the edition has no such item.
    pub fn item(&mut self, frn: Frn) -> &mut Self {
        self.end_compound();
        let item = self.begin_item(frn);
        self.begin_octets(item)
    }

    /// Begins the subitem at this position, counted from 1, of a compound item, and the item with the first of them;
    /// subitems come in order.
    ///
    /// # Panics
    /// If the edition has no such subitem.
    pub fn subitem(&mut self, frn: Frn, position: usize) -> &mut Self {
        let bit = 1u64 << (position - 1);
        let is_open = self.present.checked_ilog2() == Some(u32::from(frn.get()) - 1);
        if !is_open {
            self.end_compound();
            self.begin_item(frn);
            self.compound = Some((self.items.len(), 0));
        }
        let (_, subitems) = self.compound.as_mut().expect("begun as a compound item");
        debug_assert!(*subitems < bit, "{}: subitem {position} after a later one", self.table);
        *subitems |= bit;
        let subitem = match self.uap.item(frn).map(|item| &item.layout) {
            Some(Layout::Compound(subitems)) => subitems.get(position - 1).and_then(Option::as_ref),
            _ => None,
        };
        self.begin_octets(subitem.expect("the edition has the subitem"))
    }

    /// Puts the number of an element, which its bits can hold, into the item or subitem begun last. An extension is
    /// sent only for a number other than 0.
    #[inline(always)]
    pub fn put(&mut self, field: Field, number: impl Into<i64>) -> &mut Self {
        let number = number.into();
        debug_assert!(field.holds(number), "{}: {number} in {} bits", self.table, field.bits);
        let begin = self.begin + field.byte;
        let end = begin + field.octets;
        if end > self.items.len() {
            debug_assert!(self.is_extended, "{}: an element beyond its item", self.table);
            if number == 0 {
                return self;
            }
            self.extend_to(end);
        }
        let bits = number as u64 & u64::MAX >> (u64::BITS - field.bits);
        let octets = (bits << field.shift).to_be_bytes();
        let unused = octets.len() - field.octets;
        for (octet, bits) in self.items[begin..end].iter_mut().zip(&octets[unused..]) {
            *octet |= bits;
        }
        self
    }

    /// Appends extensions up to this end.
    #[cold]
    fn extend_to(&mut self, end: usize) {
        while self.items.len() < end {
            *self.items.last_mut().expect("the first part") |= 1;
            self.items.push(0);
        }
    }

    /// Ends the record and gives its bytes; the next item begins another.
    pub fn finish(&mut self) -> &[u8] {
        self.end_compound();
        self.record.clear();
        self.record.extend(fspec(self.present));
        self.record.extend_from_slice(&self.items);
        self.items.clear();
        self.present = 0;
        &self.record
    }

    fn begin_item(&mut self, frn: Frn) -> &'static Item {
        let bit = 1u64 << (frn.get() - 1);
        debug_assert!(
            self.present < bit,
            "{}: FRN {} after a later one",
            self.table,
            frn.get()
        );
        self.present |= bit;
        self.uap.item(frn).expect("the edition has the item")
    }

    /// Appends the least bytes of an item or subitem.
    fn begin_octets(&mut self, item: &'static Item) -> &mut Self {
        let octets = match &item.layout {
            Layout::Extended(parts) => {
                let extents = parts.iter().map(|part| extent_of_part(part).0);
                debug_assert!(
                    extents.into_iter().all(|octets| octets == 1),
                    "{}: long extensions",
                    self.table
                );
                1
            }
            _ => item.fixed_octets.map_or(0, usize::from),
        };
        self.is_extended = matches!(item.layout, Layout::Extended(_));
        self.begin = self.items.len();
        self.items.resize(self.begin + octets, 0);
        self
    }

    /// Puts the FSPEC of a compound item before its subitems.
    #[inline]
    fn end_compound(&mut self) {
        if let Some((begin, subitems)) = self.compound {
            self.compound = None;
            let before = self.items.len();
            self.items.extend(fspec(subitems));
            let octets = self.items.len() - before;
            self.items[begin..].rotate_right(octets);
        }
    }
}

/// The bytes of an FSPEC, at least one: bit i of `present` for position i.
pub(super) fn fspec(present: u64) -> impl Iterator<Item = u8> {
    let count = (u64::BITS - present.leading_zeros()).div_ceil(7).max(1) as usize;
    (0..count).map(move |i| fspec_octet((present >> (7 * i)) as u8, i + 1 < count))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::categories::{CAT062, CAT062_V1_18};
    use crate::field::{elements, field, item, subitem};
    use crate::{Block, Mode, NamedRecord, Value};

    const SOURCE: Elements<2> = elements(CAT062, "010", ["SAC", "SIC"]);
    const VELOCITY: Elements<2> = elements(CAT062, "185", ["VX", "VY"]);
    const STATUS: Frn = item(CAT062, "080");

    fn status(element: &str) -> Field {
        field(&[&CAT062_V1_18], &["080", element])
    }

    #[test]
    fn bits_join_across_octets_and_the_fspec_is_short() {
        let mut record = RecordWriter::new(&CAT062_V1_18);
        record.write(&SOURCE, [1, 2]);
        record.write(&VELOCITY, [-1, 5]);
        record.write(&elements(&[&CAT062_V1_18], "060", ["CH", "MODE3A"]), [1, 0o1234]);
        let expected = [0b1000_0011, 0b0100_0000, 1, 2, 0xFF, 0xFF, 0, 5, 0x22, 0x9C];
        assert_eq!(record.finish(), expected);
        record.write(&SOURCE, [3, 4]);
        assert_eq!(record.finish(), [0x80, 3, 4], "nothing is left of the record before");
    }

    #[test]
    fn extended_items_end_with_the_last_part_that_says_something() {
        let mut record = RecordWriter::new(&CAT062_V1_18);
        record
            .item(STATUS)
            .put(status("MON"), true)
            .put(status("MD5"), 1)
            .put(status("CST"), 0);
        assert_eq!(record.finish(), [0x01, 0b0000_0100, 0b1000_0001, 0x01, 0b0000_0010]);
        record.item(STATUS).put(status("MON"), 0).put(status("MD5"), 0);
        assert_eq!(record.finish(), [0x01, 0x04, 0x00]);
    }

    #[test]
    fn compound_items_are_read_back() {
        const AGES: Frn = item(CAT062, "290");
        const PSR: usize = subitem(CAT062, "290", "PSR");
        const MLT: usize = subitem(CAT062, "290", "MLT");
        let mut record = RecordWriter::new(&CAT062_V1_18);
        record.subitem(AGES, PSR).put(field(CAT062, &["290", "PSR"]), 7);
        record.subitem(AGES, MLT).put(field(CAT062, &["290", "MLT"]), 255);
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
        record.write(&VELOCITY, [0, 0]);
        record.write(&SOURCE, [0, 0]);
    }

    #[test]
    #[should_panic(expected = "256 in 8 bits")]
    #[cfg(debug_assertions)]
    fn numbers_that_do_not_fit_are_noticed() {
        RecordWriter::new(&CAT062_V1_18).write(&SOURCE, [256, 0]);
    }
}
