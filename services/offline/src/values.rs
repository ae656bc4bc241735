//! Values of options, and the messages for invalid values.

use std::time::Duration;

use command_line::values::finite;
use frames::Geodetic;
use outgoing::HeightReference;

/// Maximum of `--for`, seconds: a hundred years.
const SECONDS_MAX: f64 = 3.2e9;
/// Limit of times in files, either side of 0, seconds; no later time is worth scoring.
const SECOND_MAX: f64 = 4e6;

/// Parses a positive duration in seconds.
///
/// # Errors
/// If `text` is no valid duration; the message describes valid values.
pub fn seconds(text: &str) -> Result<Duration, String> {
    let seconds: f64 = text.parse().map_err(|_| "write a number of seconds".to_owned())?;
    if seconds > 0.0 && seconds <= SECONDS_MAX {
        return Ok(Duration::from_secs_f64(seconds));
    }
    Err(format!("it must be more than 0 and at most {SECONDS_MAX}"))
}

/// Parses the time between pictures.
///
/// # Errors
/// If `text` is no valid time; the message describes valid values.
pub fn refresh(text: &str) -> Result<Duration, String> {
    let time = seconds(text)?;
    if (Duration::from_millis(1)..=Duration::from_secs(3600)).contains(&time) {
        return Ok(time);
    }
    Err("it must lie between 0.001 and 3600".to_owned())
}

/// Parses a place on the Earth: latitude and longitude in degrees, and a height in metres if not 0.
///
/// # Errors
/// If `text` is no place; the message describes valid values.
pub fn place(text: &str) -> Result<Geodetic, String> {
    let numbers: Option<Vec<f64>> = text.split(',').map(|part| part.trim().parse().ok()).collect();
    let form = "write latitude and longitude in degrees, and a height in metres if it is not 0, as in 41.297,2.078,4";
    match numbers.as_deref() {
        Some([latitude, longitude]) => Geodetic::from_degrees(*latitude, *longitude, 0.0),
        Some([latitude, longitude, height]) => Geodetic::from_degrees(*latitude, *longitude, *height),
        _ => return Err(form.to_owned()),
    }
    .map_err(|error| format!("{error}; {form}"))
}

/// Parses the kind of heights.
///
/// # Errors
/// If `text` is none; the message describes valid values.
pub fn heights(text: &str) -> Result<HeightReference, String> {
    HeightReference::from_word(text).ok_or_else(|| "write geometric or barometric".to_owned())
}

/// Parses a whole second for scoring a picture.
///
/// # Errors
/// If `text` is no whole second; the message describes valid values.
pub fn whole_second(text: &str) -> Result<i64, String> {
    let second = finite(text)?;
    if second.fract() == 0.0 && second.abs() <= SECOND_MAX {
        return Ok(second as i64);
    }
    Err(format!("pictures are scored at whole seconds up to {SECOND_MAX}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_checked() {
        assert_eq!(seconds("1.5"), Ok(Duration::from_millis(1500)));
        for wrong in ["0", "-1", "nan", "inf", "1e30", "soon"] {
            assert!(seconds(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn seconds_to_score_are_checked() {
        assert_eq!((whole_second("10"), whole_second("-3.0")), (Ok(10), Ok(-3)));
        for wrong in ["0.5", "1e7", "nan", "noon"] {
            assert!(whole_second(wrong).is_err(), "{wrong}");
        }
    }
}
