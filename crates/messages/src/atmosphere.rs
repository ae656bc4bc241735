//! Pressure altitude and height.
//!
//! A transponder sends a pressure altitude: the altitude at which the standard atmosphere has the outside pressure,
//! relative to 1013.25 hPa, independent of the pilot's setting. With the real pressure at sea level (QNH), the
//! altimeter's formula gives a constant offset, 27 ft per hPa near the ground. The temperature remains uncorrected:
//! on a day 10 °C colder than standard, an aircraft flies 4 % lower. All sources of a deployment have the same
//! offset, so that fusion does not need the correction; the correction matters at slant ranges of a few heights, and
//! for comparisons with geometric heights.
//!
//! ICAO Doc 7488, the standard atmosphere up to 11 km.

/// Pressure at mean sea level in the standard atmosphere, hPa.
pub const STANDARD_PRESSURE_HPA: f64 = 1013.25;
/// Temperature at mean sea level, divided by its decrease with height, metres.
const SCALE_M: f64 = 288.15 / 0.0065;
/// Gas constant of air times the decrease of temperature, divided by gravity.
const EXPONENT: f64 = 0.190_263;

/// Correction to add to a pressure altitude where mean sea level has the pressure `qnh_hpa`, metres.
pub fn pressure_correction_m(qnh_hpa: f64) -> f64 {
    SCALE_M * ((qnh_hpa / STANDARD_PRESSURE_HPA).powf(EXPONENT) - 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hectopascal_is_27_feet() {
        assert_eq!(pressure_correction_m(STANDARD_PRESSURE_HPA), 0.0);
        let feet = pressure_correction_m(1014.25) / 0.3048;
        assert!((feet - 27.3).abs() < 0.1, "{feet}");
        // The pilots' table from altimeter setting to pressure altitude: 29.0 inches of mercury, 863 ft.
        let feet = pressure_correction_m(29.0 * 33.863_886) / 0.3048;
        assert!((feet + 863.0).abs() < 1.0, "{feet}");
    }
}
