//! The tracker over many scans.

mod allocation;
