//! Which report belongs to which track.
//!
//! Comparing each report with every track is simple and, at 10,000 tracks, hopeless. [`Grid`] finds the few tracks
//! near a place in a time that does not depend on how many there are (PL-7, QF-1); [`distance`] then says how
//! surprising it would be if the report belonged to one of them, and [`assignment`] decides for all reports of a scan
//! together (BF-2). [`augmenting`] is the solver that every assignment problem of the project uses.

#![forbid(unsafe_code)]

pub mod assignment;
pub mod augmenting;
pub mod components;
pub mod distance;
mod grid;

pub use grid::Grid;
