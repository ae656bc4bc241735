//! Records out of values: the exact inverse of [`named`](super::named).
//!
//! The table determines everything except the values, so that a tree of names and values has a unique encoding:
//! FSPECs end with the last announced item, extended items have as many parts as given elements, spare bits are zero.
//! An unknown name, a missing element of a group, a value of another kind, or a value too large for its bits is an
//! error that names the place, because any substitute would be read as other data. Only quantities are rounded, to
//! the nearest multiple of the LSB.
//!
//! Members may have any order. In the table's order, the order of decoding, each look-up succeeds at the first
//! attempt.
//!
//! # Use
//!
//! Look up the table of category and edition, make a [`NamedRecord`] with the table's names, encode the record, and
//! pack the bytes of records into blocks. A name read from a text is replaced by the table's own name, which has a
//! static lifetime: `table.item(text)?.name` for an item; names of elements are in the item's layout.
//!
//! ```
//! use asterix::{BlockWriter, Edition, NamedRecord, Value, registry};
//!
//! let table = registry::find(34, Edition::new(1, 29)).expect("an edition there is");
//! let source = Value::group([("SAC", 20u64.into()), ("SIC", 10u64.into())]);
//! let north = NamedRecord::of(34, [("010", source), ("000", 1u64.into()), ("030", 43_200.5.into())]);
//!
//! let mut bytes = Vec::new();
//! north.encode(table, &mut bytes)?;
//! let mut blocks = BlockWriter::new(table.number, 1472);
//! assert_eq!(blocks.push(&bytes)?, None, "the block has room for more");
//! assert_eq!(blocks.finish(), Some(&[34, 0, 10, 0xE0, 20, 10, 1, 0x54, 0x60, 0x40][..]));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use super::bits::{goes_on, put, sign_extend};
use super::encode_error::{EncodeError, EncodeFault, Failure};
use super::expansion::Expansion;
use super::extent::MAX_UNKNOWN_EXTENSION_OCTETS;
use super::named::{NamedRecord, UNKNOWN_EXTENSION, Value, find};
use super::record_writer::fspec;
use super::table::{Category, Content, Item, Layout, MAX_FRN, Part, Profile, Uap, extent_of_part};
use super::text;

/// The most that a byte can count, or give as a length.
const MAX_OCTET: usize = u8::MAX as usize;

impl NamedRecord {
    /// Appends the record's bytes, FSPEC first, as this edition lays them out. Where the category has several
    /// profiles, the deciding element's value chooses.
    ///
    /// # Errors
    /// If the record has no item, or a name or value that the table has no place for; `octets` is then unchanged.
    pub fn encode(&self, table: &'static Category, octets: &mut Vec<u8>) -> Result<(), EncodeError> {
        let begin = octets.len();
        encode(self, table, octets).map_err(|failure| {
            octets.truncate(begin);
            failure.into_error(table.number)
        })
    }
}

type Encoded = Result<(), Failure>;

fn encode(record: &NamedRecord, table: &'static Category, out: &mut Vec<u8>) -> Encoded {
    if record.category != table.number {
        return Err(EncodeFault::CategoryDiffers { found: record.category }.into());
    }
    if record.items.is_empty() {
        return Err(EncodeFault::RecordEmpty.into());
    }
    let uap = choose_profile(record, table)?;
    let announced = Announced::new(&record.items, uap.items)?;
    out.extend(fspec(announced.present));
    Encode { uap, out }.members(&announced)
}

fn choose_profile(record: &NamedRecord, table: &'static Category) -> Result<&'static Uap, Failure> {
    let (item, element, cases) = match &table.profile {
        Profile::Single(uap) => return Ok(uap),
        Profile::Depends { item, element, cases } => (item, element, cases),
    };
    let found = record.get(&[item, element]).and_then(Value::as_u64);
    let case = cases.iter().find(|(case, _)| Some(*case) == found);
    case.map(|(_, uap)| uap)
        .ok_or_else(|| EncodeFault::ProfileUndecided { item, element, found }.into())
}

/// The content of a reserved expansion field: a byte of flags, and the subitems that they announce.
pub(super) fn encode_expansion(
    rules: &'static Expansion,
    uap: &'static Uap,
    content: &Value,
) -> Result<Vec<u8>, Failure> {
    let mut out = Vec::new();
    let all = group_members(content)?;
    if all.is_empty() {
        return Ok(out);
    }
    let subitems: Vec<Member> = all
        .iter()
        .filter(|(name, _)| *name != UNKNOWN_EXTENSION)
        .cloned()
        .collect();
    let announced = Announced::new(&subitems, rules.items)?;
    out.push((announced.present as u8).reverse_bits());
    Encode { uap, out: &mut out }.members(&announced)?;
    if let Some(behind) = find(all, UNKNOWN_EXTENSION) {
        out.extend(bytes_of(behind)?);
    }
    Ok(out)
}

type Member = (&'static str, Value);

/// Items or subitems, in the order of the FSPEC that announces them.
struct Announced<'v> {
    /// Bit i for the member at position i.
    present: u64,
    members: [Option<(&'static Item, &'v Value)>; MAX_FRN],
}

impl<'v> Announced<'v> {
    /// Finds the place of each member.
    fn new(members: &'v [Member], places: &'static [Option<Item>]) -> Result<Self, Failure> {
        let mut announced = Self {
            present: 0,
            members: [None; MAX_FRN],
        };
        let mut expected = 0; // members come in order as a rule
        for (name, value) in members {
            let at = |i: usize| Some((i, places[i].as_ref().filter(|item| item.name == *name)?));
            let found = (expected..places.len()).chain(0..expected).find_map(at);
            let (position, item) = found.ok_or_else(|| Failure::at(name, EncodeFault::Unknown))?;
            if announced.members[position].replace((item, value)).is_some() {
                return Err(Failure::at(name, EncodeFault::Twice));
            }
            announced.present |= 1 << position;
            expected = position + 1;
        }
        Ok(announced)
    }
}

/// Appends items.
struct Encode<'o> {
    uap: &'static Uap,
    out: &'o mut Vec<u8>,
}

impl Encode<'_> {
    fn members(&mut self, announced: &Announced<'_>) -> Encoded {
        announced.members.iter().flatten().try_for_each(|(item, value)| {
            self.layout(&item.layout, value)
                .map_err(|failure| failure.within(item.name))
        })
    }

    fn layout(&mut self, layout: &'static Layout, value: &Value) -> Encoded {
        match layout {
            Layout::Element(..) | Layout::Group(_) => self.fixed(layout, value, layout.bit_count() as usize / 8),
            Layout::Extended(extension) => self.extended(extension, value),
            Layout::Repetitive(inner) => {
                let values = self.count(value)?;
                each(values, |value| self.layout(inner, value))
            }
            Layout::RepetitiveFx(inner) => self.repetitive_fx(inner, value),
            Layout::Explicit => self.explicit(value),
            Layout::Compound(subitems) => self.compound(subitems, value),
            Layout::RandomSequence => {
                let values = self.count(value)?;
                each(values, |value| self.item_of_sequence(value))
            }
        }
    }

    /// Writes an element or a group into `octets` bytes; remaining bits at the end are zero.
    fn fixed(&mut self, layout: &'static Layout, value: &Value, octets: usize) -> Encoded {
        let bytes = zeros(octets, self.out);
        match layout {
            Layout::Element(width, content) => element(content, *width, value, &[], bytes, 0),
            Layout::Group(elements) => group(elements, value, bytes, 0).map(|_| ()),
            _ => unreachable!("no other layout has a number of bits, which the callers asked for"),
        }
    }

    fn extended(&mut self, extension: &'static [&'static [Part]], value: &Value) -> Encoded {
        let members = group_members(value)?;
        let beyond = find(members, UNKNOWN_EXTENSION);
        let elements = members.len() - usize::from(beyond.is_some());
        let sent = match beyond {
            Some(_) => extension,
            None => &extension[..part_count(extension, elements)],
        };
        if sent.iter().map(|part| element_count(part)).sum::<usize>() != elements {
            return Err(misfit(members, extension, UNKNOWN_EXTENSION));
        }
        let mut members = Members::new(members);
        for (i, part) in sent.iter().enumerate() {
            let (octets, ends_in_fx) = extent_of_part(part);
            let bytes = zeros(octets, self.out);
            parts(part, &mut members, bytes, 0)?.ok_or_else(|| misfit(members.all, extension, UNKNOWN_EXTENSION))?;
            if i + 1 < sent.len() || beyond.is_some() {
                if !ends_in_fx {
                    return Err(Failure::at(UNKNOWN_EXTENSION, EncodeFault::Unknown)); // nothing can follow this part
                }
                bytes[octets - 1] |= 1;
            }
        }
        match beyond {
            Some(octets) => self
                .unknown_extension(octets)
                .map_err(|failure| failure.within(UNKNOWN_EXTENSION)),
            None => Ok(()),
        }
    }

    fn unknown_extension(&mut self, value: &Value) -> Encoded {
        let octets = bytes_of(value)?;
        let is_read_to_its_end = octets
            .split_last()
            .is_some_and(|(last, before)| before.iter().all(|octet| goes_on(*octet)) && !goes_on(*last));
        if !is_read_to_its_end || octets.len() > MAX_UNKNOWN_EXTENSION_OCTETS {
            return Err(EncodeFault::UnknownExtension {
                octets: octets.to_vec(),
                greatest: MAX_UNKNOWN_EXTENSION_OCTETS,
            }
            .into());
        }
        self.out.extend(octets);
        Ok(())
    }

    /// Writes the number of values in a list, and gives them.
    fn count<'v>(&mut self, value: &'v Value) -> Result<&'v [Value], Failure> {
        let values = list(value)?;
        let count = values.len();
        if count > MAX_OCTET {
            return Err(EncodeFault::Repetitions {
                count,
                greatest: MAX_OCTET,
            }
            .into());
        }
        self.out.push(count as u8);
        Ok(values)
    }

    fn repetitive_fx(&mut self, inner: &'static Layout, value: &Value) -> Encoded {
        let octets = inner.bit_count() as usize / 8 + 1;
        let values = list(value)?;
        if values.is_empty() {
            return Err(EncodeFault::NoRepetition.into());
        }
        each(values, |value| {
            self.fixed(inner, value, octets)?;
            *self.last() |= 1;
            Ok(())
        })?;
        *self.last() &= !1;
        Ok(())
    }

    fn explicit(&mut self, value: &Value) -> Encoded {
        let content = bytes_of(value)?;
        if content.len() >= MAX_OCTET {
            return Err(EncodeFault::ExplicitLength {
                octets: content.len(),
                greatest: MAX_OCTET - 1,
            }
            .into());
        }
        self.out.push(content.len() as u8 + 1);
        self.out.extend(content);
        Ok(())
    }

    fn compound(&mut self, subitems: &'static [Option<Item>], value: &Value) -> Encoded {
        let announced = Announced::new(group_members(value)?, subitems)?;
        self.out.extend(fspec(announced.present));
        self.members(&announced)
    }

    /// Writes an item of a random field sequence, the only member of a group, behind its field reference number.
    fn item_of_sequence(&mut self, value: &Value) -> Encoded {
        let [(name, value)] = group_members(value)? else {
            return Err(other_kind("a group of one item", value));
        };
        let position = self.uap.names().position(|candidate| candidate == *name);
        let frn = position.map_or(0, |position| position as u8 + 1);
        let item = self.uap.item_in_sequence(frn);
        let item = item.ok_or_else(|| Failure::at(name, EncodeFault::Unknown))?;
        self.out.push(frn);
        self.layout(&item.layout, value).map_err(|failure| failure.within(name))
    }

    fn last(&mut self) -> &mut u8 {
        self.out.last_mut().expect("an octet was written")
    }
}

/// The least number of parts with so many elements; at least one, at most all.
fn part_count(extension: &[&[Part]], elements: usize) -> usize {
    let mut sum = 0;
    let enough = extension.iter().position(|part| {
        sum += element_count(part);
        sum >= elements
    });
    enough.map_or(extension.len(), |last| last + 1)
}

/// Writes a group from bit `at` on, where there are zeros; gives the bit behind it.
fn group(elements: &'static [Part], value: &Value, bytes: &mut [u8], at: usize) -> Result<usize, Failure> {
    let members = group_members(value)?;
    let behind = match members.len() == element_count(elements) {
        true => parts(elements, &mut Members::new(members), bytes, at)?,
        false => None,
    };
    behind.ok_or_else(|| misfit(members, &[elements], ""))
}

/// Writes elements from bit `at` on, into zeros; returns the bit behind the elements, or `None` for a missing
/// element.
fn parts(
    elements: &'static [Part],
    members: &mut Members<'_>,
    bytes: &mut [u8],
    mut at: usize,
) -> Result<Option<usize>, Failure> {
    for part in elements {
        match part {
            Part::Spare(width) => at += usize::from(*width),
            Part::Element {
                name, bits, content, ..
            } => {
                let Some(value) = members.take(name) else {
                    return Ok(None);
                };
                element(content, *bits, value, members.all, bytes, at).map_err(|failure| failure.within(name))?;
                at += usize::from(*bits);
            }
            Part::Group(name, inner) => {
                let Some(value) = members.take(name) else {
                    return Ok(None);
                };
                at = group(inner, value, bytes, at).map_err(|failure| failure.within(name))?;
            }
        }
    }
    Ok(Some(at))
}

/// Members of a group, taken in turn.
struct Members<'v> {
    all: &'v [Member],
    expected: usize,
}

impl<'v> Members<'v> {
    fn new(all: &'v [Member]) -> Self {
        Self { all, expected: 0 }
    }

    fn take(&mut self, name: &str) -> Option<&'v Value> {
        let expected = self.all.get(self.expected).filter(|(candidate, _)| *candidate == name);
        self.expected += 1;
        match expected {
            Some((_, value)) => Some(value),
            None => find(self.all, name),
        }
    }
}

/// Returns the error for members that do not match the elements of an extension's first parts, or of a group's only
/// part. `besides` is an additional permitted member.
fn misfit(members: &[Member], extension: &[&'static [Part]], besides: &str) -> Failure {
    let names = |part: &'static [Part]| part.iter().filter_map(part_name);
    let is_element = |name: &str| extension.iter().any(|part| names(part).any(|element| element == name));
    for (i, (name, _)) in members.iter().enumerate() {
        if members[..i].iter().any(|(before, _)| before == name) {
            return Failure::at(name, EncodeFault::Twice);
        }
        if !is_element(name) && *name != besides {
            return Failure::at(name, EncodeFault::Unknown);
        }
    }
    let is_member = |name: &str| members.iter().any(|(member, _)| *member == name);
    let all = extension.iter().flat_map(|part| names(part));
    let missing = all.clone().find(|element| !is_member(element));
    Failure::at(missing.unwrap_or_default(), EncodeFault::Missing)
}

fn element_count(parts: &[Part]) -> usize {
    parts.iter().filter(|part| part_name(part).is_some()).count()
}

fn part_name(part: &Part) -> Option<&'static str> {
    match part {
        Part::Element { name, .. } | Part::Group(name, _) => Some(name),
        Part::Spare(_) => None,
    }
}

/// Writes an element. `members` are the elements of its group.
fn element(
    content: &'static Content,
    width: u8,
    value: &Value,
    members: &[Member],
    bytes: &mut [u8],
    at: usize,
) -> Encoded {
    let bits = usize::from(width);
    let number = match (content, value) {
        (Content::Raw | Content::Integer { signed: false }, Value::Unsigned(number)) => unsigned(*number, bits)?,
        (Content::Raw | Content::Integer { signed: false }, _) => {
            return Err(other_kind("a number without sign", value));
        }
        (Content::Integer { signed: true }, Value::Signed(number)) => signed(*number, bits)?,
        (Content::Integer { signed: true }, _) => return Err(other_kind("a number with sign", value)),
        (Content::Quantity { signed, lsb, unit }, Value::Quantity(quantity)) => {
            steps(*quantity, *signed, *lsb, unit, bits)?
        }
        (Content::Quantity { .. }, _) => return Err(other_kind("a quantity", value)),
        (Content::Text(coding), Value::Text(text)) => return Ok(text::encode(*coding, text, bytes, at, bits)?),
        (Content::Text(_), _) => return Err(other_kind("a text", value)),
        (Content::Depends { on, cases, otherwise }, _) => {
            let decider = find(members, on).and_then(Value::as_u64);
            let case = cases.iter().find(|(case, _)| Some(*case) == decider);
            let chosen = case.map_or(*otherwise, |(_, content)| content);
            return element(chosen, width, value, members, bytes, at);
        }
    };
    put(bytes, at, bits, number);
    Ok(())
}

/// A number without sign in so many bits.
fn unsigned(value: u64, bits: usize) -> Result<u64, EncodeFault> {
    let greatest = u64::MAX >> (64 - bits);
    if value > greatest {
        return Err(EncodeFault::NumberOutOfRange {
            value: value.into(),
            least: 0,
            greatest: greatest.into(),
        });
    }
    Ok(value)
}

/// A number in two's complement in so many bits.
fn signed(value: i64, bits: usize) -> Result<u64, EncodeFault> {
    let number = value as u64 & (u64::MAX >> (64 - bits));
    if sign_extend(number, bits) != value {
        let greatest = i64::MAX >> (64 - bits);
        return Err(EncodeFault::NumberOutOfRange {
            value: value.into(),
            least: (-greatest - 1).into(),
            greatest: greatest.into(),
        });
    }
    Ok(number)
}

/// A quantity as the nearest number of LSBs, in so many bits.
fn steps(value: f64, signed: bool, lsb: f64, unit: &'static str, bits: usize) -> Result<u64, EncodeFault> {
    if value.is_nan() {
        return Err(EncodeFault::NotANumber);
    }
    let number = (value / lsb).round();
    let half = (1u64 << (bits - 1)) as f64;
    let (least, behind) = if signed { (-half, half) } else { (0.0, 2.0 * half) };
    if number < least || number >= behind {
        return Err(EncodeFault::QuantityOutOfRange {
            value,
            least: least * lsb,
            greatest: (behind - 1.0) * lsb,
            unit,
        });
    }
    let number = if signed { number as i64 as u64 } else { number as u64 };
    Ok(number & (u64::MAX >> (64 - bits)))
}

/// Appends so many bytes of zeros and gives them.
fn zeros(octets: usize, out: &mut Vec<u8>) -> &mut [u8] {
    let begin = out.len();
    out.resize(begin + octets, 0);
    &mut out[begin..]
}

fn each(values: &[Value], mut write: impl FnMut(&Value) -> Encoded) -> Encoded {
    values
        .iter()
        .enumerate()
        .try_for_each(|(i, value)| write(value).map_err(|failure| failure.within_repetition(i)))
}

fn group_members(value: &Value) -> Result<&[Member], Failure> {
    match value {
        Value::Group(members) => Ok(members),
        _ => Err(other_kind("a group", value)),
    }
}

fn list(value: &Value) -> Result<&[Value], Failure> {
    match value {
        Value::List(values) => Ok(values),
        _ => Err(other_kind("a list", value)),
    }
}

fn bytes_of(value: &Value) -> Result<&[u8], Failure> {
    match value {
        Value::Bytes(octets) => Ok(octets),
        _ => Err(other_kind("octets", value)),
    }
}

#[cold]
fn other_kind(expected: &'static str, value: &Value) -> Failure {
    let found = match value {
        Value::Unsigned(_) => "a number without sign",
        Value::Signed(_) => "a number with sign",
        Value::Quantity(_) => "a quantity",
        Value::Text(_) => "a text",
        Value::Bytes(_) => "octets",
        Value::Group(_) => "a group",
        Value::List(_) => "a list",
    };
    EncodeFault::Kind { expected, found }.into()
}
