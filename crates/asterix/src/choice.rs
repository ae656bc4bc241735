//! Notation of editions in options: `21=0.23` for a category, `48/RE=1.13` for its reserved expansion field.

use std::fmt::Display;
use std::str::FromStr;

use super::expansion::Expansion;
use super::registry;
use super::table::{Category, Edition, EditionError};

/// Edition chosen instead of the default.
#[derive(Clone, Copy, Debug)]
pub enum ChosenEdition {
    /// The table of a category.
    Category(&'static Category),
    /// The coding rules of its reserved expansion field.
    Expansion(&'static Expansion),
}

impl FromStr for ChosenEdition {
    /// A sentence that names the editions there are.
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
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
                registry::find_expansion(number, edition).map(Self::Expansion),
                "reserved expansion field of category",
                expansions_of(number),
            ),
            false => (
                registry::find(number, edition).map(Self::Category),
                "category",
                editions_of(number),
            ),
        };
        chosen.ok_or_else(|| match there_are.as_str() {
            "" => format!("there is no table for the {what} {number:03}; see `koseki decode --help`"),
            editions => format!("{what} {number:03} has no such edition here; there are {editions}"),
        })
    }
}

/// The editions of a category that there are tables for, the default first.
pub fn editions_of(category: u8) -> String {
    listed(registry::editions(category).map(|table| table.edition))
}

/// The same of the coding rules of its reserved expansion field.
pub fn expansions_of(category: u8) -> String {
    let expansions = registry::EXPANSIONS.iter().filter(|rules| rules.number == category);
    listed(expansions.map(|rules| rules.edition))
}

fn listed(editions: impl Iterator<Item = impl Display>) -> String {
    editions
        .map(|edition| edition.to_string())
        .collect::<Vec<_>>()
        .join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn editions_are_found_or_the_ones_there_are_named() {
        let edition = |text: &str| text.parse::<ChosenEdition>();
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
}
