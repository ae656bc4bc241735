//! Associate: assignment of sensor tracks to system tracks.

pub(crate) mod association_step;
pub(crate) mod crossing;
pub(crate) mod identity;
pub(crate) mod joining;
pub(crate) mod linking;
pub(crate) mod namesakes;
pub(crate) mod recognising;
pub(crate) mod recognition;
pub(crate) mod resumption;
pub(crate) mod scan;
