//! Tests of what is sent, through the public interface and the crate's own decoder.

mod allocation;
mod blocks;
mod bytes;
mod model;
mod reading;
mod sensors;
mod status;
mod system;
