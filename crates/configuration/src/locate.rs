//! Where in the file a key stands, so that an error can say the line.

use toml::de::{DeTable, DeValue};

/// Line (from 1) of the value at `path` (`fusion.capacity.system_tracks`, `source[1].limits.range_m`), or of its nearest
/// ancestor that the file spells out; `None` if not even the first part is there.
pub(crate) fn line_of(text: &str, path: &str) -> Option<usize> {
    let root = DeTable::parse(text).ok()?;
    let mut offset = None;
    let mut table = Some(root.get_ref());
    for part in path.split('.') {
        let (key, index) = split_index(part);
        let Some((name, value)) = table.and_then(|table| table.get_key_value(key)) else {
            break;
        };
        // A table's own span may begin at its first entry; its key is where a person looks.
        offset = Some(if matches!(value.get_ref(), DeValue::Table(_)) {
            name.span().start
        } else {
            value.span().start
        });
        table = match (value.get_ref(), index) {
            (DeValue::Array(items), Some(index)) => match items.get(index) {
                Some(item) => {
                    offset = Some(item.span().start);
                    item.get_ref().as_table()
                }
                None => None,
            },
            (value, _) => value.as_table(),
        };
    }
    Some(line_at(text, offset?))
}

/// Line (from 1) of a byte offset.
pub(crate) fn line_at(text: &str, offset: usize) -> usize {
    1 + text.as_bytes()[..offset.min(text.len())]
        .iter()
        .filter(|byte| **byte == b'\n')
        .count()
}

/// `source[1]` is (`source`, 1).
fn split_index(part: &str) -> (&str, Option<usize>) {
    match part.split_once('[') {
        Some((key, rest)) => (key, rest.trim_end_matches(']').parse().ok()),
        None => (part, None),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_found_where_they_stand() {
        let text = "name = \"x\"\n\n[fusion]\nwait = \"spin\"\n[fusion.capacity]\nqueue = 0\n\n[[source]]\nname = \"a\"\n[[source]]\nname = \"b\"\n[source.limits]\nrange_m = -1\n";
        assert_eq!(line_of(text, "name"), Some(1));
        assert_eq!(line_of(text, "fusion.wait"), Some(4));
        assert_eq!(line_of(text, "fusion.capacity.queue"), Some(6));
        assert_eq!(line_of(text, "source[1].name"), Some(11));
        assert_eq!(line_of(text, "source[1].limits.range_m"), Some(13));
        assert_eq!(
            line_of(text, "fusion.life.terminate_s"),
            Some(3),
            "the nearest ancestor"
        );
        assert_eq!(line_of(text, "scenario"), None);
    }
}
