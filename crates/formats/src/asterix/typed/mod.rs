//! The fields fusion needs, read straight from the octets of a [`Record`](super::Record): SI units, no allocation.
//!
//! One module for each edition of a category, since a field's place, width and meaning are the edition's. What all
//! of them have in common, positions, velocities, codes, is in [`fields`]. Every field is an `Option`: `None` where
//! the record does not carry the item. A reader gives `None` for a record of another table, or of another message
//! type.
//!
//! These readers write down LSBs a second time, beside the tables. The two are compared over whole recordings and
//! over random records in the tests; that is what makes the comparison worth something.

pub mod cat010;
pub mod cat019;
pub mod cat020;
pub mod cat021_v0_23;
pub mod fields;
