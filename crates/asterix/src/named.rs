//! Every item of a record as a tree of names and values: to show, to compare, to search.
//!
//! The numbers are the document's: a quantity is the number sent times the LSB, in the unit the table gives
//! (degrees, NM/s, feet, flight levels). Codes and identifiers stay numbers; their meanings are in the document.

use std::fmt::Write;

use serde::ser::{Serialize, SerializeMap, Serializer};

use super::bits::{bits, fspec_bits, goes_on, sign_extend};
use super::record::Record;
use super::table::{Content, Item, Layout, Part, Uap, extent_of_part};
use super::text;

/// The name under which an extended item's bytes after its last defined part are shown, as [`Value::Bytes`].
pub const UNKNOWN_EXTENSION: &str = "_unknown_extension";

/// Content of an item or an element.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// A code, flag, identifier or number without sign.
    Unsigned(u64),
    /// A number with sign.
    Signed(i64),
    /// A quantity in the table's unit.
    Quantity(f64),
    /// Characters, trailing spaces included; [`text::UNDEFINED`] where a code has none.
    Text(String),
    /// The content of an explicit item, without its length byte.
    Bytes(Vec<u8>),
    /// The elements of a group or of an extended item, or the subitems of a compound one.
    Group(Vec<(&'static str, Value)>),
    /// The repetitions of a repetitive item.
    List(Vec<Value>),
}

impl Value {
    /// A group of these members.
    pub fn group(members: impl IntoIterator<Item = (&'static str, Value)>) -> Self {
        Self::Group(members.into_iter().collect())
    }

    /// A list of these values.
    pub fn list(values: impl IntoIterator<Item = Value>) -> Self {
        Self::List(values.into_iter().collect())
    }

    /// The member of a group.
    pub fn get(&self, name: &str) -> Option<&Value> {
        match self {
            Self::Group(members) => find(members, name),
            _ => None,
        }
    }

    /// Returns the code, flag, identifier or unsigned number; `None` for other kinds.
    pub fn as_u64(&self) -> Option<u64> {
        match *self {
            Self::Unsigned(number) => Some(number),
            _ => None,
        }
    }

    /// The value as a floating-point number, if it is any number.
    pub fn as_f64(&self) -> Option<f64> {
        match *self {
            Self::Unsigned(number) => Some(number as f64),
            Self::Signed(number) => Some(number as f64),
            Self::Quantity(number) => Some(number),
            _ => None,
        }
    }
}

impl From<u64> for Value {
    fn from(number: u64) -> Self {
        Self::Unsigned(number)
    }
}

impl From<i64> for Value {
    fn from(number: i64) -> Self {
        Self::Signed(number)
    }
}

impl From<f64> for Value {
    fn from(quantity: f64) -> Self {
        Self::Quantity(quantity)
    }
}

impl From<&str> for Value {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

/// A group becomes an object, a list an array, bytes a string of hexadecimal digits.
impl Serialize for Value {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Unsigned(number) => serializer.serialize_u64(*number),
            Self::Signed(number) => serializer.serialize_i64(*number),
            Self::Quantity(number) => serializer.serialize_f64(*number),
            Self::Text(text) => serializer.serialize_str(text),
            Self::Bytes(bytes) => {
                let mut digits = String::with_capacity(2 * bytes.len());
                for octet in bytes {
                    let _ = write!(digits, "{octet:02x}"); // writing to a String does not fail
                }
                serializer.serialize_str(&digits)
            }
            Self::Group(members) => serializer.collect_map(members.iter().map(|(name, value)| (name, value))),
            Self::List(values) => serializer.collect_seq(values),
        }
    }
}

/// A record with every item decoded.
///
/// The serialised form is an object: item number → value, and `"_c"`, the category.
#[derive(Debug, Clone, PartialEq)]
pub struct NamedRecord {
    /// The category.
    pub category: u8,
    /// Time of recording, seconds, where that is known; serialised as `"_ts"`.
    pub time_stamp_s: Option<f64>,
    /// The items present, in the order sent.
    pub items: Vec<(&'static str, Value)>,
}

impl NamedRecord {
    /// Decodes every item.
    pub fn new(record: &Record<'_>) -> Self {
        let items = record
            .items()
            .map(|(item, bytes)| (item.name, decode(item, record.uap(), bytes)))
            .collect();
        Self {
            category: record.table().number,
            time_stamp_s: None,
            items,
        }
    }

    /// A record of these items, in any order: to be encoded.
    pub fn of(category: u8, items: impl IntoIterator<Item = (&'static str, Value)>) -> Self {
        Self {
            category,
            time_stamp_s: None,
            items: items.into_iter().collect(),
        }
    }

    /// The value at a path of names: `["042", "X"]` is element X of item 042.
    pub fn get(&self, path: &[&str]) -> Option<&Value> {
        let (item, elements) = path.split_first()?;
        elements
            .iter()
            .try_fold(find(&self.items, item)?, |value, name| value.get(name))
    }

    /// The record as a JSON object.
    pub fn to_json(&self) -> serde_json::Value {
        serde_json::to_value(self).expect("names are strings and numbers finite")
    }

    /// Appends the record's JSON object, on one line without line end.
    pub fn write_json(&self, line: &mut Vec<u8>) {
        serde_json::to_writer(line, self).expect("names are strings, and memory takes every write");
    }
}

impl Serialize for NamedRecord {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut object = serializer.serialize_map(None)?;
        for (name, value) in &self.items {
            object.serialize_entry(name, value)?;
        }
        object.serialize_entry("_c", &self.category)?;
        if let Some(time_stamp_s) = self.time_stamp_s {
            object.serialize_entry("_ts", &time_stamp_s)?;
        }
        object.end()
    }
}

/// Decodes the bytes of an item, as many as it has.
pub(super) fn decode(item: &'static Item, uap: &'static Uap, bytes: &[u8]) -> Value {
    Decode { uap, bytes, at: 0 }.layout(&item.layout)
}

/// A position within an item that has been measured, so that every byte the layout asks for is there.
struct Decode<'a> {
    uap: &'static Uap,
    bytes: &'a [u8],
    at: usize,
}

impl Decode<'_> {
    fn layout(&mut self, layout: &'static Layout) -> Value {
        match layout {
            Layout::Element(width, content) => {
                let value = element_value(content, self.bytes, self.at * 8, *width, &[]);
                self.at += usize::from(*width) / 8;
                value
            }
            Layout::Group(elements) => {
                let mut members = Vec::with_capacity(elements.len());
                parts(elements, self.bytes, self.at * 8, &mut members);
                self.at += layout.bit_count() as usize / 8;
                Value::Group(members)
            }
            Layout::Extended(extension) => self.extended(extension),
            Layout::Repetitive(inner) => {
                let count = self.octet();
                Value::List((0..count).map(|_| self.layout(inner)).collect())
            }
            Layout::RepetitiveFx(inner) => self.repetitive_fx(inner),
            Layout::Explicit => {
                let length = usize::from(self.octet());
                let content = &self.bytes[self.at..self.at + length - 1];
                self.at += content.len();
                Value::Bytes(content.to_vec())
            }
            Layout::Compound(subitems) => self.compound(subitems),
            Layout::RandomSequence => self.random_sequence(),
        }
    }

    fn extended(&mut self, extension: &'static [&'static [Part]]) -> Value {
        let mut members = Vec::new();
        for part in extension {
            parts(part, self.bytes, self.at * 8, &mut members);
            let (octets, ends_in_fx) = extent_of_part(part);
            self.at += octets;
            if !ends_in_fx || !goes_on(self.bytes[self.at - 1]) {
                return Value::Group(members);
            }
        }
        let begin = self.at;
        while goes_on(self.octet()) {}
        members.push((UNKNOWN_EXTENSION, Value::Bytes(self.bytes[begin..self.at].to_vec())));
        Value::Group(members)
    }

    fn repetitive_fx(&mut self, inner: &'static Layout) -> Value {
        let mut values = Vec::new();
        loop {
            let at = self.at * 8;
            values.push(match inner {
                Layout::Element(width, content) => element_value(content, self.bytes, at, *width, &[]),
                Layout::Group(elements) => {
                    let mut members = Vec::with_capacity(elements.len());
                    parts(elements, self.bytes, at, &mut members);
                    Value::Group(members)
                }
                _ => unreachable!("a table with another layout here does not compile"),
            });
            self.at += inner.bit_count() as usize / 8 + 1;
            if !goes_on(self.bytes[self.at - 1]) {
                return Value::List(values);
            }
        }
    }

    fn compound(&mut self, subitems: &'static [Option<Item>]) -> Value {
        let mut present = 0u64;
        let mut shift = 0;
        loop {
            let octet = self.octet();
            present |= u64::from(fspec_bits(octet)) << shift;
            shift += 7;
            if !goes_on(octet) {
                break;
            }
        }
        let mut members = Vec::with_capacity(present.count_ones() as usize);
        for (i, subitem) in subitems.iter().enumerate() {
            if let Some(subitem) = subitem
                && present >> i & 1 == 1
            {
                members.push((subitem.name, self.layout(&subitem.layout)));
            }
        }
        Value::Group(members)
    }

    /// A list of groups with one member each, the item.
    fn random_sequence(&mut self) -> Value {
        let count = self.octet();
        let field = |_| {
            let frn = self.octet();
            let item = self.uap.item_in_sequence(frn).expect("measured");
            Value::Group(vec![(item.name, self.layout(&item.layout))])
        };
        Value::List((0..count).map(field).collect())
    }

    fn octet(&mut self) -> u8 {
        self.at += 1;
        self.bytes[self.at - 1]
    }
}

/// Decodes elements from bit `at` on; gives the bit behind them.
fn parts(elements: &'static [Part], bytes: &[u8], mut at: usize, members: &mut Vec<(&'static str, Value)>) -> usize {
    for part in elements {
        match part {
            Part::Spare(width) => at += usize::from(*width),
            Part::Element {
                name,
                bits: width,
                content,
                ..
            } => {
                let value = element_value(content, bytes, at, *width, members);
                members.push((name, value));
                at += usize::from(*width);
            }
            Part::Group(name, inner) => {
                let mut inner_members = Vec::with_capacity(inner.len());
                at = parts(inner, bytes, at, &mut inner_members);
                members.push((name, Value::Group(inner_members)));
            }
        }
    }
    at
}

/// Decodes an element. `before` are the earlier elements of its group.
fn element_value(
    content: &'static Content,
    bytes: &[u8],
    at: usize,
    width: u8,
    before: &[(&'static str, Value)],
) -> Value {
    let width = usize::from(width);
    match content {
        Content::Raw | Content::Integer { signed: false } => Value::Unsigned(bits(bytes, at, width)),
        Content::Integer { signed: true } => Value::Signed(sign_extend(bits(bytes, at, width), width)),
        Content::Quantity { signed, lsb, .. } => {
            let number = bits(bytes, at, width);
            let number = if *signed {
                sign_extend(number, width) as f64
            } else {
                number as f64
            };
            Value::Quantity(number * lsb)
        }
        Content::Text(coding) => Value::Text(text::decode(*coding, bytes, at, width)),
        Content::Depends { on, cases, otherwise } => {
            let decider = find(before, on).and_then(Value::as_u64);
            let case = cases.iter().find(|(case, _)| Some(*case) == decider);
            let chosen = case.map_or(*otherwise, |(_, content)| content);
            element_value(chosen, bytes, at, width as u8, before)
        }
    }
}

/// The member of this name.
pub(super) fn find<'v>(members: &'v [(&'static str, Value)], name: &str) -> Option<&'v Value> {
    members
        .iter()
        .find(|(candidate, _)| *candidate == name)
        .map(|(_, value)| value)
}
