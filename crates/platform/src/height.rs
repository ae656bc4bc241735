//! The elevation of a target of known height, as seen from a platform.
//!
//! A radar without elevation measures slant range and bearing, and the target's transponder, or the radar itself,
//! states the height. Ashore, range and height give the place on the ground at once. On board, the height of the radar
//! and the tilt of the deck are known with the platform's state only. The elevation follows from the difference of the
//! heights over the slant range; the tilted plane of the antenna, at this elevation, gives the bearing.
//!
//! The obvious way, an elevation in the axes of the deck, would make errors of pitch and roll errors of the target's
//! height: at 0.3° and 50 km, 260 m. A stated height does not depend on the deck. So the elevation here has the errors
//! of the height, of the range and of the sensor's own height alone.

use frames::SystemFrame;
use observations::StatedHeight;

/// Most steps to the elevation; each is a step of Newton's method, which needs three.
const STEPS_MAX: usize = 6;
/// Difference of height at which the elevation is found, metres.
const FOUND_M: f64 = 0.01;
/// Least horizontal part of the direction by which the errors are divided: straight above, the tangent has no end.
const HORIZONTAL_MIN: f64 = 0.05;

/// Dependence of an elevation that follows from a height on the inputs of the computation.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Rise {
    /// Standard deviation by the stated height's own, radians; `None` if the elevation does not follow from a height.
    pub(crate) sigma_rad: Option<f64>,
    /// Change by the measured range, radians per metre.
    pub(crate) by_range: f64,
    /// Change by the sensor's own height, radians per metre.
    pub(crate) by_up: f64,
}

/// Elevation of the target at the end of the range, in the stated height, from the sensor's place; `unit_at` gives the
/// unit vector of the direction at an elevation. `None` if no direction leads to this height.
pub(crate) fn elevation_to(
    height: StatedHeight,
    range_m: f64,
    place_m: [f64; 3],
    frame: Option<&SystemFrame>,
    unit_at: impl Fn(f64) -> Option<[f64; 3]>,
) -> Option<(f64, Rise)> {
    let height_of = |point: [f64; 3]| frame.map_or(point[2], |frame| frame.to_geodetic(point).height_m());
    let mut sine = (height.height_m - height_of(place_m)) / range_m;
    if sine.is_nan() || sine.abs() >= 1.0 {
        return None;
    }
    for _ in 0..STEPS_MAX {
        let unit = unit_at(sine.asin())?;
        let end = std::array::from_fn(|axis| place_m[axis] + range_m * unit[axis]);
        let missing_m = height.height_m - height_of(end);
        if missing_m.abs() <= FOUND_M {
            return Some((sine.asin(), Rise::of(height, range_m, sine)));
        }
        sine += missing_m / range_m;
        if sine.is_nan() || sine.abs() >= 1.0 {
            return None;
        }
    }
    None
}

impl Rise {
    fn of(height: StatedHeight, range_m: f64, sine: f64) -> Self {
        let along_m = range_m * (1.0 - sine * sine).sqrt().max(HORIZONTAL_MIN);
        Self {
            sigma_rad: Some(height.sigma_m / along_m),
            by_range: -sine / along_m,
            by_up: -1.0 / along_m,
        }
    }
}
