//! `system-filter`: one filter per target, fed with the measurements behind the sensor tracks (BF-1).
//!
//! Sensor tracks of a target have correlated errors: each repeats its own past, and all lag behind the same
//! manoeuvre. Instead of modelling the correlation, the engine undoes the sources' filters if possible, and filters
//! their measurements, with independent errors, again: the estimate of a central tracker with all sensors'
//! measurements. See the modules `filter` and `source_model`.
//!
//! Shares are the contributions of sources to the present estimate: a measurement with gain g takes g of everything
//! and leaves 1 − g to earlier measurements.

use super::{Candidate, RuleEntry, RuleMethod, Share};

pub(super) const ENTRY: RuleEntry = RuleEntry {
    code: messages::FusionRule::SystemFilter,
    summary: "one Kalman filter per target over the measurements behind all sensor tracks",
    assumption: "measurement errors are independent between sources and in time, once the sources' filters are undone",
    claims_consistency: true,
    keeps_points: false,
    chooses_by_accuracy: false,
    method: RuleMethod::Filter,
};

/// Fills a share per candidate, at least one.
pub(super) fn share_out(candidates: &[Candidate], shares: &mut [Share]) {
    let total: f64 = candidates.iter().map(|candidate| candidate.filter_share).sum();
    let even = 1.0 / candidates.len() as f64;
    for (share, candidate) in shares.iter_mut().zip(candidates) {
        let weight = if total > 0.0 {
            (candidate.filter_share / total).min(1.0)
        } else {
            even
        };
        *share = Share {
            weight: [weight; 3],
            accuracy: candidate.lambda,
            ..Share::default()
        };
    }
}
