//! The tables there are: one line for each edition of a category.

use super::categories::{CAT010_V1_1, CAT019_V1_3, CAT020_V1_9, CAT021_V0_23};
use super::table::{Category, Edition};

/// Every table, by category. The first of a category is its default edition.
pub static REGISTRY: &[&Category] = &[&CAT010_V1_1, &CAT019_V1_3, &CAT020_V1_9, &CAT021_V0_23];

/// The table of one edition.
pub fn find(number: u8, edition: Edition) -> Option<&'static Category> {
    editions(number).find(|table| table.edition == edition)
}

/// The table of a category's default edition.
pub fn default_edition(number: u8) -> Option<&'static Category> {
    editions(number).next()
}

/// The tables of one category, the default first.
pub fn editions(number: u8) -> impl Iterator<Item = &'static Category> {
    REGISTRY.iter().copied().filter(move |table| table.number == number)
}

/// The default table of each category.
pub fn defaults() -> impl Iterator<Item = &'static Category> {
    let is_first = |i: usize| REGISTRY[..i].iter().all(|table| table.number != REGISTRY[i].number);
    (0..REGISTRY.len()).filter(move |&i| is_first(i)).map(|i| REGISTRY[i])
}
