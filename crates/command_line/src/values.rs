//! Numbers as values of options, and the messages for invalid ones.

/// Parses a finite number.
///
/// # Errors
/// If `text` is no number; the message describes valid values.
pub fn finite(text: &str) -> Result<f64, String> {
    let number: f64 = text.parse().map_err(|_| "write a number".to_owned())?;
    number
        .is_finite()
        .then_some(number)
        .ok_or_else(|| "it must be finite".to_owned())
}

/// Parses a positive number.
///
/// # Errors
/// If `text` is no positive number; the message describes valid values.
pub fn above_zero(text: &str) -> Result<f64, String> {
    let number = finite(text)?;
    (number > 0.0)
        .then_some(number)
        .ok_or_else(|| "it must be more than 0".to_owned())
}

/// Parses a number of at least 0.
///
/// # Errors
/// If `text` is no such number; the message describes valid values.
pub fn not_negative(text: &str) -> Result<f64, String> {
    let number = finite(text)?;
    (number >= 0.0)
        .then_some(number)
        .ok_or_else(|| "it must not be negative".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_checked() {
        assert_eq!((above_zero("0.5"), not_negative("0")), (Ok(0.5), Ok(0.0)));
        for wrong in ["0", "-1", "nan", "inf", "far"] {
            assert!(above_zero(wrong).is_err(), "{wrong}");
        }
        assert!(not_negative("-0.1").is_err() && finite("inf").is_err());
    }
}
