//! Protocols of shared memory, checked in all orders of operations.

#![cfg(test)]

mod hint;
#[path = "../../crates/bus/src/sends.rs"]
mod sends;
