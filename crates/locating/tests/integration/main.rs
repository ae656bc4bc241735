//! The locator and the measurement of bearings, from outside.

mod allocation;
mod arrivals;
mod bad_input;
mod bound;
mod common;
mod fixes;
mod keys;
mod music;
