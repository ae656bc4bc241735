//! Judge: existence of targets, and life times of tracks.

pub(crate) mod existence;
pub(crate) mod life;
