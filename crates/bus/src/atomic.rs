//! The words of shared memory, and their fences.
//!
//! The protocols of shared memory (`sends`, `last_words`, `ring`) take both from here, and from nowhere else: the
//! workspace `models` compiles the same files with words whose orders of operations are all tried.

pub(crate) use std::sync::atomic::{AtomicU64, fence};
