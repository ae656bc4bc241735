//! Publish: weights, states and owners of system tracks, as messages.

pub(crate) mod border;
pub(crate) mod outlet;
pub(crate) mod publishing;
pub(crate) mod system_track_message;
pub(crate) mod weighing;
