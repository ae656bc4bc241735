//! Protocols of shared memory, checked in all orders of operations.
//!
//! The files of the protocols are those of the crates: only the words are others.

#![cfg(test)]

mod atomic;
mod hint;
#[path = "../../crates/bus/src/last_words.rs"]
#[expect(dead_code, reason = "what only the crate needs")]
mod last_words;
mod line;
mod log;
mod outlasting;
#[path = "../../crates/kept/src/record.rs"]
#[allow(unfulfilled_lint_expectations, reason = "what is public in the crate only")]
mod record;
#[path = "../../crates/bus/src/ring.rs"]
#[expect(dead_code, reason = "what only the crate needs")]
mod ring;
#[path = "../../crates/bus/src/sends.rs"]
mod sends;
