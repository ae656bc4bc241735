//! Earlier copies of the values learned from innovations, for the time after a step of the systematic errors of a
//! source.
//!
//! The innovations between a step and its detection are large, and so are the innovations of misled filters. Such
//! innovations are no evidence of too small covariances, nor of manoeuvres. Without this memory the changed source
//! would weigh too little for a minute, and all filters would smooth less for longer.

use serde::{Deserialize, Serialize};

use crate::manoeuvres::{CLASSES, Class, Manoeuvres};
use crate::seeker::Seeker;
use crate::source_model::SourceModel;

/// Ticks between two copies. The older copy precedes a newly found step.
const EVERY_TICKS: u8 = 8;

/// Two copies of the covariance scales of all sources, and of the manoeuvres of all classes of targets.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct StepMemory {
    scales: [Vec<Seeker>; 2],
    classes: [Option<[Class; CLASSES]>; 2],
    ticks: u8,
}

impl StepMemory {
    pub(crate) fn new(sources: usize) -> Self {
        Self {
            scales: std::array::from_fn(|_| vec![Seeker::default(); sources]),
            classes: [None; 2],
            ticks: 0,
        }
    }

    /// Copies if due; to be called once per tick.
    pub(crate) fn look(&mut self, models: &[SourceModel], manoeuvres: &mut Manoeuvres) {
        self.ticks += 1;
        if self.ticks < EVERY_TICKS {
            return;
        }
        self.ticks = 0;
        self.scales.swap(0, 1);
        for (kept, model) in self.scales[1].iter_mut().zip(models) {
            *kept = model.covariance_scale;
        }
        self.classes = [self.classes[1], Some(*manoeuvres.classes_mut())];
    }

    /// Restores the values learned before a newly found step.
    pub(crate) fn restore(&mut self, models: &mut [SourceModel], manoeuvres: &mut Manoeuvres) {
        let [older, newer] = &mut self.scales;
        for (model, kept) in models.iter_mut().zip(older.iter()) {
            model.covariance_scale = *kept;
        }
        newer.copy_from_slice(older);
        if let Some(classes) = self.classes[0] {
            *manoeuvres.classes_mut() = classes;
            self.classes[1] = self.classes[0];
        }
        self.ticks = 0;
    }
}
