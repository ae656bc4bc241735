//! `auto`: the best rule without knowledge of the data; the default.
//!
//! This rule is the system filter with corrections: biases of the sources are removed, optimistic covariances are
//! scaled, and if sources observe different points of large targets, a single reference point is kept per target
//! instead of an average. As in `best-source`, this is the point of the source that has tracked the target longest,
//! while the measurements of other sources, moved to this point, continue to improve the position. See the module
//! `reference_point`.
//!
//! The rule has no threshold on a position or a speed: the distance of the detection points, relative to the sources'
//! own measurement errors, decides whether points are kept.

use super::{RuleEntry, RuleMethod};

pub(super) const ENTRY: RuleEntry = RuleEntry {
    code: messages::FusionRule::Auto,
    summary: "the system filter, keeping one point of each target where the sources see different ones",
    assumption: "as system-filter; differences that persist are systematic errors or detection points, not noise",
    claims_consistency: true,
    keeps_points: true,
    chooses_by_accuracy: false,
    method: RuleMethod::Filter,
};
