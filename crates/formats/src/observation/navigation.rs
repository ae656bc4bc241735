//! Navigation accuracy as aircraft state it: small numbers that stand for radii.
//!
//! Aircraft of the first generation send an uncertainty category for position (NUCp); later ones an accuracy category
//! (NACp), the radius that holds 95 % of the errors, beside an integrity category (NIC) and level (SIL): a radius that
//! an undetected error exceeds with a probability of 10⁻³ to 10⁻⁷ an hour. All of them send a category for velocity
//! (NUCr, later NACv).
//!
//! A standard deviation follows from the accuracy category alone: the radius by 2.45, the ratio of a circular normal
//! distribution. The integrity bounds faults of satellites and receivers; errors without a fault are several times
//! smaller than any share of its radius, and no distribution leads from one to the other. The integrity decides where
//! the accuracy is missing: with a bound, the position is as good as the configuration assumes of the source; without
//! a bound, its accuracy is unknown.
//!
//! Source: RTCA DO-260B (EUROCAE ED-102A), 2.2.3.2.7.

use asterix::field::NAUTICAL_MILE_M;
use observations::{Quality, RADIUS95_SIGMAS};

/// Radius of 95 % containment for a navigation uncertainty category (NUCp): RTCA DO-260, table of horizontal position
/// error.
pub(super) fn radius_of_nucp(category: u8) -> Quality {
    match category {
        9 => Quality::Radius95(3.0),
        8 => Quality::Radius95(10.0),
        7 => Quality::Radius95(0.05 * NAUTICAL_MILE_M),
        6 => Quality::Radius95(0.1 * NAUTICAL_MILE_M),
        5 => Quality::Radius95(0.25 * NAUTICAL_MILE_M),
        4 => Quality::Radius95(0.5 * NAUTICAL_MILE_M),
        3 => Quality::Radius95(NAUTICAL_MILE_M),
        2 => Quality::Radius95(5.0 * NAUTICAL_MILE_M),
        1 => Quality::Radius95(10.0 * NAUTICAL_MILE_M),
        _ => Quality::Unknown,
    }
}

/// Returns the covariance of a velocity category, NUCr or NACv: RTCA DO-260, DO-260A and DO-260B define the same
/// horizontal 95 % errors for both. `None` for the category "unknown".
pub(crate) fn covariance_of_velocity_category(category: u8) -> Option<[f64; 3]> {
    let error_mps = match category {
        4 => 0.3,
        3 => 1.0,
        2 => 3.0,
        1 => 10.0,
        _ => return None,
    };
    let variance = (error_mps / RADIUS95_SIGMAS).powi(2);
    Some([variance, 0.0, variance])
}

/// Radius of 95 % containment for a navigation accuracy category (NACp): RTCA DO-260B, table of the estimated position
/// uncertainty.
pub(crate) fn radius_of_nacp(category: u8) -> Quality {
    match category {
        11 => Quality::Radius95(3.0),
        10 => Quality::Radius95(10.0),
        9 => Quality::Radius95(30.0),
        8 => Quality::Radius95(0.05 * NAUTICAL_MILE_M),
        7 => Quality::Radius95(0.1 * NAUTICAL_MILE_M),
        6 => Quality::Radius95(0.3 * NAUTICAL_MILE_M),
        5 => Quality::Radius95(0.5 * NAUTICAL_MILE_M),
        4 => Quality::Radius95(NAUTICAL_MILE_M),
        3 => Quality::Radius95(2.0 * NAUTICAL_MILE_M),
        2 => Quality::Radius95(4.0 * NAUTICAL_MILE_M),
        1 => Quality::Radius95(10.0 * NAUTICAL_MILE_M),
        _ => Quality::Unknown,
    }
}

/// Integrity of a position: category of the containment radius (NIC), and level of the probability that the error
/// exceeds the radius (SIL), if stated.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Integrity {
    pub(crate) category: u8,
    pub(crate) level: Option<u8>,
}

impl Integrity {
    /// Whether any radius bounds the error.
    fn is_bounded(self) -> bool {
        self.category != 0 && self.level != Some(0)
    }
}

/// Quality of a position by version, integrity and accuracy category (NACp). An aircraft that sends no version is of
/// version 0, and `integrity.category` its NUCp.
pub(crate) fn position_quality(version: Option<u64>, integrity: Integrity, accuracy: Option<u8>) -> Quality {
    if version.unwrap_or(0) == 0 {
        return radius_of_nucp(integrity.category);
    }
    quality_of_accuracy(integrity, accuracy)
}

/// Quality of a position of version 1 or later by integrity and accuracy category (NACp).
pub(crate) fn quality_of_accuracy(integrity: Integrity, accuracy: Option<u8>) -> Quality {
    match accuracy.map_or(Quality::Unknown, radius_of_nacp) {
        Quality::Unknown if integrity.is_bounded() => Quality::Unstated,
        by_accuracy => by_accuracy,
    }
}

/// Quality of a position that was sent in steps of `step_m` metres: rounding adds an even distribution of this width on
/// each axis.
pub(crate) fn with_step(quality: Quality, step_m: f64) -> Quality {
    match quality {
        Quality::Radius95(radius_m) => Quality::Radius95(radius_m.hypot(RADIUS95_SIGMAS * step_m / 12f64.sqrt())),
        other => other,
    }
}

/// Covariance of a velocity whose components were sent in steps of `step_mps`, metres per second.
pub(crate) fn covariance_with_step([xx, xy, yy]: [f64; 3], step_mps: f64) -> [f64; 3] {
    let rounding = step_mps * step_mps / 12.0;
    [xx + rounding, xy, yy + rounding]
}

/// Step of positions in extended squitters, metres, by whether the aircraft is on the ground: a zone of 6° (1.5° on the
/// ground) of latitude has 2¹⁷ steps. Zones of longitude are about as wide.
pub(crate) fn squitter_step_m(is_surface: bool) -> f64 {
    if is_surface { 1.27 } else { 5.09 }
}

/// Step of velocities in extended squitters of subsonic aircraft, metres per second: a knot.
pub(crate) const SQUITTER_STEP_MPS: f64 = 1852.0 / 3600.0;
