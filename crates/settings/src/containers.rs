//! Compound values: options, lists, and tables whose keys are names chosen by the user.

use std::collections::BTreeMap;

use toml::de::DeValue;

use crate::leaves::found;
use crate::{KeyTable, KeyValue, Node, Place, Range, SettingsError};

/// The word that stands for `None`.
const OFF: &str = "off";

impl<T: KeyValue + Default> KeyValue for Option<T> {
    fn read(&mut self, node: &Node<'_>, range: Range, at: &Place<'_>) -> Result<(), SettingsError> {
        if node.get_ref().as_str() == Some(OFF) {
            *self = None;
            return Ok(());
        }
        let mut value = T::default();
        let read = value.read(node, range, at);
        read.map_err(|error| match node.get_ref().is_str() {
            true => SettingsError::new(error.key, format!("{}, or \"{OFF}\"", error.what)),
            false => error,
        })?;
        *self = Some(value);
        Ok(())
    }

    fn check(&self, range: Range, at: &Place<'_>) -> Result<(), SettingsError> {
        self.as_ref().map_or(Ok(()), |value| value.check(range, at))
    }

    fn kind(&self) -> String {
        format!("{}, or \"{OFF}\"", T::default().kind())
    }

    fn text(&self) -> String {
        self.as_ref().map_or_else(|| format!("\"{OFF}\""), KeyValue::text)
    }

    fn table(&self) -> Option<Box<dyn KeyTable>> {
        self.as_ref().map_or_else(|| T::default().table(), KeyValue::table)
    }
}

impl<T: KeyValue + Default> KeyValue for Vec<T> {
    fn read(&mut self, node: &Node<'_>, range: Range, at: &Place<'_>) -> Result<(), SettingsError> {
        let DeValue::Array(items) = node.get_ref() else {
            let (found, is_of_tables) = (found(node), T::default().table().is_some());
            return Err(at.error(match is_of_tables {
                true => format!("{found} is no list of tables; write each below [[{at}]]"),
                false => format!("{found} is no list; write it in brackets: [{}]", T::default().kind()),
            }));
        };
        self.clear();
        for (index, item) in items.iter().enumerate() {
            let mut value = T::default();
            value.read(item, range, &at_item(&value, at, index))?;
            self.push(value);
        }
        Ok(())
    }

    fn check(&self, range: Range, at: &Place<'_>) -> Result<(), SettingsError> {
        let mut items = self.iter().enumerate();
        items.try_for_each(|(index, value)| value.check(range, &at_item(value, at, index)))
    }

    fn kind(&self) -> String {
        format!("list of: {}", T::default().kind())
    }

    fn text(&self) -> String {
        list(self)
    }

    fn table(&self) -> Option<Box<dyn KeyTable>> {
        T::default().table()
    }
}

impl<T: KeyValue + Default, const N: usize> KeyValue for [T; N] {
    fn read(&mut self, node: &Node<'_>, range: Range, at: &Place<'_>) -> Result<(), SettingsError> {
        match node.get_ref() {
            DeValue::Array(items) if items.len() == N => {
                let mut pairs = self.iter_mut().zip(items);
                pairs.try_for_each(|(value, item)| value.read(item, range, at))
            }
            DeValue::Array(items) => {
                let (found, like) = (items.len(), list(self));
                Err(at.error(format!("{found} values; write {N}, like {like}")))
            }
            _ => Err(at.error(format!(
                "{} is no list; write {N} values, like {}",
                found(node),
                list(self)
            ))),
        }
    }

    fn check(&self, range: Range, at: &Place<'_>) -> Result<(), SettingsError> {
        self.iter().try_for_each(|value| value.check(range, at))
    }

    fn kind(&self) -> String {
        format!("{N} × {}", self[0].kind())
    }

    fn text(&self) -> String {
        list(self)
    }
}

impl<T: KeyValue + Default> KeyValue for BTreeMap<String, T> {
    fn read(&mut self, node: &Node<'_>, range: Range, at: &Place<'_>) -> Result<(), SettingsError> {
        let DeValue::Table(table) = node.get_ref() else {
            let what = format!("{} is no table; write names with values below [{at}]", found(node));
            return Err(at.error(what));
        };
        self.clear();
        for (name, item) in table {
            let mut value = T::default();
            value.read(item, range, &at.key(name.get_ref()))?;
            self.insert(name.get_ref().to_string(), value);
        }
        Ok(())
    }

    fn check(&self, range: Range, at: &Place<'_>) -> Result<(), SettingsError> {
        let mut items = self.iter();
        items.try_for_each(|(name, value)| value.check(range, &at.key(name)))
    }

    fn kind(&self) -> String {
        format!("table of: {}", T::default().kind())
    }

    fn text(&self) -> String {
        let items: Vec<String> = self
            .iter()
            .map(|(name, value)| format!("{name} = {}", value.text()))
            .collect();
        format!("{{{}}}", items.join(", "))
    }
}

/// An item that is a table has its own place; a number has the place of its list.
fn at_item<'a>(value: &impl KeyValue, at: &Place<'a>, index: usize) -> Place<'a> {
    match value.table() {
        Some(_) => at.item(index),
        None => *at,
    }
}

fn list<T: KeyValue>(items: &[T]) -> String {
    let items: Vec<String> = items.iter().map(KeyValue::text).collect();
    format!("[{}]", items.join(", "))
}
