//! The bus as other crates use it: both transports, real processes, bare ports.

mod allocation;
mod bare;
mod common;
mod conformance;
mod intruders;
mod lines;
mod processes;
mod queues;
