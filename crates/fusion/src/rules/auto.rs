//! `auto`: the best there is without knowing the data; the default.
//!
//! It is the system filter with its eyes open. The sources' systematic errors are taken off, covariances that claim too
//! much are inflated, and where the sources turn out to see different points of large targets, one point is kept per
//! target instead of being averaged away: that of the source which has followed the target longest, as `best-source`
//! would, but with the other sources' measurements, moved to that point, still improving it. See the module `feeding`.
//!
//! Nothing in it is a threshold on a position or a speed: whether points are kept is decided by how far the detection
//! points lie apart, compared with the sources' own measurement errors.

use super::{Method, RuleEntry};

pub(super) const ENTRY: RuleEntry = RuleEntry {
    code: messages::FusionRule::Auto,
    summary: "the system filter, keeping one point of each target where the sources see different ones",
    assumption: "as system-filter; differences that persist are systematic errors or detection points, not noise",
    claims_consistency: true,
    keeps_points: true,
    method: Method::Filter,
};
