//! A line of JSON from outside: readers of JSON choose silently between two values for a name.

use std::fmt;

use serde::Deserializer;
use serde::de::{DeserializeSeed, MapAccess, SeqAccess, Visitor};
use serde_json::{Map, Value};

/// The value of a line.
#[derive(Debug)]
pub(crate) struct GivenLine {
    pub(crate) value: Value,
    /// First name that stands more than once in an object, with the second value.
    pub(crate) twice: Option<(String, Value)>,
}

impl GivenLine {
    /// Reads a line. The mark that some programs write at the begin of a file is skipped: the mark is invisible in a
    /// message.
    pub(crate) fn read(line: &[u8]) -> serde_json::Result<Self> {
        let line = line.strip_prefix(b"\xef\xbb\xbf").unwrap_or(line);
        let mut twice = None;
        let mut reader = serde_json::Deserializer::from_slice(line);
        let value = GivenValue(&mut twice).deserialize(&mut reader)?;
        reader.end()?;
        Ok(Self { value, twice })
    }
}

/// Reader of a value, with the place for a name that stands twice.
struct GivenValue<'t>(&'t mut Option<(String, Value)>);

impl<'de> DeserializeSeed<'de> for GivenValue<'_> {
    type Value = Value;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Value, D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for GivenValue<'_> {
    type Value = Value;

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("a value of JSON")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut given: A) -> Result<Value, A::Error> {
        let mut fields = Map::new();
        while let Some(name) = given.next_key::<String>()? {
            let value = given.next_value_seed(GivenValue(self.0))?;
            if fields.contains_key(&name) {
                self.0.get_or_insert((name, value));
            } else {
                fields.insert(name, value);
            }
        }
        Ok(Value::Object(fields))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut given: A) -> Result<Value, A::Error> {
        let mut values = Vec::new();
        while let Some(value) = given.next_element_seed(GivenValue(self.0))? {
            values.push(value);
        }
        Ok(Value::Array(values))
    }

    fn visit_unit<E>(self) -> Result<Value, E> {
        Ok(Value::Null)
    }

    fn visit_bool<E>(self, given: bool) -> Result<Value, E> {
        Ok(given.into())
    }

    fn visit_u64<E>(self, given: u64) -> Result<Value, E> {
        Ok(given.into())
    }

    fn visit_i64<E>(self, given: i64) -> Result<Value, E> {
        Ok(given.into())
    }

    fn visit_f64<E>(self, given: f64) -> Result<Value, E> {
        Ok(given.into())
    }

    fn visit_str<E>(self, given: &str) -> Result<Value, E> {
        Ok(given.into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_the_value_that_serde_json_reads() {
        for line in [
            r#"{"a": [1, -2, 2.5e3, "é\n", null, true], "b": {"c": {}}}"#,
            "5",
            "[]",
            "\"x\"",
        ] {
            let read = GivenLine::read(line.as_bytes()).unwrap();
            assert_eq!(
                (read.value, read.twice),
                (serde_json::from_str(line).unwrap(), None),
                "{line}"
            );
            assert_eq!(
                GivenLine::read(format!("\u{feff}{line}").as_bytes()).unwrap().twice,
                None
            );
        }
        for line in ["", "{", "{\"a\" 5}", "5 5", "nonsense"] {
            assert!(GivenLine::read(line.as_bytes()).is_err(), "{line}");
        }
    }

    #[test]
    fn a_name_given_twice_is_found_at_any_depth() {
        for (line, name) in [
            (r#"{"a": 1, "b": 2, "a": 3}"#, "a"),
            (r#"{"a": [{"b": 1, "c": 2, "b": 3}]}"#, "b"),
        ] {
            let twice = GivenLine::read(line.as_bytes()).unwrap().twice;
            assert_eq!(twice, Some((name.to_owned(), 3.into())), "{line}");
        }
        assert_eq!(GivenLine::read(br#"{"a": {"b": 1}, "b": 2}"#).unwrap().twice, None);
    }
}
