//! Samples from lines of JSON, as [`LineWriter`](crate::LineWriter) writes them: field by field by name.
//!
//! Words become the codes, bits and numbers of sources again, with or without [`SampleNames`](crate::SampleNames). A
//! field that a line does not have keeps the value of the sample that the line is read into; a field that no such
//! sample has is a fault. Places on the earth repeat the position, and are not read.
//!
//! Limits: a source of another deployment is no source here. Numbers that were not finite are NaN. A number of 64 bits
//! has its first fifteen digits.

use messages::admission::Fault;
use messages::layout::{CodeGroup, Layout, Sample as _, SampleField, code_groups};
use messages::{Identity, IdentityText, NO_SOURCE, identity_bits};
use serde_json::{Map, Value};

use crate::lines::{PLACES, fields, is_spelled, layout_of, spellings};
use crate::names::SOURCES;

/// Reader of lines of one sample.
#[derive(Debug)]
pub struct LineReader {
    layout: &'static Layout,
    groups: Vec<CodeGroup>,
    sources: Vec<String>,
}

impl LineReader {
    /// Returns a reader of samples with this layout, for a deployment with these sources.
    pub fn new(layout: &'static Layout, sources: Vec<String>) -> Self {
        Self {
            layout,
            groups: code_groups(),
            sources,
        }
    }

    /// Reads the fields of a line into a sample, given as the bytes of its layout.
    ///
    /// # Errors
    /// The fault of a field that the sample does not have, or of a value that the field cannot hold.
    pub fn read(&self, line: &Map<String, Value>, sample: &mut [u8]) -> Result<(), Fault> {
        let has_place = self.layout.fields.iter().any(|field| field.name == "position_m");
        let is_place = |name: &str| has_place && PLACES.contains(&name);
        let own = line.iter().filter(|(name, _)| !is_place(name));
        self.object(self.layout, own, sample)
    }

    fn object<'a>(
        &self,
        layout: &'static Layout,
        line: impl Iterator<Item = (&'a String, &'a Value)>,
        sample: &mut [u8],
    ) -> Result<(), Fault> {
        let mut numbers = Vec::new();
        for (name, value) in line {
            let spelling = fields(layout).flat_map(|field| spellings(layout, field));
            if let Some(spelling) = spelling.into_iter().find(|spelling| spelling.key == name) {
                numbers.push((*spelling, value));
                continue;
            }
            let field = fields(layout).find(|field| field.name == name && !is_spelled(layout, field));
            let Some(field) = field else {
                let limit = format!("is no field of a {}", layout.name);
                return Err(fault(name, value, &limit, "`koseki tap --schema` lists the fields"));
            };
            self.field(field, value, &mut sample[field.offset..field.offset + field.size])?;
        }
        if layout.name == Identity::LAYOUT.name {
            identify(&numbers, sample)?;
        }
        Ok(())
    }

    fn field(&self, field: &SampleField, value: &Value, octets: &mut [u8]) -> Result<(), Fault> {
        match field.element() {
            ("u8", Some(_)) => characters(field, value, octets),
            (kind, Some(count)) => {
                let all = value.as_array().filter(|all| all.len() <= count);
                let limit = format!("must be an array of up to {count} values");
                let all = all.ok_or_else(|| fault(field.name, value, &limit, "write it as `koseki tap` does"))?;
                let size = field.size / count;
                let places = octets.chunks_mut(size).zip(all);
                places
                    .into_iter()
                    .try_for_each(|(octets, value)| self.value(field, kind, value, octets))
            }
            (kind, None) => self.value(field, kind, value, octets),
        }
    }

    fn value(&self, field: &SampleField, kind: &str, value: &Value, octets: &mut [u8]) -> Result<(), Fault> {
        if let Some(inner) = layout_of(kind) {
            let object = value.as_object();
            let object =
                object.ok_or_else(|| fault(field.name, value, "must be an object", "write its fields by name"))?;
            return self.object(inner, object.iter(), octets);
        }
        let number = match value {
            Value::String(_) | Value::Array(_) => Some(self.code(field, value)?),
            Value::Null if SOURCES.contains(&field.name) => Some(NO_SOURCE.into()),
            _ => None,
        };
        let wrong = || {
            fault(
                field.name,
                value,
                "is no value of this field",
                "write it as `koseki tap` does",
            )
        };
        let written = match number {
            Some(number) => whole(kind, i128::from(number), octets),
            None => plain(kind, value, octets),
        };
        written.ok_or_else(wrong)
    }

    /// The number of a word, or of several: code, bits, or source.
    fn code(&self, field: &SampleField, value: &Value) -> Result<u64, Fault> {
        if let (true, Value::String(name)) = (SOURCES.contains(&field.name), value) {
            let place = self.sources.iter().position(|source| source == name);
            return Ok(place.map_or(NO_SOURCE.into(), |place| place as u64));
        }
        let group = field.codes(&self.groups);
        let found = |word: &Value| {
            let constants = group.as_ref().map(|group| &group.constants).into_iter().flatten();
            let word = word.as_str()?;
            constants
                .into_iter()
                .find(|constant| constant.word == word)
                .map(|constant| constant.value)
        };
        let number = match value {
            Value::Array(words) if group.as_ref().is_some_and(|group| group.is_flags) => {
                words.iter().try_fold(0, |bits, word| Some(bits | found(word)?))
            }
            word => found(word),
        };
        number.ok_or_else(|| {
            let words = group.as_ref().map(|group| &group.constants).into_iter().flatten();
            let words: Vec<&str> = words.map(|constant| constant.word).collect();
            let remedy = match words.is_empty() {
                true => "write digits without quotation marks".to_owned(),
                false => format!("there are: {}", words.join(", ")),
            };
            fault(field.name, value, "is no value of this field", remedy)
        })
    }
}

/// Sets the numbers of an identity, and what follows from them: its kind, and whether there is a code.
fn identify(numbers: &[(IdentityText, &Value)], sample: &mut [u8]) -> Result<(), Fault> {
    let Some(mut identity) = Identity::of_octets(sample) else {
        return Ok(());
    };
    identity = identity.without_unique_number();
    (identity.mode_3a, identity.valid) = (0, identity.valid & !identity_bits::MODE_3A);
    for (spelling, value) in numbers {
        let text = match value {
            Value::Null => continue,
            Value::String(text) => spelling.read(text),
            _ => None,
        };
        let wrong = || {
            let limit = format!("must be {}, as text", spelling.form);
            fault(
                spelling.key,
                value,
                &limit,
                format!("write it as in \"{}\"", spelling.example),
            )
        };
        let before = identity.unique_number();
        identity = spelling.set(identity, text.ok_or_else(wrong)?);
        if before.is_some_and(|before| identity.unique_number() != Some(before)) {
            let remedy = "a target is an aircraft or a ship: leave one out";
            return Err(fault(spelling.key, value, "must not stand beside an address", remedy));
        }
    }
    sample.copy_from_slice(Identity::octets(&[identity]));
    Ok(())
}

fn characters(field: &SampleField, value: &Value, octets: &mut [u8]) -> Result<(), Fault> {
    let text = value.as_str().filter(|text| text.len() <= octets.len());
    let limit = format!("must be a text of up to {} octets", octets.len());
    let text = text.ok_or_else(|| fault(field.name, value, &limit, "shorten it"))?;
    // Padding is of blanks; a text that is not known has none.
    octets.fill(if text.is_empty() { 0 } else { b' ' });
    octets[..text.len()].copy_from_slice(text.as_bytes());
    Ok(())
}

/// Writes a number that stands in a line; `None` if it is none of the kind.
fn plain(kind: &str, value: &Value, octets: &mut [u8]) -> Option<()> {
    match (kind, value) {
        ("f32", Value::Null) => octets.copy_from_slice(&f32::NAN.to_le_bytes()),
        ("f64", Value::Null) => octets.copy_from_slice(&f64::NAN.to_le_bytes()),
        // The least time means "unknown".
        ("i64", Value::Null) => octets.copy_from_slice(&i64::MIN.to_le_bytes()),
        ("f32", _) => octets.copy_from_slice(&(value.as_f64()? as f32).to_le_bytes()),
        ("f64", _) => octets.copy_from_slice(&value.as_f64()?.to_le_bytes()),
        _ => {
            let number = value.as_i64().map(i128::from).or(value.as_u64().map(i128::from));
            whole(kind, number?, octets)?;
        }
    }
    Some(())
}

/// Writes a whole number; `None` if the kind cannot hold it.
fn whole(kind: &str, number: i128, octets: &mut [u8]) -> Option<()> {
    macro_rules! of {
        ($number:ty) => {
            octets.copy_from_slice(&<$number>::try_from(number).ok()?.to_le_bytes())
        };
    }
    match kind {
        "u8" => of!(u8),
        "u16" => of!(u16),
        "u32" => of!(u32),
        "u64" => of!(u64),
        "i8" => of!(i8),
        "i16" => of!(i16),
        "i32" => of!(i32),
        "i64" => of!(i64),
        _ => return None,
    }
    Some(())
}

fn fault(field: &str, value: &Value, limit: &str, remedy: impl Into<String>) -> Fault {
    let mut value = value.to_string();
    if let Some((end, _)) = value.char_indices().nth(60) {
        value.truncate(end);
        value.push('…');
    }
    Fault {
        field: field.to_owned(),
        value,
        limit: limit.to_owned(),
        remedy: remedy.into(),
    }
}

#[cfg(test)]
#[path = "reader_tests.rs"]
mod tests;
