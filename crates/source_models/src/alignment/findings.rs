//! Findings of the search on two sources: one estimate per hypothesis.
//!
//! A hypothesis is a kind of bias on one side of the pair. An azimuth or a range bias depends on the position of the
//! sensor, so that both sides are tried. A time or place bias of the first source equals that of the second source with
//! the opposite sign, so that one side is enough.

use kept::kept;
use messages::BiasKind;
use serde::{Deserialize, Serialize};

/// Chi-square with four degrees of freedom beyond which two tracks belong to different targets.
pub(super) const GATE: f64 = 20.0;
/// Number of collections that confirm a bias.
pub(super) const WINDOWS_MIN: u32 = 2;
/// Hypotheses: the erring source of the pair, and the kind of bias.
pub(super) const HYPOTHESES: [(Side, BiasKind); 6] = [
    (Side::First, BiasKind::Azimuth),
    (Side::First, BiasKind::Range),
    (Side::First, BiasKind::Time),
    (Side::First, BiasKind::Position),
    (Side::Second, BiasKind::Azimuth),
    (Side::Second, BiasKind::Range),
];
/// Width of a bin of each kind, in the unit of the kind. Values that differ by up to twice this width are the same.
pub(super) const fn bin(kind: BiasKind) -> f64 {
    match kind {
        BiasKind::Azimuth => 0.0025,
        BiasKind::Range => 100.0,
        BiasKind::Time => 1.0,
        BiasKind::Position => 200.0,
    }
}

/// Erring source of a pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) enum Side {
    First,
    Second,
}

kept!(BiasEstimate {
    value: [f64; 2],
    score: f64,
    windows: u32
});
kept!(PairFindings {
    estimates: [BiasEstimate; HYPOTHESES.len()],
    agree: bool,
    disagree: bool,
    addresses: u32
});

/// Estimate of a kind of bias between two sources, over consecutive confirming collections.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(super) struct BiasEstimate {
    /// Radians, metres or seconds, by the kind.
    pub(super) value: [f64; 2],
    /// Number of explained tracks, each reduced by its distance.
    pub(super) score: f64,
    /// Collections that confirmed the value.
    pub(super) windows: u32,
}

/// Findings on two sources.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(crate) struct PairFindings {
    pub(super) estimates: [BiasEstimate; HYPOTHESES.len()],
    /// Whether the two sources agree without a bias.
    pub(super) agree: bool,
    /// Whether few tracks of the two sources fit without a bias.
    pub(super) disagree: bool,
    /// Pairs of tracks with the same address that fit with the bias.
    pub(super) addresses: u32,
}

impl PairFindings {
    /// Whether the two sources seemed to differ.
    pub(super) fn is_open(&self) -> bool {
        self.disagree || self.estimates.iter().any(|estimate| estimate.windows > 0)
    }

    /// Index of the confirmed hypothesis with the highest score.
    pub(super) fn best(&self) -> Option<usize> {
        let believed = (0..HYPOTHESES.len()).filter(|h| self.estimates[*h].windows >= WINDOWS_MIN);
        believed.max_by(|a, b| self.estimates[*a].score.total_cmp(&self.estimates[*b].score))
    }
}
