//! Altitudes: pressure altitudes corrected by the pressure at sea level (QNH) of the region, below the transition
//! level.
//!
//! Altimeters are set to QNH below the transition level and to 1013.25 hPa at and above it, so controllers speak of
//! altitudes below and of flight levels above. Transponders always send the latter. A region has a pressure from its
//! configuration, which may change with time, or by an order.
//!
//! ICAO Doc 8168 (PANS-OPS), volume III, for transition levels.

use messages::{LEVEL_STEP_M, altitude_m, pressure_correction_m};

use crate::region::Region;

/// Most regions with a pressure.
pub const QNH_REGIONS_MAX: usize = 64;
/// Steps of a transponder's level in a flight level.
const STEPS_OF_LEVEL: i16 = 4;

/// Pressure at sea level in a region.
#[derive(Clone, Debug, PartialEq)]
pub struct RegionalQnh {
    /// Name, by which orders set the pressure.
    pub name: String,
    /// Region; `None`: everywhere.
    pub region: Option<Region>,
    /// Lowest flight level in use, hundreds of feet.
    pub transition_level: i16,
    /// Pressures, hPa, each from a time on (UTC, nanoseconds), in the order of time. The first one also holds before
    /// its time.
    pub readings: Vec<(i64, f64)>,
    /// Pressure by an order in force, hPa.
    pub ordered_hpa: Option<f64>,
}

/// Altitude of a target, with the pressure that it refers to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Altitude {
    /// Metres above mean sea level.
    pub altitude_m: f64,
    /// Pressure at mean sea level, hPa.
    pub qnh_hpa: f64,
}

impl RegionalQnh {
    /// Pressures of a region.
    pub fn new(name: String, region: Option<Region>, transition_level: i16, readings: Vec<(i64, f64)>) -> Self {
        Self {
            name,
            region,
            transition_level,
            readings,
            ordered_hpa: None,
        }
    }

    fn contains(&self, place: [f64; 2]) -> bool {
        self.region.as_ref().is_none_or(|region| region.contains(place))
    }

    /// Pressure in force at a time, UTC, nanoseconds; `None` without any.
    fn hpa(&self, time_ns: i64) -> Option<f64> {
        let begun = self.readings.iter().rev().find(|(from_ns, _)| *from_ns <= time_ns);
        let configured = begun.or(self.readings.first()).map(|(_, hpa)| *hpa);
        self.ordered_hpa.or(configured)
    }
}

/// Returns the altitude of a target at a place (east and north, metres) with a transponder's level, in the first of the
/// regions that contains the place; `None` outside of them, and from the transition level on.
pub fn altitude(regions: &[RegionalQnh], place: [f64; 2], level: i16, time_ns: i64) -> Option<Altitude> {
    let regional = regions.iter().find(|regional| regional.contains(place))?;
    if level >= regional.transition_level.saturating_mul(STEPS_OF_LEVEL) {
        return None;
    }
    let qnh_hpa = regional.hpa(time_ns)?;
    Some(Altitude {
        altitude_m: altitude_m(level) + pressure_correction_m(qnh_hpa),
        qnh_hpa,
    })
}

const _: () = assert!(STEPS_OF_LEVEL as f64 * LEVEL_STEP_M > 30.47 && STEPS_OF_LEVEL as f64 * LEVEL_STEP_M < 30.49);

#[cfg(test)]
mod tests {
    use super::*;

    fn square(half_m: f64) -> Region {
        Region {
            corners_m: vec![
                [-half_m, -half_m],
                [half_m, -half_m],
                [half_m, half_m],
                [-half_m, half_m],
            ],
            ..Region::default()
        }
    }

    fn regions() -> Vec<RegionalQnh> {
        vec![
            RegionalQnh::new(
                "port".to_owned(),
                Some(square(1e4)),
                60,
                vec![(0, 1003.25), (100, 993.25)],
            ),
            RegionalQnh::new("rest".to_owned(), None, 100, vec![(50, 1023.25)]),
        ]
    }

    fn feet(place: [f64; 2], level: i16, time_ns: i64) -> Option<f64> {
        let found = altitude(&regions(), place, level, time_ns);
        found.map(|found| (found.altitude_m / 0.3048).round())
    }

    #[test]
    fn low_pressure_means_low_altitude_below_the_transition_level_only() {
        // 10 hPa are some 274 ft near the standard pressure, 20 hPa some 550 ft.
        assert_eq!(feet([0.0; 2], 160, 10), Some(4_000.0 - 274.0));
        assert_eq!(feet([0.0; 2], 239, 10), Some(5_975.0 - 274.0));
        assert_eq!(feet([0.0; 2], 240, 10), None, "a flight level");
        assert_eq!(feet([0.0; 2], 160, 100), Some(4_000.0 - 551.0), "a later reading");
        assert_eq!(feet([0.0; 2], -4, -7), Some(-100.0 - 274.0), "before the first one");
        assert_eq!(feet([2e4, 0.0], 240, 10), Some(6_000.0 + 272.0), "elsewhere");
    }

    #[test]
    fn an_order_goes_before_the_readings() {
        let mut regions = regions();
        regions[0].ordered_hpa = Some(1013.25);
        let found = altitude(&regions, [0.0; 2], 160, 100).unwrap();
        assert_eq!((found.altitude_m, found.qnh_hpa), (altitude_m(160), 1013.25));
        assert_eq!(altitude(&[], [0.0; 2], 160, 100), None);
    }
}
