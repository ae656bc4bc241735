//! A file whose tables belong to several crates.
//!
//! The crate that reads the file declares the key of each table, so that every key of the file is known there. The
//! value of a key is [`Unread`] if another crate declares the table: a program without that crate ignores the table.
//! A program with the crate puts the crate's own declaration of the key in its place ([`Shared`]).

use crate::{Key, KeyTable, KeyValue, Node, Place, Range, SettingsError};

/// A value that this program does not read: a crate that is no part of the program declares its keys.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Unread;

impl KeyValue for Unread {
    fn read(&mut self, _: &Node<'_>, _: Range, _: &Place<'_>) -> Result<(), SettingsError> {
        Ok(())
    }

    fn check(&self, _: Range, _: &Place<'_>) -> Result<(), SettingsError> {
        Ok(())
    }

    fn kind(&self) -> String {
        "unread".to_owned()
    }

    fn text(&self) -> String {
        String::new()
    }
}

/// A file's table, in which some keys have the values of other tables.
pub struct Shared<'f, 'p> {
    file: &'f mut dyn KeyTable,
    parts: Vec<&'p mut dyn KeyTable>,
    /// For each key of the file: the part with the key and the place there; `None` if the file itself has the value.
    owners: Vec<Option<(usize, usize)>>,
}

impl<'f, 'p> Shared<'f, 'p> {
    /// Gives each key of `parts` to the key of the same name of `file`, which keeps its place among the keys.
    ///
    /// # Panics
    /// If the file has no such key, which is a mistake in the declarations.
    pub fn new(file: &'f mut dyn KeyTable, parts: Vec<&'p mut dyn KeyTable>) -> Self {
        let mut owners = vec![None; file.keys().len()];
        for (part, table) in parts.iter().enumerate() {
            for (index, key) in table.keys().into_iter().enumerate() {
                let place = file.keys().iter().position(|known| known.name == key.name);
                let place = place.unwrap_or_else(|| panic!("{} declares no key {}", file.name(), key.name));
                owners[place] = Some((part, index));
            }
        }
        Self { file, parts, owners }
    }
}

impl KeyTable for Shared<'_, '_> {
    fn name(&self) -> &'static str {
        self.file.name()
    }

    fn doc(&self) -> &'static str {
        self.file.doc()
    }

    fn keys(&self) -> Vec<&'static Key> {
        let own = self.file.keys().into_iter().zip(&self.owners);
        own.map(|(key, owner)| owner.map_or(key, |(part, index)| self.parts[part].keys()[index]))
            .collect()
    }

    fn values(&self) -> Vec<&dyn KeyValue> {
        let own = self.file.values().into_iter().zip(&self.owners);
        own.map(|(value, owner)| owner.map_or(value, |(part, index)| self.parts[part].values()[index]))
            .collect()
    }

    fn values_mut(&mut self) -> Vec<&mut dyn KeyValue> {
        let parts = self.parts.iter_mut().map(|part| part.values_mut());
        let mut parts: Vec<Vec<Option<&mut dyn KeyValue>>> =
            parts.map(|values| values.into_iter().map(Some).collect()).collect();
        let own = self.file.values_mut().into_iter().zip(&self.owners);
        own.map(|(value, owner)| {
            let of_part = owner.and_then(|(part, index)| parts[part][index].take());
            of_part.unwrap_or(value)
        })
        .collect()
    }

    fn bases(&self) -> Vec<&dyn KeyTable> {
        self.file.bases()
    }

    fn bases_mut(&mut self) -> Vec<&mut dyn KeyTable> {
        self.file.bases_mut()
    }

    fn check_together(&self) -> Result<(), SettingsError> {
        self.file.check_together()?;
        self.parts.iter().try_for_each(|part| part.check_together())
    }
}
