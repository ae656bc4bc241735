//! Errors of a configuration.

/// A value that cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{key}{separator}{what}", separator = if key.is_empty() { "" } else { ": " })]
pub struct SettingsError {
    /// Path of the key as the file spells it (`source[1].limits.range_m`); empty if it is about the file as a whole.
    pub key: String,
    /// The value, what is wrong with it, and what would be right.
    pub what: String,
    /// Line of the file, from 1; `None` if the value does not come from a file, or the file does not mention the key.
    pub line: Option<usize>,
}

impl SettingsError {
    /// An error of the value at `key`.
    pub fn new(key: impl Into<String>, what: impl Into<String>) -> Self {
        Self {
            key: key.into(),
            what: what.into(),
            line: None,
        }
    }

    /// The same error of the table at `path`, which knew its key by its own name only.
    #[must_use]
    pub fn under(mut self, path: &str) -> Self {
        self.key = match (path, self.key.as_str()) {
            ("", _) => self.key,
            (_, "") => path.to_owned(),
            (_, key) => format!("{path}.{key}"),
        };
        self
    }
}
