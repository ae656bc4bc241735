//! Display of a deployment while it runs: at the terminal of `koseki demo` and `koseki up`, and in `koseki top`.
//!
//! | module | purpose |
//! |---|---|
//! | `overview` | state of a deployment at the end of an interval |
//! | `tracks` | latest states of the system tracks, and rows of them |
//! | `pages` | turns an overview into lines of text: pure functions |
//! | `columns` | tables that give up columns until they fit |
//! | `view` | what the keys have chosen to see: page, row, span |
//! | `draw` | lines onto a screen: a pure function of overview and view |
//!
//! A terminal may be small. Text that is longer than a line would wrap, and push what stands above it out of sight, so
//! nothing here does: the columns that matter least are left out, and what is left is cut at the margin.

pub(crate) mod columns;
pub(crate) mod draw;
pub(crate) mod overview;
pub(crate) mod pages;
#[cfg(test)]
pub(crate) mod sample;
pub(crate) mod tracks;
pub(crate) mod view;
