//! Significance of the estimated errors: the choice of errors to remove from the reports of the source.
//!
//! Removal of an error begins at a squared statistical length far beyond chance, and ends at a length within chance.
//! The means of the detection points over the targets add to the variance. A range or azimuth bias is removed as soon
//! as the evidence selects a model with this bias (module `model`).
//!
//! If all targets fly in parallel, an offset along the way and a time offset displace all reports alike. Neither is
//! significant alone, while the joint displacement is (module `displacement`). Both are then removed together: the
//! reports are right for any split of the displacement.

use crate::registration::displacement::Displacement;
use crate::registration::errors::{SAMPLES_MIN, SourceErrors};
use crate::registration::model::BiasModel;
use crate::registration::rows::{AZIMUTH, RANGE, TIME};

/// Chi-square with two degrees of freedom above which a horizontal offset is removed, and below which removal stops.
const SIGNIFICANT_2: f64 = 13.8;
const INSIGNIFICANT_2: f64 = 2.8;
/// Chi-square with one degree of freedom, likewise, for height and time offset.
const SIGNIFICANT_1: f64 = 10.8;
const INSIGNIFICANT_1: f64 = 1.6;

/// Variances that the detection points add to a mean over all targets.
pub(crate) struct PointsVariance {
    /// Per axis, m².
    pub(crate) offset_m2: f64,
    /// In the time offset, s². Infinite if the points are known to lie far apart: a point ahead of the others looks
    /// like a fast clock.
    pub(crate) time_s2: f64,
}

/// Decides the significance of the errors of one source: the horizontal offset jointly, the others separately.
pub(super) fn decide(known: &mut SourceErrors, points: &PointsVariance, displacement: &Displacement) {
    let enough = known.samples >= SAMPLES_MIN;
    let squared = |row: usize, extra: f64| known.errors[row] * known.errors[row] / (known.variances[row] + extra);
    let is_joint = points.time_s2.is_finite()
        && known.model == BiasModel::OFFSET
        && displacement.confounds_time(known.variances[TIME]);
    let horizontal = match is_joint {
        true => displacement.squared_length(&known.errors, points.offset_m2),
        false => squared(0, points.offset_m2) + squared(1, points.offset_m2),
    };
    let apart_s = known.errors[TIME] - known.stamps.mean_s;
    let time = apart_s * apart_s / (known.variances[TIME] + points.time_s2);
    let values = [horizontal, horizontal, squared(2, 0.0), time];
    for (row, (removed, value)) in known.removed.iter_mut().zip(values).enumerate() {
        let limit = match (row < 2, *removed) {
            (true, false) => SIGNIFICANT_2,
            (true, true) => INSIGNIFICANT_2,
            (false, false) => SIGNIFICANT_1,
            (false, true) => INSIGNIFICANT_1,
        };
        *removed = enough && value > limit;
    }
    if is_joint {
        known.removed[TIME] = known.removed[0];
    }
    for row in [RANGE, AZIMUTH] {
        known.removed[row] = enough && known.model.estimates(row);
    }
    if known.model.is_polar() && known.model.has_offset() {
        // The offset belongs to the rotation.
        known.removed[..2].fill(enough);
    }
}
