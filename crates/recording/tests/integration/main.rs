//! Recordings of all topics, sound and damaged.

mod damaged;
mod files;
