//! The tables of sensor tracks and system tracks, linked with each other.

pub(crate) mod description;
pub(crate) mod former_members;
pub(crate) mod number_hasher;
pub(crate) mod quota;
pub(crate) mod sensor_tracks;
pub(crate) mod silent_tracks;
pub(crate) mod system_tracks;
pub(crate) mod tracks;
