//! Rules for weighing the contributions to a target, and the inputs of the rules: states, histories of reports,
//! accuracy values and quality indices (TI-4 to TI-7, QF).
//!
//! The engine applies the configured rule; the display applies all rules to the same contributions ([`comparison`]).
//! No rule has access to a track of the engine.

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
