//! Errors of a configuration.

/// A value that cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{key}{separator}{what}", separator = if key.is_empty() { "" } else { ": " })]
pub struct SettingsError {
    /// Path of the key as in the file (`source[1].limits.range_m`); empty for an error of the whole file.
    pub key: String,
    /// The value, its fault, and the permitted values.
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

    /// Returns this error with `path` before the key, which so far contains the name in its table only.
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
