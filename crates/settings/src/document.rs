//! A configuration as text: parsed once, with single values replaced, and with the line of every key.

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::syntax;
use crate::{KeyTable, KeyValue, Node, Place, SettingsError, read_table};

/// Offset that a value has which is not in the text.
const NOT_IN_TEXT: usize = usize::MAX;

/// A parsed configuration.
#[derive(Clone, Debug)]
pub struct Document<'a> {
    text: &'a str,
    root: Node<'a>,
}

impl<'a> Document<'a> {
    /// Parses `text`; each of `overrides` (`key.path=value`, the value in TOML) replaces a value of it.
    ///
    /// # Errors
    /// If the text is no TOML, with its line, or an override cannot be applied.
    pub fn parse(text: &'a str, overrides: &'a [String]) -> Result<Self, SettingsError> {
        let root = DeTable::parse(text).map_err(|error| SettingsError {
            line: error.span().map(|span| line_at(text, span.start)),
            ..SettingsError::new("", syntax::fault(text, &error))
        })?;
        let (span, mut root) = (root.span(), root.into_inner());
        for each in overrides {
            set(&mut root, each).map_err(|what| SettingsError::new("", format!("--set {each}: {what}")))?;
        }
        Ok(Self {
            text,
            root: Spanned::new(span, DeValue::Table(root)),
        })
    }

    /// Whether the document has this key at its top.
    pub fn has(&self, key: &str) -> bool {
        self.root.get_ref().get(key).is_some()
    }

    /// Reads the whole document as a table `T`.
    ///
    /// # Errors
    /// The first mistake, with its line.
    pub fn read<T: KeyTable + KeyValue + Default>(&self) -> Result<T, SettingsError> {
        let mut table = T::default();
        self.read_into(&mut table).map(|()| table)
    }

    /// Reads the whole document into `table`; keys missing in the document keep their values.
    ///
    /// # Errors
    /// The first mistake, with its line.
    pub fn read_into(&self, table: &mut dyn KeyTable) -> Result<(), SettingsError> {
        read_table(table, &self.root, &Place::ROOT).map_err(|error| self.located(error))
    }

    /// Returns this error with the line of its key, or with the option that set the key. Later calls change nothing.
    #[must_use]
    pub fn located(&self, mut error: SettingsError) -> SettingsError {
        let offset = self.offset(&error.key);
        if offset == Some(NOT_IN_TEXT) {
            let of_option = " (--set)";
            if !error.what.ends_with(of_option) {
                error.what.push_str(of_option);
            }
        }
        let offset = offset.filter(|offset| *offset != NOT_IN_TEXT);
        error.line = error.line.or(offset.map(|offset| line_at(self.text, offset)));
        error
    }

    /// Where the value at `path` begins, or its nearest ancestor that the text spells out.
    fn offset(&self, path: &str) -> Option<usize> {
        let mut offset = None;
        let mut table = self.root.get_ref().as_table();
        for part in path.split('.') {
            let (key, index) = split_index(part);
            let Some((name, value)) = table.and_then(|table| table.get_key_value(key)) else {
                break;
            };
            // The span of a table may begin at its first entry; users look for the key.
            let is_of_text = matches!(value.get_ref(), DeValue::Table(_)) && value.span().start != NOT_IN_TEXT;
            offset = Some(if is_of_text {
                name.span().start
            } else {
                value.span().start
            });
            table = match (value.get_ref(), index.map(|index| value.get_ref().get(index))) {
                (_, Some(Some(item))) => {
                    offset = Some(item.span().start);
                    item.get_ref().as_table()
                }
                (_, Some(None)) => None,
                (value, None) => value.as_table(),
            };
            if offset == Some(NOT_IN_TEXT) {
                break;
            }
        }
        offset
    }
}

/// Applies `key.path=value` or `source[0].key=value`.
fn set<'a>(root: &mut DeTable<'a>, assignment: &'a str) -> Result<(), String> {
    let outside = |value| Spanned::new(NOT_IN_TEXT..NOT_IN_TEXT, value);
    let (path, value) = assignment.split_once('=').ok_or("write it as key.path=value")?;
    let value = match DeValue::parse(value.trim()) {
        Ok(value) => value.into_inner(),
        Err(_) => DeValue::String(value.trim().into()),
    };
    let mut parts: Vec<&str> = path.trim().split('.').collect();
    let last = parts.pop().filter(|last| !last.is_empty()).ok_or("the key is empty")?;
    let mut table = root;
    for part in parts {
        let (key, index) = split_index(part);
        let entry = table
            .entry(Spanned::new(NOT_IN_TEXT..NOT_IN_TEXT, key.into()))
            .or_insert_with(|| outside(DeValue::Table(DeTable::new())));
        let entry = match (index, entry.get_mut()) {
            (None, entry) => Some(entry),
            (Some(index), DeValue::Array(items)) => items.get_mut(index).map(Spanned::get_mut),
            (Some(_), _) => None,
        };
        table = match entry {
            Some(DeValue::Table(table)) => table,
            Some(DeValue::Array(_)) => return Err(format!("{part} is a list; name an item, as in {part}[0]")),
            Some(_) => return Err(format!("{part} is not a table")),
            None => return Err(format!("there is no {part}")),
        };
    }
    table.remove(last);
    table.insert(Spanned::new(NOT_IN_TEXT..NOT_IN_TEXT, last.into()), outside(value));
    Ok(())
}

/// Line (from 1) of a byte offset.
fn line_at(text: &str, offset: usize) -> usize {
    let before = &text.as_bytes()[..offset.min(text.len())];
    1 + before.iter().filter(|byte| **byte == b'\n').count()
}

/// `source[1]` is (`source`, 1).
fn split_index(part: &str) -> (&str, Option<usize>) {
    match part.split_once('[') {
        Some((key, rest)) => (key, rest.trim_end_matches(']').parse().ok()),
        None => (part, None),
    }
}
