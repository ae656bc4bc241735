//! Values of options, and what is said of anything else.

use std::time::Duration;

use asterix::table::EditionError;
use asterix::{Edition, registry};
use formats::rows::Utc;
use runtime::Speed;

use super::ChosenEdition;

/// Longest time that `--for` accepts, seconds: a hundred years.
const SECONDS_MAX: f64 = 3.2e9;
/// Times in files reach this far to either side of 0, seconds; no second beyond is worth scoring.
const SECOND_MAX: f64 = 4e6;

/// Choice that `CAT=ED` or `CAT/RE=ED` makes.
pub(super) fn edition(text: &str) -> Result<ChosenEdition, String> {
    let (category, edition) = text
        .split_once('=')
        .ok_or("write a category and its edition, as in 21=0.23")?;
    let (category, is_expansion) = match category.strip_suffix("/RE") {
        Some(category) => (category, true),
        None => (category, false),
    };
    let number: u8 = category.parse().map_err(|_| "a category is a number up to 255")?;
    let edition: Edition = edition.parse().map_err(|error: EditionError| error.to_string())?;
    let (chosen, what, there_are) = match is_expansion {
        true => (
            registry::find_expansion(number, edition).map(ChosenEdition::Expansion),
            "reserved expansion field of category",
            expansions_of(number),
        ),
        false => (
            registry::find(number, edition).map(ChosenEdition::Category),
            "category",
            editions_of(number),
        ),
    };
    chosen.ok_or_else(|| match there_are.as_str() {
        "" => format!("there is no table for the {what} {number:03}; see `koseki decode --help`"),
        editions => format!("{what} {number:03} has no such edition here; there are {editions}"),
    })
}

/// The editions of a category that there are tables for, the default first.
fn editions_of(category: u8) -> String {
    let editions = registry::editions(category).map(|table| table.edition.to_string());
    editions.collect::<Vec<_>>().join(", ")
}

/// The same of the coding rules of its reserved expansion field.
fn expansions_of(category: u8) -> String {
    let expansions = registry::EXPANSIONS.iter().filter(|rules| rules.number == category);
    let editions = expansions.map(|rules| rules.edition.to_string());
    editions.collect::<Vec<_>>().join(", ")
}

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
    fn editions_are_found_or_the_ones_there_are_named() {
        let chosen = edition("21=0.23").unwrap();
        assert!(matches!(chosen, ChosenEdition::Category(table) if table.to_string() == "CAT021 ed 0.23"));
        let chosen = edition("048/RE=1.13").unwrap();
        assert!(matches!(chosen, ChosenEdition::Expansion(rules) if rules.edition == Edition::new(1, 13)));
        for (wrong, expected) in [
            ("21", "as in 21=0.23"),
            ("x=1.0", "a number up to 255"),
            ("300=1.0", "a number up to 255"),
            ("21=023", "is no edition"),
            ("21=9.9", "there are 2.4, 2.1"),
            ("99=1.0", "no table for the category 099"),
            ("48/RE=1.31", "there are 1.11, 1.12, 1.13"),
            ("10/RE=1.1", "no table for the reserved expansion field of category 010"),
        ] {
            let line = edition(wrong).unwrap_err();
            assert!(line.contains(expected), "{line}");
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
