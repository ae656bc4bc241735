//! The fields fusion needs, read straight from the octets of a [`Record`](super::Record): SI units, no allocation.
//!
//! One module for each category, or for the editions of one that are laid out alike; it reads every edition there is a
//! table for, and says where they differ. What all of them have in common, positions, velocities, codes, is in
//! [`fields`]. Every field is an `Option`: `None` where the record does not carry the item. A reader gives `None` for a
//! record of another table, or of another message type.
//!
//! These readers write down LSBs a second time, beside the tables. The two are compared over whole recordings and
//! over random records of every edition in the tests; that is what makes the comparison worth something.

pub mod cat001;
pub mod cat002;
pub mod cat010;
pub mod cat019;
pub mod cat020;
pub mod cat021_v0;
pub mod cat021_v2;
pub mod cat023;
pub mod cat034;
pub mod cat048;
pub mod cat062;
pub mod cat063;
pub mod cat065;
pub mod fields;

mod subitems;
