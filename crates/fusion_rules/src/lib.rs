//! Rules that weigh the contributions to a target, and what the rules read: states, histories of reports, accuracy
//! values and quality indices (TI-4 to TI-7, QF).
//!
//! The engine lets the configured rule weigh; the display lets all of them weigh the same contributions
//! ([`comparison`]). No rule knows a track of the engine.

#![forbid(unsafe_code)]

pub mod accuracy;
pub mod candidate;
pub mod comparison;
pub mod gross;
pub mod history;
pub mod places;
pub mod quality;
pub mod rules;
pub mod state;
#[cfg(test)]
mod testing;

pub use fusion_settings as settings;
pub use state::State;
