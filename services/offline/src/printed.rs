//! Figures as text.

use std::fmt::Write as _;

use scoring::Word;
use serde::Serialize;
use serde_json::Value;

use crate::host::Host;

/// Significant digits on the screen.
const DIGITS: usize = 4;

/// Prints the available figures named by `words`.
pub(crate) fn show(host: &dyn Host, found: &impl Serialize, words: &[Word], json: bool) -> anyhow::Result<()> {
    let text = match json {
        true => format!("{}\n", serde_json::to_string(found)?),
        false => figures_text(found, words)?,
    };
    host.print(&text)
}

/// Returns the available figures named by `words`, a line each.
///
/// # Errors
/// If the figures cannot be converted.
pub(crate) fn figures_text(found: &impl Serialize, words: &[Word]) -> anyhow::Result<String> {
    let found = serde_json::to_value(found)?;
    let mut text = String::new();
    for word in words {
        let figure = match &found[word.name] {
            Value::Number(number) => match number.as_f64() {
                Some(value) if number.is_f64() => digits(value),
                _ => number.to_string(),
            },
            // The word belongs to another case.
            _ if found.get(word.name).is_none() => continue,
            _ => "-".to_owned(),
        };
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{:<26} {figure:>9} {:<4} {}", word.name, word.unit, word.meaning);
    }
    Ok(text)
}

/// Formats a number with the decimals required for its significant digits.
pub(crate) fn digits(value: f64) -> String {
    let magnitude = value.abs().log10().floor();
    let decimals = if magnitude.is_finite() {
        (DIGITS as f64 - 1.0 - magnitude).clamp(0.0, 12.0) as usize
    } else {
        0
    };
    let text = format!("{value:.decimals$}");
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_four_digits_where_they_have_so_many() {
        for (value, text) in [
            (641.234, "641.2"),
            (0.98765, "0.9877"),
            (1234.56, "1235"),
            (123_456.7, "123457"),
            (0.000_123_456, "0.0001235"),
            (0.0, "0"),
            (-2.5, "-2.5"),
            (1.0, "1"),
        ] {
            assert_eq!(digits(value), text);
        }
    }
}
