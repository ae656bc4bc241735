//! Where a value stands.

use std::fmt;

use crate::SettingsError;

/// Where a value stands, for messages: the path of its key.
#[derive(Clone, Copy, Debug)]
pub struct Place<'a> {
    before: Option<&'a Place<'a>>,
    name: &'a str,
    index: Option<usize>,
}

impl<'a> Place<'a> {
    /// The file as a whole.
    pub const ROOT: Place<'static> = Place {
        before: None,
        name: "",
        index: None,
    };

    /// The key `name` of the table that stands here.
    pub fn key(&'a self, name: &'a str) -> Place<'a> {
        Place {
            before: Some(self),
            name,
            index: None,
        }
    }

    /// An item of the list that stands here, counted from 0.
    pub fn item(self, index: usize) -> Place<'a> {
        Place {
            index: Some(index),
            ..self
        }
    }

    /// Name of the key that stands here, or of the list with the item.
    pub(crate) fn name(&self) -> &str {
        self.name
    }

    /// An error of the value that stands here.
    pub fn error(&self, what: impl Into<String>) -> SettingsError {
        SettingsError::new(self.to_string(), what)
    }
}

impl fmt::Display for Place<'_> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(before) = self.before {
            let path = before.to_string();
            formatter.write_str(&path)?;
            formatter.write_str(if path.is_empty() { "" } else { "." })?;
        }
        formatter.write_str(self.name)?;
        match self.index {
            Some(index) => write!(formatter, "[{index}]"),
            None => Ok(()),
        }
    }
}
