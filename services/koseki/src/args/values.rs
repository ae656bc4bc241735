//! Parsers of option values, with their error texts.

use std::time::Duration;

use asterix::choice::{editions_of, expansions_of};
use asterix::registry;
use formats::rows::Utc;
use offline::values::seconds;
use runtime::Speed;

/// Reads west, south, east, north, degrees.
pub(super) fn area(text: &str) -> Result<[f64; 4], String> {
    let numbers: Result<Vec<f64>, _> = text.split(',').map(|number| number.trim().parse::<f64>()).collect();
    let area: Option<[f64; 4]> = numbers.ok().and_then(|numbers| numbers.try_into().ok());
    let is_area = |[west, south, east, north]: &[f64; 4]| {
        [west, east].iter().all(|degrees| (-180.0..=180.0).contains(*degrees))
            && (-90.0..=90.0).contains(south)
            && (south..=&90.0).contains(&north)
    };
    area.filter(is_area)
        .ok_or_else(|| "write west, south, east and north in degrees, as in 1.5,41.0,2.5,41.6".to_owned())
}

/// Parses a UTC time in the form of the recordings; returns nanoseconds since 1970.
pub(super) fn utc(text: &str) -> Result<i64, String> {
    let form = "write a time as in 2026-05-01T10:00:00Z";
    let Utc(time_ns) = text.parse().map_err(|_| form.to_owned())?;
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
        "\nReserved expansion fields (RE) are shown as bytes unless an edition of their coding rules is given.",
    );
    text
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn speeds_are_checked() {
        assert_eq!(speed("2.5"), Ok(Speed::Factor(2.5)));
        assert_eq!(speed("max"), Ok(Speed::Max));
        for wrong in ["0", "-1", "nan", "inf", "fast", ""] {
            assert!(speed(wrong).is_err(), "{wrong}");
        }
    }
}
