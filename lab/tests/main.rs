//! Tests of `koseki bench` and `koseki torture`, as a user starts them.
//!
//! The executable `koseki` is taken from `$KOSEKI`, or from the target folder of the repository.

mod common;

mod bench;
mod documents;
mod missing;
mod torture;
