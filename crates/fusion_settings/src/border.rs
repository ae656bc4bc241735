//! Settings of the borders between centres.

use std::fmt;

use settings::Seconds;

use crate::region::{Region, TOUCH_M};

settings::settings! {
    /// Borders with other centres, where there are regions: `[[region]]`.
    pub struct BorderSettings beside [regions: Vec<Region>] {
        /// Distance from another centre's region within which this centre receives targets.
        strip_m: f64 = 20e3, in [0, 1e6];
        /// Distance beyond its owner's region, and time spent there, after which a target changes hands.
        hand_over_m: f64 = 500.0, in [0, 1e5];
        /// See `hand_over_m`.
        hand_over_s: Seconds = Seconds::of(10.0), in [0, 3600];
    }
}

impl BorderSettings {
    /// Returns whether other centres receive a target at this place, east and north, metres; always without regions.
    pub fn is_in_strip(&self, place: [f64; 2]) -> bool {
        let mut others = self.regions.iter().filter(|region| !region.is_own);
        self.regions.is_empty() || others.any(|region| region.distance_m(place) <= self.strip_m)
    }

    /// Returns the widest gap of each region to its neighbour, for corners outside other regions and nearer than the
    /// strip's width to a region of another centre.
    pub fn gaps(&self) -> Vec<Gap> {
        let widest = |one: usize| {
            let region = &self.regions[one];
            let others = || (0..self.regions.len()).filter(move |other| *other != one);
            let gaps = region.corners_m.iter().filter_map(|corner| {
                let to = |other: usize| (self.regions[other].distance_m(*corner), other);
                let (width_m, other) = others().map(to).min_by(|a, b| a.0.total_cmp(&b.0))?;
                let is_gap = width_m > TOUCH_M && width_m <= self.strip_m;
                (is_gap && self.regions[other].origin != region.origin).then_some(Gap {
                    regions: [one, other],
                    width_m,
                })
            });
            gaps.max_by(|a, b| a.width_m.total_cmp(&b.width_m))
        };
        (0..self.regions.len()).filter_map(widest).collect()
    }
}

/// Regions that nearly meet: targets in between have no owner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gap {
    /// Places of both regions in the configuration, from 0.
    pub regions: [usize; 2],
    /// Distance between them at a corner, metres.
    pub width_m: f64,
}

impl fmt::Display for Gap {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ([one, other], width_m) = (self.regions, self.width_m);
        write!(
            f,
            "region[{one}] and region[{other}] leave a gap of {width_m:.0} m: each centre takes targets in it for its own; \
             let them meet at a line"
        )
    }
}
