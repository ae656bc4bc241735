//! Tables by category and edition.

use super::expansion::Expansion;
use super::field::{elements, whole};
use super::record::SENDER;
use super::table::{Category, Edition};

pub use super::categories::{EXPANSIONS, REGISTRY, WITHOUT_TABLE};

// Checks assumptions about every table: the sender is the first item, and times of day have the same form.
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
        let times = REGISTRY[i].times;
        let mut j = 0;
        while j < times.len() {
            let [time] = whole(&[REGISTRY[i]], times[j]).fields;
            assert!(
                time.bits == 24 && time.lsb == 1.0 / 128.0,
                "a time of day is in ticks of 1/128 s"
            );
            j += 1;
        }
        i += 1;
    }
};

/// Fails the build where one of these editions is not in the registry.
pub(crate) const fn assert_registered(editions: &[&Category]) {
    let mut i = 0;
    while i < editions.len() {
        let (number, edition) = (editions[i].number, editions[i].edition);
        let mut j = 0;
        while REGISTRY[j].number != number
            || REGISTRY[j].edition.major != edition.major
            || REGISTRY[j].edition.minor != edition.minor
        {
            j += 1;
            assert!(j < REGISTRY.len(), "an edition is not in the registry");
        }
        i += 1;
    }
}

// A category has a table, or a name alone.
const _: () = {
    let mut i = 0;
    while i < WITHOUT_TABLE.len() {
        let mut j = 0;
        while j < REGISTRY.len() {
            assert!(WITHOUT_TABLE[i].0 != REGISTRY[j].number, "a category has a table");
            j += 1;
        }
        i += 1;
    }
};

/// What the blocks of a category without a table hold, in a few words; `None` for categories with a table, and for
/// numbers that are not known.
pub fn name_without_table(number: u8) -> Option<&'static str> {
    let named = WITHOUT_TABLE.iter().find(|(of, _)| *of == number);
    named.map(|(_, name)| *name)
}

/// The table of one edition.
pub fn find(number: u8, edition: Edition) -> Option<&'static Category> {
    editions(number).find(|table| table.edition == edition)
}

/// Coding rules of a category's reserved expansion field in one edition.
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
