//! Navigation accuracy as aircraft state it: small numbers that stand for radii.
//!
//! Aircraft of the first generation send an uncertainty category for position (NUCp); later ones an accuracy category
//! (NACp), the radius that holds 95 % of the errors, beside an integrity category (NIC), the radius that an error
//! leaves unnoticed hardly ever. All of them send a category for velocity (NUCr, later NACv).

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
/// exceeds the radius (SIL).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Integrity {
    pub(crate) category: u8,
    pub(crate) level: Option<u8>,
}

/// Factor on the radius of an accuracy category where nothing is known of the integrity. The standards give none: a
/// position that nobody monitors is believed half as well.
const UNMONITORED: f64 = 2.0;

/// Quality of a position by version, integrity and accuracy category (NACp). An aircraft that sends no version is of
/// version 0.
pub(crate) fn position_quality(version: Option<u64>, integrity: Integrity, accuracy: Option<u8>) -> Quality {
    if version.unwrap_or(0) == 0 {
        return radius_of_nucp(integrity.category);
    }
    let by_accuracy = accuracy.map_or(Quality::Unknown, radius_of_nacp);
    match by_accuracy {
        Quality::Radius95(radius_m) if integrity.category == 0 || integrity.level == Some(0) => {
            Quality::Radius95(UNMONITORED * radius_m)
        }
        Quality::Radius95(_) => by_accuracy,
        _ => integrity.radius95(),
    }
}

impl Integrity {
    /// Radius of 95 % containment: by a Rayleigh distribution of the errors, of which so many exceed the containment
    /// radius as the level says. RTCA DO-260B gives 10⁻³, 10⁻⁵ and 10⁻⁷ for the levels 1, 2 and 3.
    fn radius95(self) -> Quality {
        let exceeding: f64 = match self.level {
            Some(0) => return Quality::Unknown,
            Some(1) => 1e-3,
            Some(2) => 1e-5,
            Some(_) => 1e-7,
            // Without a level, the radius is an upper bound.
            None => return radius_of_nic(self.category),
        };
        match radius_of_nic(self.category) {
            Quality::Radius95(contained_m) => {
                Quality::Radius95(contained_m * RADIUS95_SIGMAS / (-2.0 * exceeding.ln()).sqrt())
            }
            other => other,
        }
    }
}

/// Returns the containment radius of a navigation integrity category (NIC), by RTCA DO-260B; if the radius depends on
/// supplements, the largest radius.
pub(super) fn radius_of_nic(category: u8) -> Quality {
    match category {
        11 => Quality::Radius95(7.5),
        10 => Quality::Radius95(25.0),
        9 => Quality::Radius95(75.0),
        8 => Quality::Radius95(0.1 * NAUTICAL_MILE_M),
        7 => Quality::Radius95(0.2 * NAUTICAL_MILE_M),
        6 => Quality::Radius95(0.6 * NAUTICAL_MILE_M),
        5 => Quality::Radius95(NAUTICAL_MILE_M),
        4 => Quality::Radius95(2.0 * NAUTICAL_MILE_M),
        3 => Quality::Radius95(4.0 * NAUTICAL_MILE_M),
        2 => Quality::Radius95(8.0 * NAUTICAL_MILE_M),
        1 => Quality::Radius95(20.0 * NAUTICAL_MILE_M),
        _ => Quality::Unknown,
    }
}
