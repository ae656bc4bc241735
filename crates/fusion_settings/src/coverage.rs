//! Coverage of a source: the area in which it can detect targets, and its probability of detection there.
//!
//! A configured coverage is an intersection of a range, a sector of azimuths and a polygon. Within it the probability
//! is constant. Without configuration, module `detection_map` learns the coverage from tracks.

use serde::{Deserialize, Serialize};
use settings::{Degrees, SettingsError};

settings::settings! {
    /// Coverage of a source; a key that is left out sets no limit.
    pub struct CoverageTable {
        check CoverageTable::check;
        /// Farthest horizontal distance.
        range_m: Option<f64> = None, in [1, 2e6];
        /// First and last azimuth of the observed sector, clockwise from north.
        sector_deg: Option<[Degrees; 2]> = None, in [-360, 360];
        /// Corners of the observed area, east and north in the system frame.
        polygon_m: Vec<[f64; 2]> = Vec::new(), in [-2e6, 2e6];
        /// Probability that the source tracks a target in this region.
        probability: f64 = 0.9, in [0.01, 1];
    }
}

impl CoverageTable {
    fn check(&self) -> Result<(), SettingsError> {
        if !(1..3).contains(&self.polygon_m.len()) {
            return Ok(());
        }
        let what = "a polygon has three corners or more, each [east, north]; leave it out for no further limit";
        Err(SettingsError::new("polygon_m", what))
    }

    /// Where the source at this place sees, east and north, metres.
    pub fn at(&self, place_m: [f64; 2]) -> CoverageArea {
        CoverageArea {
            place_m,
            range_m: self.range_m.unwrap_or(f64::INFINITY),
            sector_rad: self.sector_deg.map(|sector| sector.map(Degrees::rad)),
            polygon_m: self.polygon_m.clone(),
            probability: self.probability,
        }
    }
}

/// Where a source sees targets, and how surely.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CoverageArea {
    /// East and north of the sensor in the system frame, metres.
    pub place_m: [f64; 2],
    /// Farthest horizontal distance, metres.
    pub range_m: f64,
    /// First and last azimuth of the sector that is seen, clockwise from north, radians; `None`: all around.
    pub sector_rad: Option<[f64; 2]>,
    /// Corners, east and north in the system frame, metres, of the area that is seen; empty: no further limit.
    pub polygon_m: Vec<[f64; 2]>,
    /// Probability that the source tracks a target in this region.
    pub probability: f64,
}

impl CoverageArea {
    /// Returns the coverage of a sensor without informative silence, such as a direction finder: probability 0.
    pub fn none() -> Self {
        Self {
            place_m: [0.0; 2],
            range_m: f64::INFINITY,
            sector_rad: None,
            polygon_m: Vec::new(),
            probability: 0.0,
        }
    }

    /// Probability that the source follows a target at this place.
    pub fn probability_at(&self, position_m: [f64; 3]) -> f64 {
        let (dx, dy) = (position_m[0] - self.place_m[0], position_m[1] - self.place_m[1]);
        let in_sector = self.sector_rad.is_none_or(|[first, last]| {
            let turn = std::f64::consts::TAU;
            (dx.atan2(dy) - first).rem_euclid(turn) <= (last - first).rem_euclid(turn)
        });
        let inside = dx * dx + dy * dy <= self.range_m * self.range_m
            && in_sector
            && self.polygon_holds(position_m[0], position_m[1]);
        if inside { self.probability } else { 0.0 }
    }

    /// Whether a ray from (x, y) crosses the polygon's edges an odd number of times.
    fn polygon_holds(&self, x: f64, y: f64) -> bool {
        let corners = &self.polygon_m;
        let edges = corners.iter().zip(corners.iter().cycle().skip(1));
        let crosses = |([ax, ay], [bx, by]): &(&[f64; 2], &[f64; 2])| {
            (*ay > y) != (*by > y) && x < (bx - ax) * (y - ay) / (by - ay) + ax
        };
        corners.is_empty() || edges.filter(crosses).count() % 2 == 1
    }
}
