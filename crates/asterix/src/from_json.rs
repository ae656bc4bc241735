//! Records out of JSON: the inverse of how [`named`](super::named) writes them.
//!
//! JSON has a single kind of number and of text; a record has several of each: a code, a signed number or a quantity,
//! characters or bytes. The table determines the kind. An unknown name, or a value of an unsuitable kind, is an error
//! that names the place. [`NamedRecord::encode`] checks whether a value fits into its bits.

use serde_json::{Map, Value as Json};

use super::encode::encode_expansion;
use super::encode_error::{EncodeError, EncodeFault, Failure};
use super::expansion::{Expansion, FIELD};
use super::named::{NamedRecord, UNKNOWN_EXTENSION, Value};
use super::table::{Category, Content, Item, Layout, Part};

/// Members about the record itself: its category and its time of recording.
const OF_THE_RECORD: [&str; 2] = ["_c", "_ts"];

impl NamedRecord {
    /// Reads a record as [`NamedRecord::to_json`] gives it, by the edition of `table`. The content of its reserved
    /// expansion field is bytes, or an object by the coding rules of `expansion`.
    ///
    /// # Errors
    /// If the record is of another category, or holds a name or a kind of value that the table has no place for.
    pub fn from_json(
        record: &Json,
        table: &'static Category,
        expansion: Option<&'static Expansion>,
    ) -> Result<Self, EncodeError> {
        read(record, table, expansion).map_err(|failure| failure.into_error(table.number))
    }
}

fn read(
    record: &Json,
    table: &'static Category,
    expansion: Option<&'static Expansion>,
) -> Result<NamedRecord, Failure> {
    let members = object(record)?;
    let category = members.get("_c").and_then(Json::as_u64);
    if category != Some(u64::from(table.number)) {
        let found = category.and_then(|found| u8::try_from(found).ok()).unwrap_or_default();
        return Err(EncodeFault::CategoryDiffers { found }.into());
    }
    let reader = Reader { table };
    let items = members
        .iter()
        .filter(|(name, _)| !OF_THE_RECORD.contains(&name.as_str()));
    let items = items.map(|(name, value)| {
        let item = table
            .item(name)
            .ok_or_else(|| Failure::at(name, EncodeFault::Unknown))?;
        let value = match (item.name, value, expansion) {
            (FIELD, Json::Object(subitems), Some(rules)) => {
                let content = reader.subitems(rules.items, subitems);
                content.and_then(|content| encode_expansion(rules, table.uap(), &content).map(Value::Bytes))
            }
            _ => reader.layout(&item.layout, value),
        };
        Ok((item.name, value.map_err(|failure| failure.within(name))?))
    });
    Ok(NamedRecord {
        category: table.number,
        time_stamp_s: members.get("_ts").and_then(Json::as_f64),
        items: items.collect::<Result<_, Failure>>()?,
    })
}

struct Reader {
    table: &'static Category,
}

impl Reader {
    fn layout(&self, layout: &'static Layout, value: &Json) -> Result<Value, Failure> {
        match layout {
            Layout::Element(_, content) => element(content, value, &Map::new()),
            Layout::Group(parts) => group(&[parts], value),
            Layout::Extended(parts) => group(parts, value),
            Layout::Repetitive(inner) | Layout::RepetitiveFx(inner) => list(value, |value| self.layout(inner, value)),
            Layout::Explicit => octets(value),
            Layout::Compound(subitems) => self.subitems(subitems, object(value)?),
            Layout::RandomSequence => list(value, |value| self.item_of_sequence(value)),
        }
    }

    fn subitems(&self, subitems: &'static [Option<Item>], members: &Map<String, Json>) -> Result<Value, Failure> {
        let members = members.iter().map(|(name, value)| {
            if name == UNKNOWN_EXTENSION {
                return Ok((UNKNOWN_EXTENSION, octets(value)?));
            }
            let subitem = subitems.iter().flatten().find(|subitem| subitem.name == name);
            let subitem = subitem.ok_or_else(|| Failure::at(name, EncodeFault::Unknown))?;
            let value = self.layout(&subitem.layout, value);
            Ok((subitem.name, value.map_err(|failure| failure.within(name))?))
        });
        members.collect::<Result<_, _>>().map(Value::Group)
    }

    /// An object of one member, the item.
    fn item_of_sequence(&self, value: &Json) -> Result<Value, Failure> {
        let members = object(value)?.iter().map(|(name, value)| {
            let item = self.table.item(name);
            let item = item.ok_or_else(|| Failure::at(name, EncodeFault::Unknown))?;
            let value = self.layout(&item.layout, value);
            Ok((item.name, value.map_err(|failure| failure.within(name))?))
        });
        members.collect::<Result<_, _>>().map(Value::Group)
    }
}

/// The elements of a group, or of all parts of an extended item.
fn group(parts: &[&'static [Part]], value: &Json) -> Result<Value, Failure> {
    let members = object(value)?;
    let elements = members.iter().map(|(name, value)| {
        if name == UNKNOWN_EXTENSION {
            return Ok((UNKNOWN_EXTENSION, octets(value)?));
        }
        let found = parts.iter().copied().flatten().find_map(|part| match part {
            Part::Element {
                name: known, content, ..
            } if known == name => Some((*known, element(content, value, members))),
            Part::Group(known, inner) if known == name => Some((*known, group(&[inner], value))),
            _ => None,
        });
        let (name, value) = found.ok_or_else(|| Failure::at(name, EncodeFault::Unknown))?;
        Ok((name, value.map_err(|failure| failure.within(name))?))
    });
    elements.collect::<Result<_, _>>().map(Value::Group)
}

/// One element, in a group with these members.
fn element(content: &'static Content, value: &Json, members: &Map<String, Json>) -> Result<Value, Failure> {
    match content {
        Content::Raw | Content::Integer { signed: false } => {
            let number = value.as_u64().map(Value::Unsigned);
            number.ok_or_else(|| other_kind("a whole number without sign", value))
        }
        Content::Integer { signed: true } => {
            let number = value.as_i64().map(Value::Signed);
            number.ok_or_else(|| other_kind("a whole number", value))
        }
        Content::Quantity { .. } => {
            let number = value.as_f64().map(Value::Quantity);
            number.ok_or_else(|| other_kind("a number", value))
        }
        Content::Text(_) => Ok(Value::Text(text(value)?.to_owned())),
        Content::Depends { on, cases, otherwise } => {
            let decider = members.get(*on).and_then(Json::as_u64);
            let case = cases.iter().find(|(case, _)| Some(*case) == decider);
            element(case.map_or(*otherwise, |(_, content)| content), value, members)
        }
    }
}

fn object(value: &Json) -> Result<&Map<String, Json>, Failure> {
    value.as_object().ok_or_else(|| other_kind("an object", value))
}

fn list(value: &Json, mut read: impl FnMut(&Json) -> Result<Value, Failure>) -> Result<Value, Failure> {
    let values = value.as_array().ok_or_else(|| other_kind("an array", value))?;
    let values = values.iter().enumerate();
    let values = values.map(|(i, value)| read(value).map_err(|failure| failure.within_repetition(i)));
    values.collect::<Result<_, _>>().map(Value::List)
}

fn text(value: &Json) -> Result<&str, Failure> {
    value.as_str().ok_or_else(|| other_kind("a text", value))
}

/// Bytes, written in pairs of hexadecimal digits.
fn octets(value: &Json) -> Result<Value, Failure> {
    let digits = value.as_str().map(str::as_bytes).unwrap_or(b"?");
    let digit = |character: &u8| char::from(*character).to_digit(16).map(|digit| digit as u8);
    let octets = digits.chunks(2).map(|pair| match pair {
        [high, low] => Some(digit(high)? << 4 | digit(low)?),
        _ => None,
    });
    let octets = octets.collect::<Option<Vec<u8>>>().map(Value::Bytes);
    octets.ok_or_else(|| other_kind("octets, two hexadecimal digits each", value))
}

#[cold]
fn other_kind(expected: &'static str, value: &Json) -> Failure {
    let found = match value {
        Json::Null => "null",
        Json::Bool(_) => "true or false",
        Json::Number(number) if number.is_f64() => "a number with decimals",
        Json::Number(number) if number.is_i64() && !number.is_u64() => "a negative number",
        Json::Number(_) => "a number",
        Json::String(_) => "a text",
        Json::Array(_) => "an array",
        Json::Object(_) => "an object",
    };
    EncodeFault::Kind { expected, found }.into()
}
