//! Association of reports with tracks.
//!
//! Comparing each report with every track is simple but too slow at 10,000 tracks. [`Grid`] finds the few tracks near
//! a place in a time independent of the number of tracks (PL-7, QF-1). [`distance`] then measures the improbability of
//! each pair, and [`assignment`] decides for all reports of a scan together (BF-2). [`augmenting`] is the solver for
//! every assignment problem of the project.

#![forbid(unsafe_code)]

pub mod assignment;
pub mod augmenting;
pub mod components;
pub mod distance;
mod grid;

pub use grid::{Grid, floor};
