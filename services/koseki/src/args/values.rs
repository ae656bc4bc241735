//! Values of options, and what is said of anything else.

use std::time::Duration;

use asterix::choice::{editions_of, expansions_of};
use asterix::registry;
use formats::rows::Utc;
use runtime::Speed;

/// Longest time that `--for` accepts, seconds: a hundred years.
const SECONDS_MAX: f64 = 3.2e9;
/// Times in files reach this far to either side of 0, seconds; no second beyond is worth scoring.
const SECOND_MAX: f64 = 4e6;

/// Nanoseconds since 1970 of a time as files write it.
pub(super) fn utc(text: &str) -> Result<i64, String> {
    let Utc(time_ns) = text
        .parse()
        .map_err(|error| format!("{error}; write it as in 2026-05-01T10:00:00Z"))?;
    Ok(time_ns)
}

pub(super) fn editions_help() -> String {
    let mut text =
        "Read a category by this edition, as in 21=0.23 (repeatable). The first of each is the default:".to_owned();
    for table in registry::defaults() {
        let number = table.number;
        text.push_str(&format!("\n  {number:03}: {}", editions_of(number)));
        let expansions = expansions_of(number);
        if !expansions.is_empty() {
            text.push_str(&format!("\n  {number:03}/RE: {expansions}"));
        }
    }
    text.push_str(
        "\nReserved expansion fields (RE) are shown as octets unless an edition of their coding rules is named.",
    );
    text
}

pub(super) fn seconds(text: &str) -> Result<Duration, String> {
    let seconds: f64 = text.parse().map_err(|_| "write a number of seconds".to_owned())?;
    if seconds > 0.0 && seconds <= SECONDS_MAX {
        return Ok(Duration::from_secs_f64(seconds));
    }
    Err(format!("it must be more than 0 and at most {SECONDS_MAX}"))
}

pub(super) fn refresh(text: &str) -> Result<Duration, String> {
    let time = seconds(text)?;
    if (Duration::from_millis(1)..=Duration::from_secs(3600)).contains(&time) {
        return Ok(time);
    }
    Err("it must lie between 0.001 and 3600".to_owned())
}

pub(super) fn interval(text: &str) -> Result<Duration, String> {
    let time = seconds(text)?;
    if (Duration::from_millis(100)..=Duration::from_secs(3600)).contains(&time) {
        return Ok(time);
    }
    Err("it must lie between 0.1 and 3600".to_owned())
}

pub(super) fn speed(text: &str) -> Result<Speed, String> {
    if text == "max" {
        return Ok(Speed::Max);
    }
    let factor: f64 = text.parse().map_err(|_| "write a factor, or max".to_owned())?;
    if factor > 0.0 && factor.is_finite() {
        return Ok(Speed::Factor(factor));
    }
    Err("a factor must be more than 0; write max for as fast as possible".to_owned())
}

pub(super) fn finite(text: &str) -> Result<f64, String> {
    let number: f64 = text.parse().map_err(|_| "write a number".to_owned())?;
    number
        .is_finite()
        .then_some(number)
        .ok_or_else(|| "it must be finite".to_owned())
}

pub(super) fn above_zero(text: &str) -> Result<f64, String> {
    let number = finite(text)?;
    (number > 0.0)
        .then_some(number)
        .ok_or_else(|| "it must be more than 0".to_owned())
}

pub(super) fn not_negative(text: &str) -> Result<f64, String> {
    let number = finite(text)?;
    (number >= 0.0)
        .then_some(number)
        .ok_or_else(|| "it must not be negative".to_owned())
}

pub(super) fn whole_second(text: &str) -> Result<i64, String> {
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
    fn speeds_and_times_are_checked() {
        assert_eq!(speed("2.5"), Ok(Speed::Factor(2.5)));
        assert_eq!(speed("max"), Ok(Speed::Max));
        for wrong in ["0", "-1", "nan", "inf", "fast", ""] {
            assert!(speed(wrong).is_err(), "{wrong}");
        }
        assert_eq!(seconds("1.5"), Ok(Duration::from_millis(1500)));
        for wrong in ["0", "-1", "nan", "inf", "1e30", "soon"] {
            assert!(seconds(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn distances_and_seconds_to_score_are_checked() {
        assert_eq!((above_zero("0.5"), not_negative("0")), (Ok(0.5), Ok(0.0)));
        for wrong in ["0", "-1", "nan", "inf", "far"] {
            assert!(above_zero(wrong).is_err(), "{wrong}");
        }
        assert!(not_negative("-0.1").is_err() && finite("inf").is_err());
        assert_eq!((whole_second("10"), whole_second("-3.0")), (Ok(10), Ok(-3)));
        for wrong in ["0.5", "1e7", "nan", "noon"] {
            assert!(whole_second(wrong).is_err(), "{wrong}");
        }
    }
}
