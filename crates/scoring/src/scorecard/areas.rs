//! Areas that have scorecards of their own.

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

/// Rings of a polygon, each a list of points east and north, metres: the outline first, then its holes.
pub type PolygonRings = Vec<Vec<[f64; 2]>>;

/// Named part of the plane.
#[derive(Clone, Debug, PartialEq)]
pub struct ScoredArea {
    /// Name of the area.
    pub name: String,
    /// Kind of the area; without a kind, all lines of a standard apply.
    pub kind: Option<AreaKind>,
    /// Polygons of the area.
    pub polygons: Vec<PolygonRings>,
}

impl ScoredArea {
    /// Whether a place is in the area. Places on an outline belong to either side.
    pub fn contains(&self, place_m: [f64; 2]) -> bool {
        // A place in a hole is in two rings.
        let rings = |polygon: &PolygonRings| polygon.iter().filter(|ring| encloses(ring, place_m)).count();
        self.polygons.iter().any(|polygon| rings(polygon) % 2 == 1)
    }
}

/// Whether a ray to the east crosses the ring an odd number of times.
fn encloses(ring: &[[f64; 2]], [east, north]: [f64; 2]) -> bool {
    let ends = ring.iter().zip(ring.iter().cycle().skip(1));
    let crossed = ends.filter(|([x1, y1], [x2, y2])| {
        (*y1 > north) != (*y2 > north) && east < x1 + (north - y1) / (y2 - y1) * (x2 - x1)
    });
    crossed.count() % 2 == 1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn holes_and_further_polygons_count() {
        let square = |low: f64, high: f64| vec![[low, low], [high, low], [high, high], [low, high]];
        let area = ScoredArea {
            name: "two".to_owned(),
            kind: None,
            polygons: vec![vec![square(0.0, 10.0), square(4.0, 6.0)], vec![square(20.0, 30.0)]],
        };
        for (place, inside) in [
            ([1.0, 1.0], true),
            ([5.0, 5.0], false),
            ([7.0, 5.0], true),
            ([25.0, 25.0], true),
            ([15.0, 15.0], false),
            ([-1.0, 5.0], false),
            ([25.0, 5.0], false),
        ] {
            assert_eq!(area.contains(place), inside, "{place:?}");
        }
    }

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
