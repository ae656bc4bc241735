//! State of a stepwise solution for the errors of all sources.

use nalgebra::{Cholesky, Const};
use serde::{Deserialize, Serialize};

use crate::registration::errors::{SAMPLES_MIN, SourceErrors};
use crate::registration::model::BiasModel;
use crate::registration::rows::ERRORS;

/// Least number of samples of a source for the judgement of other sources' models by comparison.
pub(super) const SETTLED_MIN: f64 = 2.0 * SAMPLES_MIN;

/// A solution in progress.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct SolutionProgress {
    /// Next sweep and source; `None` if no solution is in progress.
    pub(super) next: Option<(usize, usize)>,
    /// Ticks since the beginning of the solution before.
    pub(super) ticks: i32,
    pub(super) sources: Vec<SourceErrors>,
    /// Factored normal equations of each source, set in the first sweep.
    pub(super) factors: Vec<Option<Cholesky<f64, Const<ERRORS>>>>,
    /// Change of a model with the greatest gain of evidence, and this gain.
    pub(super) best: Option<(f64, usize, BiasModel)>,
    /// Rotation for which each source votes, set with the comparison of its models.
    pub(super) votes: Vec<Vote>,
}

impl SolutionProgress {
    pub(super) fn new(sources: usize) -> Self {
        Self {
            next: None,
            ticks: 0,
            sources: vec![SourceErrors::unknown(); sources],
            factors: vec![None; sources],
            best: None,
            votes: vec![Vote::None; sources],
        }
    }
}

/// Rotation that a source has in common with the frame, radians; 0 for the present frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) enum Vote {
    /// Too few comparisons.
    None,
    /// A rotation, and an offset.
    Free(f64),
    /// No offset: a rotation about the known position of the sensor alone, or none.
    Fixed(f64),
}

impl Vote {
    /// Returns the rotation; `None` without a vote.
    pub(super) fn turn(self) -> Option<f64> {
        match self {
            Self::None => None,
            Self::Free(turn) | Self::Fixed(turn) => Some(turn),
        }
    }

    /// Returns the rotation of a source with an offset.
    pub(super) fn free(self) -> Option<f64> {
        if let Self::Free(turn) = self { Some(turn) } else { None }
    }
}
