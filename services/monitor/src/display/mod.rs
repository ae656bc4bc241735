//! Display of a deployment while it runs: at the terminal of `koseki demo` and `koseki up`, and in `koseki top`.
//!
//! | module | purpose |
//! |---|---|
//! | `overview` | state of a deployment at the end of an interval |
//! | `tracks` | latest states of the system tracks, and their rows |
//! | `pages` | turns an overview into lines of text: pure functions |
//! | `columns` | tables that leave out columns to fit |
//! | `view` | choice made by the keys: page, row, span |
//! | `draw` | lines onto a screen: a pure function of overview and view |
//!
//! A terminal may be small. Text longer than a line would wrap, and push the lines above out of sight. Nothing here
//! wraps: the least important columns are left out, and the rest is cut at the margin.

pub(crate) mod columns;
pub(crate) mod draw;
pub(crate) mod overview;
pub(crate) mod pages;
#[cfg(test)]
pub(crate) mod sample;
pub(crate) mod tracks;
pub(crate) mod view;
