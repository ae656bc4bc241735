//! Length of an item in bytes: the one thing that must be known of every item to reach the next.
//!
//! # Beyond the edition
//!
//! A sender of a later edition, or a faulty sender, may set the FX bit of the last part of an edition. The
//! multilateration system of a European airport does so in I019/553: ed 1.3 has the state of four reference
//! transponders in two bytes, the system has six and sends a third byte. Later editions usually extend an item by
//! single bytes. In lenient mode such bytes are taken as extension parts of unknown meaning: skipped, counted, and
//! shown among the named values as [`UNKNOWN_EXTENSION`](super::named::UNKNOWN_EXTENSION). At most
//! [`MAX_UNKNOWN_EXTENSION_OCTETS`] are accepted; more indicate that the reader is out of step. In strict mode the
//! first is an error.
//!
//! An undefined bit in an FSPEC permits no such guess: the length of the announced item is unknown.

use super::bits::{fspec_bits, goes_on};
use super::error::Error;
use super::mode::Mode;
use super::table::{Item, Layout, MAX_FSPEC_OCTETS, Part, Uap, extent_of_part};

/// The most bytes that lenient reading takes as an extension beyond the edition.
pub(super) const MAX_UNKNOWN_EXTENSION_OCTETS: usize = 4;

/// The measured length of an item.
#[derive(Debug, Default, Clone, Copy)]
pub(super) struct ItemLength {
    /// All bytes of the item.
    pub(super) octets: usize,
    /// Bytes among them that lie beyond the edition's last extension part.
    pub(super) unknown: usize,
}

/// Measures an item that begins with the first of `bytes` and may reach to the last of them. `offset` and
/// `category` are for the error.
pub(super) fn measure(
    item: &'static Item,
    uap: &'static Uap,
    bytes: &[u8],
    mode: Mode,
    category: u8,
    offset: usize,
) -> Result<ItemLength, Error> {
    let mut measure = Measure {
        uap,
        bytes,
        mode,
        at: 0,
        unknown: 0,
    };
    measure.layout(&item.layout).map_err(|fault| {
        let item = item.name;
        match fault {
            ItemFault::Truncated { needed } => Error::ItemTruncated {
                offset,
                category,
                item,
                needed,
                available: bytes.len(),
            },
            ItemFault::ExplicitLength => Error::ExplicitLength { offset, category, item },
            ItemFault::Extension { tolerated } => Error::ExtensionUndefined {
                offset,
                category,
                item,
                tolerated,
            },
            ItemFault::Subitem { position } => Error::SubitemUndefined {
                offset,
                category,
                item,
                position,
            },
            ItemFault::Sequence { frn } => Error::SequenceUndefined {
                offset,
                category,
                item,
                frn,
            },
        }
    })?;
    Ok(ItemLength {
        octets: measure.at,
        unknown: measure.unknown,
    })
}

/// Fault of an item, without its place, which [`measure`] adds.
enum ItemFault {
    Truncated { needed: usize },
    ExplicitLength,
    Extension { tolerated: usize },
    Subitem { position: usize },
    Sequence { frn: u8 },
}

struct Measure<'a> {
    uap: &'static Uap,
    bytes: &'a [u8],
    mode: Mode,
    at: usize,
    unknown: usize,
}

impl Measure<'_> {
    fn item(&mut self, item: &'static Item) -> Result<(), ItemFault> {
        match item.quick_octets(&self.bytes[self.at..]) {
            Some(octets) => self.skip(octets),
            None => self.layout(&item.layout),
        }
    }

    fn layout(&mut self, layout: &'static Layout) -> Result<(), ItemFault> {
        match layout {
            Layout::Element(bits, _) => self.skip(usize::from(*bits) / 8),
            Layout::Group(_) => self.skip(layout.bit_count() as usize / 8),
            Layout::Extended(parts) => self.extended(parts),
            Layout::Repetitive(inner) => {
                let count = self.octet()?;
                match inner {
                    Layout::Element(..) | Layout::Group(_) => {
                        self.skip(usize::from(count) * inner.bit_count() as usize / 8)
                    }
                    _ => (0..count).try_for_each(|_| self.layout(inner)),
                }
            }
            Layout::RepetitiveFx(inner) => self.repetitive_fx(inner.bit_count() as usize / 8 + 1),
            Layout::Explicit => match self.octet()? {
                0 => Err(ItemFault::ExplicitLength),
                length => self.skip(usize::from(length) - 1),
            },
            Layout::Compound(subitems) => self.compound(subitems),
            Layout::RandomSequence => self.random_sequence(),
        }
    }

    fn extended(&mut self, parts: &'static [&'static [Part]]) -> Result<(), ItemFault> {
        for part in parts {
            let (octets, ends_in_fx) = extent_of_part(part);
            if !self.goes_on_after(octets)? || !ends_in_fx {
                return Ok(());
            }
        }
        let tolerated = match self.mode {
            Mode::Strict => 0,
            Mode::Lenient => MAX_UNKNOWN_EXTENSION_OCTETS,
        };
        for _ in 0..tolerated {
            self.unknown += 1;
            if !self.goes_on_after(1)? {
                return Ok(());
            }
        }
        Err(ItemFault::Extension { tolerated })
    }

    fn repetitive_fx(&mut self, octets: usize) -> Result<(), ItemFault> {
        while self.goes_on_after(octets)? {} // ends with the bytes at the latest
        Ok(())
    }

    fn compound(&mut self, subitems: &'static [Option<Item>]) -> Result<(), ItemFault> {
        let mut present = 0u64;
        for i in 0..=MAX_FSPEC_OCTETS {
            if i == MAX_FSPEC_OCTETS {
                return Err(ItemFault::Subitem { position: 7 * i + 1 });
            }
            let octet = self.octet()?;
            present |= u64::from(fspec_bits(octet)) << (7 * i);
            if !goes_on(octet) {
                break;
            }
        }
        while present != 0 {
            let i = present.trailing_zeros() as usize;
            present &= present - 1;
            match subitems.get(i) {
                Some(Some(subitem)) => self.item(subitem)?,
                _ => return Err(ItemFault::Subitem { position: i + 1 }),
            }
        }
        Ok(())
    }

    fn random_sequence(&mut self) -> Result<(), ItemFault> {
        let count = self.octet()?;
        (0..count).try_for_each(|_| {
            let frn = self.octet()?;
            let item = self.uap.item_in_sequence(frn).ok_or(ItemFault::Sequence { frn })?;
            self.item(item)
        })
    }

    /// Skips a part; returns whether the FX bit at its end is set.
    fn goes_on_after(&mut self, octets: usize) -> Result<bool, ItemFault> {
        self.skip(octets)?;
        Ok(goes_on(self.bytes[self.at - 1]))
    }

    fn octet(&mut self) -> Result<u8, ItemFault> {
        self.skip(1)?;
        Ok(self.bytes[self.at - 1])
    }

    fn skip(&mut self, octets: usize) -> Result<(), ItemFault> {
        self.at += octets;
        if self.at > self.bytes.len() {
            Err(ItemFault::Truncated { needed: self.at })
        } else {
            Ok(())
        }
    }
}
