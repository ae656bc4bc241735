//! The locator and the measurement of bearings, from outside.

mod allocation;
mod bad_input;
mod bound;
mod common;
mod keys;
mod music;
