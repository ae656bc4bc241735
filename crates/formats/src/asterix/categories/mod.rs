//! The tables: one file for each edition of a category, named after both.
//!
//! Item numbers, titles, element names, widths and LSBs are those of the document; enumerated values are summed up
//! behind their element. Where a table departs from a published layout on purpose, a comment says so and why.

mod cat010_v1_1;
mod cat019_v1_3;
mod cat020_v1_9;
mod cat021_v0_23;

pub use cat010_v1_1::CAT010_V1_1;
pub use cat019_v1_3::CAT019_V1_3;
pub use cat020_v1_9::CAT020_V1_9;
pub use cat021_v0_23::CAT021_V0_23;

/// The profiles, for the constants of the typed readers.
pub(super) mod uap {
    pub(in crate::asterix) use super::cat010_v1_1::UAP as CAT010_V1_1;
    pub(in crate::asterix) use super::cat019_v1_3::UAP as CAT019_V1_3;
    pub(in crate::asterix) use super::cat020_v1_9::UAP as CAT020_V1_9;
    pub(in crate::asterix) use super::cat021_v0_23::UAP as CAT021_V0_23;
}
