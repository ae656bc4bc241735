//! The words in which a category's table is written.
//!
//! A table is constant data: [`Category`] → [`Item`] → [`Layout`] → [`Part`] → [`Content`]. The `const` constructors
//! check whole bytes, element widths and names in the profile, so that a table with such an error does not compile. A
//! wrong width that happens to fit, or a wrong LSB, is found only by a reader or by comparison with recordings.

use std::fmt;
use std::ptr;
use std::str::FromStr;

use super::bits::goes_on;
use super::key::Key;

/// The most FSPEC bytes a record or a compound item may have. The longest profile published has 7.
pub const MAX_FSPEC_OCTETS: usize = 8;
/// The most field reference numbers a profile may have: seven for each FSPEC byte.
pub const MAX_FRN: usize = 7 * MAX_FSPEC_OCTETS;

/// Edition of a category: the items that a record may hold, and where.
#[derive(Debug)]
pub struct Category {
    /// The category byte of its data blocks.
    pub number: u8,
    /// The document's edition.
    pub edition: Edition,
    /// The document's title.
    pub title: &'static str,
    /// The document's number.
    pub document: &'static str,
    /// Items with a record's time of day, 24 bits of 1/128 s; of several, the first that a record has counts.
    pub times: &'static [&'static str],
    /// Items by FSPEC bit.
    pub profile: Profile,
}

impl Category {
    /// Returns a category with a single profile: number, edition, title and document, the items of the profile, and
    /// the items with the time of day.
    pub(crate) const fn new(
        number: u8,
        edition: Edition,
        [title, document]: [&'static str; 2],
        items: &'static [Option<Item>],
        times: &'static [&'static str],
    ) -> Self {
        Self {
            number,
            edition,
            title,
            document,
            times,
            profile: Profile::Single(Uap::new(items)),
        }
    }

    /// The item of this name.
    pub const fn item(&self, name: &str) -> Option<&'static Item> {
        let cases = match &self.profile {
            Profile::Single(uap) => return uap.item_named(name),
            Profile::Depends { cases, .. } => cases,
        };
        let mut i = 0;
        while i < cases.len() {
            if let Some(item) = cases[i].1.item_named(name) {
                return Some(item);
            }
            i += 1;
        }
        None
    }

    /// The profile, or the first of several: for the field reference numbers of items by name.
    pub const fn uap(&self) -> &Uap {
        match &self.profile {
            Profile::Single(uap) => uap,
            Profile::Depends { cases, .. } => &cases[0].1,
        }
    }

    /// The profile for a value of the element that decides, or the only one.
    ///
    /// # Panics
    /// If there are several, and none for this value.
    pub const fn uap_of(&self, value: u64) -> &Uap {
        let cases = match &self.profile {
            Profile::Single(uap) => return uap,
            Profile::Depends { cases, .. } => cases,
        };
        let mut i = 0;
        while cases[i].0 != value {
            i += 1;
        }
        &cases[i].1
    }

    /// True if this is one of `tables` itself and not only like it: a reader's item places and widths hold for some
    /// editions and must not be tried on other tables.
    #[inline]
    pub fn is_one_of(&self, tables: &[&Category]) -> bool {
        tables.iter().any(|table| ptr::eq(*table, self))
    }
}

impl fmt::Display for Category {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "CAT{:03} ed {}", self.number, self.edition)
    }
}

/// An edition number such as 0.23, ordered as documents are: 0.9 comes before 0.23.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Edition {
    /// Before the point.
    pub major: u8,
    /// After the point, a whole number.
    pub minor: u8,
}

impl Edition {
    /// The edition `major.minor`.
    pub const fn new(major: u8, minor: u8) -> Self {
        Self { major, minor }
    }
}

impl fmt::Display for Edition {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}.{}", self.major, self.minor)
    }
}

/// A text that is no edition number.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{found:?} is no edition; write an edition as in 1.9 or 0.23")]
pub struct EditionError {
    /// Text that was given.
    pub found: String,
}

impl FromStr for Edition {
    type Err = EditionError;

    fn from_str(text: &str) -> Result<Self, EditionError> {
        text.split_once('.')
            .and_then(|(major, minor)| Some(Self::new(major.parse().ok()?, minor.parse().ok()?)))
            .ok_or_else(|| EditionError { found: text.to_owned() })
    }
}

/// Items of a category by FSPEC bit.
#[derive(Debug)]
pub enum Profile {
    /// The usual case: one profile.
    Single(Uap),
    /// Several profiles, chosen by an element of the record itself (CAT001: plot or track). The items up to and
    /// including the deciding one must have the same field reference numbers in all of them.
    Depends {
        /// The deciding item.
        item: &'static str,
        /// The deciding element, mandatory in such an item: an element of a group, or of the first part of an
        /// extended item.
        element: &'static str,
        /// The value of that element, and its profile.
        cases: &'static [(u64, Uap)],
    },
}

/// A user application profile: the item for each field reference number.
#[derive(Debug)]
pub struct Uap {
    /// Items in FRN order; `None` for a number that stands for no item.
    pub items: &'static [Option<Item>],
}

impl Uap {
    /// The profile with these items in FRN order. Does not compile where there are too many.
    pub const fn new(items: &'static [Option<Item>]) -> Self {
        assert!(items.len() <= MAX_FRN, "a profile has more entries than MAX_FRN");
        Self { items }
    }

    /// Item names in FRN order; empty for a number that stands for no item.
    pub fn names(&self) -> impl ExactSizeIterator<Item = &'static str> + use<> {
        self.items.iter().map(name_of)
    }

    /// The field reference number of a named item. Evaluated in a constant it does not compile where there is none.
    ///
    /// # Panics
    /// If the profile has no item of this name.
    pub const fn frn(&self, name: &str) -> Frn {
        match self.find(name) {
            Some(frn) => frn,
            None => panic!("the profile has no item of this name"),
        }
    }

    /// Returns the field reference number of a named item, if present.
    pub(crate) const fn find(&self, name: &str) -> Option<Frn> {
        let mut i = 0;
        while i < self.items.len() {
            if let Some(item) = &self.items[i]
                && same(item.name, name)
            {
                return Some(Frn(i as u8 + 1));
            }
            i += 1;
        }
        None
    }

    const fn item_named(&self, name: &str) -> Option<&'static Item> {
        match self.find(name) {
            Some(frn) => self.items[frn.0 as usize - 1].as_ref(),
            None => None,
        }
    }

    /// The item at a field reference number.
    #[inline]
    pub(super) fn item(&self, frn: Frn) -> Option<&'static Item> {
        self.items.get(usize::from(frn.0) - 1)?.as_ref()
    }

    /// The item that a byte of a random field sequence stands for. Another sequence does not.
    pub(super) fn item_in_sequence(&self, octet: u8) -> Option<&'static Item> {
        let item = self.item(Frn(octet.max(1)))?;
        (octet > 0 && !matches!(item.layout, Layout::RandomSequence)).then_some(item)
    }
}

/// A field reference number: the position of an item in its profile, counted from 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Frn(pub(super) u8);

impl Frn {
    /// The number, from 1 to [`MAX_FRN`].
    pub const fn get(self) -> u8 {
        self.0
    }
}

/// A data item, or a subitem of a compound one.
#[derive(Debug)]
pub struct Item {
    /// The number after the stroke ("140" of I010/140), or a subitem's short name ("DOP").
    pub name: &'static str,
    /// The document's title.
    pub title: &'static str,
    /// Division of its bytes.
    pub layout: Layout,
    /// Length in bytes, where the layout has only one.
    pub(super) fixed_octets: Option<u16>,
    /// Number of parts of an extended item whose parts are all of one octet; 0 for other layouts.
    pub(super) octet_parts: usize,
    /// The name as JSON has it.
    pub(super) key: Key,
}

impl Item {
    /// An item. Does not compile where a part of it is no whole number of bytes.
    pub const fn new(name: &'static str, title: &'static str, layout: Layout) -> Self {
        let fixed_octets = layout.fixed_octets();
        let octet_parts = layout.octet_parts();
        Self {
            name,
            title,
            layout,
            fixed_octets,
            octet_parts,
            key: Key::new(name),
        }
    }

    /// The length in bytes, where it is found without a look at the layout.
    #[inline]
    pub(super) fn quick_octets(&self, bytes: &[u8]) -> Option<usize> {
        if let Some(octets) = self.fixed_octets {
            return Some(usize::from(octets));
        }
        let mut parts = bytes.iter().take(self.octet_parts);
        parts.position(|octet| !goes_on(*octet)).map(|before| before + 1)
    }
}

/// Name of the item or subitem at a place of an FSPEC; empty where there is none.
pub(super) fn name_of(item: &Option<Item>) -> &'static str {
    item.as_ref().map_or("", |item| item.name)
}

/// Division of an item's bytes.
#[derive(Debug)]
pub enum Layout {
    /// Element of so many bits, which is the whole item.
    Element(u8, Content),
    /// Elements and spare bits one after the other.
    Group(&'static [Part]),
    /// Parts that each end in an FX bit, not written in the table: 1 if the next part follows. Only the last part may
    /// be whole bytes, without FX bit.
    Extended(&'static [&'static [Part]]),
    /// A count byte, then so many of the inner layout.
    Repetitive(&'static Layout),
    /// An inner layout followed by an FX bit that announces another repetition. The inner layout is an [`Element`] or
    /// a [`Group`] one bit short of whole bytes.
    ///
    /// [`Element`]: Layout::Element
    /// [`Group`]: Layout::Group
    RepetitiveFx(&'static Layout),
    /// A byte with the length, itself included, then content that this table does not describe.
    Explicit,
    /// An FSPEC and the announced subitems; `None` for a bit without a meaning.
    Compound(&'static [Option<Item>]),
    /// Random field sequencing: a count byte, then so many times a field reference number, in one byte, and the
    /// item that the profile has there. So a sender may give items in another order, or one more than once.
    RandomSequence,
}

impl Layout {
    /// The length in bytes where it is always the same; checks on the way that everything is whole bytes.
    const fn fixed_octets(&self) -> Option<u16> {
        match self {
            Self::Element(bits, _) => Some(whole_octets(*bits as u32)),
            Self::Group(parts) => Some(whole_octets(bit_count(parts))),
            Self::Extended(parts) => {
                let mut i = 0;
                while i < parts.len() {
                    let is_last = i + 1 == parts.len();
                    let without_fx = is_last && bit_count(parts[i]).is_multiple_of(8);
                    whole_octets(bit_count(parts[i]) + if without_fx { 0 } else { 1 });
                    i += 1;
                }
                None
            }
            Self::RepetitiveFx(inner) => {
                whole_octets(inner.bit_count() + 1);
                None
            }
            Self::Repetitive(inner) => {
                inner.fixed_octets();
                None
            }
            Self::Explicit | Self::Compound(_) | Self::RandomSequence => None,
        }
    }

    const fn octet_parts(&self) -> usize {
        let Self::Extended(parts) = self else {
            return 0;
        };
        let mut i = 0;
        while i < parts.len() {
            if bit_count(parts[i]) != 7 {
                return 0;
            }
            i += 1;
        }
        parts.len()
    }

    /// The bits of an element or a group.
    pub(super) const fn bit_count(&self) -> u32 {
        match self {
            Self::Element(bits, _) => *bits as u32,
            Self::Group(parts) => bit_count(parts),
            _ => panic!("only an element or a group has a number of bits"),
        }
    }
}

/// A piece of a group or of a part of an extended item.
#[derive(Debug)]
pub enum Part {
    /// A named element.
    Element {
        /// Name in the document.
        name: &'static str,
        /// The name as JSON has it.
        key: Key,
        /// Width in bits.
        bits: u8,
        /// Meaning of the bits.
        content: Content,
    },
    /// Bits without meaning, sent as zero.
    Spare(u8),
    /// Elements under a common name.
    Group(&'static str, &'static [Part]),
}

/// Meaning of an element's bits.
#[derive(Debug)]
pub enum Content {
    /// Bits as they are: a flag, a code of some list, an identifier.
    Raw,
    /// A whole number.
    Integer {
        /// True for a number in two's complement.
        signed: bool,
    },
    /// A physical quantity: value = number × LSB.
    Quantity {
        /// True for a number in two's complement.
        signed: bool,
        /// The value of the least significant bit, in `unit`.
        lsb: f64,
        /// The document's unit; empty for none.
        unit: &'static str,
    },
    /// Characters.
    Text(TextCoding),
    /// Content that depends on the value of an element before it in the same group.
    Depends {
        /// The deciding element.
        on: &'static str,
        /// Values of it, and the content in each case.
        cases: &'static [(u64, Content)],
        /// The content for any other value.
        otherwise: &'static Content,
    },
}

/// Coding of characters; see [`text`](super::text).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TextCoding {
    /// Eight bits each.
    Ascii,
    /// Six bits each, ICAO Annex 10 volume IV, 3.1.2.9.
    Icao,
    /// Three bits each: the digits 0 to 7.
    Octal,
}

/// Bits as they are.
pub const RAW: Content = Content::Raw;
/// A whole number without sign.
pub const NUMBER: Content = Content::Integer { signed: false };
/// A whole number in two's complement.
pub const SIGNED_NUMBER: Content = Content::Integer { signed: true };
/// Six-bit characters.
pub const ICAO: Content = Content::Text(TextCoding::Icao);
/// Octal digits.
pub const OCTAL: Content = Content::Text(TextCoding::Octal);
/// Eight-bit characters.
pub const ASCII: Content = Content::Text(TextCoding::Ascii);

/// A quantity without sign.
pub const fn unsigned(lsb: f64, unit: &'static str) -> Content {
    Content::Quantity {
        signed: false,
        lsb,
        unit,
    }
}

/// A quantity in two's complement.
pub const fn signed(lsb: f64, unit: &'static str) -> Content {
    Content::Quantity {
        signed: true,
        lsb,
        unit,
    }
}

/// A named element of some bits.
pub const fn element(name: &'static str, bits: u8, content: Content) -> Part {
    assert!(bits >= 1 && bits <= 64, "an element has 1 to 64 bits");
    if let Content::Text(coding) = content {
        let width = match coding {
            TextCoding::Ascii => 8,
            TextCoding::Icao => 6,
            TextCoding::Octal => 3,
        };
        assert!(bits.is_multiple_of(width), "a text is a whole number of characters");
    }
    Part::Element {
        name,
        key: Key::new(name),
        bits,
        content,
    }
}

/// A single bit, as it is.
pub const fn flag(name: &'static str) -> Part {
    element(name, 1, RAW)
}

/// Elements under a common name.
pub const fn group(name: &'static str, parts: &'static [Part]) -> Part {
    Part::Group(name, parts)
}

/// Bits without meaning.
pub const fn spare(bits: u8) -> Part {
    Part::Spare(bits)
}

/// A subitem of a compound item; `None` in its place where a bit has no meaning.
pub const fn subitem(name: &'static str, title: &'static str, layout: Layout) -> Option<Item> {
    Some(Item::new(name, title, layout))
}

/// Two to the power of `exponent`: documents write an LSB as 180/2^23, tables as `180.0 / pow2(23)`.
pub const fn pow2(exponent: u32) -> f64 {
    assert!(exponent < 64, "the exponent is too large");
    (1u64 << exponent) as f64
}

/// Returns the length of a part of an extended item in bytes, and whether its last bit is an FX bit.
pub(super) fn extent_of_part(part: &[Part]) -> (usize, bool) {
    let bits = bit_count(part) as usize;
    (bits.div_ceil(8), !bits.is_multiple_of(8))
}

/// The first bit and the width of an element that every item of this layout has: one of a group, or of the first part
/// of an extended item.
pub(super) fn first_element(layout: &Layout, name: &str) -> Option<(usize, usize)> {
    let parts = match layout {
        Layout::Group(parts) | Layout::Extended([parts, ..]) => parts,
        _ => return None,
    };
    let mut at = 0;
    for part in *parts {
        match part {
            Part::Element { name: found, bits, .. } if *found == name => return Some((at, usize::from(*bits))),
            _ => at += bit_count(std::slice::from_ref(part)) as usize,
        }
    }
    None
}

pub(crate) const fn bit_count(parts: &[Part]) -> u32 {
    let mut bits = 0;
    let mut i = 0;
    while i < parts.len() {
        bits += match &parts[i] {
            Part::Element { bits, .. } | Part::Spare(bits) => *bits as u32,
            Part::Group(_, inner) => bit_count(inner),
        };
        i += 1;
    }
    bits
}

const fn whole_octets(bits: u32) -> u16 {
    assert!(
        bits > 0 && bits.is_multiple_of(8),
        "an item or a part of one is no whole number of octets"
    );
    (bits / 8) as u16
}

pub(crate) const fn same(a: &str, b: &str) -> bool {
    let (a, b) = (a.as_bytes(), b.as_bytes());
    if a.len() != b.len() {
        return false;
    }
    let mut i = 0;
    while i < a.len() {
        if a[i] != b[i] {
            return false;
        }
        i += 1;
    }
    true
}
