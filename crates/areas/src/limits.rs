//! Floors and ceilings.

use std::fmt;
use std::str::FromStr;

use crate::AreaError;

const FOOT_M: f64 = 0.3048;
/// Forms of a level.
const FORMS: &str = "write FL95, 2500 ft, 760 m, GND or unlimited";

/// A height that limits an area.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Level {
    /// Flight level: hundreds of feet of pressure altitude.
    Flight(f64),
    /// Height above mean sea level, metres.
    Sea(f64),
}

/// Floor and ceiling of an area; without one, the area is unlimited there.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct VerticalLimits {
    /// Lowest height.
    pub floor: Option<Level>,
    /// Greatest height.
    pub ceiling: Option<Level>,
}

impl VerticalLimits {
    /// Reads both limits; `None` states none.
    ///
    /// # Errors
    /// If a text is no level, a level is above ground, or the floor is not below the ceiling.
    pub fn read(floor: Option<&str>, ceiling: Option<&str>) -> Result<Self, AreaError> {
        let limits = Self {
            floor: floor.map(|text| limit(text, true)).transpose()?.flatten(),
            ceiling: ceiling.map(|text| limit(text, false)).transpose()?.flatten(),
        };
        let bounds = match (limits.floor, limits.ceiling) {
            (Some(Level::Flight(floor)), Some(Level::Flight(ceiling)))
            | (Some(Level::Sea(floor)), Some(Level::Sea(ceiling))) => Some((floor, ceiling)),
            _ => None,
        };
        match bounds.is_some_and(|(floor, ceiling)| floor >= ceiling) {
            true => Err(AreaError(format!(
                "the floor {} is not below the ceiling {}",
                floor.unwrap_or_default(),
                ceiling.unwrap_or_default()
            ))),
            false => Ok(limits),
        }
    }
}

/// A level in words; `None`: there is no limit.
fn limit(text: &str, is_floor: bool) -> Result<Option<Level>, AreaError> {
    let word = text.trim().to_ascii_lowercase();
    match word.as_str() {
        "gnd" | "sfc" | "ground" | "surface" if is_floor => Ok(None),
        "gnd" | "sfc" | "ground" | "surface" => Err(AreaError(format!("the ceiling {text} leaves no room; {FORMS}"))),
        "unl" | "unlim" | "unltd" | "unlimited" if !is_floor => Ok(None),
        "unl" | "unlim" | "unltd" | "unlimited" => Err(AreaError(format!("the floor {text} leaves no room; {FORMS}"))),
        _ => text.parse().map(Some),
    }
}

impl FromStr for Level {
    type Err = AreaError;

    fn from_str(text: &str) -> Result<Self, AreaError> {
        let word = text.trim().to_ascii_lowercase();
        if ["agl", "sfc", "gnd", "asfc"].iter().any(|end| word.ends_with(end)) {
            return Err(AreaError(format!(
                "the level {text} is above ground, and there is no terrain; write the height above mean sea level"
            )));
        }
        let word = word.trim_end_matches("amsl").trim_end_matches("msl").trim_end();
        let parsed = if let Some(level) = word.strip_prefix("fl") {
            level.trim().parse().ok().map(Self::Flight)
        } else if let Some(feet) = word.strip_suffix("ft") {
            feet.trim().parse().ok().map(|feet: f64| Self::Sea(FOOT_M * feet))
        } else if let Some(metres) = word.strip_suffix('m') {
            metres.trim().parse().ok().map(Self::Sea)
        } else {
            None
        };
        let is_finite = |level: &Self| match level {
            Self::Flight(value) | Self::Sea(value) => value.is_finite(),
        };
        parsed
            .filter(is_finite)
            .ok_or_else(|| AreaError(format!("\"{text}\" is no level; {FORMS}")))
    }
}

impl fmt::Display for Level {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Flight(level) => write!(f, "FL{level:03.0}"),
            Self::Sea(metres) => write!(f, "{:.0} ft ({metres:.0} m)", metres / FOOT_M),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_have_their_usual_forms() {
        for (text, expected) in [
            ("FL95", Level::Flight(95.0)),
            ("fl 095", Level::Flight(95.0)),
            ("2500 ft", Level::Sea(762.0)),
            ("2500ft AMSL", Level::Sea(762.0)),
            ("760 m MSL", Level::Sea(760.0)),
            ("-20 m", Level::Sea(-20.0)),
        ] {
            assert_eq!(text.parse::<Level>(), Ok(expected), "{text}");
        }
        assert_eq!(Level::Flight(95.0).to_string(), "FL095");
        assert_eq!(Level::Sea(762.0).to_string(), "2500 ft (762 m)");
        let open = VerticalLimits::read(Some("GND"), Some("unlimited")).unwrap();
        assert_eq!(open, VerticalLimits::default());
        let mixed = VerticalLimits::read(Some("2500 ft"), Some("FL65")).unwrap();
        assert_eq!(
            (mixed.floor, mixed.ceiling),
            (Some(Level::Sea(762.0)), Some(Level::Flight(65.0)))
        );
    }

    #[test]
    fn what_is_no_level_is_refused_with_the_remedy() {
        let refused = |floor: Option<&str>, ceiling: Option<&str>, expected: &str| {
            let fault = VerticalLimits::read(floor, ceiling).unwrap_err().0;
            assert!(fault.contains(expected), "{fault}");
        };
        refused(Some("1000 ft AGL"), None, "there is no terrain");
        refused(Some("300 m sfc"), None, "there is no terrain");
        refused(Some("95"), None, "\"95\" is no level; write FL95");
        refused(Some("inf m"), None, "is no level");
        refused(None, Some("GND"), "leaves no room");
        refused(Some("unl"), None, "leaves no room");
        refused(Some("FL95"), Some("FL95"), "is not below the ceiling FL95");
        refused(Some("900 m"), Some("2500 ft"), "is not below");
    }
}
