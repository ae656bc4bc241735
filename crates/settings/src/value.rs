//! Values that keys stand for, and tables of them.

use toml::Spanned;
use toml::de::DeValue;

use crate::place::Place;
use crate::{Key, Range, SettingsError};

/// A value of the file.
pub type Node<'a> = Spanned<DeValue<'a>>;

/// Something that a key can stand for.
pub trait KeyValue {
    /// Checks the value in the file, and stores it.
    ///
    /// # Errors
    /// If it is of another type, or out of range.
    fn read(&mut self, node: &Node<'_>, range: Range, at: &Place<'_>) -> Result<(), SettingsError>;

    /// Checks the value that it has.
    ///
    /// # Errors
    /// If it is out of range.
    fn check(&self, range: Range, at: &Place<'_>) -> Result<(), SettingsError>;

    /// Its type in words.
    fn kind(&self) -> String;

    /// The value as a file spells it.
    fn text(&self) -> String;

    /// Returns the table of this value with its defaults, if the value is a table, or a list or option of tables.
    fn table(&self) -> Option<Box<dyn KeyTable>> {
        None
    }
}

/// A table that was declared by [`settings!`](crate::settings!).
pub trait KeyTable {
    /// Name of the type.
    fn name(&self) -> &'static str;

    /// Documentation of the key, as in the source.
    fn doc(&self) -> &'static str;

    /// Its own keys.
    fn keys(&self) -> Vec<&'static Key>;

    /// The values of its own keys, in the same order.
    fn values(&self) -> Vec<&dyn KeyValue>;

    /// As [`KeyTable::values`], to be changed.
    fn values_mut(&mut self) -> Vec<&mut dyn KeyValue>;

    /// Returns the included tables.
    fn bases(&self) -> Vec<&dyn KeyTable>;

    /// As [`KeyTable::bases`], to be changed.
    fn bases_mut(&mut self) -> Vec<&mut dyn KeyTable>;

    /// Checks conditions on several keys together.
    ///
    /// # Errors
    /// A key, by its name in this table, with its value and the permitted values.
    fn check_together(&self) -> Result<(), SettingsError>;
}
