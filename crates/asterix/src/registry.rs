//! The tables there are: one line for each category.

use super::categories::*;
use super::expansion::Expansion;
use super::field::elements;
use super::record::SENDER;
use super::table::{Category, Edition};

/// Every table, by category. The first of a category is its default edition.
#[rustfmt::skip]
pub static REGISTRY: &[&Category] = &[
    &CAT001_V1_4, &CAT001_V1_3, &CAT001_V1_2,
    &CAT002_V1_2, &CAT002_V1_1, &CAT002_V1_0,
    &CAT010_V1_1,
    &CAT019_V1_3,
    &CAT020_V1_9, &CAT020_V1_10, &CAT020_V1_11,
    &CAT021_V2_4, &CAT021_V2_1, &CAT021_V2_2, &CAT021_V2_3, &CAT021_V2_5, &CAT021_V2_6, &CAT021_V2_7,
    &CAT021_V0_23, &CAT021_V0_24, &CAT021_V0_25, &CAT021_V0_26,
    &CAT023_V1_3, &CAT023_V1_2,
    &CAT034_V1_29, &CAT034_V1_28, &CAT034_V1_27,
    &CAT048_V1_31, &CAT048_V1_32, &CAT048_V1_30, &CAT048_V1_29, &CAT048_V1_28, &CAT048_V1_27,
    &CAT062_V1_18, &CAT062_V1_21, &CAT062_V1_20, &CAT062_V1_19, &CAT062_V1_17, &CAT062_V1_16,
    &CAT063_V1_6, &CAT063_V1_7,
    &CAT065_V1_5, &CAT065_V1_6, &CAT065_V1_4,
];

/// What is known of the content of reserved expansion fields.
#[rustfmt::skip]
pub static EXPANSIONS: &[&Expansion] = &[
    &CAT021_RE_V1_4, &CAT021_RE_V1_5,
    &CAT048_RE_V1_11, &CAT048_RE_V1_12, &CAT048_RE_V1_13,
    &CAT062_RE_V1_2, &CAT062_RE_V1_3,
];

const _: () = {
    let mut i = 0;
    while i < REGISTRY.len() {
        let sender = elements(&[REGISTRY[i]], "010", ["SAC", "SIC"]);
        assert!(sender.item.0 == SENDER.0, "the sender is not the first item");
        let [sac, sic] = sender.fields;
        assert!(
            sac.byte == 0 && sac.bits == 8 && sic.byte == 1 && sic.bits == 8,
            "the sender is not two octets"
        );
        i += 1;
    }
};

/// The table of one edition.
pub fn find(number: u8, edition: Edition) -> Option<&'static Category> {
    editions(number).find(|table| table.edition == edition)
}

/// What a category's reserved expansion field holds in one edition of its coding rules.
pub fn find_expansion(number: u8, edition: Edition) -> Option<&'static Expansion> {
    let is_it = |expansion: &&&Expansion| expansion.number == number && expansion.edition == edition;
    EXPANSIONS.iter().find(is_it).copied()
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
