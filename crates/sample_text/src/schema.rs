//! JSON Schema of a sample's line.

use messages::layout::{Layout, SampleField, code_groups};
use serde_json::{Map, Value, json};

use crate::lines::{PLACES, fields, is_spelled, layout_of, spellings};
use crate::names::SOURCES;

/// Dialect of the schema.
const DIALECT: &str = "https://json-schema.org/draft/2020-12/schema";

/// Returns the JSON Schema of the lines that [`LineWriter`](crate::LineWriter) writes for a sample: with names if
/// `is_named`, else with numbers only.
pub fn json_schema(layout: &'static Layout, is_named: bool) -> Value {
    let mut schema = object(layout, is_named);
    let mut add = |key: &str, value: Value| schema.insert(key.to_owned(), value);
    add("$schema", DIALECT.into());
    add("title", layout.name.into());
    if is_named && layout.fields.iter().any(|field| field.name == "position_m") {
        let places = PLACES.map(|name| (name.to_owned(), json!({"type": ["number", "null"]})));
        for part in ["properties", "required"] {
            match schema.get_mut(part) {
                Some(Value::Object(properties)) => properties.extend(places.clone()),
                Some(Value::Array(required)) => required.extend(PLACES.map(Value::from)),
                _ => {}
            }
        }
    }
    Value::Object(schema)
}

fn object(layout: &'static Layout, is_named: bool) -> Map<String, Value> {
    let mut properties = Map::new();
    let mut required = Vec::new();
    for field in fields(layout) {
        for spelling in spellings(layout, field) {
            let text = json!({"type": ["string", "null"], "pattern": spelling.pattern, "description": spelling.form});
            properties.insert(spelling.key.to_owned(), text);
            required.push(spelling.key);
        }
        if !is_spelled(layout, field) {
            properties.insert(field.name.to_owned(), property(field, is_named));
            required.push(field.name);
        }
    }
    [
        ("type", "object".into()),
        ("properties", properties.into()),
        ("required", required.into()),
        ("additionalProperties", false.into()),
    ]
    .map(|(key, value)| (key.to_owned(), value))
    .into_iter()
    .collect()
}

fn property(field: &SampleField, is_named: bool) -> Value {
    let (kind, count) = field.element();
    let mut property = match (kind, count) {
        ("u8", Some(count)) => json!({"type": "string", "maxLength": count}),
        (_, Some(count)) => {
            // Elements behind the last used sample are omitted; numbers are complete.
            let least = if layout_of(kind).is_some() { 0 } else { count };
            json!({"type": "array", "items": value(field, kind, is_named), "minItems": least, "maxItems": count})
        }
        (_, None) => value(field, kind, is_named),
    };
    property["description"] = field.doc.into();
    property
}

fn value(field: &SampleField, kind: &str, is_named: bool) -> Value {
    if let Some(layout) = layout_of(kind) {
        return object(layout, is_named).into();
    }
    if is_named && SOURCES.contains(&field.name) {
        return json!({"type": ["string", "integer", "null"]});
    }
    if let Some(group) = field.codes(&code_groups()).filter(|_| is_named) {
        let words: Vec<&str> = group.constants.iter().map(|constant| constant.word).collect();
        return match group.is_flags {
            true => json!({"type": "array", "items": {"enum": words}}),
            // A code of another version stays a number.
            false => json!({"anyOf": [{"enum": words}, {"type": "integer", "minimum": 0}]}),
        };
    }
    match kind {
        "f32" | "f64" => json!({"type": ["number", "null"]}),
        // The least time means "unknown".
        "i64" => json!({"type": ["integer", "null"]}),
        "u8" | "u16" | "u32" | "u64" => json!({"type": "integer", "minimum": 0}),
        _ => json!({"type": "integer"}),
    }
}

#[cfg(test)]
mod tests {
    use frames::{Geodetic, SystemFrame};
    use messages::layout::ALL;

    use super::*;
    use crate::{LineFormat, LineWriter, SampleNames};

    /// Checks a value against the parts of JSON Schema that are used here.
    fn check(value: &Value, schema: &Value, at: &str) {
        if let Some(choices) = schema["anyOf"].as_array() {
            let fits = |choice: &Value| match choice["enum"].as_array() {
                Some(words) => words.contains(value),
                None => value.is_u64(),
            };
            return assert!(choices.iter().any(fits), "{at}: {value}");
        }
        if let Some(words) = schema["enum"].as_array() {
            return assert!(words.contains(value), "{at}: {value}");
        }
        let kind = match value {
            Value::Null => "null",
            Value::String(_) => "string",
            Value::Array(_) => "array",
            Value::Object(_) => "object",
            Value::Number(number) if number.is_f64() => "number",
            _ => "integer",
        };
        let kinds = match &schema["type"] {
            Value::Array(kinds) => kinds.clone(),
            one => vec![one.clone()],
        };
        assert!(kinds.contains(&kind.into()), "{at}: {kind}, not {kinds:?}");
        match value {
            Value::Array(items) => {
                let most = schema["maxItems"].as_u64().unwrap_or(64);
                let least = schema["minItems"].as_u64().unwrap_or(0);
                assert!(
                    (least..=most).contains(&(items.len() as u64)),
                    "{at}: {} items",
                    items.len()
                );
                items.iter().for_each(|item| check(item, &schema["items"], at));
            }
            Value::Object(members) => {
                let required = schema["required"].as_array().unwrap();
                assert_eq!(members.len(), required.len(), "{at}");
                for (name, member) in members {
                    assert!(required.contains(&name.as_str().into()), "{at}.{name}");
                    check(member, &schema["properties"][name], &format!("{at}.{name}"));
                }
            }
            _ => {}
        }
    }

    #[test]
    fn every_line_of_every_sample_follows_its_schema() {
        let frame = SystemFrame::at(Geodetic::from_degrees(45.0, 9.0, 0.0).unwrap());
        let names = || SampleNames::new(vec!["north".to_owned()], frame);
        for layout in ALL {
            for octet in [0, 1, 7, 0xFF] {
                let sample = vec![octet; layout.size];
                for names in [None, Some(names())] {
                    let schema = json_schema(layout, names.is_some());
                    let mut line = Vec::new();
                    LineWriter::new(layout, LineFormat::Json, names).write(&sample, &mut line);
                    check(&serde_json::from_slice(&line).unwrap(), &schema, layout.name);
                }
            }
        }
    }
}
