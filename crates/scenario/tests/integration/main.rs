//! The simulated world and its sensors, from outside.

mod no_allocation;
mod resolution;
mod sensors;
mod wide_area;
