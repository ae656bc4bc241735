//! Room for a comparison of mean innovations.

use source_models::MeanInnovation;

use crate::tables::sensor_tracks::SensorSlot;

/// Room for the means of a target's sensor tracks while these are compared.
#[derive(Debug, Default)]
pub(crate) struct ComparedMeans {
    pub(super) means: Vec<MeanInnovation>,
    pub(super) members: Vec<SensorSlot>,
}

impl ComparedMeans {
    /// Room for a sensor track of each source.
    pub(crate) fn new(sources: usize) -> Self {
        Self {
            means: Vec::with_capacity(sources),
            members: Vec::with_capacity(sources),
        }
    }
}
