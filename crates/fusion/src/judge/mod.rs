//! Judge: whether there is a target, and how long its track lives.

pub(crate) mod existence;
pub(crate) mod life;
