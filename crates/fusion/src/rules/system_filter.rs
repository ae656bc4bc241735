//! `system-filter`: one filter per target, fed with the measurements behind the sensor tracks (BF-1).
//!
//! Sensor tracks of one target have correlated errors: each repeats its own past, and all lag behind the same manoeuvre.
//! Instead of modelling the correlation, the engine undoes the sources' filters where it can, and filters their
//! measurements, whose errors are independent, once more by itself: the estimate that one central tracker with all
//! sensors' measurements would have. See the modules `filter` and `source_model`.
//!
//! Shares are what each source contributed to the present estimate: a measurement with gain g takes g of everything and
//! leaves 1 − g to those before it.

use super::{Memory, RuleEntry, Share, Target};
use crate::settings::RuleSettings;
use crate::state::State;

pub(super) const ENTRY: RuleEntry = RuleEntry {
    name: "system-filter",
    summary: "one Kalman filter per target over the measurements behind all sensor tracks",
    assumption: "measurement errors are independent between sources and in time, once the sources' filters are undone",
    claims_consistency: true,
    keeps_points: false,
    from_filter: true,
    fuse,
};

pub(super) fn fuse(_: &RuleSettings, target: &Target<'_>, memory: &mut Memory, shares: &mut [Share]) -> Option<State> {
    let total: f64 = target.candidates.iter().map(|candidate| candidate.filter_share).sum();
    let even = 1.0 / target.candidates.len() as f64;
    let mut heaviest: Option<(f64, u16)> = None;
    for (share, candidate) in shares.iter_mut().zip(target.candidates) {
        let weight = if total > 0.0 {
            (candidate.filter_share / total).min(1.0)
        } else {
            even
        };
        share.weight = [weight; 3];
        if heaviest.is_none_or(|(most, _)| weight > most) {
            heaviest = Some((weight, candidate.source));
        }
    }
    if let Some((_, source)) = heaviest {
        memory.selected = [source; 3];
    }
    target.filtered.copied()
}
