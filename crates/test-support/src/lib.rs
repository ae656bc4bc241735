//! Tools of tests that more than one crate needs. No product code depends on this crate.

#![forbid(unsafe_code)]

mod golden;
mod mutated;
pub mod page;
mod random;
mod recordings;
mod table;

pub use golden::{Digest, assert_golden};
pub use mutated::{Dice, mutated};
pub use random::Random;
pub use recordings::{recording, recordings};
pub use table::{MIDNIGHT_S, column, numbers, places, rows, since_1970};

/// Nanoseconds in a second.
pub const S: i64 = 1_000_000_000;
