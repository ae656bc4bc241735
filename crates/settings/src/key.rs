//! The declaration of a key.

use crate::SettingsError;
use crate::place::Place;

/// Declaration of a key, except its type and value.
#[derive(Clone, Copy, Debug)]
pub struct Key {
    /// Name in the file.
    pub name: &'static str,
    /// Documentation of the key, as in the source; the first sentence defines the key.
    pub doc: &'static str,
    /// Numbers that it may have.
    pub range: Range,
    /// The default in words; `None` if the default value is clear by itself.
    pub usually: Option<&'static str>,
    /// Whether it must be given.
    pub is_required: bool,
}

/// Numbers that a key may have. NaN lies in none of them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Range {
    /// Any, also none.
    Any,
    /// Both limits are allowed.
    Within(f64, f64),
    /// Finite and greater.
    Above(f64),
    /// Finite, and at least so great.
    From(f64),
}

impl Range {
    /// Checks `value`, which stands at `at`.
    ///
    /// # Errors
    /// If it is outside.
    pub fn check(self, value: f64, at: &Place<'_>) -> Result<(), SettingsError> {
        let (is_inside, right) = match self {
            Self::Any => return Ok(()),
            Self::Within(low, high) => ((low..=high).contains(&value), format!("lie between {low} and {high}")),
            Self::Above(low) => (value > low && value.is_finite(), format!("be greater than {low}")),
            Self::From(low) => (value >= low && value.is_finite(), format!("be {low} or greater")),
        };
        match is_inside {
            true => Ok(()),
            false => Err(at.error(format!("{value} is out of range; it must {right}"))),
        }
    }

    /// For people: `0.5 … 1`.
    pub(crate) fn text(self) -> String {
        let text = |limit: f64| match limit.abs() {
            0.0 => "0".to_owned(),
            size if (1e-3..1e10).contains(&size) => format!("{limit}"),
            _ => format!("{limit:e}"),
        };
        match self {
            Self::Any => String::new(),
            Self::Within(low, high) => format!("{} … {}", text(low), text(high)),
            Self::Above(low) => format!("> {}", text(low)),
            Self::From(low) => format!("≥ {}", text(low)),
        }
    }
}

/// Checks a value with a range that depends on other keys; the table names the value `key`.
///
/// # Errors
/// If it is outside.
pub fn within(key: &str, value: f64, low: f64, high: f64) -> Result<(), SettingsError> {
    Range::Within(low, high).check(value, &Place::ROOT.key(key))
}

/// Endings of names with their units, longer endings before their own endings.
const UNITS: &[(&str, &str)] = &[
    ("_rad2ps3", "rad²/s³"),
    ("_deg_per_s", "°/s"),
    ("_per_hour", "1/h"),
    ("_m2ps3", "m²/s³"),
    ("_bytes", "bytes"),
    ("_per_s", "1/s"),
    ("_degps", "°/s"),
    ("_radps", "rad/s"),
    ("_m2ps", "m²/s"),
    ("_mps", "m/s"),
    ("_deg", "°"),
    ("_rad", "rad"),
    ("_hpa", "hPa"),
    ("_hz", "Hz"),
    ("_ms", "ms"),
    ("_us", "µs"),
    ("_s", "s"),
    ("_m", "m"),
];

/// Returns the unit of a key from the end of its name; empty for a key without a unit.
pub fn unit_of(name: &str) -> &'static str {
    let found = UNITS.iter().find(|(ending, _)| name.ends_with(ending));
    found.map_or("", |(_, unit)| unit)
}
