//! Records, with the positions of their items.
//!
//! Reading a record finds its items without decoding: a pass over the FSPEC and the lengths, into a fixed array of
//! offsets. Unused items cost the hot path nothing else.

use super::bits::{bits, fspec_bits, goes_on};
use super::block::{Block, HEADER_OCTETS};
use super::error::Error;
use super::extent;
use super::mode::Mode;
use super::spare;
use super::table::{Category, Frn, Item, Layout, MAX_FRN, MAX_FSPEC_OCTETS, Profile, Uap, first_element};

/// Item 010, the sender, in every category: [`registry`](crate::registry) makes sure of it.
pub(crate) const SENDER: Frn = Frn(1);

/// A record with known positions of its items.
#[derive(Debug, Clone, Copy)]
pub struct Record<'a> {
    table: &'static Category,
    uap: &'static Uap,
    bytes: &'a [u8],
    offset: usize,
    /// Bit FRN − 1 for each item present.
    present: u64,
    /// Offsets of the items in `bytes`, in FRN order, and after the last of them the end.
    starts: [u16; MAX_FRN + 1],
    unknown_extension_octets: u16,
}

impl<'a> Record<'a> {
    /// The table it was read with.
    pub fn table(&self) -> &'static Category {
        self.table
    }

    /// The profile it was read with; of interest where the category has several.
    pub fn uap(&self) -> &'static Uap {
        self.uap
    }

    /// Offset of its first byte in the bytes the caller passed.
    pub fn offset(&self) -> usize {
        self.offset
    }

    /// All its bytes, beginning with the FSPEC.
    pub fn bytes(&self) -> &'a [u8] {
        self.bytes
    }

    /// Its bytes behind the FSPEC.
    pub(crate) fn body(&self) -> &'a [u8] {
        &self.bytes[usize::from(self.starts[0])..]
    }

    /// The bytes of an item, if it is present. [`field::item`](crate::field::item) and
    /// [`Uap::frn`] give the number of a named item.
    #[inline]
    pub fn item(&self, frn: Frn) -> Option<&'a [u8]> {
        let bit = 1u64 << (frn.get() - 1);
        if self.present & bit == 0 {
            return None;
        }
        let rank = (self.present & (bit - 1)).count_ones() as usize;
        Some(&self.bytes[usize::from(self.starts[rank])..usize::from(self.starts[rank + 1])])
    }

    /// The bytes of an item; none if it is not present.
    #[inline]
    pub fn octets(&self, frn: Frn) -> &'a [u8] {
        self.item(frn).unwrap_or_default()
    }

    /// System area code and system identification code of the sender, item 010; `None` where the record has none.
    #[inline]
    pub fn sender(&self) -> Option<(u8, u8)> {
        match self.item(SENDER)? {
            [sac, sic, ..] => Some((*sac, *sic)),
            _ => None,
        }
    }

    /// The subitems present in a compound item, in the order sent: the position of each in the item's FSPEC, counted
    /// from 1, and its bytes. Empty where the record has no such item.
    #[inline]
    pub fn subitems(&self, frn: Frn) -> impl Iterator<Item = (usize, &'a [u8])> + use<'a> {
        let (uap, category) = (self.uap, self.table.number);
        let defined: &'static [Option<Item>] = match uap.item(frn).map(|item| &item.layout) {
            Some(Layout::Compound(subitems)) => subitems,
            _ => &[],
        };
        let (mut present, mut rest) = self.item(frn).map_or((0, &[][..]), split_fspec);
        std::iter::from_fn(move || {
            let position = (present != 0).then(|| present.trailing_zeros() as usize + 1)?;
            present &= present - 1;
            let subitem = defined.get(position - 1)?.as_ref()?;
            let octets = match subitem.fixed_octets {
                Some(octets) => usize::from(octets),
                // The item has been measured before, subitem by subitem.
                None => {
                    extent::measure(subitem, uap, rest, Mode::Lenient, category, 0)
                        .ok()?
                        .octets
                }
            };
            let (subitem, behind) = rest.split_at_checked(octets)?;
            rest = behind;
            Some((position, subitem))
        })
    }

    /// The bytes of an item, by name; slower than [`item`](Self::item).
    pub fn item_named(&self, name: &str) -> Option<&'a [u8]> {
        self.item_at(name).map(|(_, bytes)| bytes)
    }

    /// A named item's bytes, and where they begin in the bytes the caller passed.
    pub(crate) fn item_at(&self, name: &str) -> Option<(usize, &'a [u8])> {
        let mut offset = self.offset + usize::from(self.starts[0]);
        for (item, bytes) in self.items() {
            if item.name == name {
                return Some((offset, bytes));
            }
            offset += bytes.len();
        }
        None
    }

    /// The items present and their bytes, in the order sent.
    pub fn items(&self) -> impl Iterator<Item = (&'static Item, &'a [u8])> + '_ {
        self.frns()
            .filter_map(|frn| Some((self.uap.item(frn)?, self.item(frn)?)))
    }

    /// The field reference numbers of the items present, ascending.
    pub fn frns(&self) -> impl Iterator<Item = Frn> + use<> {
        frns(self.present)
    }

    /// The bytes after the last defined part of extended items, skipped in lenient mode.
    pub fn unknown_extension_octets(&self) -> usize {
        usize::from(self.unknown_extension_octets)
    }
}

/// Iterator over the records of a block. Ends after the first error, because the start of the next record is then
/// unknown.
#[derive(Debug, Clone)]
pub struct Records<'a> {
    table: &'static Category,
    mode: Mode,
    rest: &'a [u8],
    offset: usize,
    octets_skipped: usize,
}

impl<'a> Block<'a> {
    /// The records, read with one edition's table. The caller has chosen a table of the block's category.
    pub fn records(&self, table: &'static Category, mode: Mode) -> Records<'a> {
        Records::new(self, table, mode)
    }
}

impl<'a> Records<'a> {
    fn new(block: &Block<'a>, table: &'static Category, mode: Mode) -> Self {
        let offset = block.offset + HEADER_OCTETS;
        Self {
            table,
            mode,
            rest: block.body(),
            offset,
            octets_skipped: 0,
        }
    }

    /// The bytes from a record in error to the end of the block; zero while there was no error.
    pub fn octets_skipped(&self) -> usize {
        self.octets_skipped
    }
}

impl<'a> Iterator for Records<'a> {
    type Item = Result<Record<'a>, Error>;

    #[inline]
    fn next(&mut self) -> Option<Self::Item> {
        if self.rest.is_empty() {
            return None;
        }
        let record = find_items(self.table, self.mode, self.rest, self.offset);
        match &record {
            Ok(record) => {
                self.rest = &self.rest[record.bytes.len()..];
                self.offset += record.bytes.len();
            }
            Err(_) => {
                self.octets_skipped = self.rest.len();
                self.rest = &[];
            }
        }
        Some(record)
    }
}

/// Splits a compound item into a bit per announced subitem, the first lowest, and the bytes behind the FSPEC.
#[inline]
fn split_fspec(item: &[u8]) -> (u64, &[u8]) {
    let mut present = 0;
    for (i, &octet) in item.iter().enumerate() {
        present |= u64::from(fspec_bits(octet)) << (7 * i);
        if !goes_on(octet) {
            return (present, &item[i + 1..]);
        }
    }
    (0, &[])
}

fn frns(present: u64) -> impl Iterator<Item = Frn> + use<> {
    let mut rest = present;
    std::iter::from_fn(move || {
        let frn = (rest != 0).then(|| Frn(rest.trailing_zeros() as u8 + 1))?;
        rest &= rest - 1;
        Some(frn)
    })
}

/// Finds the items of the record at the begin of `bytes`.
fn find_items<'a>(table: &'static Category, mode: Mode, bytes: &'a [u8], offset: usize) -> Result<Record<'a>, Error> {
    let category = table.number;
    let (present, fspec_octets) = read_fspec(category, bytes, offset)?;
    let uap = match &table.profile {
        Profile::Single(uap) => uap,
        Profile::Depends { .. } => decide_profile(table, mode, bytes, offset)?,
    };
    let mut starts = [0; MAX_FRN + 1];
    let mut unknown = 0;
    let mut at = fspec_octets;
    let mut rank = 0;
    for frn in frns(present) {
        starts[rank] = at as u16; // a block has at most 65,535 octets
        rank += 1;
        let Some(item) = uap.item(frn) else {
            return Err(Error::ItemUndefined {
                offset,
                category,
                frn: frn.get(),
            });
        };
        let available = bytes.len() - at;
        match item.quick_octets(&bytes[at..]) {
            Some(octets) if octets <= available => at += octets,
            Some(needed) => {
                let (offset, item) = (offset + at, item.name);
                return Err(Error::ItemTruncated {
                    offset,
                    category,
                    item,
                    needed,
                    available,
                });
            }
            None => {
                let extent = extent::measure(item, uap, &bytes[at..], mode, category, offset + at)?;
                at += extent.octets;
                unknown += extent.unknown;
            }
        }
    }
    starts[rank] = at as u16;
    let record = Record {
        table,
        uap,
        bytes: &bytes[..at],
        offset,
        present,
        starts,
        unknown_extension_octets: unknown as u16,
    };
    if mode == Mode::Strict {
        check_spare_bits(&record)?;
    }
    Ok(record)
}

/// Returns the FSPEC as a bit per FRN, and its length in bytes.
fn read_fspec(category: u8, bytes: &[u8], offset: usize) -> Result<(u64, usize), Error> {
    let mut present = 0;
    for i in 0..MAX_FSPEC_OCTETS {
        let Some(&octet) = bytes.get(i) else {
            return Err(Error::FspecTruncated {
                offset,
                category,
                octets: i,
            });
        };
        present |= u64::from(fspec_bits(octet)) << (7 * i);
        if !goes_on(octet) {
            if present == 0 {
                return Err(Error::RecordEmpty { offset, category });
            }
            return Ok((present, i + 1));
        }
    }
    Err(Error::FspecTooLong {
        offset,
        category,
        maximum: MAX_FSPEC_OCTETS,
    })
}

/// Reads the record up to the item that decides, with the first profile: up to there all profiles are the same.
fn decide_profile(table: &'static Category, mode: Mode, bytes: &[u8], offset: usize) -> Result<&'static Uap, Error> {
    let category = table.number;
    let Profile::Depends {
        item: decider,
        element,
        cases,
    } = &table.profile
    else {
        unreachable!("the caller has looked");
    };
    let undecided = |found| Error::ProfileUndecided {
        offset,
        category,
        item: decider,
        found,
    };
    let (present, mut at) = read_fspec(category, bytes, offset)?;
    let first = cases.first().map(|(_, uap)| uap).ok_or_else(|| undecided(None))?;
    for frn in frns(present) {
        let Some(item) = first.item(frn) else {
            break;
        };
        let octets = extent::measure(item, first, &bytes[at..], mode, category, offset + at)?.octets;
        if item.name == *decider {
            let value = first_element(&item.layout, element).map(|(begin, width)| bits(bytes, 8 * at + begin, width));
            let case = cases.iter().find(|(case, _)| Some(*case) == value);
            return case.map(|(_, uap)| uap).ok_or_else(|| undecided(value));
        }
        at += octets;
    }
    Err(undecided(None))
}

fn check_spare_bits(record: &Record<'_>) -> Result<(), Error> {
    let mut at = usize::from(record.starts[0]);
    for (item, bytes) in record.items() {
        if spare::any_set(item, record.uap, bytes) {
            let (offset, category) = (record.offset + at, record.table.number);
            return Err(Error::SpareBitSet {
                offset,
                category,
                item: item.name,
            });
        }
        at += bytes.len();
    }
    Ok(())
}
