//! Where a transmitter is, from bearings alone (EL).

#![forbid(unsafe_code)]

pub mod music;
