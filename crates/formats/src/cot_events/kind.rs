//! Types of events: letters between hyphens, from the general to the special.
//!
//! `a-f-A-M-F-Q` is a thing (atom), friend, in the air, military, fixed wing, drone. Some drones have a small `q`.

use observations::TargetCategory;

/// Letters of the type of a thing behind the affiliation, the dimension first; `None` for other events.
pub(super) fn thing(kind: &str) -> Option<impl Iterator<Item = &str> + Clone> {
    let (letters, _) = kind.split_once(';').unwrap_or((kind, ""));
    let mut letters = letters.split('-');
    (letters.next() == Some("a")).then(|| letters.skip(1))
}

/// Category by the letters behind the affiliation.
pub(super) fn category<'a>(letters: impl Iterator<Item = &'a str>) -> TargetCategory {
    let mut first = [""; 4];
    for (place, letter) in first.iter_mut().zip(letters) {
        *place = letter;
    }
    match first {
        ["A", "M" | "C", "F" | "H", "Q" | "q"] => TargetCategory::Unmanned,
        ["A", "M" | "C", "H", _] => TargetCategory::Rotorcraft,
        ["A", "M" | "C", "L", _] => TargetCategory::LighterThanAir,
        ["P", ..] => TargetCategory::Space,
        ["S", "C", ..] => TargetCategory::Military,
        ["S", "X", "F", _] => TargetCategory::Fishing,
        ["S", "X", "L", _] => TargetCategory::LawEnforcement,
        ["S", "X", "R", _] => TargetCategory::Pleasure,
        ["S", "X", "M", "C"] => TargetCategory::Cargo,
        ["S", "X", "M", "O"] => TargetCategory::Tanker,
        ["S", "X", "M", "P"] => TargetCategory::Passenger,
        ["S", "" | "N" | "X", ..] => TargetCategory::Ship,
        _ => TargetCategory::Unknown,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn letters_name_categories_where_that_is_sure() {
        for (kind, expected) in [
            ("a-f-A-M-F-Q", TargetCategory::Unmanned),
            ("a-n-A-C-F-q", TargetCategory::Unmanned),
            ("a-h-A-M-H-Q-x;text", TargetCategory::Unmanned),
            ("a-f-A-C-H", TargetCategory::Rotorcraft),
            ("a-f-A-M-H-A", TargetCategory::Rotorcraft),
            ("a-f-A-C-L", TargetCategory::LighterThanAir),
            ("a-f-A-C-F", TargetCategory::Unknown),
            ("a-f-A-W-M", TargetCategory::Unknown),
            ("a-u-P", TargetCategory::Space),
            ("a-u-S", TargetCategory::Ship),
            ("a-u-S-X-M", TargetCategory::Ship),
            ("a-u-S-X-M-C", TargetCategory::Cargo),
            ("a-u-S-C-L", TargetCategory::Military),
            ("a-u-S-W", TargetCategory::Unknown),
            ("a-f-G-U-C", TargetCategory::Unknown),
            ("a-f", TargetCategory::Unknown),
            ("a", TargetCategory::Unknown),
        ] {
            assert_eq!(category(thing(kind).unwrap()), expected, "{kind}");
        }
        for kind in ["", "b-m-p-s-m", "t-x-c-t", "A-f-G", "ab-f-G", ";a-f-G"] {
            assert!(thing(kind).is_none(), "{kind}");
        }
    }
}
