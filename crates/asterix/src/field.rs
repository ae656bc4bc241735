//! Positions and units of elements, looked up in the tables at compile time.
//!
//! A reader of a category names its elements. [`field`] finds byte, shift, width, sign and least significant bit of
//! an element in the tables of all editions supported by the reader; the compiled program contains only these
//! numbers. A name missing in the tables, or a difference between two editions, fails the build:
//!
//! ```
//! use asterix::categories::CAT048;
//! use asterix::field::{Field, field, item};
//! use asterix::table::Frn;
//!
//! const POSITION: Frn = item(CAT048, "040");
//! const RHO: Field = field(CAT048, &["040", "RHO"]);
//!
//! assert_eq!((POSITION.get(), RHO.bits, RHO.lsb), (4, 16, 1852.0 / 256.0));
//! assert_eq!(RHO.quantity(&[0x01, 0x00, 0x40, 0x00]), Some(1852.0)); // 256/256 NM, 90°
//! ```
//!
//! ```compile_fail
//! # use asterix::{categories::CAT048, field::{Field, field}};
//! const RHO: Field = field(CAT048, &["040", "ROH"]); // no such element
//! ```
//!
//! ```compile_fail
//! # use asterix::{categories::CAT048, field::item, table::Frn};
//! const POSITION: Frn = item(CAT048, "041"); // no such item
//! ```
//!
//! ```compile_fail
//! # use asterix::{categories::CAT021_V0, field::{Field, field}};
//! const LAT: Field = field(CAT021_V0, &["130", "LAT"]); // 24 bits in one edition, 32 in the others
//! ```

use std::f64::consts::PI;

use crate::bits::sign_extend;
use crate::record::Record;
use crate::table::{Category, Content, Edition, Frn, Layout, Part, bit_count, same};

/// Metres in a nautical mile.
pub const NAUTICAL_MILE_M: f64 = 1852.0;
/// Metres in a foot.
pub const FOOT_M: f64 = 0.3048;
/// Metres in a flight level, 100 ft of pressure altitude.
pub const FLIGHT_LEVEL_M: f64 = 100.0 * FOOT_M;
/// Metres per second in a knot.
const KNOT_M_S: f64 = NAUTICAL_MILE_M / 3600.0;

/// An element of an item: position of its bits in the item's bytes, and their unit.
///
/// The methods take the item's bytes, [`Record::octets`](crate::Record::bytes), or, for an element in a compound
/// item, the subitem's bytes. If the bytes end before the element, because the item or an extension was not sent, the
/// methods return `None` or `false`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Field {
    /// First byte of the item that has bits of the element.
    pub byte: usize,
    /// Bytes that have bits of the element.
    pub octets: usize,
    /// Bits behind the element in the last of its bytes.
    pub shift: u32,
    /// Bits of the element, 1 to 64.
    pub bits: u32,
    /// True for a number in two's complement.
    pub signed: bool,
    /// Least significant bit in SI units: metres, seconds, radians and derived units; the document's unit for other
    /// quantities. 1 for codes.
    pub lsb: f64,
    /// First of the editions passed that has the element.
    pub since: Edition,
}

impl Field {
    /// The bits as a number without sign.
    #[inline(always)]
    pub fn number(self, octets: &[u8]) -> Option<u64> {
        let number = match *octets.get(self.byte..self.byte + self.octets)? {
            [octet] => u64::from(octet),
            [high, low] => u64::from(u16::from_be_bytes([high, low])),
            [high, middle, low] => u64::from(u32::from_be_bytes([0, high, middle, low])),
            [a, b, c, d] => u64::from(u32::from_be_bytes([a, b, c, d])),
            ref more => more.iter().fold(0, |number, &octet| number << 8 | u64::from(octet)),
        };
        Some(number >> self.shift & (u64::MAX >> (64 - self.bits)))
    }

    /// The bits as a code of at most eight bits.
    #[inline(always)]
    pub fn code(self, octets: &[u8]) -> Option<u8> {
        debug_assert!(self.bits <= 8);
        self.number(octets).map(|number| number as u8)
    }

    /// True if the element was sent and has a bit set.
    #[inline(always)]
    pub fn is_set(self, octets: &[u8]) -> bool {
        self.number(octets).is_some_and(|number| number != 0)
    }

    /// The number with its sign.
    #[inline(always)]
    pub fn integer(self, octets: &[u8]) -> Option<i64> {
        let number = self.number(octets)?;
        Some(match self.signed {
            true => sign_extend(number, self.bits as usize),
            false => number as i64,
        })
    }

    /// The number in SI units: number × [`lsb`](Self::lsb).
    #[inline(always)]
    pub fn quantity(self, octets: &[u8]) -> Option<f64> {
        self.integer(octets).map(|number| number as f64 * self.lsb)
    }
}

impl Field {
    /// True if the bits can hold a number.
    pub fn holds(self, number: i64) -> bool {
        let bits = if self.signed { self.bits - 1 } else { self.bits };
        let least = if self.signed { -1 << bits } else { 0 };
        bits >= 63 || (least..1 << bits).contains(&number)
    }

    /// Returns the number nearest to a quantity in SI units; `None` if the number does not fit into the bits, or if
    /// the quantity is not finite.
    pub fn nearest(self, quantity: f64) -> Option<i64> {
        let number = (quantity / self.lsb).round();
        (number.is_finite() && self.holds(number as i64)).then_some(number as i64)
    }

    /// The greatest number.
    pub fn greatest(self) -> i64 {
        let bits = if self.signed { self.bits - 1 } else { self.bits };
        (u64::MAX >> (u64::BITS - bits)) as i64
    }
}

/// Elements of one item that are read or written together.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Elements<const N: usize> {
    /// The item.
    pub item: Frn,
    /// The elements.
    pub fields: [Field; N],
}

impl<const N: usize> Elements<N> {
    /// The elements as numbers without sign; `None` where the record lacks the item, or the last of the elements in it.
    #[inline(always)]
    pub fn numbers(&self, record: &Record<'_>) -> Option<[u64; N]> {
        let octets = record.item(self.item)?;
        let mut numbers = [0; N];
        for (number, field) in numbers.iter_mut().zip(self.fields) {
            *number = field.number(octets)?;
        }
        Some(numbers)
    }

    /// The elements in SI units; `None` where the record lacks the item, or the last of the elements in it.
    #[inline(always)]
    pub fn quantities(&self, record: &Record<'_>) -> Option<[f64; N]> {
        let octets = record.item(self.item)?;
        let mut quantities = [0.0; N];
        for (quantity, field) in quantities.iter_mut().zip(self.fields) {
            *quantity = field.quantity(octets)?;
        }
        Some(quantities)
    }
}

impl Elements<1> {
    /// The element as a number without sign; `None` where the record lacks it.
    #[inline(always)]
    pub fn number(&self, record: &Record<'_>) -> Option<u64> {
        self.numbers(record).map(|[number]| number)
    }

    /// The element in SI units; `None` where the record lacks it.
    #[inline(always)]
    pub fn quantity(&self, record: &Record<'_>) -> Option<f64> {
        self.quantities(record).map(|[quantity]| quantity)
    }
}

/// Elements of an item by name. In a constant, it does not compile where [`item`] or [`field`] would not.
///
/// # Panics
/// Where it would not compile in a constant.
pub const fn elements<const N: usize>(editions: &[&Category], name: &str, elements: [&str; N]) -> Elements<N> {
    elements_at(editions, item(editions, name), name, elements)
}

/// Elements of an item in a category with several profiles, with the item's field reference number in a profile.
///
/// # Panics
/// Where it would not compile in a constant.
pub const fn elements_at<const N: usize>(
    editions: &[&Category],
    item: Frn,
    name: &str,
    elements: [&str; N],
) -> Elements<N> {
    let mut fields = [field(editions, &[name, elements[0]]); N];
    let mut i = 1;
    while i < N {
        fields[i] = field(editions, &[name, elements[i]]);
        i += 1;
    }
    Elements { item, fields }
}

/// An item with a single element. In a constant, fails to compile under the conditions of [`item`] and [`field`].
///
/// # Panics
/// Where it would not compile in a constant.
pub const fn whole(editions: &[&Category], name: &str) -> Elements<1> {
    whole_at(editions, item(editions, name), name)
}

/// An item with a single element in a category with several profiles, with its field reference number in a profile.
///
/// # Panics
/// Where it would not compile in a constant.
pub const fn whole_at(editions: &[&Category], item: Frn, name: &str) -> Elements<1> {
    Elements {
        item,
        fields: [field(editions, &[name])],
    }
}

/// Returns the field reference number of an item in these editions. In a constant, fails to compile if no edition has
/// the item, or if an edition has another item in its place.
///
/// # Panics
/// Where it would not compile in a constant.
pub const fn item(editions: &[&Category], name: &str) -> Frn {
    let mut found: Option<Frn> = None;
    let mut i = 0;
    while i < editions.len() {
        let uap = editions[i].uap();
        if let Some(frn) = uap.find(name) {
            assert!(
                found.is_none() || found.unwrap().0 == frn.0,
                "the editions have the item in different places"
            );
            found = Some(frn);
        }
        i += 1;
    }
    let Some(frn) = found else {
        panic!("no edition has an item of this name");
    };
    i = 0;
    while i < editions.len() {
        let items = editions[i].uap().items;
        let at = frn.0 as usize - 1;
        let is_free = match if at < items.len() { &items[at] } else { &None } {
            Some(item) => same(item.name, name),
            None => true,
        };
        assert!(is_free, "an edition has another item in this place");
        i += 1;
    }
    frn
}

/// Returns the position of a subitem in its compound item, counted from 1 as in
/// [`subitems`](crate::Record::subitems). In a constant, fails to compile if an edition lacks the subitem or has it
/// at another position.
///
/// # Panics
/// Where it would not compile in a constant.
pub const fn subitem(editions: &[&Category], item: &str, name: &str) -> usize {
    let mut found = 0;
    let mut i = 0;
    while i < editions.len() {
        let Some(item) = editions[i].item(item) else {
            panic!("an edition has no item of this name");
        };
        let position = position_in(&item.layout, name);
        assert!(position > 0, "an edition has no subitem of this name");
        assert!(
            found == 0 || found == position,
            "the editions have the subitem in different places"
        );
        found = position;
        i += 1;
    }
    found
}

/// An element of an item: the item's name, then the names of subitem, group and element as far as there are any. In a
/// constant, it does not compile where an edition lacks the element, or where two differ in its place, width, sign or
/// LSB.
///
/// # Panics
/// Where it would not compile in a constant.
pub const fn field(editions: &[&Category], path: &[&str]) -> Field {
    let field = added(editions, path);
    let first = editions[0].edition;
    assert!(
        field.since.major == first.major && field.since.minor == first.minor,
        "an edition has no element of this name"
    );
    field
}

/// Element introduced by one of the editions, which are passed oldest first. A reader has to check
/// [`since`](Field::since) before it reads the bits, which are spare in earlier editions. Otherwise like [`field`].
///
/// # Panics
/// Where it would not compile in a constant.
pub const fn added(editions: &[&Category], path: &[&str]) -> Field {
    let Some((name, rest)) = path.split_first() else {
        panic!("the path is empty");
    };
    let mut found: Option<Field> = None;
    let mut i = 0;
    while i < editions.len() {
        let field = match editions[i].item(name) {
            Some(item) => find(&item.layout, rest, editions[i].edition),
            None => None,
        };
        match (found, field) {
            (None, field) => found = field,
            (Some(_), None) => panic!("a later edition no longer has the element"),
            (Some(before), Some(field)) => assert!(before.is_like(field), "the editions differ in the element"),
        }
        i += 1;
    }
    let Some(field) = found else {
        panic!("no edition has an element of this name");
    };
    field
}

/// Returns the elements of this name in the items of `table`: one per item, without elements of subitems.
pub fn named(table: &Category, name: &str) -> Vec<Elements<1>> {
    let items = table.uap().items.iter().zip(1..);
    let found = items.filter_map(|(item, frn)| {
        let field = find(&item.as_ref()?.layout, &[name], table.edition)?;
        Some(Elements {
            item: Frn(frn),
            fields: [field],
        })
    });
    found.collect()
}

impl Field {
    const fn is_like(self, other: Self) -> bool {
        self.byte == other.byte
            && self.octets == other.octets
            && self.shift == other.shift
            && self.bits == other.bits
            && self.signed == other.signed
            && self.lsb == other.lsb
    }

    const fn new(at: u32, bits: u32, content: &Content, since: Edition) -> Self {
        let byte = at / 8;
        let end = at + bits;
        let octets = end.div_ceil(8) - byte;
        assert!(octets <= 8, "the element has bits in more than eight octets");
        let (signed, lsb) = match content {
            Content::Integer { signed } => (*signed, 1.0),
            Content::Quantity { signed, lsb, unit } => (*signed, in_si_units(*lsb, unit)),
            Content::Raw | Content::Text(_) | Content::Depends { .. } => (false, 1.0),
        };
        Self {
            byte: byte as usize,
            octets: octets as usize,
            shift: (byte + octets) * 8 - end,
            bits,
            signed,
            lsb,
            since,
        }
    }
}

/// Exact for an LSB that is a power of two of the unit, or such a part of 180°.
const fn in_si_units(lsb: f64, unit: &str) -> f64 {
    if same(unit, "NM") || same(unit, "NM/s") {
        lsb * NAUTICAL_MILE_M
    } else if same(unit, "°") || same(unit, "°/s") {
        lsb / 180.0 * PI
    } else if same(unit, "FL") {
        lsb * FLIGHT_LEVEL_M
    } else if same(unit, "ft") {
        lsb * FOOT_M
    } else if same(unit, "ft/min") {
        lsb * FOOT_M / 60.0
    } else if same(unit, "kt") {
        lsb * KNOT_M_S
    } else if same(unit, "ms") {
        lsb / 1000.0
    } else {
        lsb
    }
}

/// The element at the end of a path in an item, or in a subitem of it.
const fn find(layout: &Layout, path: &[&str], since: Edition) -> Option<Field> {
    match layout {
        Layout::Element(bits, content) if path.is_empty() => Some(Field::new(0, *bits as u32, content, since)),
        Layout::Group(parts) => find_in(parts, path, 0, since),
        Layout::Extended(extensions) => {
            let mut at = 0;
            let mut i = 0;
            while i < extensions.len() {
                if let Some(field) = find_in(extensions[i], path, at, since) {
                    return Some(field);
                }
                at += bit_count(extensions[i]).next_multiple_of(8);
                i += 1;
            }
            None
        }
        Layout::Repetitive(inner) | Layout::RepetitiveFx(inner) => find(inner, path, since),
        Layout::Compound(subitems) => {
            let Some((name, rest)) = path.split_first() else {
                return None;
            };
            match position_in(layout, name) {
                0 => None,
                position => match &subitems[position - 1] {
                    Some(subitem) => find(&subitem.layout, rest, since),
                    None => None,
                },
            }
        }
        Layout::Element(..) | Layout::Explicit | Layout::RandomSequence => None,
    }
}

/// Returns the element at the end of a path in a group with its first bit at bit `at` of the item.
const fn find_in(parts: &[Part], path: &[&str], mut at: u32, since: Edition) -> Option<Field> {
    let Some((first, rest)) = path.split_first() else {
        return None;
    };
    let mut i = 0;
    while i < parts.len() {
        match &parts[i] {
            Part::Element {
                name, bits, content, ..
            } if rest.is_empty() && same(name, first) => {
                return Some(Field::new(at, *bits as u32, content, since));
            }
            Part::Group(name, inner) if same(name, first) => return find_in(inner, rest, at, since),
            Part::Element { bits, .. } | Part::Spare(bits) => at += *bits as u32,
            Part::Group(_, inner) => at += bit_count(inner),
        }
        i += 1;
    }
    None
}

/// The position of a subitem in its compound item, counted from 1; 0 where there is none of this name.
const fn position_in(layout: &Layout, name: &str) -> usize {
    if let Layout::Compound(subitems) = layout {
        let mut i = 0;
        while i < subitems.len() {
            if let Some(subitem) = &subitems[i]
                && same(subitem.name, name)
            {
                return i + 1;
            }
            i += 1;
        }
    }
    0
}
