//! Areas that have scorecards of their own.

use ::areas::Outline;

/// Kind of an area: which lines of a standard apply.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AreaKind {
    /// Name in files.
    pub word: &'static str,
    /// Whether the area is part of the manoeuvring area, whose lines then apply, too.
    manoeuvring: bool,
}

impl AreaKind {
    /// Runways and taxiways.
    pub const MANOEUVRING: Self = kind("manoeuvring", true);
    /// A runway.
    pub const RUNWAY: Self = kind("runway", true);
    /// Taxiways of the manoeuvring area.
    pub const TAXIWAY: Self = kind("taxiway", true);
    /// Taxiways of the apron.
    pub const APRON: Self = kind("apron", false);
    /// Stands.
    pub const STAND: Self = kind("stand", false);
    /// The approaches, to 2.5 nautical miles from the threshold.
    pub const APPROACH: Self = kind("approach", false);
    /// The approaches from 2.5 to 5 nautical miles.
    pub const OUTER_APPROACH: Self = kind("outer-approach", false);
    /// Terminal area.
    pub const TERMINAL: Self = kind("terminal", false);
    /// En-route airspace.
    pub const EN_ROUTE: Self = kind("en-route", false);

    /// All kinds.
    pub const ALL: [Self; 9] = [
        Self::MANOEUVRING,
        Self::RUNWAY,
        Self::TAXIWAY,
        Self::APRON,
        Self::STAND,
        Self::APPROACH,
        Self::OUTER_APPROACH,
        Self::TERMINAL,
        Self::EN_ROUTE,
    ];

    /// Returns the kind with this name.
    pub fn from_word(word: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.word == word)
    }

    /// Whether lines for `other` apply to areas of this kind.
    pub(crate) fn has(self, other: Self) -> bool {
        self == other || other == Self::MANOEUVRING && self.manoeuvring
    }
}

const fn kind(word: &'static str, manoeuvring: bool) -> AreaKind {
    AreaKind { word, manoeuvring }
}

/// Named part of the plane.
#[derive(Clone, Debug, PartialEq)]
pub struct ScoredArea {
    /// Name of the area.
    pub name: String,
    /// Kind of the area; without a kind, all lines of a standard apply.
    pub kind: Option<AreaKind>,
    /// The area on the ground.
    pub outline: Outline,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_runway_is_part_of_the_manoeuvring_area() {
        assert!(AreaKind::RUNWAY.has(AreaKind::MANOEUVRING) && AreaKind::RUNWAY.has(AreaKind::RUNWAY));
        assert!(!AreaKind::MANOEUVRING.has(AreaKind::RUNWAY) && !AreaKind::APRON.has(AreaKind::MANOEUVRING));
        assert!(
            AreaKind::ALL
                .into_iter()
                .all(|kind| AreaKind::from_word(kind.word) == Some(kind))
        );
        assert_eq!(AreaKind::from_word("lake"), None);
    }
}
