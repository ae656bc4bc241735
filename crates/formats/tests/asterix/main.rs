//! Tests of the ASTERIX codec through its public interface.

mod agreement;
mod allocation;
#[path = "../any_bytes/mod.rs"]
mod any_bytes;
mod canonical;
mod decoder;
mod encoding;
mod encoding_errors;
mod errors;
mod expansions;
#[path = "../files/mod.rs"]
mod files;
mod generator;
mod item_kinds;
mod properties;
mod recordings;
mod reports;
mod round_trip;
mod sample;
mod tables;
mod values;
