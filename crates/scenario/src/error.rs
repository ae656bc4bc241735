//! What is wrong with a setting, and the checks that find it.

use std::fmt::Display;

/// A setting that cannot be used: which one, its value, and what it has to be.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{key} = {value}: must be {limit}")]
pub struct SettingsError {
    /// Name of the setting as written in the configuration.
    pub key: &'static str,
    /// Its value.
    pub value: String,
    /// What it has to be.
    pub limit: String,
}

impl SettingsError {
    pub(crate) fn new(key: &'static str, value: impl Display, limit: impl Display) -> Self {
        Self {
            key,
            value: value.to_string(),
            limit: limit.to_string(),
        }
    }
}

/// Refuses a value outside `min..=max` (and NaN).
pub(crate) fn within(key: &'static str, value: f64, min: f64, max: f64) -> Result<(), SettingsError> {
    if (min..=max).contains(&value) {
        Ok(())
    } else {
        Err(SettingsError::new(key, value, format_args!("between {min} and {max}")))
    }
}

/// Refuses a count outside `min..=max`.
pub(crate) fn count_within(key: &'static str, value: u32, min: u32, max: u32) -> Result<(), SettingsError> {
    if (min..=max).contains(&value) {
        Ok(())
    } else {
        Err(SettingsError::new(key, value, format_args!("between {min} and {max}")))
    }
}
