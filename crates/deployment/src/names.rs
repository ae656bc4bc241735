//! Names in a deployment's file.

use settings::SettingsError;

/// Checks a name, which the key `key` gives.
///
/// # Errors
/// If the name has other characters than those of topics and processes, or too many.
pub fn check_name(key: &str, name: &str) -> Result<(), SettingsError> {
    let fits = (1..=31).contains(&name.len())
        && name
            .bytes()
            .all(|byte| byte.is_ascii_alphanumeric() || byte == b'-' || byte == b'_');
    if fits {
        return Ok(());
    }
    Err(SettingsError::new(
        key,
        format!("\"{name}\" cannot be a name: use 1 to 31 letters, digits, - and _"),
    ))
}
