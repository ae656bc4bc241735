//! Tests of the ASTERIX codec through its public interface.

mod agreement;
mod allocation;
mod decoder;
mod errors;
mod expansions;
mod generator;
mod item_kinds;
mod properties;
mod recordings;
mod reports;
mod sample;
mod tables;
