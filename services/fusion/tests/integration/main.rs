//! The agent of fusion over an in-process bus.

mod agent;
mod allocation;
mod smoothing;
