//! Tests of the ASTERIX codec through its public interface.

#[path = "../any_bytes/mod.rs"]
mod any_bytes;
mod canonical;
mod decoder;
mod encoding;
mod encoding_errors;
mod errors;
mod expansions;
mod fields;
#[path = "../files/mod.rs"]
mod files;
mod generator;
mod item_kinds;
mod mutated;
mod properties;
mod round_trip;
mod sample;
mod specs;
mod tables;
mod values;
