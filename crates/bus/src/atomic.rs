//! The words of shared memory, and the fences.
//!
//! The protocols of shared memory (`sends`, `last_words`, `ring`) take both from here, and from nowhere else: the
//! workspace `models` compiles the same files with words that try all orders of operations.

pub(crate) use std::sync::atomic::{AtomicU64, fence};
