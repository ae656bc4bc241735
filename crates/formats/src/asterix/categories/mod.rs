//! The tables: one file for each category, with all its editions.
//!
//! Item numbers, titles, element names, widths and LSBs are those of the document; enumerated values are summed up
//! behind their element. Where a table departs from a published layout on purpose, a comment says so and why.
//!
//! An item that changed has a constant for each of its layouts: the one without edition in its name is that of the
//! first edition here, and `I020_V1_31` is item 020 from ed 1.31 on. At the end of a file each edition is put together
//! from its items, so that the last lines show in what the editions differ.

mod cat010;
mod cat019;
mod cat020;
mod cat021;
mod cat034;
mod cat048;
mod cat062;
mod cat063;
mod cat065;

pub use cat010::*;
pub use cat019::*;
pub use cat020::*;
pub use cat021::*;
pub use cat034::*;
pub use cat048::*;
pub use cat062::*;
pub use cat063::*;
pub use cat065::*;

use crate::asterix::table::{Item, Layout};

const RE: Item = Item::new("RE", "Reserved Expansion Field", Layout::Explicit);
const SP: Item = Item::new("SP", "Special Purpose Field", Layout::Explicit);

/// The profiles, for the constants of the typed readers.
pub(super) mod uap {
    use crate::asterix::table::Uap;

    pub(in crate::asterix) const CAT010_V1_1: &Uap = super::CAT010_V1_1.uap();
    pub(in crate::asterix) const CAT019_V1_3: &Uap = super::CAT019_V1_3.uap();
    pub(in crate::asterix) const CAT020_V1_9: &Uap = super::CAT020_V1_9.uap();
    pub(in crate::asterix) const CAT021_V0_23: &Uap = super::CAT021_V0_23.uap();
}
