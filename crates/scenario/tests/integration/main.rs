//! Integration tests of the simulated world and its sensors.

mod no_allocation;
mod replies;
mod resolution;
mod sensors;
mod wide_area;
