//! Faults of a text that is no TOML, in the words of its keys.

use toml::de::Error;

use crate::unit_of;

/// Returns the fault of `text`, with the key of its line.
pub(crate) fn fault(text: &str, error: &Error) -> String {
    let span = error.span().unwrap_or_default();
    let begin = text[..span.start].rfind('\n').map_or(0, |end| end + 1);
    let line = text[begin..].lines().next().unwrap_or_default();
    let is_value = text[begin..span.start].contains('=');
    let (key, value) = line.split_once('=').unwrap_or_default();
    let value = value.split('#').next().unwrap_or_default().trim();
    match error.message() {
        "duplicate key" => twice(text, line, &text[span]),
        _ if is_value && !value.starts_with(['"', '\'', '[', '{']) => no_value(key.trim(), value),
        message => message.replace('\n', " "),
    }
}

/// The fault of a key or table that is given twice.
fn twice(text: &str, line: &str, key: &str) -> String {
    let header = line.trim().split(']').next().unwrap_or_default();
    let Some(path) = header.strip_prefix('[') else {
        return format!("{key}: is given twice; remove one of the two");
    };
    let path = path.trim_start_matches('[').trim();
    match text.contains(&format!("[[{path}]]")) {
        true => format!("{path}: is given twice; each table of a list stands below [[{path}]]"),
        false => format!("{path}: is given twice; write all its keys below one [{path}]"),
    }
}

/// The fault of what stands behind the `=`, and is neither a number nor in quotes.
fn no_value(key: &str, value: &str) -> String {
    let unit = unit_of(key);
    match value.chars().next() {
        None => format!("{key}: the value is missing; write it behind the '='"),
        Some(first) if !unit.is_empty() && (first.is_ascii_digit() || "+-.".contains(first)) => {
            format!("{key}: {value} is no value; write the number alone (the unit, {unit}, is in the name of the key)")
        }
        Some(_) => format!("{key}: {value} is no value; write a number, true, false, or a text in quotes"),
    }
}
