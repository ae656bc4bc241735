//! The words of memory that outlasts its process.
//!
//! The protocol of records takes them from here, and from nowhere else: the workspace `models` compiles the same file
//! with words whose orders of operations are all tried.

pub(crate) use std::sync::atomic::AtomicU64;
